"""One observation of a point: how far off it is, and what it says of the pose and the point.

A residual is (u, v, u_r). u and u_r share the keypoint's noise, and u − u_r = b·fx / z carries the depth sensor's
alone, so the third component is whitened as the disparity u − u_r, with a sigma and a Huber kernel of its own.

Kernels of least squares may fuse a product and a sum into one instruction ("contract"): a third less time.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

CHI2_PIXEL = 5.991
"""95 % of the χ² distribution with two degrees of freedom."""

CHI2_DEPTH = 3.841
"""95 % of the χ² distribution with one degree of freedom; pixel and depth apart replace 7.815 for the three."""

MIN_DEPTH = 0.05
"""Metres; a point nearer than this, or behind the camera, is not seen."""

UNSEEN_COST = 1e4
"""Cost of an observation whose point is not before the camera."""


@njit(cache=True, nogil=True, fastmath={"contract"})
def errors(
    x: float, y: float, z: float, u: float, v: float, disparity: float, intrinsics: NDArray[np.float64]
) -> tuple[float, float]:
    """Squared errors, in pixels², of a pixel and a disparity at a point (x, y, z) of the camera frame."""
    w = 1.0 / z
    eu = u - (intrinsics[0] * x * w + intrinsics[2])
    ev = v - (intrinsics[1] * y * w + intrinsics[3])
    ed = disparity - intrinsics[4] * w
    return eu * eu + ev * ev, ed * ed


@njit(cache=True, nogil=True, fastmath={"contract"})
def robust_cost(chi2: float, gate: float) -> float:
    """Huber's cost of a whitened squared error: linear beyond the gate."""
    return chi2 if chi2 <= gate else 2.0 * math.sqrt(gate * chi2) - gate


@njit(cache=True, nogil=True, fastmath={"contract"})
def in_camera_terms(
    x: float,
    y: float,
    z: float,
    u: float,
    v: float,
    disparity: float,
    pixel_information: float,
    disparity_information: float,
    pixel_gate: float,
    depth_gate: float,
    intrinsics: NDArray[np.float64],
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Normal equations of one observation for the point (x, y, z) in the camera frame, and its robust cost.

    Every Jacobian is that of the point in the camera frame times a simple one: M = AᵀWA and g = AᵀWe are all that the
    measurement has to say.

    Args:
        x, y, z: the point in the camera frame, metres.
        u, v, disparity: what was measured, pixels.
        pixel_information, disparity_information: 1/σ²; 0 leaves the one or the other out.
        pixel_gate, depth_gate: χ² from which on an error counts linearly.
        intrinsics: (fx, fy, cx, cy, b·fx).

    Returns:
        M00, M02, M11, M12, M22 (M01 is 0), g0, g1, g2 and the cost.
    """
    w = 1.0 / z
    a0, b1 = intrinsics[0] * w, intrinsics[1] * w
    eu = u - (a0 * x + intrinsics[2])
    ev = v - (b1 * y + intrinsics[3])
    a2, b2 = -a0 * x * w, -b1 * y * w
    weight = pixel_information
    chi2 = (eu * eu + ev * ev) * weight
    cost = chi2
    if chi2 > pixel_gate:
        root = math.sqrt(pixel_gate / chi2)
        cost = 2.0 * root * chi2 - pixel_gate
        weight *= root
    m00, m11, m02, m12 = weight * a0 * a0, weight * b1 * b1, weight * a0 * a2, weight * b1 * b2
    m22 = weight * (a2 * a2 + b2 * b2)
    g0, g1, g2 = weight * a0 * eu, weight * b1 * ev, weight * (a2 * eu + b2 * ev)
    if disparity_information > 0.0:
        d = intrinsics[4] * w
        ed = disparity - d
        weight = disparity_information
        chi2 = ed * ed * weight
        if chi2 > depth_gate:
            root = math.sqrt(depth_gate / chi2)
            cost += 2.0 * root * chi2 - depth_gate
            weight *= root
        else:
            cost += chi2
        d2 = -d * w
        m22 += weight * d2 * d2
        g2 += weight * d2 * ed
    return m00, m02, m11, m12, m22, g0, g1, g2, cost


@njit(cache=True, nogil=True, fastmath={"contract"})
def add_pose_terms(
    x: float,
    y: float,
    z: float,
    m00: float,
    m02: float,
    m11: float,
    m12: float,
    m22: float,
    g0: float,
    g1: float,
    g2: float,
    k: int,
    hessian: NDArray[np.float64],
    gradient: NDArray[np.float64],
) -> None:
    """Add an observation to the upper triangles (n, 6, 6) and gradients (n, 6) of twists, at the k-th pose."""
    k00, k01, k02 = y * m02, z * m00 - x * m02, -y * m00
    k10, k11, k12 = y * m12 - z * m11, -x * m12, x * m11
    k20, k21, k22 = y * m22 - z * m12, z * m02 - x * m22, x * m12 - y * m02
    hessian[k, 0, 0] += m00
    hessian[k, 0, 2] += m02
    hessian[k, 0, 3] += k00
    hessian[k, 0, 4] += k01
    hessian[k, 0, 5] += k02
    hessian[k, 1, 1] += m11
    hessian[k, 1, 2] += m12
    hessian[k, 1, 3] += k10
    hessian[k, 1, 4] += k11
    hessian[k, 1, 5] += k12
    hessian[k, 2, 2] += m22
    hessian[k, 2, 3] += k20
    hessian[k, 2, 4] += k21
    hessian[k, 2, 5] += k22
    hessian[k, 3, 3] += y * k20 - z * k10
    hessian[k, 3, 4] += y * k21 - z * k11
    hessian[k, 3, 5] += y * k22 - z * k12
    hessian[k, 4, 4] += z * k01 - x * k21
    hessian[k, 4, 5] += z * k02 - x * k22
    hessian[k, 5, 5] += x * k12 - y * k02
    gradient[k, 0] += g0
    gradient[k, 1] += g1
    gradient[k, 2] += g2
    gradient[k, 3] += y * g2 - z * g1
    gradient[k, 4] += z * g0 - x * g2
    gradient[k, 5] += x * g1 - y * g0
