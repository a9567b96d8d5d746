"""Files that are written whole or not at all, and places that nothing can be written to, told before the work."""

import hashlib
import os
import re
import secrets
import shutil
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from lpslam.errors import UserError


@contextmanager
def written_whole(
    path: Path, what: str = "", remedy: str = "choose another place", kept: Path | None = None
) -> Iterator[Path]:
    """A place beside `path` for a file or a folder, which takes that name once it is whole.

    Whoever reads `path` sees what was there or what is new, never a part; a full disk, a failure and Ctrl-C leave what
    was there. Of a link, what it leads to is replaced.

    Args:
        path: where to; nothing, a file, or an empty folder for a folder.
        what: what it is, as it stands before its name in errors ("map").
        remedy: the end of the error.
        kept: where a part goes that cannot be had again; removed without. Neither does `refuse_unwritable` remove it.

    Raises:
        UserError: it cannot be written.
    """
    target = Path(os.path.realpath(path))
    part = _beside(target, "part" if kept is None else "kept")
    try:
        try:
            yield part
            if part.is_dir() and target.is_dir():
                target.rmdir()
            os.replace(part, target)
        finally:
            if kept is not None and part.exists():
                os.replace(part, kept)
            _remove(part)
    except OSError as error:
        raise UserError(f"{_named(path, what)} cannot be written ({error.strerror or error}); {remedy}") from error


def refuse_unwritable(path: Path, what: str = "") -> None:
    """Refuse, before the work for it is done, a place where no file can be written.

    What writers that were killed have left in its folder is removed.

    Args:
        path: of the file that is to be.
        what: as of `written_whole`.

    Raises:
        UserError: it is a folder, a device or a pipe, its folder is missing, or nothing can be made there.
    """
    name, target = _named(path, what), Path(os.path.realpath(path))
    if os.path.isdir(target):
        raise UserError(f"{name} cannot be written: it is a folder; give the name of a file")
    if not os.path.isdir(target.parent):
        raise UserError(f"{name} cannot be written: the folder {path.parent} does not exist; make it first")
    try:
        if not stat.S_ISREG(target.stat().st_mode):
            raise UserError(f"{name} cannot be written: it is no file but a device or a pipe; give the name of a file")
    except FileNotFoundError:
        pass
    except OSError as error:
        # A name that is too long, or a link to itself.
        raise UserError(f"{name} cannot be written ({error.strerror}); choose another name") from error
    _try_out(target.parent, name)


def refuse_unwritable_folder(folder: Path, what: str = "") -> None:
    """The same of a folder that is made with all that lead to it."""
    name, there = _named(folder, what), Path(os.path.realpath(folder))
    while not os.path.lexists(there):
        there = there.parent
    if not os.path.isdir(there):
        raise UserError(f"{name} cannot be written: {there} is no folder; choose another folder")
    _try_out(there, name)


def _try_out(folder: Path, name: str) -> None:
    """Make a file there, and remove it: permissions do not tell what a system of files allows."""
    _remove_stale(folder)
    trial = _beside(folder / "trial", "part")
    try:
        trial.touch(exist_ok=False)
        trial.unlink()
    except OSError as error:
        raise UserError(f"{name} cannot be written ({error.strerror}); choose another place") from error


def _beside(target: Path, ending: str) -> Path:
    """A name of its own for each writer; short, since that of `target` may be as long as names can be."""
    return target.with_name(f".lpslam-{os.getpid()}-{_here()}{secrets.token_hex(4)}.{ending}")


_PART = re.compile(r"\.lpslam-(\d+)-([0-9a-f]{8})?[0-9a-f]{8}\.part")

_LONG_AGO = 86400.0
"""Seconds without a change after which a part is nobody's, wherever its writer ran: writers write all the time."""


@cache
def _here() -> str:
    """Eight hexadecimal digits of where numbers of processes mean the same as here; none where that is not told."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii")
        return hashlib.sha256(f"{boot}{os.stat('/proc/self/ns/pid').st_ino}".encode()).hexdigest()[:8]
    except OSError:
        return ""


def _remove_stale(folder: Path) -> None:
    """Remove this user's parts in a folder whose writers are gone; what cannot be removed does not matter."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            named = _PART.fullmatch(entry.name)
            if named is not None and not entry.is_symlink():
                is_own = not hasattr(os, "geteuid") or entry.stat().st_uid == os.geteuid()
                if is_own and (_is_gone(int(named[1]), named[2]) or _is_old(Path(entry.path))):
                    _remove(Path(entry.path))


def _is_gone(process: int, where: str | None) -> bool:
    """Whether a process ran here and does no more."""
    if not where or where != _here():
        return False
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except OSError:
        return False
    return False


def _is_old(part: Path) -> bool:
    newest = max(each.stat().st_mtime for each in [part, *part.rglob("*")])
    return time.time() - newest > _LONG_AGO


def _remove(part: Path) -> None:
    if part.is_dir():
        shutil.rmtree(part, ignore_errors=True)
    else:
        part.unlink(missing_ok=True)


def _named(path: Path, what: str) -> str:
    return f"{what} {path}" if what else f"{path}"
