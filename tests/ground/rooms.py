"""Rooms of boxes, seen by a camera that knows exactly where it is."""

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera

Array = NDArray[np.float64]

CAMERA = PinholeCamera(320, 240, 262.0, 261.0, 158.4, 121.2)


@dataclass(frozen=True)
class Box:
    """From one corner to the other, metres; the floor is a flat one."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]


FLOOR = Box((-20.0, -20.0, -1.0), (20.0, 20.0, 0.0))


def looking(at: tuple[float, float], yaw: float, height: float = 1.3, down: float = 0.35) -> Array:
    """World from camera (4×4): where it stands, which way it looks (radians from x), and how far down."""
    forward = np.array([np.cos(yaw) * np.cos(down), np.sin(yaw) * np.cos(down), -np.sin(down)])
    right = np.array([np.sin(yaw), -np.cos(yaw), 0.0])
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2] = right, np.cross(forward, right), forward
    pose[:3, 3] = *at, height
    return pose


def depth_of(boxes: list[Box], world_from_camera: Array, noise: float = 0.0, seed: int = 0) -> NDArray[np.float32]:
    """(h, w) metres along the optical axis; noise grows with depth squared."""
    pose = world_from_camera.tobytes()
    nearest = np.min([_entered(box, pose) for box in boxes], axis=0)
    depth = np.where(np.isfinite(nearest), nearest, 0.0)
    depth += noise * depth**2 * np.random.default_rng(seed).normal(size=depth.shape) * (depth > 0)
    return np.where(depth < 12.0, depth, 0.0).reshape(CAMERA.height, CAMERA.width).astype(np.float32)


@lru_cache(maxsize=128)
def _entered(box: Box, pose: bytes) -> Array:
    """Where the rays of all pixels enter a box: the same walls are seen from the same places again and again."""
    origin = np.frombuffer(pose).reshape(4, 4)[:3, 3]
    directions = _directions(pose)
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = ((np.array(corner) - origin)[:, None] / directions for corner in (box.low, box.high))
    enter, leave = np.minimum(first, second).max(axis=0), np.maximum(first, second).min(axis=0)
    return np.where((enter < leave) & (enter > 0.05), enter, np.inf)


@lru_cache(maxsize=64)
def _directions(pose: bytes) -> Array:
    """(3, n) in the world, one row a coordinate: numpy goes through long rows quickly."""
    return np.ascontiguousarray((_rays() @ np.frombuffer(pose).reshape(4, 4)[:3, :3].T).T)


@cache
def _rays() -> Array:
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    return CAMERA.back_project(np.column_stack([u.ravel(), v.ravel()]).astype(float), np.ones(u.size))
