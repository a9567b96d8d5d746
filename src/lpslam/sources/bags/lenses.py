"""`CameraInfo` of both ROS generations as a pinhole camera.

The fields: https://docs.ros.org/en/api/sensor_msgs/html/msg/CameraInfo.html
"""

import logging
from typing import Any

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.sources.registering.lens_fit import WORTH_SAYING, five_of

logger = logging.getLogger(__name__)

MILLIMETRES = 1000.0


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
    model = str(info.distortion_model).strip().lower()
    five, off = five_of(model, d, (width, height), matrix, topic)
    if off > WORTH_SAYING:
        logger.warning("%s: the lens model %s is used as k1, k2, p1, p2, k3, off by %.2f pixels", topic, model, off)
    return PinholeCamera(width, height, *matrix, five, depth_scale)


def _numbers(info: Any, name: str) -> list[float]:
    value = getattr(info, name, None)
    if value is None:
        value = getattr(info, name.upper(), None)
    try:
        numbers = [float(number) for number in (() if value is None else value)]
    except (TypeError, ValueError, OverflowError):
        return []
    return numbers if np.isfinite(numbers).all() else []
