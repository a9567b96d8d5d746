"""Stray Scanner's folders: rgb.mp4, depth/NNNNNN.png in millimetres, confidence/, camera_matrix.csv, odometry.csv.

The layout: https://docs.strayrobots.io/formats/data.html
"""

from pathlib import Path

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.regular_files import text_of
from lpslam.sources.captures.common import enlarged, numbered, rising_times
from lpslam.sources.captures.holders.videos import Video
from lpslam.sources.images import BadImageError, read_depth, read_raw
from lpslam.sources.listed import ListedSource, Picture

_MILLIMETRES = 1000.0
_SURE = 1
"""Of Apple's confidences 0, 1 and 2: below this, readings are guesses."""


def open_capture(folder: Path, camera_file: Path | None, max_frames: int | None, *, nominal: bool) -> ListedSource:
    """Open a scan's folder; its video is decoded in order, and colour keeps its size.

    Raises:
        UserError: the video or the calibration cannot be read.
    """
    video = Video(folder / "rgb.mp4")
    try:
        words = text_of(folder / "camera_matrix.csv").replace(",", " ").split()
        matrix = np.array([float(word) for word in words], np.float64).reshape(3, 3)
    except ValueError as error:
        raise UserError(f"{folder / 'camera_matrix.csv'}: expected the nine numbers of a 3×3 matrix") from error
    width, height = video.size
    fx, fy, cx, cy = (float(matrix[row]) for row in ((0, 0), (1, 1), (0, 2), (1, 2)))
    camera = PinholeCamera(width, height, fx, fy, cx, cy, depth_scale=_MILLIMETRES)
    depths = numbered(folder / "depth", (".png",))
    sure = numbered(folder / "confidence", (".png",)) if (folder / "confidence").is_dir() else {}
    stamps, notes = _stamps(folder / "odometry.csv", min(len(video), len(depths)))

    def decode(number: int) -> Picture:
        rgb = video.picture(number)
        if number not in depths:
            raise BadImageError(f"frame {number} has no depth image")
        depth = read_depth(depths[number], _MILLIMETRES)
        if number in sure:
            confidence = read_raw(sure[number])
            if confidence.shape == depth.shape:
                depth[confidence < _SURE] = 0.0
        return rgb, enlarged(depth, (rgb.shape[1], rgb.shape[0]))

    return ListedSource(folder.resolve().name, camera, stamps, decode, notes=notes, max_frames=max_frames)


def _stamps(path: Path, count: int) -> tuple[list[float], tuple[str, ...]]:
    """Seconds of the frames: the first column of odometry.csv."""
    try:
        lines = text_of(path).splitlines()[1:]
        seconds = [float(line.split(",")[0]) for line in lines if line.strip()]
    except (UserError, ValueError):
        seconds = []
    return rising_times(seconds, count)
