"""What a job's process may use and read: a recording from a stranger may list any path as a picture's."""

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lpslam.config import JobsConfig
from lpslam.isolated import search_path

_SYSTEM = ("/usr", "/lib", "/lib64", "/opt", "/proc", "/sys", "/dev", "/etc/ld.so.cache", "/etc/localtime", "/run/udev")


def kernel_places() -> list[Path]:
    """Where compiled kernels may be kept besides beside their code."""
    named = os.environ.get("NUMBA_CACHE_DIR")
    return [Path(named)] if named else [Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "numba"]


def limit_resources(limits: JobsConfig) -> None:
    """Bound this process's memory, processor time and files, where the system can."""
    try:
        import resource
    except ImportError:
        return
    for kind, most in (
        (resource.RLIMIT_AS, limits.memory_bytes),
        (resource.RLIMIT_CPU, limits.processor_s),
        (resource.RLIMIT_FSIZE, limits.file_bytes),
        (resource.RLIMIT_CORE, 0),
    ):
        _, hard = resource.getrlimit(kind)
        bound = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (bound, bound))
    os.nice(10)


def read_only_inside(folder: Path, others: Iterable[Path] = ()) -> None:
    """From now on, refuse to open files outside a folder, but for the system's and the packages' own.

    It holds for whatever Python opens, which is how recordings are read; it is no jail for hostile code.

    Args:
        folder: of the job.
        others: files and folders that may be opened besides.
    """
    named = (folder, *others, sys.prefix, sys.base_prefix, *search_path(), *_SYSTEM)
    allowed = tuple({os.path.realpath(str(each)) for each in named})

    def refuse(event: str, arguments: tuple[Any, ...]) -> None:
        if event != "open" or not isinstance(arguments[0], str | bytes | os.PathLike):
            return
        place = os.path.realpath(os.fsdecode(arguments[0]))
        if not any(place == root or place.startswith(root + os.sep) for root in allowed):
            raise PermissionError(13, "it lies outside of the recording", os.fsdecode(arguments[0]))

    sys.addaudithook(refuse)
