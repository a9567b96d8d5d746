"""The depth scale, where the true path of the camera is known: nothing else in a recording tells metres."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.poses import StampedPoses
from lpslam.timestamps import associate

Array = NDArray[np.float64]

_TOLERANCE = 0.02
"""Seconds between a view and its true pose."""


@dataclass(frozen=True, slots=True)
class TrueScale:
    """True metres in a metre of depth: the ratio, and its standard deviation."""

    ratio: float
    sigma: float


def true_scale(timestamps: Array, camera_from_world: Array, truth: StampedPoses) -> TrueScale | None:
    """Compare the path that follows from depth with the true one (Umeyama 1991, Eq. 42).

    Args:
        timestamps: (v,) seconds.
        camera_from_world: (v, 4, 4), estimated with depth as it was read.
        truth: the true path.

    Returns:
        None where fewer than four views have a true pose.
    """
    rows, true_rows = associate(timestamps, truth.timestamps, _TOLERANCE)
    if len(rows) < 4:
        return None
    ours = np.array([inverse_transform(camera_from_world[row])[:3, 3] for row in rows])
    true = truth.positions[true_rows]
    a, b = ours - ours.mean(axis=0), true - true.mean(axis=0)
    u, stretch, vt = np.linalg.svd(b.T @ a)
    handedness = np.array([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    spread = float((a**2).sum())
    if spread <= 0:
        return None
    ratio = float((stretch * handedness).sum() / spread)
    left = b - ratio * a @ (u * handedness @ vt).T
    # Seven numbers were fitted: turn, shift and scale.
    variance = float((left**2).sum() / max(3 * len(rows) - 7, 1))
    return TrueScale(ratio, float(np.sqrt(variance / spread)))
