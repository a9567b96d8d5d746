"""How the camera has moved between two pictures: from corners with depth, without, and on things that move."""

import numpy as np
import pytest
from corner_room import CAMERA, CORNER, shot
from slam_scenes import pose_error

from lpslam.config import SurfaceConfig, TurningConfig
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.tracking.turning import Glance, Moved, Turning

SECONDS = 0.1
MOTIONS = [
    pytest.param([0.0, 0.0, 0.0, 0.0, 0.06, 0.0], id="turn"),
    pytest.param([0.02, -0.01, 0.03, 0.02, -0.04, 0.05], id="turn and step"),
    pytest.param([0.0, 0.0, 0.0, 0.0, 0.0, 0.0], id="none"),
]


def glance(turning: Turning, camera_from_world: np.ndarray, seed: int, depth_share: float, noise: float) -> Glance:
    random = np.random.default_rng(seed)
    gray, depth = shot(CORNER, camera_from_world, 2.0, checks=1)
    noisy = (gray + random.normal(0.0, noise, gray.shape)).clip(0, 255).astype(np.uint8)
    kept = np.where(random.random(depth.shape) < depth_share, depth, 0.0).astype(np.float32)
    return turning.glance(noisy, kept)


def told(motion: np.ndarray, guess: np.ndarray, depth_share: float, noise: float = 2.0) -> Moved | None:
    turning = Turning(CAMERA, TurningConfig(), SurfaceConfig())
    before, now = (glance(turning, pose, seed, depth_share, noise) for seed, pose in enumerate((np.eye(4), motion)))
    return turning.told(before, now, guess, SECONDS)


@pytest.mark.parametrize("twist", MOTIONS)
def test_with_depth_the_whole_motion_is_told(twist: list[float]) -> None:
    motion = exponential(np.array(twist))
    moved = told(motion, np.eye(4), 1.0)
    assert moved is not None
    assert moved.is_step_told
    metres, radians = pose_error(moved.motion, motion)
    assert metres < 0.006
    assert radians < 0.004


@pytest.mark.parametrize("twist", MOTIONS)
def test_without_depth_the_turn_is_told_and_the_step_is_the_guess(twist: list[float]) -> None:
    motion = exponential(np.array([0.0, 0.0, 0.0, *twist[3:]]))
    guess = np.eye(4)
    guess[:3, 3] = [0.01, 0.0, -0.02]
    moved = told(motion, guess, 0.0)
    assert moved is not None
    assert not moved.is_step_told
    assert np.allclose(moved.motion[:3, 3], guess[:3, 3])
    assert pose_error(moved.motion, motion)[1] < 0.004


def test_noise_and_blank_pictures_tell_nothing() -> None:
    turning = Turning(CAMERA, TurningConfig(), SurfaceConfig())
    random = np.random.default_rng(3)
    depth = np.full((CAMERA.height, CAMERA.width), 2.0, np.float32)
    before, now = (
        turning.glance(random.integers(0, 255, depth.shape, dtype=np.uint8).astype(np.uint8), depth) for _ in range(2)
    )
    assert turning.told(before, now, np.eye(4), SECONDS) is None
    blank = turning.glance(np.full(depth.shape, 90, np.uint8), depth)
    assert turning.told(blank, blank, np.eye(4), SECONDS) is None
    seen = glance(turning, np.eye(4), 0, 1.0, 2.0)
    assert turning.told(seen, blank, np.eye(4), SECONDS) is None
    assert turning.told(seen, turning.glance(np.zeros(depth.shape, np.uint8), depth), np.eye(4), SECONDS) is None


def test_where_a_third_of_the_picture_moves_by_itself_the_rest_tells() -> None:
    motion = exponential(np.array([0.0, 0.0, 0.01, 0.0, 0.03, 0.0]))
    walked = exponential(np.array([0.15, 0.0, 0.0, 0.0, 0.03, 0.0]))
    turning = Turning(CAMERA, TurningConfig(), SurfaceConfig())
    before = glance(turning, np.eye(4), 0, 1.0, 2.0)
    still, moving = (glance(turning, pose, 1, 1.0, 2.0) for pose in (motion, walked))
    third = before.gray.shape[1] // 3
    mixed = np.concatenate([moving.gray[:, :third], still.gray[:, third:]], axis=1)
    moved = turning.told(before, Glance(mixed, still.depth), np.eye(4), SECONDS)
    assert moved is not None
    metres, radians = pose_error(moved.motion, motion)
    assert metres < 0.02
    assert radians < 0.01


def test_where_all_moves_apart_nothing_is_told() -> None:
    turning = Turning(CAMERA, TurningConfig(), SurfaceConfig())
    before = glance(turning, np.eye(4), 0, 1.0, 2.0)
    bands = [
        glance(turning, exponential(np.array([0.0, 0.0, 0.0, 0.0, turn, 0.0])), 1, 1.0, 2.0)
        for turn in (-0.06, -0.02, 0.02, 0.06)
    ]
    height = before.gray.shape[0] // 4
    mixed = np.concatenate([band.gray[height * row : height * (row + 1)] for row, band in enumerate(bands)])
    assert turning.told(before, Glance(mixed, before.depth), np.eye(4), SECONDS) is None
