"""Pose-only robust optimisation (motion-only bundle adjustment; ORB-SLAM2, III-C).

Residuals and their weights are those of `reprojection.py`, against points held fixed.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import logarithm, move, multiply
from lpslam.slam.kernels.linear import solve_positive
from lpslam.slam.kernels.rays import RaySights, add_ray_terms, judge_rays
from lpslam.slam.kernels.relative import CHI2_POSE, pose_chi2
from lpslam.slam.kernels.reprojection import (
    CHI2_DEPTH,
    CHI2_PIXEL,
    MIN_DEPTH,
    add_pose_terms,
    errors,
    in_camera_terms,
    robust_cost,
)


class PosePrior(NamedTuple):
    """What something else than points tells of a pose.

    Attributes:
        world_from_camera: (4, 4) inverse of the pose that it tells.
        information: (6, 6) of a twist (translation, rotation vector) in the camera frame; all 0 where nothing tells it.
    """

    world_from_camera: NDArray[np.float64]
    information: NDArray[np.float64]


def no_prior() -> PosePrior:
    """Nothing but points tells the pose."""
    return PosePrior(np.eye(4), np.zeros((6, 6)))


@njit(cache=True, nogil=True)
def prior_chi2(camera_from_world: NDArray[np.float64], prior: PosePrior) -> float:
    """χ² (six degrees of freedom) by which a pose (4×4) is not what a prior tells."""
    return pose_chi2(logarithm(multiply(camera_from_world, prior.world_from_camera)), prior.information)


@njit(cache=True, nogil=True)
def _add_prior(
    pose: NDArray[np.float64], prior: PosePrior, hessian: NDArray[np.float64], gradient: NDArray[np.float64]
) -> float:
    """Add a prior to the normal equations (6, 6), (6,) of a twist from the left; its cost by Huber's kernel."""
    error = logarithm(multiply(pose, prior.world_from_camera))
    chi2 = pose_chi2(error, prior.information)
    weight = 1.0 if chi2 <= CHI2_POSE else math.sqrt(CHI2_POSE / chi2)
    for a in range(6):
        for b in range(6):
            gradient[a] -= weight * prior.information[a, b] * error[b]
            if b >= a:
                hessian[a, b] += weight * prior.information[a, b]
    return robust_cost(chi2, CHI2_POSE)


@njit(cache=True, nogil=True, fastmath={"contract"})
def optimise_pose(
    camera_from_world: NDArray[np.float64],
    points: NDArray[np.float64],
    pixels: NDArray[np.float32],
    disparity: NDArray[np.float32],
    has_depth: NDArray[np.bool_],
    pixel_information: NDArray[np.float32],
    disparity_information: NDArray[np.float32],
    rays: RaySights,
    prior: PosePrior,
    intrinsics: NDArray[np.float64],
    rounds: int,
    iterations: int,
) -> tuple[NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_], NDArray[np.float64]]:
    """Camera pose that minimises the robust reprojection error of fixed points.

    Rounds of Gauss-Newton, each from the pose that the last one found and judging outliers anew; the last round runs
    without the robust kernel. A reading of depth is judged apart from its pixel: on an edge the one is wrong and the
    other right.

    Args:
        camera_from_world: 4×4 first guess.
        points: (n, 3) world frame.
        pixels: (n, 2) observed u, v.
        disparity: (n,) observed u − u_r, pixels.
        has_depth: (n,) which disparities exist.
        pixel_information, disparity_information: (n,) 1/σ², per pixel².
        rays: points whose distance is not known.
        prior: what else tells the pose.
        intrinsics: (fx, fy, cx, cy, b·fx).
        rounds, iterations: rounds of outlier judgement, and Gauss-Newton steps at most in each.

    Returns:
        The 4×4 pose, which observations are inliers (n,), which depths among them agree (n,), which rays do (m,), and
        the 6×6 information matrix of the pose (translation, rotation; left perturbation in the camera frame).
    """
    n = points.shape[0]
    pose = camera_from_world.copy()
    inlier = np.ones(n, np.bool_)
    depth_inlier = has_depth.copy()
    ray_inlier = np.ones(len(rays.inverse), np.bool_)
    hessians, gradients, damped = np.zeros((1, 6, 6)), np.zeros((1, 6)), np.empty((6, 6))
    hessian, gradient = hessians[0], gradients[0]
    is_told = bool(np.any(prior.information))
    for turn in range(rounds):
        pixel_gate, depth_gate = (CHI2_PIXEL, CHI2_DEPTH) if turn < rounds - 1 else (math.inf, math.inf)
        previous = math.inf
        before_step = pose
        for _ in range(iterations):
            hessian[:] = 0.0
            gradient[:] = 0.0
            cost = 0.0
            used = 0
            for i in range(n):
                if not inlier[i]:
                    continue
                p, q, r = points[i, 0], points[i, 1], points[i, 2]
                z = pose[2, 0] * p + pose[2, 1] * q + pose[2, 2] * r + pose[2, 3]
                if z < MIN_DEPTH:
                    continue
                x = pose[0, 0] * p + pose[0, 1] * q + pose[0, 2] * r + pose[0, 3]
                y = pose[1, 0] * p + pose[1, 1] * q + pose[1, 2] * r + pose[1, 3]
                used += 1
                m00, m02, m11, m12, m22, g0, g1, g2, own_cost = in_camera_terms(
                    x, y, z, np.float64(pixels[i, 0]), np.float64(pixels[i, 1]), np.float64(disparity[i]),
                    np.float64(pixel_information[i]), disparity_information[i] if depth_inlier[i] else 0.0,
                    pixel_gate, depth_gate, intrinsics,
                )  # fmt: skip
                add_pose_terms(x, y, z, m00, m02, m11, m12, m22, g0, g1, g2, 0, hessians, gradients)
                cost += own_cost
            if used < 3:
                return pose, np.zeros(n, np.bool_), np.zeros(n, np.bool_), np.zeros(len(ray_inlier), np.bool_), hessian
            cost += add_ray_terms(pose, rays, ray_inlier, pixel_gate, intrinsics, hessian, gradient)
            if is_told:
                cost += _add_prior(pose, prior, hessian, gradient)
            for a in range(6):
                for b in range(a):
                    hessian[a, b] = hessian[b, a]
            if cost > previous:
                pose = before_step
                break
            if cost > previous * (1.0 - 1e-5):
                break
            previous = cost
            before_step = pose
            largest = 0.0
            for a in range(6):
                for b in range(a, 6):
                    damped[a, b] = hessian[a, b]
                damped[a, a] += 1e-9 * hessian[a, a] + 1e-9
            if not solve_positive(damped, gradient):
                break
            for a in range(6):
                largest = max(largest, abs(gradient[a]))
            pose = before_step.copy()
            move(pose, gradient)
            if largest < 1e-7:
                break
        for i in range(n):
            p, q, r = points[i, 0], points[i, 1], points[i, 2]
            z = pose[2, 0] * p + pose[2, 1] * q + pose[2, 2] * r + pose[2, 3]
            inlier[i] = depth_inlier[i] = False
            if z >= MIN_DEPTH:
                x = pose[0, 0] * p + pose[0, 1] * q + pose[0, 2] * r + pose[0, 3]
                y = pose[1, 0] * p + pose[1, 1] * q + pose[1, 2] * r + pose[1, 3]
                off, depth_off = errors(
                    x, y, z, np.float64(pixels[i, 0]), np.float64(pixels[i, 1]), np.float64(disparity[i]), intrinsics
                )
                inlier[i] = off * pixel_information[i] <= CHI2_PIXEL
                agrees = depth_off * disparity_information[i] <= CHI2_DEPTH
                depth_inlier[i] = has_depth[i] and inlier[i] and agrees
        judge_rays(pose, rays, intrinsics, ray_inlier)
    return pose, inlier, depth_inlier, ray_inlier, hessian
