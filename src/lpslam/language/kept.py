"""What every process would make alike, kept in the user's cache: tables as they are looked up, what boards say.

Values are plain ones of Python, written as Python writes its compiled modules. A file is named by a hash of all that
its value is made of, the tables and the program among it; one that cannot be read or written does no harm.
"""

import gc
import hashlib
import inspect
import marshal
import os
import stat
import sys
import tempfile
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

_HERE = Path(__file__).parent
MANY = 50
"""Texts of boards of which it is kept what they say: fewer are read in a twentieth of a second."""
_MOST_BYTES = 200 << 20  # of all files: tables of a few versions, and boards of a few million signs
_MUCH_BUILT = 50_000  # objects made since the last collection: of tables; what a question builds is far less
_SUM = 4  # bytes of a checksum: what is torn is made anew


@contextmanager
def building() -> Iterator[None]:
    """Let the garbage collector wait: nothing built here is garbage yet (a fifth of the first answer's time)."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            # All that there is counts as old now, so that the next collections do not go through it three times. To
            # count what is frozen goes through it, too, as long as a question takes.
            if gc.get_count()[0] > _MUCH_BUILT and not gc.get_freeze_count():
                gc.freeze()
                gc.unfreeze()
            gc.enable()


def steps_of(parts: Iterable[object]) -> Iterator[None]:
    """Build what some objects keep once it was asked for (`cached_property`), one such thing a step."""
    for part in parts:
        for name, each in inspect.getmembers_static(type(part)):
            if isinstance(each, cached_property):
                getattr(part, name)
                yield


def user_cache_folder() -> Path | None:
    """Where this user's caches live, on this system; XDG_CACHE_HOME is honoured everywhere. None without a home."""
    named = os.environ.get("XDG_CACHE_HOME")
    if named and Path(named).is_absolute():
        return Path(named) / "lpslam"
    try:
        home = Path.home()
    except RuntimeError:
        return None
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local") / "lpslam" / "Cache"
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "lpslam"
    return home / ".cache" / "lpslam"


def kept(name: str, made_of: bytes, make: Callable[[], Any], program: Path = _HERE) -> Any:
    """Return what `make` returns, from the cache if it is there.

    Args:
        name: of what is made; a word.
        made_of: what it is made of beside the tables and the program.
        make: returns plain values, alike in every process.
        program: the folder of all that makes it; the language layer without.
    """
    folder = user_cache_folder()
    if folder is None:
        return make()
    path = folder / "made" / f"{name}-{hashlib.sha256(_program(program) + made_of).hexdigest()[:32]}"
    with suppress(OSError, ValueError, EOFError, TypeError):
        data = _own(path)
        if zlib.crc32(data[_SUM:]) == int.from_bytes(data[:_SUM], "big"):
            return marshal.loads(data[_SUM:])
    value = make()
    with suppress(OSError, ValueError):
        data = marshal.dumps(value)
        write_private(path, zlib.crc32(data).to_bytes(_SUM, "big") + data)
        _forget(path.parent)
    return value


def kept_of_boards(name: str, count: int, texts: Iterable[str], make: Callable[[], Any]) -> Any:
    """Return what `make` returns of so many boards, by `kept` where they are many; all that they say tells them."""
    return kept(name, "\0".join(texts).encode("utf-8", "surrogatepass"), make) if count >= MANY else make()


@lru_cache
def _program(folder: Path) -> bytes:
    """What tells this version of a part of the program, its tables and Python from others."""
    # What is compiled beside the program (bytecode, kernels) comes at any time, and changes nothing that it says.
    written = ((each, names) for each, _, names in os.walk(folder) if os.path.basename(each) != "__pycache__")
    files = sorted(os.path.join(each, name) for each, names in written for name in names)
    stats = ((path, os.stat(path)) for path in files if not path.endswith(".md"))
    told = [f"{os.path.relpath(path, folder)} {about.st_size} {about.st_mtime_ns}" for path, about in stats]
    return "\n".join([str(sys.implementation.cache_tag), sys.version, *told]).encode()


def _own(path: Path) -> bytes:
    """What a file of this user's holds: values are read as code is, so nobody else's are.

    Raises:
        OSError: it is not there, is a pipe or a device, or somebody else's.
    """
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0))) as file:
        is_ours = not hasattr(os, "geteuid") or os.fstat(file.fileno()).st_uid == os.geteuid()
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode) or not is_ours:
            raise OSError("no file of this user's")
        return file.read()


def write_private(path: Path, data: bytes) -> None:
    """Write a file of a cache, whole or not at all, for this user alone; where that fails, nothing is kept."""
    part: Path | None = None
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix="part-", delete=False) as file:
            part = Path(file.name)
            file.write(data)
        part.replace(path)
    except OSError:
        if part is not None:
            with suppress(OSError):
                part.unlink(missing_ok=True)


def _forget(folder: Path) -> None:
    """Leave the newest files."""
    left = _MOST_BYTES
    stats = ((path, path.stat()) for path in folder.iterdir())
    for path, about in sorted(stats, key=lambda each: -each[1].st_mtime_ns):
        left -= about.st_size
        if left < 0:
            path.unlink(missing_ok=True)
