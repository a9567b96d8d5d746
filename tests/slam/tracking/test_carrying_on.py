"""A room whose pattern vanishes for a second: surfaces and shades carry the camera over it, without the map."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from corner_room import CAMERA, CORNER, shot
from slam_scenes import pose_error

from lpslam.camera import inverse_transform
from lpslam.config import SlamConfig, SurfaceConfig, TrackingConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.sensor import SensorModel
from lpslam.slam.state import EventKind, TrackedFrame, TrackingState
from lpslam.slam.system import RgbdSlam
from lpslam.slam.tracking.carrying_on import CarryingOn, Doubtful, Told
from lpslam.slam.tracking.coasting import Coasting
from lpslam.slam.tracking.guesses import LastFrame
from lpslam.slam.tracking.motion import ConstantVelocity
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.surfaces import Surfaces
from lpslam.slam.tracking.turning import Turning

FRAMES, LATE, RATE = 44, 50, 20.0
BARE = range(12, 32)
"""Frames without a keypoint: a second."""


def truth(index: int) -> np.ndarray:
    """Camera from world: the camera sways, turns and comes nearer."""
    way = index / RATE
    return exponential(np.array([0.12 * np.sin(1.5 * way), 0.03 * way, -0.08 * way, 0.0, 0.15 * np.sin(way), 0.03]))


def taken(first: int, last: int, checks: int, turned: float = 0.0) -> list[RgbdFrame]:
    """Some of the camera's frames; colour and depth have noise, and without checks the room is all but one shade.

    The camera may look to the side by some radians.
    """
    aside = exponential(np.array([0.0, 0.0, 0.0, 0.0, turned, 0.0]))
    random, taken = np.random.default_rng([6, first]), []
    for index in range(first, last):
        gray, depth = shot(CORNER, aside @ truth(index), 2.0, checks=checks)
        noisy = (gray + random.normal(0.0, 0.7, gray.shape)).clip(0, 255).round().astype(np.uint8)
        strayed = random.normal(depth, 0.001 + 0.0015 * depth**2).astype(np.float32)
        taken.append(
            RgbdFrame(index, index / RATE, np.repeat(noisy[:, :, None], 3, axis=2), np.where(depth > 0, strayed, 0))
        )
    return taken


@pytest.fixture(scope="module")
def until_found() -> list[RgbdFrame]:
    return taken(0, BARE.start, 1) + taken(BARE.start, BARE.stop, 0)


@pytest.fixture(scope="module")
def frames(until_found: list[RgbdFrame]) -> list[RgbdFrame]:
    return until_found + taken(BARE.stop, FRAMES, 1)


def track(frames: list[RgbdFrame], config: SlamConfig) -> tuple[RgbdSlam, list[TrackedFrame]]:
    slam = RgbdSlam(CAMERA, config)
    told = [slam.process(frame) for frame in frames]
    slam.finish()
    return slam, told


def worst(slam: RgbdSlam) -> tuple[float, float]:
    """Metres and degrees by which the pose that is farthest off in the first camera's frame is."""
    times, poses = slam.trajectory.world_from_camera(slam.map)
    errors = np.array([
        pose_error(inverse_transform(poses[0]) @ pose, truth(0) @ inverse_transform(truth(round(RATE * time))))
        for time, pose in zip(times, poses, strict=True)
    ])  # fmt: skip
    return float(errors[:, 0].max()), float(np.degrees(errors[:, 1].max()))


@pytest.mark.slow
def test_a_second_without_keypoints_is_carried_over_in_one_map(frames: list[RgbdFrame]) -> None:
    slam, tracked = track(frames, SlamConfig())
    assert all(frame.is_tracked for frame in tracked)
    assert all(frame.is_coasted and frame.state is TrackingState.WEAK for frame in tracked[BARE.start : BARE.stop])
    assert all(frame.reason.startswith("carried without the map: ") for frame in tracked[BARE.start : BARE.stop])
    assert set(slam.map.submaps().tolist()) == {0}
    assert {event.kind for event in slam.events} == {EventKind.INITIALISED, EventKind.WEAK, EventKind.TRACKING}
    assert slam.trajectory.tracked_count == FRAMES
    metres, degrees = worst(slam)
    assert metres < 0.02
    assert degrees < 0.7


@pytest.mark.slow
def test_the_map_goes_on_where_the_camera_was_carried_to_what_is_unknown(until_found: list[RgbdFrame]) -> None:
    slam, tracked = track(until_found + taken(BARE.stop, LATE, 2), SlamConfig())
    assert all(frame.is_tracked for frame in tracked)
    assert set(slam.map.submaps().tolist()) == {0}
    begun = next(frame for frame in tracked[BARE.stop :] if frame.is_keyframe)
    assert begun.timestamp - BARE.stop / RATE == pytest.approx(TrackingConfig().submap_after, abs=1.1 / RATE)
    (event,) = [event for event in slam.events if event.frame == begun.index]
    assert (event.kind, event.reason) == (
        EventKind.TRACKING,
        "the map goes on from where the camera was carried without it",
    )
    assert not slam.map.is_root(begun.keyframe)
    assert all(frame.state is TrackingState.TRACKING for frame in tracked[begun.index :])
    metres, degrees = worst(slam)
    assert metres < 0.03
    assert degrees < 1.0


@pytest.mark.slow
def test_a_view_to_which_not_even_the_turn_was_told_begins_a_submap_soon(until_found: list[RgbdFrame]) -> None:
    seen, covered = until_found[: BARE.start], until_found[BARE.start : BARE.start + 3]
    dark = [replace(frame, rgb=np.zeros_like(frame.rgb), depth=np.zeros_like(frame.depth)) for frame in covered]
    slam, tracked = track(seen + dark + taken(BARE.start + 3, LATE, 2, 0.8), SlamConfig())
    (event,) = [event for event in slam.events if event.kind is EventKind.NEW_SUBMAP]
    uncovered = (BARE.start + 3) / RATE
    assert event.timestamp - uncovered == pytest.approx(TrackingConfig().submap_after, abs=1.1 / RATE)
    assert set(slam.map.submaps().tolist()) == {0, 1}
    assert all(frame.state is TrackingState.TRACKING for frame in tracked[event.frame :])


@pytest.mark.parametrize(
    "config",
    [
        SlamConfig(tracking=TrackingConfig(coast_seconds=0.0)),
        SlamConfig(surfaces=SurfaceConfig(held_seconds=0.32)),
    ],
    ids=["none", "short"],
)
def test_it_is_not_where_that_is_not_wanted(frames: list[RgbdFrame], config: SlamConfig) -> None:
    slam, tracked = track(frames, config)
    assert tracked[BARE.stop - 1].state is TrackingState.LOST
    assert any(event.kind is EventKind.LOST for event in slam.events)
    assert sum(frame.is_coasted for frame in tracked) == (7 if config.tracking.coast_seconds else 0)


# Frames that are passed over -----------------------------------------------------------------------------------------


def test_what_is_told_is_believed_for_longer_than_the_motion_alone() -> None:
    coasting = Coasting(0.5, 10.0, 0.4)
    assert coasting.goes_on(0.0, 0.0, Told.NOTHING, Doubtful())
    for index in range(3):
        coasting.pass_over(index, float(index), np.eye(4), Told.WAY)
        assert coasting.guessed_since is None
    assert coasting.goes_on(9.9, 0.0, Told.WAY, Doubtful())
    assert not coasting.goes_on(10.1, 0.0, Told.WAY, Doubtful())
    for timestamp in (5.0, 5.2):
        coasting.pass_over(5, timestamp, np.eye(4), Told.NOTHING)
        assert coasting.guessed_since == 5.0
    assert coasting.goes_on(5.4, 0.0, Told.NOTHING, Doubtful(9.0, 0.4))
    assert not coasting.goes_on(5.6, 0.0, Told.NOTHING, Doubtful(0.0, 0.6))
    coasting.pass_over(6, 5.7, np.eye(4), Told.WAY)
    assert coasting.guessed_since is None
    coasting.end()
    assert coasting.since is None
    assert not Coasting(0.0, 10.0, 0.4).goes_on(0.0, 0.0, Told.WAY, Doubtful())


def test_a_turn_is_believed_until_the_position_may_be_too_far_off() -> None:
    coasting = Coasting(0.5, 10.0, 0.4)
    coasting.pass_over(0, 0.0, np.eye(4), Told.TURN)
    assert coasting.guessed_since is None
    assert coasting.goes_on(3.0, 0.0, Told.TURN, Doubtful(0.39))
    assert not coasting.goes_on(3.0, 0.0, Told.TURN, Doubtful(0.41))


@pytest.mark.parametrize(
    ("gap", "told", "is_passed"), [(0.4, Told.NOTHING, True), (2.0, Told.NOTHING, False), (2.0, Told.TURN, True)]
)
def test_over_frames_that_are_missing_the_motion_is_not_believed_for_longer(
    gap: float, told: Told, is_passed: bool
) -> None:
    assert Coasting(0.5, 10.0, 0.4).goes_on(7.0 + gap, 7.0, told, Doubtful()) is is_passed


@pytest.mark.parametrize(
    ("doubtful", "is_told"),
    [
        (Doubtful(), True),
        (Doubtful(0.15), True),
        (Doubtful(0.25), False),
        (Doubtful(0.15, 0.03), True),
        (Doubtful(0.15, 0.07), False),
    ],
    ids=["told", "a few turns alone", "many turns alone", "one turn less", "not even the turn"],
)
def test_a_way_is_told_though_a_few_frames_told_their_turn_alone(doubtful: Doubtful, is_told: bool) -> None:
    config = SlamConfig()
    surfaces = Surfaces(CAMERA, SensorModel.of(CAMERA, config), config.surfaces)
    carrying_on = CarryingOn(surfaces, Turning(CAMERA, config.turning, config.surfaces), ConstantVelocity(), 0.5)
    carrying_on.told, carrying_on.doubtful = Told.WAY, doubtful
    untold = Doubtful(config.surfaces.untold_metres, config.surfaces.untold_seconds)
    assert carrying_on.is_told(untold) == is_told
    carrying_on.told = Told.TURN
    assert not carrying_on.is_told(untold)


def test_a_turn_that_is_told_for_long_stays_a_rotation() -> None:
    """Rounding adds to a rotation; a reference that is renewed with every frame must not double that each time."""
    config, motion = SlamConfig(), ConstantVelocity()
    surfaces = Surfaces(CAMERA, SensorModel.of(CAMERA, config), config.surfaces)
    carrying_on = CarryingOn(surfaces, Turning(CAMERA, config.turning, config.surfaces), motion, 0.5)
    pictures = []
    for index in range(90):
        turn = exponential(np.array([0.0, 0.0, 0.0, 0.01 * np.sin(index), 0.3 * np.sin(index / 20.0), 0.0]))
        gray, depth = shot(CORNER, turn, 2.0, checks=1)
        frame = RgbdFrame(index, index / 60.0, np.repeat(gray[:, :, None], 3, axis=2), np.zeros_like(depth))
        nothing: Any = None
        pictures.append(Picture(frame, gray, nothing, nothing, False))
    first = pictures[0]
    last = LastFrame(0.0, first.gray, first.frame.depth, nothing, nothing, nothing, 0, np.eye(4))
    for picture in pictures[1:]:
        pose = carrying_on.follow(last, picture)
        assert carrying_on.told is Told.TURN
        assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3), abs=1e-9)
        assert np.linalg.norm(pose[:3, 3]) < 1e-3
    assert pose[0, 2] == pytest.approx(np.sin(0.3 * np.sin(89 / 20.0)), abs=0.02)
