"""Bundle adjustment with the Schur complement: poses and points that agree best with all their observations.

Residuals and weights are those of `pose.py`: (u, v) by the keypoint's sigma, disparity by the depth sensor's, each
under its own Huber kernel. Levenberg-Marquardt; points are eliminated, the reduced camera system is dense.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import exponential, orthonormalise
from lpslam.slam.kernels.pose import CHI2_DEPTH, CHI2_PIXEL


class BundleProblem(NamedTuple):
    """An adjustment problem by columns; the observations of one point are consecutive.

    Attributes:
        camera_from_world: (k, 4, 4); the first `free_count` are adjusted, the rest hold the frame.
        free_count: number of free keyframes.
        points: (p, 3) world frame.
        starts: (p + 1,) where the observations of each point begin.
        keyframe: (o,) row in `camera_from_world`.
        pixels: (o, 2) u, v.
        disparity: (o,) u − u_r.
        has_depth: (o,) which disparities exist.
        pixel_information, disparity_information: (o,) 1/σ².
        observation: (o,) caller's number of each observation.
    """

    camera_from_world: NDArray[np.float64]
    free_count: int
    points: NDArray[np.float64]
    starts: NDArray[np.int64]
    keyframe: NDArray[np.int32]
    pixels: NDArray[np.float32]
    disparity: NDArray[np.float32]
    has_depth: NDArray[np.bool_]
    pixel_information: NDArray[np.float32]
    disparity_information: NDArray[np.float32]
    observation: NDArray[np.int64]


@njit(cache=True, nogil=True)
def _total_cost(
    problem: BundleProblem,
    poses: NDArray[np.float64],
    points: NDArray[np.float64],
    use: NDArray[np.bool_],
    use_depth: NDArray[np.bool_],
    intrinsics: NDArray[np.float64],
) -> float:
    fx, fy, cx, cy, bf = intrinsics
    cost = 0.0
    for j in range(points.shape[0]):
        p = points[j]
        for o in range(problem.starts[j], problem.starts[j + 1]):
            if not use[o]:
                continue
            c = poses[problem.keyframe[o]]
            z = c[2, 0] * p[0] + c[2, 1] * p[1] + c[2, 2] * p[2] + c[2, 3]
            if z < 0.05:
                cost += 1e4
                continue
            x = c[0, 0] * p[0] + c[0, 1] * p[1] + c[0, 2] * p[2] + c[0, 3]
            y = c[1, 0] * p[0] + c[1, 1] * p[1] + c[1, 2] * p[2] + c[1, 3]
            eu = problem.pixels[o, 0] - (fx * x / z + cx)
            ev = problem.pixels[o, 1] - (fy * y / z + cy)
            chi2 = (eu * eu + ev * ev) * problem.pixel_information[o]
            cost += chi2 if chi2 <= CHI2_PIXEL else 2.0 * math.sqrt(CHI2_PIXEL * chi2) - CHI2_PIXEL
            if use_depth[o]:
                ed = problem.disparity[o] - bf / z
                chi2 = ed * ed * problem.disparity_information[o]
                cost += chi2 if chi2 <= CHI2_DEPTH else 2.0 * math.sqrt(CHI2_DEPTH * chi2) - CHI2_DEPTH
    return cost


@njit(cache=True, nogil=True)
def _linearise(
    problem: BundleProblem,
    poses: NDArray[np.float64],
    points: NDArray[np.float64],
    use: NDArray[np.bool_],
    use_depth: NDArray[np.bool_],
    intrinsics: NDArray[np.float64],
    pose_hessian: NDArray[np.float64],
    pose_gradient: NDArray[np.float64],
    point_hessian: NDArray[np.float64],
    point_gradient: NDArray[np.float64],
    cross: NDArray[np.float64],
) -> None:
    """Normal equations in blocks: poses (k, 6, 6), points (p, 3, 3), and pose-point per observation (o, 6, 3)."""
    fx, fy, cx, cy, bf = intrinsics
    pose_hessian[:] = 0.0
    pose_gradient[:] = 0.0
    jacobian_pose = np.zeros((3, 6))
    jacobian_point = np.empty((3, 3))
    error = np.empty(3)
    weights = np.empty(3)
    for j in range(points.shape[0]):
        p = points[j]
        for a in range(3):
            point_gradient[j, a] = 0.0
            for b in range(3):
                point_hessian[j, a, b] = 0.0
        for o in range(problem.starts[j], problem.starts[j + 1]):
            if not use[o]:
                continue
            k = problem.keyframe[o]
            c = poses[k]
            z = c[2, 0] * p[0] + c[2, 1] * p[1] + c[2, 2] * p[2] + c[2, 3]
            if z < 0.05:
                for a in range(6):
                    for b in range(3):
                        cross[o, a, b] = 0.0
                continue
            x = c[0, 0] * p[0] + c[0, 1] * p[1] + c[0, 2] * p[2] + c[0, 3]
            y = c[1, 0] * p[0] + c[1, 1] * p[1] + c[1, 2] * p[2] + c[1, 3]
            w = 1.0 / z
            w2 = w * w
            error[0] = problem.pixels[o, 0] - (fx * x * w + cx)
            error[1] = problem.pixels[o, 1] - (fy * y * w + cy)
            weight = np.float64(problem.pixel_information[o])
            chi2 = (error[0] * error[0] + error[1] * error[1]) * weight
            if chi2 > CHI2_PIXEL:
                weight *= math.sqrt(CHI2_PIXEL / chi2)
            weights[0] = weights[1] = weight
            rows = 2
            if use_depth[o]:
                error[2] = problem.disparity[o] - bf * w
                weight = np.float64(problem.disparity_information[o])
                chi2 = error[2] * error[2] * weight
                if chi2 > CHI2_DEPTH:
                    weight *= math.sqrt(CHI2_DEPTH / chi2)
                weights[2] = weight
                rows = 3
            jacobian_pose[0, 0], jacobian_pose[0, 2] = fx * w, -fx * x * w2
            jacobian_pose[0, 3], jacobian_pose[0, 4] = -fx * x * y * w2, fx * (1.0 + x * x * w2)
            jacobian_pose[0, 5] = -fx * y * w
            jacobian_pose[1, 1], jacobian_pose[1, 2] = fy * w, -fy * y * w2
            jacobian_pose[1, 3], jacobian_pose[1, 4] = -fy * (1.0 + y * y * w2), fy * x * y * w2
            jacobian_pose[1, 5] = fy * x * w
            jacobian_pose[2, 2], jacobian_pose[2, 3], jacobian_pose[2, 4] = -bf * w2, -bf * y * w2, bf * x * w2
            for b in range(3):
                jacobian_point[0, b] = fx * w * c[0, b] - fx * x * w2 * c[2, b]
                jacobian_point[1, b] = fy * w * c[1, b] - fy * y * w2 * c[2, b]
                jacobian_point[2, b] = -bf * w2 * c[2, b]
            for a in range(3):
                for b in range(a, 3):
                    total = 0.0
                    for r in range(rows):
                        total += weights[r] * jacobian_point[r, a] * jacobian_point[r, b]
                    point_hessian[j, a, b] += total
                total = 0.0
                for r in range(rows):
                    total += weights[r] * jacobian_point[r, a] * error[r]
                point_gradient[j, a] += total
            if k < problem.free_count:
                for a in range(6):
                    for b in range(a, 6):
                        total = 0.0
                        for r in range(rows):
                            total += weights[r] * jacobian_pose[r, a] * jacobian_pose[r, b]
                        pose_hessian[k, a, b] += total
                    for b in range(3):
                        total = 0.0
                        for r in range(rows):
                            total += weights[r] * jacobian_pose[r, a] * jacobian_point[r, b]
                        cross[o, a, b] = total
                    total = 0.0
                    for r in range(rows):
                        total += weights[r] * jacobian_pose[r, a] * error[r]
                    pose_gradient[k, a] += total
        for a in range(3):
            for b in range(a):
                point_hessian[j, a, b] = point_hessian[j, b, a]
    for k in range(problem.free_count):
        for a in range(6):
            for b in range(a):
                pose_hessian[k, a, b] = pose_hessian[k, b, a]


@njit(cache=True, nogil=True)
def _invert3(m: NDArray[np.float64], damping: float, out: NDArray[np.float64]) -> bool:
    a, d, f = m[0, 0] * (1 + damping) + 1e-9, m[1, 1] * (1 + damping) + 1e-9, m[2, 2] * (1 + damping) + 1e-9
    b, c, e = m[0, 1], m[0, 2], m[1, 2]
    i00, i01, i02 = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * i00 + b * i01 + c * i02
    if not determinant > 1e-30:
        return False
    s = 1.0 / determinant
    out[0, 0], out[0, 1], out[0, 2] = i00 * s, i01 * s, i02 * s
    out[1, 0], out[1, 1], out[1, 2] = i01 * s, (a * f - c * c) * s, (b * c - a * e) * s
    out[2, 0], out[2, 1], out[2, 2] = i02 * s, out[1, 2], (a * d - b * b) * s
    return True


@njit(cache=True, nogil=True)
def _solve_step(
    problem: BundleProblem,
    use: NDArray[np.bool_],
    damping: float,
    pose_hessian: NDArray[np.float64],
    pose_gradient: NDArray[np.float64],
    point_hessian: NDArray[np.float64],
    point_gradient: NDArray[np.float64],
    cross: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """One damped step: (k, 6) twists and (p, 3) shifts."""
    free = problem.free_count
    points = problem.points.shape[0]
    reduced = np.zeros((6 * free, 6 * free))
    right = pose_gradient[:free].copy().reshape(-1)
    for k in range(free):
        for a in range(6):
            for b in range(6):
                reduced[6 * k + a, 6 * k + b] = pose_hessian[k, a, b]
            reduced[6 * k + a, 6 * k + a] += damping * pose_hessian[k, a, a] + 1e-6
    inverse = np.zeros((points, 3, 3))
    half = np.empty((6, 3))
    for j in range(points):
        if not _invert3(point_hessian[j], damping, inverse[j]):
            continue
        m, g = inverse[j], point_gradient[j]
        for o in range(problem.starts[j], problem.starts[j + 1]):
            k = problem.keyframe[o]
            if not use[o] or k >= free:
                continue
            for a in range(6):
                for b in range(3):
                    half[a, b] = cross[o, a, 0] * m[0, b] + cross[o, a, 1] * m[1, b] + cross[o, a, 2] * m[2, b]
                right[6 * k + a] -= half[a, 0] * g[0] + half[a, 1] * g[1] + half[a, 2] * g[2]
            for q in range(problem.starts[j], problem.starts[j + 1]):
                l = problem.keyframe[q]  # noqa: E741
                if not use[q] or l >= free or l < k:
                    continue
                for a in range(6):
                    for b in range(6):
                        reduced[6 * k + a, 6 * l + b] -= (
                            half[a, 0] * cross[q, b, 0] + half[a, 1] * cross[q, b, 1] + half[a, 2] * cross[q, b, 2]
                        )
    for a in range(6 * free):
        for b in range(a):
            reduced[a, b] = reduced[b, a]
    twists: NDArray[np.float64] = np.linalg.solve(reduced, right).reshape(free, 6)  # type: ignore[assignment]
    shifts = np.zeros((points, 3))
    rest = np.empty(3)
    for j in range(points):
        for a in range(3):
            rest[a] = point_gradient[j, a]
        for o in range(problem.starts[j], problem.starts[j + 1]):
            k = problem.keyframe[o]
            if use[o] and k < free:
                for a in range(3):
                    for b in range(6):
                        rest[a] -= cross[o, b, a] * twists[k, b]
        for a in range(3):
            shifts[j, a] = inverse[j, a, 0] * rest[0] + inverse[j, a, 1] * rest[1] + inverse[j, a, 2] * rest[2]
    return twists, shifts


@njit(cache=True, nogil=True)
def _optimise(
    problem: BundleProblem,
    poses: NDArray[np.float64],
    points: NDArray[np.float64],
    use: NDArray[np.bool_],
    use_depth: NDArray[np.bool_],
    intrinsics: NDArray[np.float64],
    iterations: int,
    stop: NDArray[np.bool_],
) -> None:
    observations = problem.keyframe.shape[0]
    free = problem.free_count
    pose_hessian, pose_gradient = np.empty((free, 6, 6)), np.empty((free, 6))
    point_hessian, point_gradient = np.empty((points.shape[0], 3, 3)), np.empty((points.shape[0], 3))
    cross = np.zeros((observations, 6, 3))
    damping = 1e-5
    cost = _total_cost(problem, poses, points, use, use_depth, intrinsics)
    for _ in range(iterations):
        if stop[0]:
            return
        _linearise(
            problem, poses, points, use, use_depth, intrinsics,
            pose_hessian, pose_gradient, point_hessian, point_gradient, cross,
        )  # fmt: skip
        improved = False
        for _ in range(6):
            twists, shifts = _solve_step(
                problem, use, damping, pose_hessian, pose_gradient, point_hessian, point_gradient, cross
            )
            new_poses = poses.copy()
            for k in range(free):
                new_poses[k] = exponential(twists[k]) @ poses[k]
                orthonormalise(new_poses[k])
            new_points = points + shifts
            new_cost = _total_cost(problem, new_poses, new_points, use, use_depth, intrinsics)
            if new_cost < cost:
                improved = True
                break
            damping *= 10.0
        if not improved:
            return
        converged = cost - new_cost < 1e-3 * cost
        poses[:] = new_poses
        points[:] = new_points
        cost = new_cost
        damping = max(damping * 0.2, 1e-9)
        if converged:
            return


@njit(cache=True, nogil=True)
def _judge(
    problem: BundleProblem,
    poses: NDArray[np.float64],
    points: NDArray[np.float64],
    intrinsics: NDArray[np.float64],
    use: NDArray[np.bool_],
    use_depth: NDArray[np.bool_],
) -> None:
    fx, fy, cx, cy, bf = intrinsics
    for j in range(points.shape[0]):
        p = points[j]
        for o in range(problem.starts[j], problem.starts[j + 1]):
            c = poses[problem.keyframe[o]]
            z = c[2, 0] * p[0] + c[2, 1] * p[1] + c[2, 2] * p[2] + c[2, 3]
            if z < 0.05:
                use[o] = False
                use_depth[o] = False
                continue
            x = c[0, 0] * p[0] + c[0, 1] * p[1] + c[0, 2] * p[2] + c[0, 3]
            y = c[1, 0] * p[0] + c[1, 1] * p[1] + c[1, 2] * p[2] + c[1, 3]
            eu = problem.pixels[o, 0] - (fx * x / z + cx)
            ev = problem.pixels[o, 1] - (fy * y / z + cy)
            use[o] = (eu * eu + ev * ev) * problem.pixel_information[o] <= CHI2_PIXEL
            ed = problem.disparity[o] - bf / z
            agrees = ed * ed * problem.disparity_information[o] <= CHI2_DEPTH
            use_depth[o] = problem.has_depth[o] and use[o] and agrees


@njit(cache=True, nogil=True)
def adjust_bundle(
    problem: BundleProblem,
    intrinsics: NDArray[np.float64],
    first_iterations: int,
    iterations: int,
    stop: NDArray[np.bool_],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Adjust free keyframes and points: a first robust pass, outliers out, a second pass without them.

    Args:
        problem: see `BundleProblem`; it is not changed.
        intrinsics: (fx, fy, cx, cy, b·fx).
        first_iterations, iterations: Levenberg-Marquardt steps of the two passes at most.
        stop: (1,) set to True from another thread to end after the running step.

    Returns:
        camera_from_world (k, 4, 4), points (p, 3) and which observations are inliers (o,).
    """
    poses = problem.camera_from_world.copy()
    points = problem.points.copy()
    use = np.ones(problem.keyframe.shape[0], np.bool_)
    use_depth = problem.has_depth.copy()
    if problem.free_count > 0 and points.shape[0] > 0:
        _optimise(problem, poses, points, use, use_depth, intrinsics, first_iterations, stop)
        _judge(problem, poses, points, intrinsics, use, use_depth)
        if not stop[0] and iterations > 0:
            _optimise(problem, poses, points, use, use_depth, intrinsics, iterations, stop)
            _judge(problem, poses, points, intrinsics, use, use_depth)
    return poses, points, use
