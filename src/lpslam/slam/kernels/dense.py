"""Direct alignment of two small RGB-D images: brightness and depth of every pixel (Steinbrücker 2011; Kerl 2013)."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import exponential, logarithm, multiply
from lpslam.slam.kernels.linear import solve_positive
from lpslam.slam.kernels.reprojection import MIN_DEPTH

_HUBER = 1.5
"""Sigmas from which on a residual counts linearly."""

_AGREES = 3.0
"""Sigmas within which a reading of depth agrees with a pose."""

_ONE = np.uint64(1)


@njit(cache=True, nogil=True, inline="always")
def _weight(residual: float, certainty: float) -> float:
    """Huber's, of a residual with 1/σ."""
    size = abs(residual) * certainty
    return (1.0 if size < _HUBER else _HUBER / size) * certainty * certainty


@njit(cache=True, nogil=True, inline="always")
def _between(
    image: NDArray[np.float32],
    k: int,
    corner: tuple[np.uint64, np.uint64, np.uint64, np.uint64],
    shares: tuple[float, float, float, float],
) -> float:
    """A channel of (h, w, 6) between four pixels: top, left, low, right, and the shares of what lies there."""
    top, left, low, right = corner
    above: float = shares[0] * image[top, left, k] + shares[1] * image[top, right, k]
    below: float = shares[2] * image[low, left, k] + shares[3] * image[low, right, k]
    return above + below


@njit(cache=True, nogil=True)
def align_terms(
    reference: NDArray[np.float32],
    image: NDArray[np.float32],
    intrinsics: NDArray[np.float64],
    pose: NDArray[np.float64],
    brightness: tuple[float, float],
    depth_noise: tuple[float, float],
    every: int,
    hessian: NDArray[np.float64],
    gradient: NDArray[np.float64],
    residuals: NDArray[np.float64],
) -> tuple[int, int, int]:
    """Normal equations of the pose between two images, from pixels of the reference with depth.

    Args:
        reference: (2, h, w) grey value and depth in metres, 0 where there is none.
        image: (h, w, 6) grey value, its slope along u and v, depth, its slope along u and v; depth and slopes are not
            a number off smooth surfaces.
        intrinsics: fx, fy, cx, cy of both.
        pose: 4×4 image from reference; it is moved by a twist from the left.
        brightness: what is added to the image's grey values, and their sigma.
        depth_noise: c in metres and q a metre of σ = c + q z².
        every: how many pixels of a row one pixel is asked for, shifted from row to row; it counts as often.
        hessian, gradient: (6, 6), of which the upper half is filled, and (6,); overwritten.
        residuals: (2, n) with room for all that are asked; overwritten for each pixel that fell into the image: by how
            much its grey value differs, and the reference's grey value.

    Returns:
        How many pixels that were asked fell into the image, how many have depth in both, and how many of these agree.
    """
    height, width = reference.shape[1:]
    cx, cy, fx, fy = intrinsics[2], intrinsics[3], intrinsics[0], intrinsics[1]
    across, down, last_u, last_v = 1.0 / fx, 1.0 / fy, width - 1.0, height - 1.0
    offset, grey_certainty = brightness[0], 1.0 / brightness[1]
    xx, xy, xz, x0 = pose[0, 0], pose[0, 1], pose[0, 2], pose[0, 3]
    yx, yy, yz, y0 = pose[1, 0], pose[1, 1], pose[1, 2], pose[1, 3]
    zx, zy, zz, z0 = pose[2, 0], pose[2, 1], pose[2, 2], pose[2, 3]
    inside = measured = agreeing = 0
    # Sums in registers and not in arrays: the 27 of a pixel cost more than all else.
    h00 = h01 = h02 = h11 = h12 = h22 = 0.0
    h03 = h04 = h05 = h13 = h14 = h15 = h23 = h24 = h25 = 0.0
    h33 = h34 = h35 = h44 = h45 = h55 = 0.0
    g0 = g1 = g2 = g3 = g4 = g5 = 0.0
    for row in range(height):
        slope = (row - cy) * down
        for column in range(row % every, width, every):
            depth = np.float64(reference[1, row, column])
            if depth <= 0.0:
                continue
            p, q = (column - cx) * across * depth, slope * depth
            x = xx * p + xy * q + xz * depth + x0
            y = yx * p + yy * q + yz * depth + y0
            z = zx * p + zy * q + zz * depth + z0
            if z < MIN_DEPTH:
                continue
            by_z = 1.0 / z
            u_x, v_y = fx * by_z, fy * by_z
            u, v = u_x * x + cx, v_y * y + cy
            if not (0.0 <= u < last_u and 0.0 <= v < last_v):
                continue
            left, top = np.uint64(u), np.uint64(v)  # unsigned: an index is not looked at for being counted from the end
            right, low = np.uint64(left + _ONE), np.uint64(top + _ONE)
            right_share, low_share = u - left, v - top
            w11 = right_share * low_share
            w10, w01 = low_share - w11, right_share - w11
            corner, shares = (top, left, low, right), (1.0 - right_share - w10, w01, w10, w11)
            shade, there = _between(image, 0, corner, shares), _between(image, 3, corner, shares)
            a, b = _between(image, 1, corner, shares), _between(image, 2, corner, shares)
            grey = np.float64(reference[0, row, column])
            residual = shade + offset - grey
            residuals[0, inside], residuals[1, inside] = residual, grey
            inside += 1
            # Both residuals change with the point by (a, b, c); with the twist by that and by the point × that.
            u_z, v_z = -x * by_z, -y * by_z
            a, b = a * u_x, b * v_y
            c = a * u_z + b * v_z
            weight = _weight(residual, grey_certainty)
            saa, sab, sac, sbb, sbc, scc = (
                weight * a * a,
                weight * a * b,
                weight * a * c,
                weight * b * b,
                weight * b * c,
                weight * c * c,
            )
            weight *= residual
            ra, rb, rc = weight * a, weight * b, weight * c
            if there == there:
                a, b = _between(image, 4, corner, shares), _between(image, 5, corner, shares)
                if a == a:
                    certainty = 1.0 / (depth_noise[0] + depth_noise[1] * z * z)
                    residual = there - z
                    measured += 1
                    agreeing += abs(residual) * certainty < _AGREES
                    a, b = a * u_x, b * v_y
                    c = a * u_z + b * v_z - 1.0
                    weight = _weight(residual, certainty)
                    saa += weight * a * a
                    sab += weight * a * b
                    sac += weight * a * c
                    sbb += weight * b * b
                    sbc += weight * b * c
                    scc += weight * c * c
                    weight *= residual
                    ra, rb, rc = ra + weight * a, rb + weight * b, rc + weight * c
            h00, h01, h02, h11, h12, h22 = h00 + saa, h01 + sab, h02 + sac, h11 + sbb, h12 + sbc, h22 + scc
            aa, ab, ac = y * sac - z * sab, z * saa - x * sac, x * sab - y * saa
            ba, bb, bc = y * sbc - z * sbb, z * sab - x * sbc, x * sbb - y * sab
            ca, cb, cc = y * scc - z * sbc, z * sac - x * scc, x * sbc - y * sac
            h03, h04, h05 = h03 + aa, h04 + ab, h05 + ac
            h13, h14, h15 = h13 + ba, h14 + bb, h15 + bc
            h23, h24, h25 = h23 + ca, h24 + cb, h25 + cc
            h33, h34, h35 = h33 + y * ca - z * ba, h34 + y * cb - z * bb, h35 + y * cc - z * bc
            h44, h45, h55 = h44 + z * ab - x * cb, h45 + z * ac - x * cc, h55 + x * bc - y * ac
            g0, g1, g2 = g0 + ra, g1 + rb, g2 + rc
            g3, g4, g5 = g3 + y * rc - z * rb, g4 + z * ra - x * rc, g5 + x * rb - y * ra
    hessian[:] = 0.0
    hessian[0, 0], hessian[0, 1], hessian[0, 2], hessian[0, 3], hessian[0, 4], hessian[0, 5] = (
        h00,
        h01,
        h02,
        h03,
        h04,
        h05,
    )
    hessian[1, 1], hessian[1, 2], hessian[1, 3], hessian[1, 4], hessian[1, 5] = h11, h12, h13, h14, h15
    hessian[2, 2], hessian[2, 3], hessian[2, 4], hessian[2, 5] = h22, h23, h24, h25
    hessian[3, 3], hessian[3, 4], hessian[3, 5] = h33, h34, h35
    hessian[4, 4], hessian[4, 5], hessian[5, 5] = h44, h45, h55
    gradient[0], gradient[1], gradient[2], gradient[3], gradient[4], gradient[5] = g0, g1, g2, g3, g4, g5
    hessian *= every
    gradient *= every
    return inside, measured, agreeing


@njit(cache=True, nogil=True)
def descend(
    images: tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float64]],
    pose: NDArray[np.float64],
    prior: tuple[NDArray[np.float64], NDArray[np.float64]],
    shades: tuple[float, float, float, float],
    depth_noise: tuple[float, float],
    every: int,
    limits: tuple[int, float, float, float],
    terms: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
) -> tuple[int, int, int]:
    """Gauss-Newton from a pose between two images, until a step is a small part of what they can tell.

    Args:
        images: reference, image and intrinsics, as `align_terms` takes them.
        pose: (4, 4) image from reference; where to begin, overwritten with where it ends.
        prior: inverse of the guess, (4, 4) reference from image, and (6,) how sure it is, σ⁻² each.
        shades: what is added to the image's grey values; their sigma before they are compared; by how much more they
            err than that tells; and the least sigma.
        depth_noise, every: as of `align_terms`.
        limits: steps at most; how many pixels must fall into the image, and have depth in both; and the squared sigmas
            of a step that is the last one.
        terms: hessian, gradient and residuals, as of `align_terms`, of the last step, but for the lower half of the
            hessian.

    Returns:
        The counts of `align_terms` in the last step; -1 first where too few pixels were compared, or tell no step.
    """
    steps, least_inside, least_measured, settled = limits
    offset, sigma, doubt, least_sigma = shades
    reference, image, intrinsics = images
    hessian, gradient, residuals = terms
    sizes, system, step = np.empty(residuals.shape[1]), np.empty((6, 6)), np.empty(6)
    inside = measured = agreeing = 0
    for _ in range(steps):
        brightness = (offset, doubt * sigma)
        inside, measured, agreeing = align_terms(
            reference, image, intrinsics, pose, brightness, depth_noise, every, hessian, gradient, residuals
        )
        if inside < least_inside or measured < least_measured:
            return -1, measured, agreeing
        count = 0
        for k in range(0, inside, every):
            sizes[count] = abs(residuals[0, k])
            count += 1
        sigma = max(1.4826 * _middle(sizes, count), least_sigma)
        astray = logarithm(multiply(pose, prior[0]))
        slope = gradient + prior[1] * astray
        system[:] = hessian
        for i in range(6):
            system[i, i] += prior[1][i]
            step[i] = -slope[i]
        if not solve_positive(system, step):
            return -1, measured, agreeing
        pose[:] = multiply(exponential(step), pose)
        if -np.dot(step, slope) < settled:
            break
    return inside, measured, agreeing


@njit(cache=True, nogil=True)
def _middle(values: NDArray[np.float64], count: int) -> float:
    """The upper median of the first `count` values, which are put into another order (Hoare 1961)."""
    wanted, low, high = count // 2, 0, count - 1
    while low < high:
        pivot = values[(low + high) // 2]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if wanted <= j:
            high = j
        elif wanted >= i:
            low = i
        else:
            break
    return float(values[wanted])


@njit(cache=True, nogil=True)
def bring(
    depth: NDArray[np.float32],
    intrinsics: NDArray[np.float64],
    pose: NDArray[np.float64],
    nearest: float,
    slope_noise: float,
    across: NDArray[np.float32],
    down: NDArray[np.float32],
) -> NDArray[np.float64]:
    """Where a pose brings the pixels of a reference, and what slopes of depth that are noise alone would tell of it.

    A slope's noise is a share of the reading's, by which it is weighed: how large it is plays no part.

    Args:
        depth: (h, w) of the reference, metres; 0 where there is none.
        intrinsics: fx, fy, cx, cy of both images.
        pose: 4×4 image from reference.
        nearest: metres before the image; what is nearer is not seen.
        slope_noise: of a reading's noise, the share that a slope has.
        across, down: (h, w) overwritten: pixels in the image; -1 where there is none.

    Returns:
        (6, 6) of a twist from the left, where readings are off by a sigma.
    """
    fx, fy, cx, cy = intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]
    told, along = np.zeros((6, 6)), np.empty(6)
    across[:] = -1.0
    down[:] = -1.0
    for row in range(depth.shape[0]):
        for column in range(depth.shape[1]):
            far = np.float64(depth[row, column])
            if far <= 0.0:
                continue
            p, q = (column - cx) / fx * far, (row - cy) / fy * far
            x = pose[0, 0] * p + pose[0, 1] * q + pose[0, 2] * far + pose[0, 3]
            y = pose[1, 0] * p + pose[1, 1] * q + pose[1, 2] * far + pose[1, 3]
            z = pose[2, 0] * p + pose[2, 1] * q + pose[2, 2] * far + pose[2, 3]
            if z <= nearest:
                continue
            across[row, column], down[row, column] = fx * x / z + cx, fy * y / z + cy
            for k in range(2):
                a, b = (fx / z, 0.0) if k == 0 else (0.0, fy / z)
                c = -(fx * x if k == 0 else fy * y) / (z * z)
                along[0], along[1], along[2] = a, b, c
                along[3], along[4], along[5] = y * c - z * b, z * a - x * c, x * b - y * a
                for i in range(6):
                    for j in range(i, 6):
                        told[i, j] += along[i] * along[j]
    for i in range(6):
        for j in range(i, 6):
            told[i, j] *= slope_noise * slope_noise
            told[j, i] = told[i, j]
    return told
