"""Depth of one camera in the pixels of another: lifted, moved and splatted, the nearest surface first."""

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.kernel_cache import provide_cache

provide_cache(__file__)

Depth = NDArray[np.float32]
_MOST_PIXELS = 1 << 24
"""Of a picture that depth is registered in or from; each takes some hundred bytes."""


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
        for camera in (rig.depth_camera, rig.colour_camera):
            if camera.width * camera.height > _MOST_PIXELS:
                raise UserError(f"a camera of {camera.width}×{camera.height} pixels is larger than any that is known")
        self._rig = rig
        rotated = _corner_rays(rig.depth_camera) @ rig.colour_from_depth[:3, :3].T
        self._rotated = np.ascontiguousarray(np.moveaxis(rotated, 2, 1), np.float32)
        colour = rig.colour_camera
        lens = [colour.fx, colour.fy, colour.cx, colour.cy, *colour.distortion]
        self._lens = np.array(lens, np.float32)
        self._shift = np.array(rig.colour_from_depth[:3, 3], np.float32)

    def __call__(self, depth: Depth) -> Depth:
        """The depth image (h, w) of the depth camera as (height, width) of the colour camera; metres, 0 without."""
        colour = self._rig.colour_camera
        registered = np.zeros((colour.height, colour.width), np.float32)
        corners = np.empty((5, depth.shape[1]), np.float32)
        _splat(depth, self._rotated, self._shift, self._lens, corners, registered)
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


@njit(nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def _splat(
    depth: Depth,
    rotated: Depth,
    shift: Depth,
    lens: Depth,
    corners: Depth,
    registered: Depth,
) -> None:
    """Every depth pixel's two opposite corners give the rectangle of colour pixels that it covers.

    Args:
        depth: (h, w) metres; anything else than a positive number is none.
        rotated: (h + 1, 3, w + 1) rays through the corners of its pixels, in the colour camera's axes.
        shift: (3,) metres.
        lens: fx, fy, cx, cy, k1, k2, p1, p2, k3.
        corners: (5, w) for one row's results.
        registered: (height, width), zeros; filled.
    """
    for row in range(depth.shape[0]):
        # Without a branch, so that it runs on several pixels at once.
        _project_row(depth[row], rotated[row], rotated[row + 1], shift, lens, corners)
        _fill_row(depth[row], corners, registered)


@njit(nogil=True, cache=True, fastmath={"contract"}, error_model="numpy")
def _project_row(depth: Depth, above: Depth, below: Depth, shift: Depth, lens: Depth, corners: Depth) -> None:
    """Of each pixel the two corners' places in the colour image, pixels, and its depth there, metres."""
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = lens
    x, y, z = shift
    one, two, half = np.float32(1.0), np.float32(2.0), np.float32(0.5)
    for column in range(len(depth)):
        metres = depth[column]
        z0 = metres * above[2, column] + z
        z1 = metres * below[2, column + 1] + z
        x0, y0 = (metres * above[0, column] + x) / z0, (metres * above[1, column] + y) / z0
        x1, y1 = (metres * below[0, column + 1] + x) / z1, (metres * below[1, column + 1] + y) / z1
        r2 = x0 * x0 + y0 * y0
        radial = one + r2 * (k1 + r2 * (k2 + r2 * k3))
        corners[0, column] = fx * (x0 * radial + two * p1 * x0 * y0 + p2 * (r2 + two * x0 * x0)) + cx
        corners[1, column] = fy * (y0 * radial + p1 * (r2 + two * y0 * y0) + two * p2 * x0 * y0) + cy
        r2 = x1 * x1 + y1 * y1
        radial = one + r2 * (k1 + r2 * (k2 + r2 * k3))
        corners[2, column] = fx * (x1 * radial + two * p1 * x1 * y1 + p2 * (r2 + two * x1 * x1)) + cx
        corners[3, column] = fy * (y1 * radial + p1 * (r2 + two * y1 * y1) + two * p2 * x1 * y1) + cy
        # The middle of the pixel tells its depth in the other camera, the corners what it covers.
        corners[4, column] = half * (z0 + z1) if min(z0, z1) > 0 else np.float32(0.0)


@njit(nogil=True, cache=True)
def _fill_row(depth: Depth, corners: Depth, registered: Depth) -> None:
    height, width = registered.shape
    for column in range(len(depth)):
        value = corners[4, column]
        if not (depth[column] > 0.0) or not (value > 0.0) or not np.isfinite(value):
            continue
        u0, v0, u1, v1 = corners[0, column], corners[1, column], corners[2, column], corners[3, column]
        left, right = min(u0, u1), max(u0, u1)
        top, bottom = min(v0, v1), max(v0, v1)
        if not (right >= -0.5 and bottom >= -0.5 and left <= width - 0.5 and top <= height - 0.5):
            continue
        # Pixels whose centres lie within; at least the one that the middle falls on.
        left, right = max(left, np.float32(-1.0)), min(right, np.float32(width))
        top, bottom = max(top, np.float32(-1.0)), min(bottom, np.float32(height))
        first_u, last_u = int(np.ceil(left)), int(np.ceil(right)) - 1
        first_v, last_v = int(np.ceil(top)), int(np.ceil(bottom)) - 1
        if last_u < first_u:
            first_u = last_u = int(np.floor(0.5 * (left + right) + 0.5))
        if last_v < first_v:
            first_v = last_v = int(np.floor(0.5 * (top + bottom) + 0.5))
        for v in range(max(first_v, 0), min(last_v, height - 1) + 1):
            for u in range(max(first_u, 0), min(last_u, width - 1) + 1):
                known = registered[v, u]
                if known == 0.0 or value < known:
                    registered[v, u] = value
