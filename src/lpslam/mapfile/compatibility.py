"""Whether a saved map can be used with another camera than the one that made it."""

from pathlib import Path

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.config import CameraMatchConfig
from lpslam.errors import UserError

# Rays at which two lenses are compared: a grid over the image.
_GRID = 9


def refuse_other_camera(
    map_camera: PinholeCamera,
    source_camera: PinholeCamera,
    map_path: Path | str,
    config: CameraMatchConfig | None = None,
) -> None:
    """Let frames be used with a map only if the same pixel means the same ray in both.

    Depth scale and frame rate may differ: depth is kept in metres, times in seconds.

    Raises:
        UserError: size, focal length, principal point or distortion differ by more than the configuration allows; names
            the first that does, with both values.
    """
    difference = difference_of(map_camera, source_camera, config or CameraMatchConfig())
    if difference:
        raise UserError(f"{map_path} was made with another camera: {difference}; resample its frames (SeenBy)")


def difference_of(ours: PinholeCamera, other: PinholeCamera, config: CameraMatchConfig) -> str:
    """What differs between a map's camera and another, in a few words with both values; empty when nothing does."""
    if (ours.width, ours.height) != (other.width, other.height):
        return f"its images are {ours.width}×{ours.height}, the recording's {other.width}×{other.height}"
    for name in ("fx", "fy"):
        if abs(getattr(other, name) / getattr(ours, name) - 1) > config.focal_share:
            return f"its {name} is {getattr(ours, name):g}, the recording's {getattr(other, name):g}"
    for name in ("cx", "cy"):
        if abs(getattr(other, name) - getattr(ours, name)) > config.centre_pixels:
            return f"its {name} is {getattr(ours, name):g}, the recording's {getattr(other, name):g}"
    apart = _distortion_gap(ours, other)
    if apart > config.distortion_pixels:
        return f"its distortion moves pixels {apart:.1f} px otherwise than the recording's"
    return ""


def _distortion_gap(ours: PinholeCamera, other: PinholeCamera) -> float:
    """Largest distance, pixels, between what two lenses make of the same undistorted pixel of the image.

    Both are given the map camera's matrix: very different coefficients may move pixels alike.
    """
    if ours.distortion == other.distortion:
        return 0.0
    u, v = np.meshgrid(np.linspace(0, ours.width - 1, _GRID), np.linspace(0, ours.height - 1, _GRID))
    pixels = np.column_stack([u.ravel(), v.ravel()])
    alike = PinholeCamera(ours.width, ours.height, ours.fx, ours.fy, ours.cx, ours.cy, other.distortion)
    return float(np.linalg.norm(ours.distort(pixels) - alike.distort(pixels), axis=1).max())
