"""The layouts of phones and data sets: how each is known. Their readers are loaded when one is opened."""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True, slots=True)
class Capture:
    """A layout.

    Attributes:
        name: as people call it.
        sign: what is in the path.
        is_at: whether it is there.
        module: the reader's module in this room, which has `open_capture`.
    """

    name: str
    sign: str
    is_at: Callable[[Path], bool]
    module: str

    def open(self, folder: Path, camera_file: Path | None, max_frames: int | None, *, nominal: bool) -> Any:
        """Open the recording with the layout's reader."""
        reader = importlib.import_module(f"lpslam.sources.captures.{self.module}")
        return reader.open_capture(folder, camera_file, max_frames, nominal=nominal)


def _has(*names: str) -> Callable[[Path], bool]:
    return lambda path: path.is_dir() and all((path / name).exists() for name in names)


def _ends(suffix: str) -> Callable[[Path], bool]:
    return lambda path: path.is_file() and path.suffix.lower() == suffix


def _is_replica(path: Path) -> bool:
    return path.is_dir() and any((path / "results").glob("frame*.jpg")) and any((path / "results").glob("depth*.png"))


CAPTURES = (
    Capture("Record3D", "NAME.r3d", _ends(".r3d"), "record3d"),
    Capture("Stray Scanner", "rgb.mp4 and depth/", _has("rgb.mp4", "depth", "camera_matrix.csv"), "stray"),
    Capture("ScanNet", "NAME.sens", _ends(".sens"), "scannet"),
    Capture("Replica", "results/frame*.jpg and depth*.png", _is_replica, "replica"),
    Capture("Redwood, Open3D", "color/ and depth/", _has("color", "depth"), "folders"),
    Capture("folders", "rgb/ and depth/ of equal names", _has("rgb", "depth"), "folders"),
)
