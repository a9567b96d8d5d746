"""Files that somebody else may have put there: devices never end, pipes never begin, texts fill disks."""

import stat
from pathlib import Path

from lpslam.errors import UserError

_LONGEST_TEXT = 1 << 26
"""Bytes; a list of a million images has fifty million."""


def is_regular(path: Path) -> bool:
    """Whether a file is there that has an end: no folder, pipe, socket or device, nor a link to one."""
    try:
        return stat.S_ISREG(path.stat().st_mode)
    except (OSError, ValueError):
        return False


def text_of(path: Path, what: str = "", remedy: str = "") -> str:
    """What a text file holds.

    Args:
        path: the file.
        what: what it is, as it stands before its name in errors ("calibration").
        remedy: what it should be, as it stands at the end of errors.

    Raises:
        UserError: it cannot be read, is no file, no text, or longer than any text of a recording.
    """
    name, ending = f"{what} {path}" if what else f"{path}", f"; {remedy}" if remedy else ""
    try:
        if path.exists() and not path.is_dir() and not is_regular(path):
            raise UserError(f"{name} is no file but a device or a pipe{ending}")
        with path.open("rb") as file:
            data = file.read(_LONGEST_TEXT + 1)
    except (OSError, ValueError) as error:
        raise UserError(f"{name} cannot be read ({getattr(error, 'strerror', None) or error}){ending}") from error
    if len(data) > _LONGEST_TEXT:
        raise UserError(f"{name} has more than {_LONGEST_TEXT >> 20} MB{ending or '; no such text is that long'}")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise UserError(f"{name} is not a text file{ending or '; write it in UTF-8'}") from error
