"""How far an estimated trajectory is from the true one: absolute trajectory error after rigid alignment."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.poses import StampedPoses
from lpslam.timestamps import associate

__all__ = [
    "AteResult",
    "StampedPoses",
    "absolute_trajectory_error",
    "align_poses",
    "align_rigidly",
    "share_tracked",
]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class AteResult:
    """Absolute trajectory error: distances between true and aligned positions.

    Attributes:
        rmse, mean, median, max: metres.
        count: pairs of poses compared.
        truth_from_estimate: 4×4 rigid transform that was applied to the estimate.
        timestamps: (count,) seconds, the estimate's.
        errors: (count,) metres.
    """

    rmse: float
    mean: float
    median: float
    max: float
    count: int
    truth_from_estimate: Array
    timestamps: Array
    errors: Array


def absolute_trajectory_error(truth: StampedPoses, estimate: StampedPoses, tolerance: float = 0.02) -> AteResult:
    """Compare positions after a rigid alignment without scale (Sturm et al., IROS 2012).

    Args:
        truth: the true trajectory.
        estimate: the trajectory to judge, in a world frame of its own.
        tolerance: seconds; poses are paired one to one by nearest time within it.

    Raises:
        UserError: fewer than three poses can be paired, too few to align.
    """
    rows, truth_rows = associate(estimate.timestamps, truth.timestamps, tolerance)
    if len(rows) < 3:
        raise UserError(
            f"only {len(rows)} of {len(estimate)} estimated poses have a true pose within {tolerance * 1000:g} ms; "
            "the trajectory error needs at least 3: check that both use the same clock"
        )
    positions = estimate.positions[rows]
    true_positions = truth.positions[truth_rows]
    truth_from_estimate = align_rigidly(positions, true_positions)
    aligned = positions @ truth_from_estimate[:3, :3].T + truth_from_estimate[:3, 3]
    errors = np.linalg.norm(aligned - true_positions, axis=1)
    return AteResult(
        rmse=float(np.sqrt(np.mean(errors**2))),
        mean=float(errors.mean()),
        median=float(np.median(errors)),
        max=float(errors.max()),
        count=len(errors),
        truth_from_estimate=truth_from_estimate,
        timestamps=estimate.timestamps[rows],
        errors=errors,
    )


def align_rigidly(points: Array, targets: Array) -> Array:
    """Find the rigid motion that takes points nearest to their targets (Umeyama 1991, Eq. 34-43 with scale 1).

    Args:
        points: (n, 3) metres.
        targets: (n, 3) metres, row by row the same points in the other frame.

    Returns:
        The 4×4 target_from_point with the least sum of squared distances.
    """
    centre, target_centre = points.mean(axis=0), targets.mean(axis=0)
    covariance = (targets - target_centre).T @ (points - centre)
    u, _, vt = np.linalg.svd(covariance)
    # A best orthogonal matrix may be a reflection; turning the weakest axis back makes it the best rotation.
    handedness = np.diag([1.0, 1.0, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    target_from_point = np.eye(4)
    target_from_point[:3, :3] = u @ handedness @ vt
    target_from_point[:3, 3] = target_centre - target_from_point[:3, :3] @ centre
    return target_from_point


def align_poses(truth: StampedPoses, estimate: StampedPoses, tolerance: float = 0.02) -> Array:
    """Find the rigid motion that takes poses, positions and directions, nearest to the true ones.

    A camera that only turns has next to no path: its positions do not tell how the two frames are turned to each other,
    and what it saw metres away would be compared at any angle. Each pose stands for points around it.

    Args:
        truth: the true trajectory, of the same camera frame.
        estimate: the trajectory in a world frame of its own.
        tolerance: seconds; poses are paired one to one by nearest time within it.

    Returns:
        The 4×4 truth_from_estimate.
    """
    rows, truth_rows = associate(estimate.timestamps, truth.timestamps, tolerance)
    around, true_around = _around(estimate.world_from_camera[rows]), _around(truth.world_from_camera[truth_rows])
    return align_rigidly(around, true_around)


def _around(world_from_camera: Array) -> Array:
    """(6n, 3) points on either side of each of n poses (n, 4, 4), along the camera's axes."""
    arms = _ARM * np.concatenate([np.eye(3), -np.eye(3)])
    points = np.einsum("nij,kj->nki", world_from_camera[:, :3, :3], arms) + world_from_camera[:, None, :3, 3]
    return np.asarray(points.reshape(-1, 3), np.float64)


_ARM = 1.0
"""Metres: about as far as what is compared lies from the camera."""


def share_tracked(frame_timestamps: Array, estimate: StampedPoses, tolerance: float = 0.02) -> float:
    """Tell which share, 0 to 1, of a sequence's frames has an estimated pose.

    Args:
        frame_timestamps: (n,) seconds, of all frames that could be read.
        estimate: the estimated trajectory.
        tolerance: seconds between a frame and its pose.
    """
    if len(frame_timestamps) == 0:
        return 0.0
    rows, _ = associate(np.asarray(frame_timestamps, dtype=np.float64), estimate.timestamps, tolerance)
    return len(rows) / len(frame_timestamps)
