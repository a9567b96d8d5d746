"""The colour camera's geometry: a lens with distortion, rows that are read one after another, motion while exposed.

An ideal picture of the instant in the middle, the canvas, is drawn a little larger than the image. Each pixel of the
image looks along its own ray from where the camera is when its row's shutter opens and when it closes; between the two
places where the canvas shows those rays, its colour is averaged. That is exact for what the canvas shows, up to what
comes out from behind an edge within one frame.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera

MARGIN = 0.05  # of the canvas on each side, as a share of the image's width: room for motion during the readout
MAX_TAPS = 33  # samples along the longest motion blur

Picture = NDArray[np.float32]
Rays = NDArray[np.float32]
Rows = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Lens:
    """A camera's rays.

    Attributes:
        camera: with its distortion.
        canvas: undistorted, which sees all of the camera's rays and a margin.
        rays: (height, width, 2) x and y of each pixel's ray at z = 1.
    """

    camera: PinholeCamera
    canvas: PinholeCamera
    rays: Rays

    @classmethod
    def of(cls, camera: PinholeCamera) -> "Lens":
        """Undistort every pixel once."""
        u, v = np.meshgrid(np.arange(camera.width, dtype=np.float64), np.arange(camera.height, dtype=np.float64))
        pixels = camera.undistort(np.column_stack([u.ravel(), v.ravel()]))
        rays = (pixels - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
        low, high = rays.min(axis=0), rays.max(axis=0)
        margin = MARGIN * camera.width
        left, top = np.ceil(-low * [camera.fx, camera.fy] + margin)
        right, bottom = np.ceil(high * [camera.fx, camera.fy] + margin)
        canvas = PinholeCamera(
            int(left + right) + 1, int(top + bottom) + 1, camera.fx, camera.fy, float(left), float(top)
        )
        return cls(camera, canvas, rays.reshape(camera.height, camera.width, 2).astype(np.float32))

    def shoot(self, colour: Picture, depth: Picture, opened: Rows, closed: Rows) -> Picture:
        """What falls on the sensor.

        Args:
            colour: (h, w, 3) of the canvas.
            depth: (h, w) metres of the canvas; 0 for what is endlessly far.
            opened, closed: (height, 3, 4) canvas from camera, for each row when its shutter opens and closes.

        Returns:
            (height, width, 3) float32.
        """
        canvas = self.canvas
        return _shoot(colour, depth, (canvas.fx, canvas.fy, canvas.cx, canvas.cy), self.rays, opened, closed)


@njit(cache=True, nogil=True, fastmath=True)
def _shoot(
    colour: Picture,
    depth: Picture,
    intrinsics: tuple[float, float, float, float],
    rays: Rays,
    opened: Rows,
    closed: Rows,
) -> Picture:
    height, width = rays.shape[:2]
    rows, columns = depth.shape
    fx, fy, cx, cy = intrinsics
    out = np.empty((height, width, 3), np.float32)
    for row in range(height):
        a, b = opened[row], closed[row]
        nearness = 0.0
        for column in range(width):
            x, y = float(rays[row, column, 0]), float(rays[row, column, 1])
            # Along the ray to the depth that the canvas shows where the ray meets it, found by going there twice.
            u1 = a[0, 0] * x + a[0, 1] * y + a[0, 2]
            v1 = a[1, 0] * x + a[1, 1] * y + a[1, 2]
            w1 = a[2, 0] * x + a[2, 1] * y + a[2, 2]
            u2 = b[0, 0] * x + b[0, 1] * y + b[0, 2]
            v2 = b[1, 0] * x + b[1, 1] * y + b[1, 2]
            w2 = b[2, 0] * x + b[2, 1] * y + b[2, 2]
            for _ in range(2):
                z = 1.0 / (w1 + w2 + (a[2, 3] + b[2, 3]) * nearness)
                u = fx * (u1 + u2 + (a[0, 3] + b[0, 3]) * nearness) * z + cx
                v = fy * (v1 + v2 + (a[1, 3] + b[1, 3]) * nearness) * z + cy
                u0, v0 = min(max(int(u + 0.5), 0), columns - 1), min(max(int(v + 0.5), 0), rows - 1)
                seen = depth[v0, u0]
                nearness = 1.0 / seen if seen > 0.0 else 0.0
            z1, z2 = 1.0 / (w1 + a[2, 3] * nearness), 1.0 / (w2 + b[2, 3] * nearness)
            u1, v1 = fx * (u1 + a[0, 3] * nearness) * z1 + cx, fy * (v1 + a[1, 3] * nearness) * z1 + cy
            u2, v2 = fx * (u2 + b[0, 3] * nearness) * z2 + cx, fy * (v2 + b[1, 3] * nearness) * z2 + cy
            du, dv = u2 - u1, v2 - v1
            taps = min(MAX_TAPS, int(0.55 * math.sqrt(du * du + dv * dv)) + 1)
            red = green = blue = 0.0
            for tap in range(taps):
                share = (tap + 0.5) / taps
                u = min(max(u1 + share * du, 0.0), columns - 1.001)
                v = min(max(v1 + share * dv, 0.0), rows - 1.001)
                u0, v0 = int(u), int(v)
                r, d = u - u0, v - v0
                p, q, s, t = (1 - r) * (1 - d), r * (1 - d), (1 - r) * d, r * d
                red += p * colour[v0, u0, 0] + q * colour[v0, u0 + 1, 0]
                red += s * colour[v0 + 1, u0, 0] + t * colour[v0 + 1, u0 + 1, 0]
                green += p * colour[v0, u0, 1] + q * colour[v0, u0 + 1, 1]
                green += s * colour[v0 + 1, u0, 1] + t * colour[v0 + 1, u0 + 1, 1]
                blue += p * colour[v0, u0, 2] + q * colour[v0, u0 + 1, 2]
                blue += s * colour[v0 + 1, u0, 2] + t * colour[v0 + 1, u0 + 1, 2]
            out[row, column, 0], out[row, column, 1], out[row, column, 2] = red / taps, green / taps, blue / taps
    return out


def row_times(middle: float, height: int, readout: float) -> NDArray[np.float64]:
    """(height,) seconds at which each row is in the middle of its exposure; the middle row at `middle`."""
    return middle + readout * ((np.arange(height) - (height - 1) / 2) / max(height - 1, 1))
