"""Pose-only robust optimisation (motion-only bundle adjustment; ORB-SLAM2, III-C).

A residual is (u, v, u_r) against a point held fixed. u and u_r share the keypoint's noise, and u − u_r = b·fx / z
carries the depth sensor's alone, so the third component is whitened as the disparity u − u_r with a sigma of its own.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import exponential, orthonormalise

CHI2_PIXEL = 5.991
"""95 % of the χ² distribution with two degrees of freedom."""

CHI2_DEPTH = 3.841
"""95 % of the χ² distribution with one degree of freedom; pixel and depth apart replace 7.815 for the three."""


@njit(cache=True, nogil=True)
def optimise_pose(
    camera_from_world: NDArray[np.float64],
    points: NDArray[np.float64],
    pixels: NDArray[np.float32],
    disparity: NDArray[np.float32],
    has_depth: NDArray[np.bool_],
    pixel_information: NDArray[np.float32],
    disparity_information: NDArray[np.float32],
    intrinsics: NDArray[np.float64],
    rounds: int,
    iterations: int,
) -> tuple[NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], NDArray[np.float64]]:
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
        intrinsics: (fx, fy, cx, cy, b·fx).
        rounds, iterations: rounds of outlier judgement, and Gauss-Newton steps at most in each.

    Returns:
        The 4×4 pose, which observations are inliers (n,), which depths among them agree (n,), and the 6×6 information
        matrix of the pose (translation, rotation; left perturbation in the camera frame).
    """
    n = points.shape[0]
    fx, fy, cx, cy, bf = intrinsics
    pose = camera_from_world.copy()
    inlier = np.ones(n, np.bool_)
    depth_inlier = has_depth.copy()
    hessian = np.zeros((6, 6))
    gradient = np.zeros(6)
    ju, jv, jd = np.zeros(6), np.zeros(6), np.zeros(6)
    for turn in range(rounds):
        robust = turn < rounds - 1
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
                p = points[i]
                x = pose[0, 0] * p[0] + pose[0, 1] * p[1] + pose[0, 2] * p[2] + pose[0, 3]
                y = pose[1, 0] * p[0] + pose[1, 1] * p[1] + pose[1, 2] * p[2] + pose[1, 3]
                z = pose[2, 0] * p[0] + pose[2, 1] * p[1] + pose[2, 2] * p[2] + pose[2, 3]
                if z < 0.05:
                    continue
                used += 1
                w = 1.0 / z
                w2 = w * w
                eu = pixels[i, 0] - (fx * x * w + cx)
                ev = pixels[i, 1] - (fy * y * w + cy)
                weight = np.float64(pixel_information[i])
                chi2 = (eu * eu + ev * ev) * weight
                if robust and chi2 > CHI2_PIXEL:
                    cost += 2.0 * math.sqrt(CHI2_PIXEL * chi2) - CHI2_PIXEL
                    weight *= math.sqrt(CHI2_PIXEL / chi2)
                else:
                    cost += chi2
                ju[0], ju[1], ju[2] = fx * w, 0.0, -fx * x * w2
                ju[3], ju[4], ju[5] = -fx * x * y * w2, fx * (1.0 + x * x * w2), -fx * y * w
                jv[0], jv[1], jv[2] = 0.0, fy * w, -fy * y * w2
                jv[3], jv[4], jv[5] = -fy * (1.0 + y * y * w2), fy * x * y * w2, fy * x * w
                for a in range(6):
                    gradient[a] += weight * (ju[a] * eu + jv[a] * ev)
                    for b in range(a, 6):
                        hessian[a, b] += weight * (ju[a] * ju[b] + jv[a] * jv[b])
                if depth_inlier[i]:
                    ed = disparity[i] - bf * w
                    weight = np.float64(disparity_information[i])
                    chi2 = ed * ed * weight
                    if robust and chi2 > CHI2_DEPTH:
                        cost += 2.0 * math.sqrt(CHI2_DEPTH * chi2) - CHI2_DEPTH
                        weight *= math.sqrt(CHI2_DEPTH / chi2)
                    else:
                        cost += chi2
                    jd[2], jd[3], jd[4] = -bf * w2, -bf * y * w2, bf * x * w2
                    for a in range(2, 5):
                        gradient[a] += weight * jd[a] * ed
                        for b in range(a, 5):
                            hessian[a, b] += weight * jd[a] * jd[b]
            if used < 3:
                return pose, np.zeros(n, np.bool_), np.zeros(n, np.bool_), hessian
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
            damped = hessian.copy()
            for a in range(6):
                damped[a, a] += 1e-9 * hessian[a, a] + 1e-9
            step: NDArray[np.float64] = np.linalg.solve(damped, gradient)  # type: ignore[assignment]
            pose = exponential(step) @ pose
            if np.abs(step).max() < 1e-7:
                break
        orthonormalise(pose)
        _judge(
            pose, points, pixels, disparity, has_depth, pixel_information, disparity_information, intrinsics,
            inlier, depth_inlier,
        )  # fmt: skip
    return pose, inlier, depth_inlier, hessian


@njit(cache=True, nogil=True)
def _judge(
    pose: NDArray[np.float64],
    points: NDArray[np.float64],
    pixels: NDArray[np.float32],
    disparity: NDArray[np.float32],
    has_depth: NDArray[np.bool_],
    pixel_information: NDArray[np.float32],
    disparity_information: NDArray[np.float32],
    intrinsics: NDArray[np.float64],
    inlier: NDArray[np.bool_],
    depth_inlier: NDArray[np.bool_],
) -> None:
    fx, fy, cx, cy, bf = intrinsics
    for i in range(points.shape[0]):
        p = points[i]
        x = pose[0, 0] * p[0] + pose[0, 1] * p[1] + pose[0, 2] * p[2] + pose[0, 3]
        y = pose[1, 0] * p[0] + pose[1, 1] * p[1] + pose[1, 2] * p[2] + pose[1, 3]
        z = pose[2, 0] * p[0] + pose[2, 1] * p[1] + pose[2, 2] * p[2] + pose[2, 3]
        if z < 0.05:
            inlier[i] = False
            depth_inlier[i] = False
            continue
        eu = pixels[i, 0] - (fx * x / z + cx)
        ev = pixels[i, 1] - (fy * y / z + cy)
        inlier[i] = (eu * eu + ev * ev) * pixel_information[i] <= CHI2_PIXEL
        ed = disparity[i] - bf / z
        depth_inlier[i] = has_depth[i] and inlier[i] and ed * ed * disparity_information[i] <= CHI2_DEPTH
