"""Depth of one camera in the pixels of another: lifted, moved and splatted, the nearest surface first."""

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera

Depth = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class DepthRig:
    """Where the depth camera stands.

    Attributes:
        depth_camera: its intrinsics.
        colour_camera: the camera whose pixels depth is wanted in.
        colour_from_depth: 4×4, points of the depth camera's optical frame in the colour camera's, metres.
    """

    depth_camera: PinholeCamera
    colour_camera: PinholeCamera
    colour_from_depth: NDArray[np.float64]


class DepthRegistration:
    """Registers depth images of a rig.

    A depth pixel covers the colour pixels between its corners, as the maker's programs do it: a wall stays whole where
    the colour image is the larger one. Of what falls on one pixel the nearest stays. A pixel that nothing falls on has
    no depth: what the depth camera did not see is not invented.

    Args:
        rig: both cameras and what lies between them.
    """

    def __init__(self, rig: DepthRig) -> None:
        self._rig = rig
        self._corner_rays = _corner_rays(rig.depth_camera)
        self._rotated = np.ascontiguousarray(self._corner_rays @ rig.colour_from_depth[:3, :3].T)
        colour = rig.colour_camera
        self._lens = np.array([colour.fx, colour.fy, colour.cx, colour.cy, *colour.distortion])
        self._shift = np.ascontiguousarray(rig.colour_from_depth[:3, 3])

    def __call__(self, depth: Depth) -> Depth:
        """The depth image (h, w) of the depth camera as (height, width) of the colour camera; metres, 0 without."""
        colour = self._rig.colour_camera
        registered = np.zeros((colour.height, colour.width), np.float32)
        _splat(depth, self._rotated, self._shift, self._lens, registered)
        return registered


def _corner_rays(camera: PinholeCamera) -> NDArray[np.float64]:
    """(h + 1, w + 1, 3) rays through the corners of the pixels, z = 1."""
    u, v = np.meshgrid(np.arange(camera.width + 1) - 0.5, np.arange(camera.height + 1) - 0.5)
    pixels = np.column_stack([u.ravel(), v.ravel()])
    if camera.is_distorted:
        until = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 20, 1e-7)
        ideal = cv2.undistortPoints(
            pixels.reshape(-1, 1, 2), camera.matrix, np.array(camera.distortion), criteria=until
        ).reshape(-1, 2)
    else:
        ideal = (pixels - [camera.cx, camera.cy]) / [camera.fx, camera.fy]
    rays = np.column_stack([ideal, np.ones(len(ideal))])
    return np.ascontiguousarray(rays.reshape(camera.height + 1, camera.width + 1, 3))


@njit(nogil=True, cache=True, fastmath=False)
def _splat(
    depth: Depth,
    rotated: NDArray[np.float64],
    shift: NDArray[np.float64],
    lens: NDArray[np.float64],
    registered: Depth,
) -> None:
    """Every depth pixel's two opposite corners give the rectangle of colour pixels that it covers."""
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = lens
    is_bent = k1 != 0.0 or k2 != 0.0 or p1 != 0.0 or p2 != 0.0 or k3 != 0.0
    rows, columns = depth.shape
    height, width = registered.shape
    for row in range(rows):
        for column in range(columns):
            z = depth[row, column]
            if not (z > 0.0) or not np.isfinite(z):
                continue
            # The middle of the pixel tells its depth in the other camera, the corners what it covers.
            first, last = rotated[row, column], rotated[row + 1, column + 1]
            z_first, z_last = z * first[2] + shift[2], z * last[2] + shift[2]
            if z_first <= 0.0 or z_last <= 0.0:
                continue
            x0, y0 = (z * first[0] + shift[0]) / z_first, (z * first[1] + shift[1]) / z_first
            x1, y1 = (z * last[0] + shift[0]) / z_last, (z * last[1] + shift[1]) / z_last
            if is_bent:
                r2 = x0 * x0 + y0 * y0
                radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
                x0, y0 = (
                    x0 * radial + 2.0 * p1 * x0 * y0 + p2 * (r2 + 2.0 * x0 * x0),
                    y0 * radial + p1 * (r2 + 2.0 * y0 * y0) + 2.0 * p2 * x0 * y0,
                )
                r2 = x1 * x1 + y1 * y1
                radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
                x1, y1 = (
                    x1 * radial + 2.0 * p1 * x1 * y1 + p2 * (r2 + 2.0 * x1 * x1),
                    y1 * radial + p1 * (r2 + 2.0 * y1 * y1) + 2.0 * p2 * x1 * y1,
                )
            u0, v0 = fx * x0 + cx, fy * y0 + cy
            u1, v1 = fx * x1 + cx, fy * y1 + cy
            # Pixels whose centres lie within; at least the one that the middle falls on.
            left, right = min(u0, u1), max(u0, u1)
            top, bottom = min(v0, v1), max(v0, v1)
            if right < -0.5 or bottom < -0.5 or left > width - 0.5 or top > height - 0.5:
                continue
            first_u, last_u = int(np.ceil(left)), int(np.ceil(right)) - 1
            first_v, last_v = int(np.ceil(top)), int(np.ceil(bottom)) - 1
            if last_u < first_u:
                first_u = last_u = int(np.floor(0.5 * (left + right) + 0.5))
            if last_v < first_v:
                first_v = last_v = int(np.floor(0.5 * (top + bottom) + 0.5))
            value = np.float32(0.5 * (z_first + z_last))
            for v in range(max(first_v, 0), min(last_v, height - 1) + 1):
                for u in range(max(first_u, 0), min(last_u, width - 1) + 1):
                    known = registered[v, u]
                    if known == 0.0 or value < known:
                        registered[v, u] = value
