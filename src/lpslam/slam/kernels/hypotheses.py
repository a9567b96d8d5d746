"""Poses from a few random sights each, judged by all: what most of a view agrees on (Fischler and Bolles 1981).

Errors count up to the gate of an outlier and no further (MSAC; Torr and Zisserman 2000), each times its weight.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import move
from lpslam.slam.kernels.linear import solve_positive
from lpslam.slam.kernels.rays import RaySights, add_ray_terms, ray_error
from lpslam.slam.kernels.reprojection import (
    CHI2_DEPTH,
    CHI2_PIXEL,
    MIN_DEPTH,
    add_pose_terms,
    errors,
    in_camera_terms,
)


class PointSights(NamedTuple):
    """Points that a camera sees; n rows.

    Attributes:
        points: (n, 3) world frame, metres.
        pixels: (n, 2) where they are seen.
        disparity: (n,) u − u_r, pixels.
        has_depth: (n,) which disparities exist.
        pixel_information, disparity_information: (n,) 1/σ², per pixel².
    """

    points: NDArray[np.float64]
    pixels: NDArray[np.float32]
    disparity: NDArray[np.float32]
    has_depth: NDArray[np.bool_]
    pixel_information: NDArray[np.float32]
    disparity_information: NDArray[np.float32]


@njit(cache=True, nogil=True, fastmath={"contract"})
def truncated_cost(
    pose: NDArray[np.float64],
    near: PointSights,
    rays: RaySights,
    weight: NDArray[np.float64],
    intrinsics: NDArray[np.float64],
    limit: float,
) -> float:
    """Weighted sum of squared errors at a pose (4×4), none above its gate; counts no further once above the limit.

    `weight` (n + m,) is that of the points, then of the rays.
    """
    cost, n = 0.0, len(near.points)
    for i in range(n):
        p, q, r = near.points[i, 0], near.points[i, 1], near.points[i, 2]
        z = pose[2, 0] * p + pose[2, 1] * q + pose[2, 2] * r + pose[2, 3]
        own = CHI2_PIXEL + (CHI2_DEPTH if near.has_depth[i] else 0.0)
        if z >= MIN_DEPTH:
            x = pose[0, 0] * p + pose[0, 1] * q + pose[0, 2] * r + pose[0, 3]
            y = pose[1, 0] * p + pose[1, 1] * q + pose[1, 2] * r + pose[1, 3]
            u, v = np.float64(near.pixels[i, 0]), np.float64(near.pixels[i, 1])
            off, depth_off = errors(x, y, z, u, v, np.float64(near.disparity[i]), intrinsics)
            found = off * near.pixel_information[i]
            if near.has_depth[i]:
                found += min(depth_off * near.disparity_information[i], CHI2_DEPTH)
            own = min(own, found)
        cost += float(weight[i]) * own
        if cost > limit:
            return cost
    for i in range(len(rays.inverse)):
        chi2 = ray_error(pose, i, rays, intrinsics)
        cost += float(weight[n + i]) * (CHI2_PIXEL if chi2 < 0.0 else min(chi2, CHI2_PIXEL))
        if cost > limit:
            return cost
    return cost


@njit(cache=True, nogil=True)
def _drawn(shares: NDArray[np.float64], draws: NDArray[np.float64], chosen: NDArray[np.int64]) -> None:
    """Choose rows by draws in [0, 1) and the running sums of their weights."""
    for k in range(len(chosen)):
        chosen[k] = min(np.searchsorted(shares, draws[k] * shares[-1]), len(shares) - 1)


@njit(cache=True, nogil=True, fastmath={"contract"})
def _pose_of_few(
    guess: NDArray[np.float64],
    near: PointSights,
    rows: NDArray[np.int64],
    rays: RaySights,
    is_ray: NDArray[np.bool_],
    intrinsics: NDArray[np.float64],
    pose: NDArray[np.float64],
) -> bool:
    """Least squares of some points and of all these rays from a guess; whether that led to a pose."""
    hessians, gradients, damped = np.empty((1, 6, 6)), np.empty((1, 6)), np.empty((6, 6))
    hessian, gradient = hessians[0], gradients[0]
    pose[:] = guess
    for _ in range(_STEPS):
        hessian[:] = 0.0
        gradient[:] = 0.0
        for i in rows:
            p, q, r = near.points[i, 0], near.points[i, 1], near.points[i, 2]
            z = pose[2, 0] * p + pose[2, 1] * q + pose[2, 2] * r + pose[2, 3]
            if z < MIN_DEPTH:
                return False
            x = pose[0, 0] * p + pose[0, 1] * q + pose[0, 2] * r + pose[0, 3]
            y = pose[1, 0] * p + pose[1, 1] * q + pose[1, 2] * r + pose[1, 3]
            m00, m02, m11, m12, m22, g0, g1, g2, _ = in_camera_terms(
                x, y, z, np.float64(near.pixels[i, 0]), np.float64(near.pixels[i, 1]), np.float64(near.disparity[i]),
                np.float64(near.pixel_information[i]), near.disparity_information[i] if near.has_depth[i] else 0.0,
                math.inf, math.inf, intrinsics,
            )  # fmt: skip
            add_pose_terms(x, y, z, m00, m02, m11, m12, m22, g0, g1, g2, 0, hessians, gradients)
        add_ray_terms(pose, rays, is_ray, math.inf, intrinsics, hessian, gradient)
        for a in range(6):
            for b in range(a, 6):
                damped[a, b] = hessian[a, b]
            damped[a, a] += _DAMPING * (1.0 + hessian[a, a])
        if not solve_positive(damped, gradient):
            return False
        largest = np.abs(gradient).max()
        if largest > _FARTHEST_STEP:
            return False
        move(pose, gradient)
        if largest < _SMALL_STEP:
            break
    return True


@njit(cache=True, nogil=True, fastmath={"contract"})
def best_hypothesis(
    guess: NDArray[np.float64],
    near: PointSights,
    rays: RaySights,
    weight: NDArray[np.float64],
    intrinsics: NDArray[np.float64],
    draws: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float]:
    """The pose of the least truncated cost among a guess (4×4) and those that three points and three rays lead to.

    The heavier a sight, the likelier it is drawn. No more is tried once a better pose is unlikely to be missed.

    Args:
        guess: 4×4 camera from world.
        near, rays: what is seen, n points and m rays.
        weight: (n + m,).
        intrinsics: (fx, fy, cx, cy, b·fx).
        draws: (k, 6) random numbers in [0, 1); k hypotheses at most.
    """
    n, m = len(near.points), len(rays.inverse)
    point_shares, ray_shares = np.cumsum(weight[:n]), np.cumsum(weight[n:])
    rows, ray_rows = np.empty(_EACH, np.int64), np.empty(min(_EACH, m), np.int64)
    is_ray = np.ones(len(ray_rows), np.bool_)
    best, pose = guess.copy(), np.empty((4, 4))
    least = truncated_cost(guess, near, rays, weight, intrinsics, math.inf)
    most = CHI2_PIXEL * weight.sum() + CHI2_DEPTH * weight[:n][near.has_depth].sum()
    enough = float(len(draws))
    for tried in range(len(draws)):
        if tried >= enough:
            break
        _drawn(point_shares, draws[tried], rows)
        _drawn(ray_shares, draws[tried, _EACH:], ray_rows)
        few = RaySights(
            rays.origin[ray_rows], rays.direction[ray_rows], rays.inverse[ray_rows], rays.sigma[ray_rows],
            rays.pixels[ray_rows], rays.information[ray_rows],
        )  # fmt: skip
        if not _pose_of_few(guess, near, rows, few, is_ray, intrinsics, pose):
            continue
        cost = truncated_cost(pose, near, rays, weight, intrinsics, least)
        if cost < least:
            least = cost
            best[:] = pose
            all_agree = min((1.0 - least / most) ** (_EACH + len(ray_rows)), 1.0 - 1e-9)
            enough = math.log(_MISSED) / math.log(1.0 - all_agree) if all_agree > 1e-9 else math.inf
    return best, least


_EACH = 3
"""Points, and rays, to a hypothesis: three points make a pose, and three rays say how it is turned."""

_STEPS = 6
"""Gauss-Newton steps to a hypothesis."""

_SMALL_STEP = 1e-4
"""Metres and radians: no further step is made."""

_FARTHEST_STEP = 1.0
"""Metres and radians of a step: farther off, a hypothesis is of wrong matches."""

_DAMPING = 1e-6
"""Of the hessian: where a few sights leave something open, the guess stays."""

_MISSED = 0.01
"""Chance that every hypothesis had a wrong match in it, at which no more are made."""
