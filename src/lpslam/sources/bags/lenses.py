"""`CameraInfo` of both ROS generations as a pinhole camera.

The fields: https://docs.ros.org/en/api/sensor_msgs/html/msg/CameraInfo.html
"""

import logging
from typing import Any

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.sources.registering.lens_fit import fitted_inverse, fitted_rational

logger = logging.getLogger(__name__)

MILLIMETRES = 1000.0
_REPLACED = 0.5
"""Pixels by which five numbers may differ from a lens model with more, anywhere in the image."""
_NAMES_OF_FIVE = ("plumb_bob", "brown conrady", "modified brown conrady", "")
_NO_PINHOLE = ("equidistant", "fisheye", "kannala", "thin_prism", "omni", "f-theta", "ftheta", "kb4")


def camera_of(info: Any, topic: str, *, is_rectified: bool, depth_scale: float = MILLIMETRES) -> PinholeCamera:
    """The camera that a `CameraInfo` describes.

    Args:
        info: the message; the fields are K, D, P in ROS 1 and k, d, p in ROS 2.
        topic: where it was, for complaints.
        is_rectified: whether its pictures are: then the matrix P holds, and no distortion.
        depth_scale: raw depth units in a metre, passed on.

    Raises:
        UserError: it is not calibrated, or a lens that no pinhole with five numbers can stand for.
    """
    width, height = int(info.width), int(info.height)
    k, p, d = (_numbers(info, name) for name in "kpd")
    matrix = (k[0], k[4], k[2], k[5]) if len(k) == 9 else (0.0, 0.0, 0.0, 0.0)
    if is_rectified and len(p) == 12 and p[0] > 0:
        matrix, d = (p[0], p[5], p[2], p[6]), []
    if not matrix[0] > 0 or width <= 0 or height <= 0:
        raise UserError(f"{topic} is not calibrated (its matrix K is zero); give a calibration with --camera FILE")
    five = _five(str(info.distortion_model).strip().lower(), d, (width, height), matrix, topic)
    return PinholeCamera(width, height, *matrix, five, depth_scale)


def _five(
    model: str, d: list[float], size: tuple[int, int], matrix: tuple[float, float, float, float], topic: str
) -> tuple[float, float, float, float, float]:
    if not any(d):
        return (0.0, 0.0, 0.0, 0.0, 0.0)
    if model.startswith(_NO_PINHOLE):
        raise UserError(
            f"{topic}: the lens model {model} is not a pinhole's; record rectified pictures (image_proc), "
            "or give their calibration with --camera FILE"
        )
    padded = [*d, *[0.0] * 8][: max(len(d), 8)]
    if model == "inverse brown conrady":
        five, off = fitted_inverse(padded, size, matrix)
    elif any(padded[5:8]) and not any(padded[8:]):
        five, off = fitted_rational(padded, size, matrix)
    elif model in _NAMES_OF_FIVE or model == "rational_polynomial":
        five, off = (padded[0], padded[1], padded[2], padded[3], padded[4]), float(any(padded[5:]))
    else:
        raise UserError(f"{topic}: the lens model {model[:40]!r} is not known; record rectified pictures")
    if not off <= _REPLACED:
        raise UserError(
            f"{topic}: k1, k2, p1, p2, k3 cannot stand for the lens model {model[:40]} (off by {off:.2g} pixels); "
            "record rectified pictures (image_proc)"
        )
    if off > 0.01:
        logger.warning("%s: the lens model %s is used as k1, k2, p1, p2, k3, off by %.2f pixels", topic, model, off)
    return five


def _numbers(info: Any, name: str) -> list[float]:
    value = getattr(info, name, None)
    if value is None:
        value = getattr(info, name.upper(), None)
    try:
        numbers = [float(number) for number in (() if value is None else value)]
    except (TypeError, ValueError, OverflowError):
        return []
    return numbers if np.isfinite(numbers).all() else []
