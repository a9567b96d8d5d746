"""Where compiled kernels are kept: beside their code, in the user's cache folder, or until this process ends."""

import atexit
import logging
import os
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path
from types import FunctionType
from typing import Any

from numba import njit
from numba.core import config, event

from lpslam.errors import UserError
from lpslam.interruption import at_end

logger = logging.getLogger(__name__)

# Numba runs what it finds in these places, and takes their names from a file in the current folder, too, which may have
# come with a recording; a variable that is set, if only to nothing, counts before that file.
_PLACES = ("NUMBA_CACHE_DIR", "NUMBA_CACHE_LOCATOR_CLASSES")

# Tried after the system's folder for temporary files: memory, which containers have that may write nothing else.
_MEMORY = "/dev/shm"

_ROOM = 32 << 20
"""Bytes free on a disk that is not full; the kernels take a fifth of that."""

_temporary: Path | None = None


def provide_cache(file: str) -> None:
    """Have a place where numba can keep the kernels of a package; to be called before it meets the first of them.

    Where neither the package's folder, nor the user's cache folder, nor `NUMBA_CACHE_DIR` can be written, a new folder
    that only this user can enter serves this process and those that it starts, and is removed when it ends.

    Args:
        file: of the package.

    Raises:
        UserError: nothing at all can be written.
    """
    global _temporary
    for name in _PLACES:
        os.environ.setdefault(name, "")
    config.reload_config()  # type: ignore[no-untyped-call]
    if _is_kept_beside(file):
        return
    _temporary = _new_folder()
    atexit.register(_remove, _temporary, os.getpid())
    at_end(remove_temporary)
    os.environ["NUMBA_CACHE_DIR"] = str(_temporary)
    config.reload_config()  # type: ignore[no-untyped-call]
    event.register("numba:compile", _SaidOnce(Path(file).parent))  # type: ignore[no-untyped-call]


def is_kept() -> bool:
    """Whether kernels that are compiled now are there at the next start."""
    return _temporary is None


def remove_temporary() -> None:
    """Remove what would be removed at the end of this process, before an end without farewell."""
    if _temporary is not None:
        _remove(_temporary, os.getpid())


class _SaidOnce(event.Listener):
    """Warns when the first kernel is compiled: what compiles none costs nothing."""

    def __init__(self, folder: Path) -> None:
        self._folder: Path | None = folder

    def on_start(self, event: object) -> None:
        """A kernel is about to be compiled (`event` says which)."""
        if self._folder is not None:
            logger.warning(
                "kernels are compiled anew at each start, for about half a minute: neither %s nor a cache folder of "
                "yours can be written, or they are full; set NUMBA_CACHE_DIR to a folder that can be",
                self._folder,
            )
            self._folder = None

    def on_end(self, event: object) -> None:
        """A kernel was compiled: nothing follows from it."""


def _is_kept_beside(file: str) -> bool:
    """Whether numba finds a place for a function of this file."""
    function = FunctionType((lambda: None).__code__.replace(co_filename=file), globals())
    try:
        kernel: Any = njit(cache=True)(function)
    except RuntimeError:
        return False
    if kernel is function:
        # NUMBA_DISABLE_JIT: nothing is compiled.
        return True
    place = Path(kernel.stats.cache_path)
    named = os.environ["NUMBA_CACHE_DIR"]
    if place.is_absolute() or (named and place.is_relative_to(named)):
        return _has_room(place) or any(place.glob("*.nbi"))
    # Without a home, numba takes "~" for a folder in the current one, where anybody may have put what it would run.
    with suppress(OSError):
        os.removedirs(place)
    return False


def _new_folder() -> Path:
    for parent in (None, _MEMORY):
        with suppress(OSError):
            folder = Path(tempfile.mkdtemp(prefix="lpslam-kernels-", dir=parent))
            if _has_room(folder):
                return folder
            folder.rmdir()
    raise UserError("compiled kernels can be kept nowhere: set NUMBA_CACHE_DIR to a folder that can be written")


def _has_room(folder: Path) -> bool:
    return shutil.disk_usage(folder).free >= _ROOM


def _remove(folder: Path, owner: int) -> None:
    # A process forked from the one that made it leaves it alone.
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)
