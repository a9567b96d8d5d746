"""Three planes that meet, seen by a camera that knows exactly where it is."""

import numpy as np

from lpslam.camera import PinholeCamera, inverse_transform

CAMERA = PinholeCamera(320, 240, 262.0, 261.0, 158.4, 121.2)

Planes = tuple[tuple[np.ndarray, float], ...]

CORNER: Planes = (
    (np.array([1.0, 0.1, 1.0]), 2.2),
    (np.array([-1.0, 0.2, 1.0]), 2.4),
    (np.array([0.1, 1.0, 0.4]), 1.6),
)
"""Two walls and a floor: their normals in the frame of the first camera, and how far off they are along z, metres."""

WALL: Planes = ((np.array([0.0, 0.0, 1.0]), 1.5),)

_CHECKS = np.random.default_rng(1).integers(40, 220, 4096)
_RAYS = CAMERA.back_project(
    np.argwhere(np.ones((CAMERA.height, CAMERA.width)))[:, ::-1].astype(np.float64),
    np.ones(CAMERA.height * CAMERA.width),
)


def shot(
    planes: Planes, camera_from_world: np.ndarray, contrast: float, *, checks: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Grey values and depth of planes as a camera sees them.

    The shades are waves of a few decimetres, or checks of eight centimetres whose corners are keypoints: other numbers
    are other checks.
    """
    world_from_camera = inverse_transform(camera_from_world)
    rotation, centre = world_from_camera[:3, :3], world_from_camera[:3, 3]
    directions = _RAYS @ rotation.T
    depth = np.full(len(_RAYS), np.inf)
    for normal, distance in planes:
        with np.errstate(divide="ignore"):
            reached = (distance * normal[2] - centre @ normal) / (directions @ normal)
        depth = np.where((reached > 0.1) & (reached < depth), reached, depth)
    depth[~np.isfinite(depth)] = 0.0
    x, y, z = (centre + directions * depth[:, None]).T
    if checks:
        a, b, c = (np.floor(each / 0.08 + 0.5).astype(np.int64) for each in (x, y, z))
        shades = _CHECKS[(a * 73 + b * 179 + c * 283 + 997 * checks) % 4096].astype(np.float64)
    else:
        waves = np.sin(9.0 * x + 2.0 * y) + np.sin(8.0 * y - 3.0 * z) + np.sin(7.0 * z + 4.0 * x)
        shades = 120.0 + contrast * waves
    shape = CAMERA.height, CAMERA.width
    return shades.reshape(shape).round().astype(np.uint8), depth.reshape(shape).astype(np.float32)
