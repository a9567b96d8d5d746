"""Small rigid-body helpers that kernels share."""

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic
from numpy.typing import NDArray


def _popcount(typing_context, value):  # type: ignore[no-untyped-def]
    """Number of set bits of an unsigned 64-bit word, as one machine instruction."""

    def generate(context, builder: ir.IRBuilder, signature, arguments):  # type: ignore[no-untyped-def]
        return builder.ctpop(arguments[0])

    return types.uint64(types.uint64), generate


popcount: Any = intrinsic(_popcount)


@njit(cache=True, nogil=True, inline="always")
def hamming(a: NDArray[np.uint64], b: NDArray[np.uint64]) -> int:
    """Number of differing bits of two 256-bit descriptors."""
    bits = popcount(a[0] ^ b[0]) + popcount(a[1] ^ b[1]) + popcount(a[2] ^ b[2]) + popcount(a[3] ^ b[3])
    return np.int64(bits)  # type: ignore[return-value]


@njit(cache=True, nogil=True)
def median(values: NDArray[np.float64], count: int) -> float:
    """Median of the first `count` values, which are sorted in place; for the few that a loop in a kernel has.

    Compiles in a tenth of the time that `np.median` takes.
    """
    for i in range(1, count):
        value = values[i]
        j = i
        while j > 0 and values[j - 1] > value:
            values[j] = values[j - 1]
            j -= 1
        values[j] = value
    middle: float = 0.5 * (values[(count - 1) // 2] + values[count // 2])
    return middle


@njit(cache=True, nogil=True)
def multiply(left: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Product of two rigid 4×4 transforms."""
    result = np.empty((4, 4))
    for i in range(3):
        for j in range(4):
            result[i, j] = left[i, 0] * right[0, j] + left[i, 1] * right[1, j] + left[i, 2] * right[2, j]
        result[i, 3] += left[i, 3]
        result[3, i] = 0.0
    result[3, 3] = 1.0
    return result


@njit(cache=True, nogil=True)
def exponential(twist: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rigid 4×4 transform of a twist (translation, rotation vector): the exponential map of SE(3)."""
    p, q, r, x, y, z = twist
    theta2 = x * x + y * y + z * z
    theta = math.sqrt(theta2)
    if theta < 1e-6:
        a, b, c = 1.0 - theta2 / 6.0, 0.5 - theta2 / 24.0, 1.0 / 6.0 - theta2 / 120.0
    else:
        a, b = math.sin(theta) / theta, (1.0 - math.cos(theta)) / theta2
        c = (1.0 - a) / theta2
    transform = np.zeros((4, 4))
    transform[0, 0], transform[0, 1], transform[0, 2] = 1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y
    transform[1, 0], transform[1, 1], transform[1, 2] = b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x
    transform[2, 0], transform[2, 1], transform[2, 2] = b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y)
    # ω × ρ and ω × (ω × ρ).
    u, v, w = y * r - z * q, z * p - x * r, x * q - y * p
    transform[0, 3] = p + b * u + c * (y * w - z * v)
    transform[1, 3] = q + b * v + c * (z * u - x * w)
    transform[2, 3] = r + b * w + c * (x * v - y * u)
    transform[3, 3] = 1.0
    return transform


@njit(cache=True, nogil=True)
def logarithm(transform: NDArray[np.float64]) -> NDArray[np.float64]:
    """(6,) twist (translation, rotation vector) of a rigid 4×4 transform: the inverse of `exponential`.

    Turns are those of at most half a revolution; near it the axis loses its sign.
    """
    m = transform
    x, y, z = 0.5 * (m[2, 1] - m[1, 2]), 0.5 * (m[0, 2] - m[2, 0]), 0.5 * (m[1, 0] - m[0, 1])
    sine = math.sqrt(x * x + y * y + z * z)
    cosine = 0.5 * (m[0, 0] + m[1, 1] + m[2, 2] - 1.0)
    theta = math.atan2(sine, cosine)
    factor = theta / sine if sine > 1e-9 else 1.0
    x, y, z = x * factor, y * factor, z * factor
    # The coefficient of the squared rotation vector in the inverse of the left Jacobian; 1/12 in the limit.
    rest = (1.0 - 0.5 * theta * sine / (1.0 - cosine)) / (theta * theta) if theta > 1e-3 else 1.0 / 12.0
    p, q, r = m[0, 3], m[1, 3], m[2, 3]
    u, v, w = y * r - z * q, z * p - x * r, x * q - y * p
    twist = np.empty(6)
    twist[0] = p - 0.5 * u + rest * (y * w - z * v)
    twist[1] = q - 0.5 * v + rest * (z * u - x * w)
    twist[2] = r - 0.5 * w + rest * (x * v - y * u)
    twist[3], twist[4], twist[5] = x, y, z
    return twist


@njit(cache=True, nogil=True)
def orthonormalise(transform: NDArray[np.float64]) -> None:
    """Pull the rotation of a 4×4 transform back onto SO(3), in place; products drift off it by rounding."""
    m = transform
    x, y, z = m[0, 0], m[0, 1], m[0, 2]
    s = 1.0 / math.sqrt(x * x + y * y + z * z)
    x, y, z = x * s, y * s, z * s
    u, v, w = m[1, 0], m[1, 1], m[1, 2]
    s = x * u + y * v + z * w
    u, v, w = u - s * x, v - s * y, w - s * z
    s = 1.0 / math.sqrt(u * u + v * v + w * w)
    u, v, w = u * s, v * s, w * s
    m[0, 0], m[0, 1], m[0, 2] = x, y, z
    m[1, 0], m[1, 1], m[1, 2] = u, v, w
    m[2, 0], m[2, 1], m[2, 2] = y * w - z * v, z * u - x * w, x * v - y * u


@njit(cache=True, nogil=True)
def move(transform: NDArray[np.float64], twist: NDArray[np.float64]) -> None:
    """Move a 4×4 transform, in place, by a twist in the frame that it leads to."""
    result = multiply(exponential(twist), transform)
    orthonormalise(result)
    for i in range(3):
        for j in range(4):
            transform[i, j] = result[i, j]
