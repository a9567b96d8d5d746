"""Relative poses of two keyframes in a bundle adjustment: what they cost, and their part of the normal equations.

With E = T_b · T_a⁻¹ · M⁻¹, where M is the relative pose that was measured, a twist ξ from the left moves the error
log E by ξ_b − Ad(T_b T_a⁻¹) ξ_a, for small errors.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import logarithm, multiply
from lpslam.slam.kernels.reprojection import robust_cost

CHI2_POSE = 12.592
"""95 % of the χ² distribution with six degrees of freedom."""


class RelativeProblem(NamedTuple):
    """Relative poses by columns.

    Attributes:
        pairs: (t, 2) rows of two keyframes, a and b.
        a_from_b: (t, 4, 4) inverse of what was measured: camera a from camera b.
        information: (t, 6, 6) of a twist (translation, rotation vector) in the frame of camera b.
    """

    pairs: NDArray[np.int32]
    a_from_b: NDArray[np.float64]
    information: NDArray[np.float64]


def no_relative_poses() -> RelativeProblem:
    """None at all."""
    return RelativeProblem(np.empty((0, 2), np.int32), np.empty((0, 4, 4)), np.empty((0, 6, 6)))


@njit(cache=True, nogil=True)
def _relative(poses: NDArray[np.float64], a: int, b: int) -> NDArray[np.float64]:
    """Camera b from camera a (4×4)."""
    inverse = np.zeros((4, 4))
    for i in range(3):
        for j in range(3):
            inverse[i, j] = poses[a, j, i]
            inverse[i, 3] -= poses[a, j, i] * poses[a, j, 3]
    inverse[3, 3] = 1.0
    return multiply(poses[b], inverse)


@njit(cache=True, nogil=True)
def pose_chi2(error: NDArray[np.float64], information: NDArray[np.float64]) -> float:
    """χ² of the error (6,) of a pose under an information (6, 6)."""
    chi2 = 0.0
    for i in range(6):
        for j in range(6):
            chi2 += error[i] * information[i, j] * error[j]
    return max(chi2, 0.0)


@njit(cache=True, nogil=True)
def _misfit(
    relative: RelativeProblem, poses: NDArray[np.float64], t: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Camera b from camera a (4×4) as the poses have it, its error (6,) against the t-th relative pose, and its χ²."""
    b_from_a = _relative(poses, relative.pairs[t, 0], relative.pairs[t, 1])
    error = logarithm(multiply(b_from_a, relative.a_from_b[t]))
    return b_from_a, error, pose_chi2(error, relative.information[t])


@njit(cache=True, nogil=True)
def relative_cost(relative: RelativeProblem, poses: NDArray[np.float64]) -> float:
    """Huber's cost of all relative poses at camera_from_world `poses` (k, 4, 4)."""
    cost = 0.0
    for t in range(relative.pairs.shape[0]):
        _, _, chi2 = _misfit(relative, poses, t)
        cost += robust_cost(chi2, CHI2_POSE)
    return cost


@njit(cache=True, nogil=True)
def adjoint(transform: NDArray[np.float64]) -> NDArray[np.float64]:
    """(6, 6) that takes twists through a rigid 4×4 transform."""
    result = np.zeros((6, 6))
    x, y, z = transform[0, 3], transform[1, 3], transform[2, 3]
    for j in range(3):
        p, q, r = transform[0, j], transform[1, j], transform[2, j]
        for i in range(3):
            result[i, j] = result[3 + i, 3 + j] = transform[i, j]
        result[0, 3 + j], result[1, 3 + j], result[2, 3 + j] = y * r - z * q, z * p - x * r, x * q - y * p
    return result


@njit(cache=True, nogil=True)
def add_relative_terms(
    relative: RelativeProblem,
    poses: NDArray[np.float64],
    block_of: NDArray[np.int32],
    pose_hessian: NDArray[np.float64],
    pose_gradient: NDArray[np.float64],
    pair_hessian: NDArray[np.float64],
) -> None:
    """Add all relative poses to the normal equations of the poses.

    Args:
        relative: the relative poses.
        poses: (k, 4, 4) camera_from_world; the first (free) are adjusted.
        block_of: (free, free) as of `block_pattern`; says how many are free.
        pose_hessian: (free, 6, 6) upper halves, added to.
        pose_gradient: (free, 6) what each pose is drawn by, added to.
        pair_hessian: (t, 6, 6) block of the lower with the higher row, of each; set.
    """
    free = block_of.shape[0]
    for t in range(relative.pairs.shape[0]):
        a, b = int(relative.pairs[t, 0]), int(relative.pairs[t, 1])
        b_from_a, error, chi2 = _misfit(relative, poses, t)
        weight = 1.0 if chi2 <= CHI2_POSE else math.sqrt(CHI2_POSE / chi2)
        information = weight * relative.information[t]
        through = adjoint(b_from_a)
        drawn, crossed = information @ error, information @ through
        if b < free:
            for i in range(6):
                pose_gradient[b, i] -= drawn[i]
                for j in range(i, 6):
                    pose_hessian[b, i, j] += information[i, j]
        if a < free:
            back, own = through.T @ drawn, through.T @ crossed
            for i in range(6):
                pose_gradient[a, i] += back[i]
                for j in range(i, 6):
                    pose_hessian[a, i, j] += own[i, j]
        for i in range(6):
            for j in range(6):
                pair_hessian[t, i, j] = -crossed[i, j] if b < a else -crossed[j, i]


@njit(cache=True, nogil=True)
def add_relative_blocks(
    relative: RelativeProblem,
    block_of: NDArray[np.int32],
    pair_hessian: NDArray[np.float64],
    blocks: NDArray[np.float64],
) -> None:
    """Add the blocks of pairs, as `add_relative_terms` left them, to the reduced system."""
    free = block_of.shape[0]
    for t in range(relative.pairs.shape[0]):
        a, b = np.intp(relative.pairs[t, 0]), np.intp(relative.pairs[t, 1])
        if a < free and b < free:
            blocks[block_of[min(a, b), max(a, b)]] += pair_hessian[t]
