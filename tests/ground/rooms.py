"""Rooms of boxes, seen by a camera that knows exactly where it is."""

from dataclasses import dataclass

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
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    rays = CAMERA.back_project(np.column_stack([u.ravel(), v.ravel()]).astype(float), np.ones(u.size))
    directions = rays @ world_from_camera[:3, :3].T
    origin = world_from_camera[:3, 3]
    nearest = np.full(u.size, np.inf)
    for box in boxes:
        with np.errstate(divide="ignore", invalid="ignore"):
            first, second = ((np.array(corner) - origin) / directions for corner in (box.low, box.high))
        enter, leave = np.minimum(first, second).max(axis=1), np.maximum(first, second).min(axis=1)
        hit = (enter < leave) & (enter > 0.05)
        nearest = np.where(hit & (enter < nearest), enter, nearest)
    depth = np.where(np.isfinite(nearest), nearest, 0.0)
    depth += noise * depth**2 * np.random.default_rng(seed).normal(size=depth.shape) * (depth > 0)
    return np.where(depth < 12.0, depth, 0.0).reshape(u.shape).astype(np.float32)
