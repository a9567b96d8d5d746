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
def exponential(twist: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rigid 4×4 transform of a twist (translation, rotation vector): the exponential map of SE(3)."""
    rho, omega = twist[:3], twist[3:]
    theta2 = omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2
    theta = math.sqrt(theta2)
    if theta < 1e-6:
        a, b, c = 1.0 - theta2 / 6.0, 0.5 - theta2 / 24.0, 1.0 / 6.0 - theta2 / 120.0
    else:
        a, b = math.sin(theta) / theta, (1.0 - math.cos(theta)) / theta2
        c = (1.0 - a) / theta2
    skew = np.zeros((3, 3))
    skew[0, 1], skew[0, 2], skew[1, 2] = -omega[2], omega[1], -omega[0]
    skew[1, 0], skew[2, 0], skew[2, 1] = omega[2], -omega[1], omega[0]
    square = skew @ skew
    transform = np.eye(4)
    transform[:3, :3] += a * skew + b * square
    transform[:3, 3] = rho + b * (skew @ rho) + c * (square @ rho)
    return transform


@njit(cache=True, nogil=True)
def orthonormalise(transform: NDArray[np.float64]) -> None:
    """Pull the rotation of a 4×4 transform back onto SO(3), in place; products drift off it by rounding."""
    r = transform[:3, :3]
    x = r[0] / math.sqrt(r[0, 0] ** 2 + r[0, 1] ** 2 + r[0, 2] ** 2)
    y = r[1] - (x[0] * r[1, 0] + x[1] * r[1, 1] + x[2] * r[1, 2]) * x
    y = y / math.sqrt(y[0] ** 2 + y[1] ** 2 + y[2] ** 2)
    transform[0, :3] = x
    transform[1, :3] = y
    transform[2, 0] = x[1] * y[2] - x[2] * y[1]
    transform[2, 1] = x[2] * y[0] - x[0] * y[2]
    transform[2, 2] = x[0] * y[1] - x[1] * y[0]


@njit(cache=True, nogil=True)
def inverse(transform: NDArray[np.float64]) -> NDArray[np.float64]:
    """Inverse of a rigid 4×4 transform."""
    result = np.eye(4)
    for i in range(3):
        for j in range(3):
            result[i, j] = transform[j, i]
    for i in range(3):
        result[i, 3] = -(
            result[i, 0] * transform[0, 3] + result[i, 1] * transform[1, 3] + result[i, 2] * transform[2, 3]
        )
    return result
