"""Keypoints without depth: they hold the camera's turn where few map points are in view."""

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from disturbances import Clip, Disturbed, hardly_any_depth
from slam_scenes import rigid

from lpslam.camera import inverse_transform, transform_points
from lpslam.config import FarPointConfig, MappingConfig, SlamConfig, TrackingConfig
from lpslam.evaluation.trajectory import absolute_trajectory_error
from lpslam.poses import StampedPoses
from lpslam.slam.state import EventKind, TrackedFrame, TrackingState
from lpslam.slam.system import RgbdSlam

pytestmark = pytest.mark.slow

FRAMES = 50
FLAT = range(8, 36)
"""Frames with hardly any depth, while the camera turns by sixty degrees and walks two metres."""

UNTRIANGULATED = MappingConfig(triangulated_neighbours=0)
"""No new map points without depth: what was mapped before leaves the view."""


@pytest.fixture(scope="module")
def clip(walk: Path) -> Clip:
    return Clip(walk, range(FRAMES))


def run(clip: Clip, count: int = FRAMES, **tracking: int) -> tuple[RgbdSlam, list[TrackedFrame]]:
    config = SlamConfig(
        tracking=TrackingConfig.model_validate(tracking), mapping=UNTRIANGULATED, far_points=FarPointConfig(most=0)
    )
    slam = RgbdSlam(clip.camera, config)
    frames = islice(Disturbed(clip, hardly_any_depth(FLAT.start, FLAT.stop)), count)
    return slam, [slam.process(frame) for frame in frames]


def test_a_camera_is_followed_on_while_depth_is_missing(clip: Clip) -> None:
    slam, tracked = run(clip)
    assert all(frame.is_tracked for frame in tracked)
    assert sum(frame.is_coasted for frame in tracked) <= 3
    assert all(frame.state is TrackingState.TRACKING for frame in tracked[FLAT.stop + 3 :])
    assert set(slam.map.submaps().tolist()) == {0}
    error = absolute_trajectory_error(clip.truth, StampedPoses(*slam.trajectory.world_from_camera(slam.map)))
    assert error.count == FRAMES
    assert error.max < 0.04


def test_without_bearings_it_is_lost(clip: Clip) -> None:
    """Unless it is carried over the frames without the map."""
    slam, tracked = run(clip, bearings_below=0, coast_seconds=0)
    assert EventKind.LOST in {event.kind for event in slam.events}
    assert not all(frame.is_tracked for frame in tracked)


@pytest.mark.parametrize(("below", "helps"), [(10_000, True), (0, False)])
def test_bearings_tell_a_turn_and_no_step(clip: Clip, below: int, helps: bool) -> None:
    slam, _ = run(clip, FLAT.start + 6, bearings_below=below)
    tracker = slam._tracker
    last = tracker._where.last
    assert last is not None
    pose = last.camera_from_world(slam.map)
    predicted = rigid([0.05, 0.0, 0.08], [0.0, 0.03, 0.0]) @ pose
    sighted = tracker._guesser._sighted(last, predicted)
    has_place = last.features.has_depth | (last.points >= 0)
    is_bearing = ~has_place[sighted.rows]
    assert is_bearing.any() == helps
    assert (sighted.points[is_bearing] < 0).all()
    assert (sighted.spread[~is_bearing] == 0).all()
    if helps:
        assert len(sighted.rows) == last.features.rows
        assert (sighted.spread[is_bearing] > 0).all()
        seen = transform_points(predicted, sighted.positions[is_bearing])
        assert np.linalg.norm(seen, axis=1).min() > 100.0
        stepped = rigid([0.1, 0.0, 0.1], [0, 0, 0]) @ predicted
        turned = rigid([0, 0, 0], [0.0, 0.03, 0.0]) @ predicted
        moved = [
            np.linalg.norm(
                clip.camera.project(transform_points(other, sighted.positions[is_bearing])) - clip.camera.project(seen),
                axis=1,
            )
            for other in (stepped, turned)
        ]
        assert moved[0].max() < 0.6
        assert moved[1].min() > 10.0
        # Seen from where the next camera should be, each is what stands between the sensor's reach and infinity.
        centre = inverse_transform(predicted)[:3, 3]
        near = transform_points(pose, centre + (sighted.positions[is_bearing] - centre) / 100.0)
        pixels = last.features.pixels[sighted.rows[is_bearing]]
        assert np.abs(clip.camera.project(near) - pixels).max() < 0.1
