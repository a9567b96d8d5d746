"""Files that are written whole or not at all, and places that nothing can be written to, told before the work."""

import os
import secrets
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager
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
        kept: where a part goes that cannot be had again; removed without.

    Raises:
        UserError: it cannot be written.
    """
    target = Path(os.path.realpath(path))
    part = _beside(target)
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
    trial = _beside(folder / "trial")
    try:
        trial.touch(exist_ok=False)
        trial.unlink()
    except OSError as error:
        raise UserError(f"{name} cannot be written ({error.strerror}); choose another place") from error


def _beside(target: Path) -> Path:
    """A name of its own for each writer; short, since that of `target` may be as long as names can be."""
    return target.with_name(f".lpslam-{os.getpid()}-{secrets.token_hex(4)}.part")


def _remove(part: Path) -> None:
    if part.is_dir():
        shutil.rmtree(part, ignore_errors=True)
    else:
        part.unlink(missing_ok=True)


def _named(path: Path, what: str) -> str:
    return f"{what} {path}" if what else f"{path}"
