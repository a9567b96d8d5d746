"""How long a camera takes from its first row to its last, from two views taken in different motion."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.kernels.shutter import readout_terms, straighten
from lpslam.slam.sensor import SensorModel

_Matrix = NDArray[np.float64]
_Pixels = NDArray[np.float32]

_SCALES = (400.0, 200.0, 50.0, 20.0, 10.0, 6.0, 6.0)
"""χ² at which an error counts a quarter, step by step: matches may be 15 pixels off before the readout is known."""

_UNIT = 0.01
"""Seconds a unit of the readout in the normal equations, so that all unknowns are of one size."""


@dataclass(frozen=True, slots=True, eq=False)
class Correspondences:
    """The same n points in two views.

    Attributes:
        before, depth, twist_before: (n, 2) undistorted pixels as seen, (n,) metres, and the velocity of the first view.
        after, twist_after: of the second.
        information: (n,) 1/σ² of a pixel of the second.
    """

    before: _Pixels
    depth: NDArray[np.float32]
    twist_before: _Matrix
    after: _Pixels
    twist_after: _Matrix
    information: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Readout:
    """An estimate: seconds, its formal standard deviation, and how many points agree."""

    readout: float
    sigma: float
    agreeing: int


def readout_between(
    seen: Correspondences, after_from_before: _Matrix, readout: float, sensor: SensorModel
) -> Readout | None:
    """Rigid motion and readout that explain both views best, by robust Gauss-Newton; None where they do not settle.

    Args:
        seen: points of both.
        after_from_before: 4×4 first guess.
        readout: seconds, first guess.
        sensor: of the camera.
    """
    height = sensor.image_size[1]
    rows_before = (seen.before[:, 1].astype(np.float64) + 0.5) / height - 0.5
    rows_after = (seen.after[:, 1].astype(np.float64) + 0.5) / height - 0.5
    depth_after = np.zeros(len(seen.after), np.float32)
    chi2, normal = np.empty(len(seen.after)), np.eye(7)
    unit = np.array([1.0] * 6 + [_UNIT])
    for scale in _SCALES:
        pixels, depth = straighten(seen.before, seen.depth, seen.twist_before, readout, height, sensor.intrinsics)
        target, _ = straighten(seen.after, depth_after, seen.twist_after, readout, height, sensor.intrinsics)
        normal, right = readout_terms(
            sensor.back_project(pixels, depth),
            rows_before,
            seen.twist_before,
            target,
            rows_after,
            seen.twist_after,
            after_from_before,
            seen.information,
            scale,
            sensor.intrinsics,
            depth_after,
            chi2,
        )
        normal = (normal + np.triu(normal, 1).T) * np.outer(unit, unit) + np.diag([1e-6] * 6 + [1.0])
        step = np.linalg.solve(normal, right * unit)
        if not np.isfinite(step).all():
            return None
        after_from_before = exponential(step[:6]) @ after_from_before
        readout += _UNIT * float(step[6])
        if abs(readout) > _LONGEST:
            return None
    sigma = _UNIT * float(np.sqrt(np.linalg.inv(normal)[6, 6]))
    return Readout(readout, sigma, int(np.count_nonzero(chi2 < _AGREEING)))


_LONGEST = 0.1
"""Seconds; beyond, the search has run away."""

_AGREEING = 6.0
"""χ² of two degrees of freedom within which 95 % of the points that agree lie."""
