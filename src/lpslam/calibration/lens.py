"""The camera as an adjustment sees it: nine numbers, and how a pixel depends on them and on the point it shows."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera

Array = NDArray[np.float64]

NAMES = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "readout")
"""The numbers of a lens, in the order of its vector: pixels, Brown-Conrady distortion, and seconds of a rolling shutter
from the first line of a picture to the last."""

K3 = NAMES.index("k3")

NEAREST = 0.05
"""Metres; a point nearer than this, or behind the camera, is taken to be there."""


class Projection(NamedTuple):
    """Where n points are seen, and how that changes.

    Attributes:
        pixels: (n, 2) raw u, v.
        by_point: (n, 2, 3) derivatives by the point in the camera's frame.
        by_lens: (n, 2, 10) derivatives by the lens.
    """

    pixels: Array
    by_point: Array
    by_lens: Array


def lens_of(camera: PinholeCamera) -> Array:
    """The (10,) numbers of a camera whose shutter does not roll."""
    return np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion, 0.0])


def with_lens(camera: PinholeCamera, lens: Array) -> PinholeCamera:
    """A camera with other numbers."""
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = (float(value) for value in lens[:9])
    return replace(camera, fx=fx, fy=fy, cx=cx, cy=cy, distortion=(k1, k2, p1, p2, k3))


def project(points: Array, lens: Array, drag: Array) -> Projection:
    """Raw pixels of points of the optical frame, with derivatives (Brown-Conrady).

    Args:
        points: (n, 3) metres.
        lens: (10,) numbers.
        drag: (n, 2) pixels a second by which a rolling shutter would displace them: how fast the picture moves there,
            times how far below the middle it is, as a share of the height.
    """
    fx, fy, cx, cy, k1, k2, p1, p2, k3, readout = lens
    w = 1.0 / np.maximum(points[:, 2], NEAREST)
    x, y = points[:, 0] * w, points[:, 1] * w
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3))
    bent_x = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    bent_y = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    # Derivatives of the bent ray by the straight one; the mixed ones are equal.
    xx = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x
    yy = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x
    xy = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y
    by_point = np.empty((len(points), 2, 3))
    by_point[:, 0, 0], by_point[:, 0, 1], by_point[:, 0, 2] = fx * xx * w, fx * xy * w, -fx * w * (xx * x + xy * y)
    by_point[:, 1, 0], by_point[:, 1, 1], by_point[:, 1, 2] = fy * xy * w, fy * yy * w, -fy * w * (xy * x + yy * y)
    by_lens = np.zeros((len(points), 2, len(NAMES)))
    by_lens[:, 0, 0], by_lens[:, 1, 1] = bent_x, bent_y
    by_lens[:, 0, 2] = by_lens[:, 1, 3] = 1.0
    for column, power in ((4, r2), (5, r2**2), (8, r2**3)):
        by_lens[:, 0, column], by_lens[:, 1, column] = fx * x * power, fy * y * power
    by_lens[:, 0, 6], by_lens[:, 1, 6] = fx * 2.0 * x * y, fy * (r2 + 2.0 * y * y)
    by_lens[:, 0, 7], by_lens[:, 1, 7] = fx * (r2 + 2.0 * x * x), fy * 2.0 * x * y
    by_lens[:, :, 9] = drag
    pixels = np.column_stack([fx * bent_x + cx, fy * bent_y + cy]) + readout * drag
    return Projection(pixels, by_point, by_lens)


def by_small_turn(points: Array) -> Array:
    """Derivatives (n, 3, 3) of points (n, 3) by a small turn about x, y and z, which moves them by turn × point."""
    x, y, z = points.T
    zero = np.zeros_like(x)
    return np.stack([[zero, z, -y], [-z, zero, x], [y, -x, zero]]).transpose(2, 0, 1)


def gap(camera: PinholeCamera, other: PinholeCamera) -> Array:
    """How far apart, pixels (9, 9), two calibrations show the same ray, over a grid of the image.

    A turn of the camera by which the two differ is taken out: it moves the whole picture, and bends nothing.
    """
    u, v = np.meshgrid(np.linspace(0, camera.width - 1, 9), np.linspace(0, camera.height - 1, 9))
    raw = np.column_stack([u.ravel(), v.ravel()])
    straight = camera.undistort(raw)
    rays = camera.back_project(straight, np.ones(len(straight)))
    seen = project(rays, lens_of(other), np.zeros_like(raw))
    by_turn = (seen.by_point @ by_small_turn(rays)).reshape(-1, 3)
    off = (seen.pixels - raw).ravel()
    turn, *_ = np.linalg.lstsq(by_turn, off)
    left = (off - by_turn @ turn).reshape(-1, 2)
    return np.asarray(np.linalg.norm(left, axis=1).reshape(9, 9))
