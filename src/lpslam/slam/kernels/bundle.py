"""Bundle adjustment with the Schur complement: poses and points that agree best with all their observations.

Residuals and weights are those of `reprojection.py`. Levenberg-Marquardt; points are eliminated. The reduced system of
the keyframes has a block for each two that share a point: few keyframes are solved for directly, many, where most
blocks are empty, by conjugate gradients.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import move
from lpslam.slam.kernels.reduced_system import (
    block_pattern,
    eliminate_points,
    invert_points,
    moved_points,
    solve_reduced,
)
from lpslam.slam.kernels.relative import (
    RelativeProblem,
    add_relative_blocks,
    add_relative_terms,
    no_relative_poses,
    relative_cost,
)
from lpslam.slam.kernels.reprojection import (
    CHI2_DEPTH,
    CHI2_PIXEL,
    MIN_DEPTH,
    UNSEEN_COST,
    add_pose_terms,
    errors,
    in_camera_terms,
    robust_cost,
)

_DENSE = 150
"""Free keyframes up to which the reduced system is solved directly."""


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


@njit(cache=True, nogil=True, fastmath={"contract"})
def _total_cost(
    measured: NDArray[np.float64],
    keyframe: NDArray[np.int32],
    starts: NDArray[np.int64],
    poses: NDArray[np.float64],
    points: NDArray[np.float64],
    intrinsics: NDArray[np.float64],
) -> float:
    """Robust cost of all observations that count; `measured` is (o, 5): u, v, disparity and the information of each."""
    cost = 0.0
    for j in range(points.shape[0]):
        p, q, r = points[j, 0], points[j, 1], points[j, 2]
        for o in range(starts[j], starts[j + 1]):
            if measured[o, 3] == 0.0:
                continue
            k = keyframe[o]
            z = poses[k, 2, 0] * p + poses[k, 2, 1] * q + poses[k, 2, 2] * r + poses[k, 2, 3]
            if z < MIN_DEPTH:
                cost += UNSEEN_COST
                continue
            x = poses[k, 0, 0] * p + poses[k, 0, 1] * q + poses[k, 0, 2] * r + poses[k, 0, 3]
            y = poses[k, 1, 0] * p + poses[k, 1, 1] * q + poses[k, 1, 2] * r + poses[k, 1, 3]
            off, depth_off = errors(x, y, z, measured[o, 0], measured[o, 1], measured[o, 2], intrinsics)
            cost += robust_cost(off * measured[o, 3], CHI2_PIXEL)
            cost += robust_cost(depth_off * measured[o, 4], CHI2_DEPTH)
    return cost


@njit(cache=True, nogil=True, fastmath={"contract"})
def _linearise(
    measured: NDArray[np.float64],
    keyframe: NDArray[np.int32],
    starts: NDArray[np.int64],
    poses: NDArray[np.float64],
    points: NDArray[np.float64],
    intrinsics: NDArray[np.float64],
    pose_hessian: NDArray[np.float64],
    pose_gradient: NDArray[np.float64],
    point_hessian: NDArray[np.float64],
    point_gradient: NDArray[np.float64],
    cross: NDArray[np.float64],
) -> None:
    """Normal equations in blocks.

    Poses (free, 6, 6), upper half; points (p, 6): 00, 01, 02, 11, 12, 22; point-pose of each observation (o, 3, 6).
    """
    free = pose_gradient.shape[0]
    pose_hessian[:] = 0.0
    pose_gradient[:] = 0.0
    for j in range(points.shape[0]):
        p, q, r = points[j, 0], points[j, 1], points[j, 2]
        h00 = h01 = h02 = h11 = h12 = h22 = b0 = b1 = b2 = 0.0
        for o in range(starts[j], starts[j + 1]):
            if measured[o, 3] == 0.0:
                continue
            k = int(keyframe[o])
            r20, r21, r22 = poses[k, 2, 0], poses[k, 2, 1], poses[k, 2, 2]
            z = r20 * p + r21 * q + r22 * r + poses[k, 2, 3]
            if z < MIN_DEPTH:
                cross[o] = 0.0
                continue
            r00, r01, r02 = poses[k, 0, 0], poses[k, 0, 1], poses[k, 0, 2]
            r10, r11, r12 = poses[k, 1, 0], poses[k, 1, 1], poses[k, 1, 2]
            x = r00 * p + r01 * q + r02 * r + poses[k, 0, 3]
            y = r10 * p + r11 * q + r12 * r + poses[k, 1, 3]
            m00, m02, m11, m12, m22, g0, g1, g2, _ = in_camera_terms(
                x, y, z, measured[o, 0], measured[o, 1], measured[o, 2], measured[o, 3], measured[o, 4],
                CHI2_PIXEL, CHI2_DEPTH, intrinsics,
            )  # fmt: skip
            n00, n01, n02 = m00 * r00 + m02 * r20, m00 * r01 + m02 * r21, m00 * r02 + m02 * r22
            n10, n11, n12 = m11 * r10 + m12 * r20, m11 * r11 + m12 * r21, m11 * r12 + m12 * r22
            n20 = m02 * r00 + m12 * r10 + m22 * r20
            n21 = m02 * r01 + m12 * r11 + m22 * r21
            n22 = m02 * r02 + m12 * r12 + m22 * r22
            h00 += r00 * n00 + r10 * n10 + r20 * n20
            h01 += r00 * n01 + r10 * n11 + r20 * n21
            h02 += r00 * n02 + r10 * n12 + r20 * n22
            h11 += r01 * n01 + r11 * n11 + r21 * n21
            h12 += r01 * n02 + r11 * n12 + r21 * n22
            h22 += r02 * n02 + r12 * n12 + r22 * n22
            b0 += r00 * g0 + r10 * g1 + r20 * g2
            b1 += r01 * g0 + r11 * g1 + r21 * g2
            b2 += r02 * g0 + r12 * g1 + r22 * g2
            if k >= free:
                continue
            cross[o, 0, 0], cross[o, 0, 1], cross[o, 0, 2] = n00, n10, n20
            cross[o, 1, 0], cross[o, 1, 1], cross[o, 1, 2] = n01, n11, n21
            cross[o, 2, 0], cross[o, 2, 1], cross[o, 2, 2] = n02, n12, n22
            cross[o, 0, 3], cross[o, 0, 4], cross[o, 0, 5] = y * n20 - z * n10, z * n00 - x * n20, x * n10 - y * n00
            cross[o, 1, 3], cross[o, 1, 4], cross[o, 1, 5] = y * n21 - z * n11, z * n01 - x * n21, x * n11 - y * n01
            cross[o, 2, 3], cross[o, 2, 4], cross[o, 2, 5] = y * n22 - z * n12, z * n02 - x * n22, x * n12 - y * n02
            add_pose_terms(x, y, z, m00, m02, m11, m12, m22, g0, g1, g2, k, pose_hessian, pose_gradient)
        point_hessian[j, 0], point_hessian[j, 1], point_hessian[j, 2] = h00, h01, h02
        point_hessian[j, 3], point_hessian[j, 4], point_hessian[j, 5] = h11, h12, h22
        point_gradient[j, 0], point_gradient[j, 1], point_gradient[j, 2] = b0, b1, b2


@njit(cache=True, nogil=True, fastmath={"contract"})
def _optimise(
    measured: NDArray[np.float64],
    keyframe: NDArray[np.int32],
    starts: NDArray[np.int64],
    pattern: tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]],
    poses: NDArray[np.float64],
    points: NDArray[np.float64],
    intrinsics: NDArray[np.float64],
    dense: int,
    iterations: int,
    stop: NDArray[np.bool_],
    relative: RelativeProblem,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Levenberg-Marquardt: better poses and points."""
    block_of, rows, columns = pattern
    free, count = block_of.shape[0], points.shape[0]
    pose_hessian, pose_gradient = np.empty((free, 6, 6)), np.empty((free, 6))
    point_hessian, point_gradient, inverse = np.empty((count, 6)), np.empty((count, 3)), np.empty((count, 6))
    cross = np.empty((keyframe.shape[0], 3, 6))
    blocks, right = np.empty((rows.shape[0], 6, 6)), np.empty((free, 6))
    pair_hessian = np.empty((relative.pairs.shape[0], 6, 6))
    damping = 1e-5
    cost = _total_cost(measured, keyframe, starts, poses, points, intrinsics) + relative_cost(relative, poses)
    for _ in range(iterations):
        if stop[0]:
            break
        _linearise(
            measured, keyframe, starts, poses, points, intrinsics,
            pose_hessian, pose_gradient, point_hessian, point_gradient, cross,
        )  # fmt: skip
        add_relative_terms(relative, poses, block_of, pose_hessian, pose_gradient, pair_hessian)
        new_cost, new_poses, new_points = cost, poses, points
        for _ in range(6):
            blocks[:] = 0.0
            for k in range(free):
                block = blocks[block_of[k, k]]
                for a in range(6):
                    right[k, a] = pose_gradient[k, a]
                    for b in range(a, 6):
                        block[a, b] = block[b, a] = pose_hessian[k, a, b]
                    block[a, a] += damping * pose_hessian[k, a, a] + 1e-6
            add_relative_blocks(relative, block_of, pair_hessian, blocks)
            invert_points(point_hessian, damping, inverse)
            eliminate_points(measured, keyframe, starts, inverse, point_gradient, cross, block_of, blocks, right)
            twists = solve_reduced(blocks, rows, columns, right, dense, stop)
            if stop[0]:
                break
            new_poses = poses.copy()
            for k in range(free):
                move(new_poses[k], twists[k])
            new_points = moved_points(measured, keyframe, starts, inverse, point_gradient, cross, twists, points)
            new_cost = _total_cost(measured, keyframe, starts, new_poses, new_points, intrinsics)
            new_cost += relative_cost(relative, new_poses)
            if new_cost < cost:
                break
            damping *= 10.0
        if not new_cost < cost:
            break
        converged = cost - new_cost < 1e-3 * cost
        poses, points, cost = new_poses, new_points, new_cost
        damping = max(damping * 0.2, 1e-9)
        if converged:
            break
    return poses, points


@njit(cache=True, nogil=True, fastmath={"contract"})
def _judge(
    pixel_information: NDArray[np.float32],
    disparity_information: NDArray[np.float32],
    keyframe: NDArray[np.int32],
    starts: NDArray[np.int64],
    poses: NDArray[np.float64],
    points: NDArray[np.float64],
    intrinsics: NDArray[np.float64],
    measured: NDArray[np.float64],
) -> None:
    """Let only those observations count that agree within the gates."""
    for j in range(points.shape[0]):
        p, q, r = points[j, 0], points[j, 1], points[j, 2]
        for o in range(starts[j], starts[j + 1]):
            c = poses[keyframe[o]]
            z = c[2, 0] * p + c[2, 1] * q + c[2, 2] * r + c[2, 3]
            measured[o, 3] = measured[o, 4] = 0.0
            if z < MIN_DEPTH:
                continue
            x = c[0, 0] * p + c[0, 1] * q + c[0, 2] * r + c[0, 3]
            y = c[1, 0] * p + c[1, 1] * q + c[1, 2] * r + c[1, 3]
            off, depth_off = errors(x, y, z, measured[o, 0], measured[o, 1], measured[o, 2], intrinsics)
            if off * pixel_information[o] <= CHI2_PIXEL:
                measured[o, 3] = pixel_information[o]
                if depth_off * disparity_information[o] <= CHI2_DEPTH:
                    measured[o, 4] = disparity_information[o]


def adjust_bundle(
    problem: BundleProblem,
    intrinsics: NDArray[np.float64],
    first_iterations: int,
    iterations: int,
    stop: NDArray[np.bool_],
    dense: int = _DENSE,
    relative: RelativeProblem | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Adjust free keyframes and points: a first robust pass, outliers out, a second pass without them.

    Args:
        problem: see `BundleProblem`; it is not changed.
        intrinsics: (fx, fy, cx, cy, b·fx).
        first_iterations, iterations: Levenberg-Marquardt steps of the two passes at most.
        stop: (1,) set to True from another thread to end within the running step.
        dense: free keyframes up to which the reduced system is solved directly.
        relative: relative poses of the problem's keyframes that something else than points tells.

    Returns:
        camera_from_world (k, 4, 4), points (p, 3) and which observations are inliers (o,).
    """
    poses, points = problem.camera_from_world.copy(), problem.points.copy()
    relative = no_relative_poses() if relative is None else relative
    keyframe, starts = problem.keyframe, problem.starts
    disparity_information = np.where(problem.has_depth, problem.disparity_information, np.float32(0.0))
    disparity = np.where(problem.has_depth, problem.disparity, 0.0)
    measured = np.empty((len(keyframe), 5))
    measured[:, :2], measured[:, 2] = problem.pixels, disparity
    measured[:, 3], measured[:, 4] = problem.pixel_information, disparity_information
    if problem.free_count > 0 and len(points):
        pattern = block_pattern(keyframe, starts, problem.free_count, relative.pairs)
        for steps in (first_iterations, iterations) if iterations > 0 else (first_iterations,):
            poses, points = _optimise(
                measured, keyframe, starts, pattern, poses, points, intrinsics, dense, steps, stop, relative
            )
            _judge(
                problem.pixel_information, disparity_information, keyframe, starts, poses, points, intrinsics, measured
            )
            if stop[0]:
                break
    return poses, points, measured[:, 3] > 0.0
