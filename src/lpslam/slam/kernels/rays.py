"""Observations of points of which the direction is known and the distance is not (inverse depth; Civera et al. 2008).

A ray starts at the camera that saw it first. Its point is origin + direction / ρ, with ρ the inverse of the depth in
that camera, known as a mean and a sigma; ρ = 0 lies at infinity. What ρ leaves open moves the projection along one
line of the picture, by `sway` pixels a sigma: there an observation says little, and across that line all.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.reprojection import CHI2_PIXEL

LEAST_AHEAD = 0.05
"""Of the length of a direction; a ray that points more aside of the camera than this is not seen."""


class RaySights(NamedTuple):
    """Rays that a camera sees; m rows.

    Attributes:
        origin: (m, 3) world frame, metres.
        direction: (m, 3) world frame, one metre deep in the camera that saw it first.
        inverse, sigma: (m,) 1/m, its inverse depth there and how far that is uncertain.
        pixels: (m, 2) where it is seen now.
        information: (m,) 1/σ² of that, per pixel².
    """

    origin: NDArray[np.float64]
    direction: NDArray[np.float64]
    inverse: NDArray[np.float64]
    sigma: NDArray[np.float64]
    pixels: NDArray[np.float32]
    information: NDArray[np.float32]


NO_RAYS = RaySights(
    np.empty((0, 3)),
    np.empty((0, 3)),
    np.empty(0),
    np.empty(0),
    np.empty((0, 2), np.float32),
    np.empty(0, np.float32),
)


@njit(cache=True, nogil=True, fastmath={"contract"})
def _terms(
    pose: NDArray[np.float64], i: int, rays: RaySights, intrinsics: NDArray[np.float64], point: NDArray[np.float64]
) -> tuple[float, float, float, float, float]:
    """Error u, v and sway u, v of the i-th ray, pixels, and its squared error, whitened; `point` becomes q.

    q = R·direction + ρ (R·origin + t), the point in the camera frame times ρ. The squared error is negative where the
    ray is not seen.
    """
    c = np.empty(3)
    for a in range(3):
        turned = 0.0
        moved = pose[a, 3]
        for b in range(3):
            turned += pose[a, b] * rays.direction[i, b]
            moved += pose[a, b] * rays.origin[i, b]
        c[a] = moved
        point[a] = turned + rays.inverse[i] * moved
    if point[2] < LEAST_AHEAD:
        return 0.0, 0.0, 0.0, 0.0, -1.0
    w = 1.0 / point[2]
    x, y = point[0] * w, point[1] * w
    eu = rays.pixels[i, 0] - (intrinsics[0] * x + intrinsics[2])
    ev = rays.pixels[i, 1] - (intrinsics[1] * y + intrinsics[3])
    su = rays.sigma[i] * intrinsics[0] * w * (c[0] - x * c[2])
    sv = rays.sigma[i] * intrinsics[1] * w * (c[1] - y * c[2])
    information = rays.information[i]
    along = su * eu + sv * ev
    chi2 = information * (eu * eu + ev * ev - information * along * along / (1.0 + information * (su * su + sv * sv)))
    return eu, ev, su, sv, max(chi2, 0.0)


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_ray_terms(
    pose: NDArray[np.float64],
    rays: RaySights,
    agreeing: NDArray[np.bool_],
    gate: float,
    intrinsics: NDArray[np.float64],
    hessian: NDArray[np.float64],
    gradient: NDArray[np.float64],
) -> float:
    """Add what rays say of a pose to the upper triangle (6, 6) and gradient (6,) of its twist; returns their cost."""
    cost = 0.0
    q = np.empty(3)
    rows = np.empty((2, 6))
    for i in range(len(rays.inverse)):
        if not agreeing[i]:
            continue
        eu, ev, su, sv, chi2 = _terms(pose, i, rays, intrinsics, q)
        if chi2 < 0.0:
            continue
        weight = 1.0
        if chi2 > gate:
            weight = math.sqrt(gate / chi2)
            cost += 2.0 * weight * chi2 - gate
        else:
            cost += chi2
        w = 1.0 / q[2]
        a0, b1 = intrinsics[0] * w, intrinsics[1] * w
        a2, b2 = -a0 * q[0] * w, -b1 * q[1] * w
        rho = rays.inverse[i]
        rows[0, 0], rows[0, 1], rows[0, 2] = rho * a0, 0.0, rho * a2
        rows[0, 3], rows[0, 4], rows[0, 5] = a2 * q[1], a0 * q[2] - a2 * q[0], -a0 * q[1]
        rows[1, 0], rows[1, 1], rows[1, 2] = 0.0, rho * b1, rho * b2
        rows[1, 3], rows[1, 4], rows[1, 5] = b2 * q[1] - b1 * q[2], -b2 * q[0], b1 * q[0]
        information = rays.information[i]
        shared = information * information / (1.0 + information * (su * su + sv * sv))
        wuu, wuv, wvv = information - shared * su * su, -shared * su * sv, information - shared * sv * sv
        for a in range(6):
            left = weight * (rows[0, a] * wuu + rows[1, a] * wuv)
            right = weight * (rows[0, a] * wuv + rows[1, a] * wvv)
            gradient[a] += left * eu + right * ev
            for b in range(a, 6):
                hessian[a, b] += left * rows[0, b] + right * rows[1, b]
    return cost


@njit(cache=True, nogil=True)
def ray_error(pose: NDArray[np.float64], i: int, rays: RaySights, intrinsics: NDArray[np.float64]) -> float:
    """Squared error, whitened, of the i-th ray at a pose; negative where it is not seen."""
    return _terms(pose, i, rays, intrinsics, np.empty(3))[4]


@njit(cache=True, nogil=True)
def judge_rays(
    pose: NDArray[np.float64], rays: RaySights, intrinsics: NDArray[np.float64], agreeing: NDArray[np.bool_]
) -> None:
    """Set which rays (m,) agree with a pose."""
    q = np.empty(3)
    for i in range(len(rays.inverse)):
        chi2 = _terms(pose, i, rays, intrinsics, q)[4]
        agreeing[i] = 0.0 <= chi2 <= CHI2_PIXEL


@njit(cache=True, nogil=True)
def measure_inverse(
    camera_from_anchor: NDArray[np.float64],
    bearing: NDArray[np.float64],
    pixels: NDArray[np.float32],
    information: NDArray[np.float32],
    mean: NDArray[np.float64],
    sigma: NDArray[np.float64],
    intrinsics: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Inverse depths of rays seen a second time, from the priors N(mean, sigma²), 1/m (m,).

    Args:
        camera_from_anchor: (m, 4, 4).
        bearing: (m, 3) in the camera that saw them first, one metre deep.
        pixels: (m, 2) where they are seen now.
        information: (m,) 1/σ² of that and of the first sight together.

    Returns:
        (m,) mean, (m,) sigma, and (m,) squared error, whitened, of what is left.
    """
    m = len(bearing)
    means, sigmas, left = mean.copy(), sigma.copy(), np.full(m, np.inf)
    for i in range(m):
        pose = camera_from_anchor[i]
        turned = np.zeros(3)
        for a in range(3):
            for b in range(3):
                turned[a] += pose[a, b] * bearing[i, b]
        prior = 1.0 / (sigma[i] * sigma[i])
        rho, total, chi2 = mean[i], prior, np.inf
        for _ in range(6):
            z = turned[2] + rho * pose[2, 3]
            if z < LEAST_AHEAD:
                chi2 = np.inf
                break
            x, y = (turned[0] + rho * pose[0, 3]) / z, (turned[1] + rho * pose[1, 3]) / z
            eu = pixels[i, 0] - (intrinsics[0] * x + intrinsics[2])
            ev = pixels[i, 1] - (intrinsics[1] * y + intrinsics[3])
            ju = intrinsics[0] * (pose[0, 3] - x * pose[2, 3]) / z
            jv = intrinsics[1] * (pose[1, 3] - y * pose[2, 3]) / z
            total = prior + information[i] * (ju * ju + jv * jv)
            step = (information[i] * (ju * eu + jv * ev) + prior * (mean[i] - rho)) / total
            chi2 = information[i] * (eu * eu + ev * ev)
            rho += step
            if abs(step) < 1e-5:
                break
        means[i], sigmas[i], left[i] = rho, 1.0 / math.sqrt(total), chi2
    return means, sigmas, left
