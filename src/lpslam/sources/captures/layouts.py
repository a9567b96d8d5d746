"""The layouts of phones and data sets: how each is known. Their readers are loaded when one is opened."""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lpslam.config import PairingConfig
from lpslam.errors import UserError


@dataclass(frozen=True, slots=True)
class Capture:
    """A layout.

    Attributes:
        name: as people call it.
        sign: what is in the path.
        is_at: whether it is there.
        module: the reader's module in this room, which has `open_capture`.
        takes_camera: whether a calibration may be given; else the recording's own is bound to its pictures.
        is_paired: whether its reader pairs colour and depth by their times; else these come in pairs.
    """

    name: str
    sign: str
    is_at: Callable[[Path], bool]
    module: str
    takes_camera: bool = False
    is_paired: bool = False

    def open(
        self,
        folder: Path,
        camera_file: Path | None,
        max_frames: int | None,
        *,
        nominal: bool,
        pairing: PairingConfig | None = None,
    ) -> Any:
        """Open the recording with the layout's reader."""
        if camera_file is not None and not self.takes_camera:
            raise UserError(f"{folder} has its own calibration ({self.name}); leave --camera out")
        reader = importlib.import_module(f"lpslam.sources.captures.{self.module}")
        by_time = {"pairing": pairing} if self.is_paired else {}
        return reader.open_capture(folder, camera_file, max_frames, nominal=nominal, **by_time)


_ARRAYS = (".npz", ".h5", ".hdf5", ".mat")


def _has(*names: str) -> Callable[[Path], bool]:
    """Files by names with an ending, folders by those with a slash."""
    return lambda path: (
        path.is_dir()
        and all((path / name).is_dir() if name.endswith("/") else (path / name).is_file() for name in names)
    )


def _ends(suffix: str) -> Callable[[Path], bool]:
    return lambda path: path.is_file() and path.suffix.lower() == suffix


def _is_replica(path: Path) -> bool:
    return path.is_dir() and any((path / "results").glob("frame*.jpg")) and any((path / "results").glob("depth*.png"))


def _holds_pictures(path: Path) -> bool:
    reader = importlib.import_module("lpslam.sources.captures.folders")
    return (path.is_dir() or path.suffix.lower() in _ARRAYS) and bool(reader.holds_pictures(path))


CAPTURES = (
    Capture("Record3D", "NAME.r3d", _ends(".r3d"), "record3d"),
    Capture("Stray Scanner", "rgb.mp4 and depth/", _has("rgb.mp4", "depth/", "camera_matrix.csv"), "stray"),
    Capture("Azure Kinect", "NAME.mkv", _ends(".mkv"), "azure"),
    Capture("ScanNet", "NAME.sens", _ends(".sens"), "scannet"),
    Capture("Replica", "results/frame*.jpg and depth*.png", _is_replica, "replica", True),
    Capture("Redwood, Open3D", "color/ and depth/", _has("color/", "depth/"), "folders", True, True),
    Capture(
        "folders", "pictures of colour and of depth, videos, .npz, .h5, .mat", _holds_pictures, "folders", True, True
    ),
)
