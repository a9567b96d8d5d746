"""A TUM RGB-D folder in the making: what is known beforehand, pictures as they come, and the lists of them at last."""

import json
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.simulation.signs import Sign


class Recording:
    """The folder: `rgb/`, `depth/`, `rgb.txt`, `depth.txt` and what is described.

    Args:
        folder: created if need be.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._listed: dict[str, list[str]] = {"rgb": [], "depth": []}
        for name in self._listed:
            (folder / name).mkdir(parents=True, exist_ok=True)

    def describe(self, camera: PinholeCamera, signs: Sequence[Sign]) -> None:
        """Write `camera.yaml` and `signs.json`."""
        text = yaml.safe_dump(camera_fields(camera), sort_keys=False)
        (self.folder / "camera.yaml").write_text(text, encoding="utf-8")
        self.write_json("signs.json", {"signs": [sign.as_json() for sign in signs]})

    def write_json(self, name: str, tree: dict[str, Any]) -> None:
        """A file of JSON that people can read."""
        (self.folder / name).write_text(json.dumps(tree, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")

    def add(self, name: str, timestamp: float, data: bytes, kind: str = "png") -> None:
        """Keep a picture, compressed, of `rgb` or `depth`."""
        file = f"{name}/{timestamp:.6f}.{kind}"
        (self.folder / file).write_bytes(data)
        self._listed[name].append(f"{timestamp:.6f} {file}")

    def write_lists(self) -> None:
        """Write `rgb.txt` and then `depth.txt`: a folder with that is whole."""
        for name, entries in self._listed.items():
            write_list(self.folder / f"{name}.txt", "timestamp filename", entries)


@contextmanager
def recorded(folder: Path, what: str) -> Iterator[Recording]:
    """A recording whose lists are written at the end; a new folder that does not become whole is removed.

    Args:
        folder: created if need be.
        what: is recorded, for the complaint.

    Raises:
        UserError: the folder cannot be written.
    """
    is_new = not folder.exists()
    try:
        recording = Recording(folder)
        yield recording
        recording.write_lists()
    except BaseException as error:
        if is_new:
            # Two folders of pictures look like a recording to whoever opens them.
            shutil.rmtree(folder, ignore_errors=True)
        if not isinstance(error, OSError):
            raise
        raise UserError(f"{what}: {folder} cannot be written ({error.strerror}); choose another folder") from error


def as_png(picture: NDArray[np.generic]) -> bytes:
    """A picture, compressed: runs of the same, without a level, take half the time of level 1, and no more room."""
    return bytes(cv2.imencode(".png", np.asarray(picture))[1].tobytes())


def write_list(path: Path, header: str, lines: list[str]) -> None:
    """A text file with a heading."""
    path.write_text("\n".join([f"# {header}", *lines]) + "\n", encoding="utf-8")


def camera_fields(camera: PinholeCamera) -> dict[str, float | int | list[float]]:
    """A calibration as camera.yaml holds it."""
    return {
        "width": camera.width,
        "height": camera.height,
        "fx": camera.fx,
        "fy": camera.fy,
        "cx": camera.cx,
        "cy": camera.cy,
        "distortion": list(camera.distortion),
        "depth_scale": camera.depth_scale,
        "fps": camera.fps,
    }
