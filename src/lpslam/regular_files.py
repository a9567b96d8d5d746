"""Files that somebody else may have put there: devices never end, pipes never begin, texts fill disks."""

import stat
from pathlib import Path

from lpslam.errors import UserError

_LONGEST = 1 << 26
"""Bytes of a file that is read as a whole; a list of a million images has fifty million."""


def is_regular(path: Path) -> bool:
    """Whether a file is there that has an end: no folder, pipe, socket or device, nor a link to one."""
    try:
        return stat.S_ISREG(path.stat().st_mode)
    except (OSError, ValueError):
        return False


def refuse_endless(path: Path, what: str = "", remedy: str = "") -> None:
    """Raise a `UserError` if something is there that is neither a file nor a folder; arguments as of `bytes_of`."""
    try:
        is_endless = path.exists() and not path.is_dir() and not is_regular(path)
    except OSError:
        # Whoever opens it says so.
        return
    if is_endless:
        raise UserError(f"{_named(path, what)} is no file but a device or a pipe{_ending(remedy)}")


def bytes_of(path: Path, what: str = "", remedy: str = "") -> bytes:
    """What a file holds.

    Args:
        path: the file.
        what: what it is, as it stands before its name in errors ("calibration").
        remedy: what it should be, as it stands at the end of errors.

    Raises:
        UserError: it cannot be read, is no file, or is longer than any that belongs to a recording or a map.
    """
    name, ending = _named(path, what), _ending(remedy)
    refuse_endless(path, what, remedy)
    try:
        with path.open("rb") as file:
            data = file.read(_LONGEST + 1)
    except (OSError, ValueError) as error:
        raise UserError(f"{name} cannot be read ({getattr(error, 'strerror', None) or error}){ending}") from error
    if len(data) > _LONGEST:
        raise UserError(f"{name} has more than {_LONGEST >> 20} MB{ending or '; no such file is that long'}")
    return data


def text_of(path: Path, what: str = "", remedy: str = "") -> str:
    """What a text file holds; arguments and errors as of `bytes_of`, and where it is no text."""
    try:
        return bytes_of(path, what, remedy).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        ending = _ending(remedy) or "; write it in UTF-8"
        raise UserError(f"{_named(path, what)} is not a text file{ending}") from error


def _named(path: Path, what: str) -> str:
    return f"{what} {path}" if what else f"{path}"


def _ending(remedy: str) -> str:
    return f"; {remedy}" if remedy else ""
