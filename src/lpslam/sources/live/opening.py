"""Live cameras by their addresses: `realsense:` or `realsense:SERIAL`."""

from pathlib import Path

from lpslam.errors import UserError
from lpslam.sources.live.source import LiveSource

CAMERAS = ("realsense",)


def addresses() -> str:
    """Of the kinds of cameras that can be used, as they stand in errors."""
    return ", ".join(f"{name}:" for name in CAMERAS)


def is_camera(path: Path | str) -> bool:
    """Whether this is a camera's address, and no file of that name is there."""
    kind, colon, _ = str(path).partition(":")
    return bool(colon) and kind in CAMERAS and not Path(path).exists()


def open_camera(path: Path | str, max_frames: int | None = None, backlog: int = 2) -> LiveSource:
    """Open a connected camera; it begins when frames are asked for.

    Args:
        path: its address.
        max_frames: end after so many; endless without.
        backlog: frames that may wait for a consumer that is late.

    Raises:
        UserError: it is not there, or its library is not.
    """
    if max_frames is not None and max_frames < 1:
        raise UserError(f"{path}: the number of frames is limited to {max_frames}; it must be at least 1")
    from lpslam.sources.live.realsense import RealsenseDriver

    return LiveSource(RealsenseDriver(str(path).partition(":")[2]), backlog, max_frames)
