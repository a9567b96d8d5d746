"""Folders in the layout of Microsoft 7-Scenes: frame-NNNNNN.color.*, .depth.png and .pose.txt."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.config import PairingConfig
from lpslam.errors import UserError
from lpslam.regular_files import text_of
from lpslam.sources.calibration import Calibration, read_calibration
from lpslam.sources.captures.stated import calibration_among
from lpslam.sources.image_pairs import ImagePair, ImagePairSource, first_image_size, in_depth_pauses
from lpslam.sources.inside import PictureFile

FRAMES_PER_SECOND = 30.0
_DEPTH_SCALE = 1000.0
_INTRINSICS = "camera-intrinsics.txt"
_COLOUR = re.compile(r"frame-(\d+)\.color\.(?:jpe?g|png)", re.IGNORECASE)


def looks_like_seven_scenes(folder: Path) -> bool:
    """Whether the folder has at least one image named as 7-Scenes names them."""
    return any(_COLOUR.fullmatch(path.name) for path in folder.glob("frame-*"))


def open_seven_scenes(
    folder: Path,
    camera_file: Path | None = None,
    max_frames: int | None = None,
    *,
    nominal: bool = False,
    pairing: PairingConfig | None = None,
) -> ImagePairSource:
    """Open a 7-Scenes folder; its frames carry no times, so frame n is taken at n / 30 s.

    Args:
        folder: holds the images.
        camera_file: a calibration to use instead of the folder's own.
        max_frames: use only so many frames, from the first.
        nominal: depth may have another size than colour; a calibration is always known.
        pairing: how long depth may stay away before frames come without.

    Raises:
        UserError: there are no images, or the calibration is malformed.
    """
    pairs: list[ImagePair] = []
    for path in sorted(folder.glob("frame-*")):
        match = _COLOUR.fullmatch(path.name)
        if match is None:
            continue
        depth = path.with_name(f"frame-{match[1]}.depth.png")
        fault = "" if depth.is_file() else f"{path.name} has no {depth.name}"
        pairs.append(ImagePair(int(match[1]) / FRAMES_PER_SECOND, path, depth, fault))
    times = np.array([pair.timestamp for pair in pairs])
    with_depth = np.sort([pair.timestamp for pair in pairs if not pair.fault])
    pauses = in_depth_pauses(times, with_depth, (pairing or PairingConfig()).pause_s)
    pairs = [
        replace(pair, depth=None, fault="") if is_pause else pair for pair, is_pause in zip(pairs, pauses, strict=True)
    ]
    if not pairs:
        raise UserError(f"{folder}: no frame-NNNNNN.color.jpg or .png is there")
    calibration = _find_calibration(folder, camera_file, [pair.colour for pair in pairs])
    return ImagePairSource(
        folder.resolve().name,
        calibration.camera,
        pairs,
        notes=calibration.notes,
        displacement=calibration.displacement,
        may_displace=nominal,
        is_scale_assumed=calibration.is_scale_assumed,
        max_frames=max_frames,
    )


def _find_calibration(folder: Path, camera_file: Path | None, colours: list[PictureFile]) -> Calibration:
    size = first_image_size(colours)
    if camera_file is not None:
        return read_calibration(camera_file, image_size=size, default_depth_scale=_DEPTH_SCALE)
    width, height = size or (640, 480)
    path = folder / _INTRINSICS
    if not path.is_file():
        others = [each for each in sorted(folder.iterdir()) if each.is_file() and not each.name.startswith("frame-")]
        found = calibration_among(folder, others, size, _DEPTH_SCALE)
        if found is not None:
            return found
        camera = PinholeCamera(width, height, 585.0, 585.0, 320.0, 240.0, depth_scale=_DEPTH_SCALE)
        return Calibration(camera, (f"no {_INTRINSICS}: the focal length 585 of 7-Scenes is used",))
    try:
        words = text_of(path).split()
        matrix = np.array([float(word) for word in words], dtype=np.float64).reshape(3, 3)
    except ValueError as error:
        raise UserError(f"{path}: expected the nine numbers of a 3×3 intrinsic matrix") from error
    fx, fy, cx, cy = (float(matrix[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    try:
        return Calibration(PinholeCamera(width, height, fx, fy, cx, cy, depth_scale=_DEPTH_SCALE), ())
    except UserError as error:
        raise UserError(f"{path}: {error}") from error
