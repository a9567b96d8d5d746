"""Rolling shutter: what bends is straightened, and the readout is found from views in different motion."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from slam_scenes import UNCHECKED

from lpslam.camera import PinholeCamera
from lpslam.config import ShutterConfig, SlamConfig
from lpslam.evaluation.trajectory import absolute_trajectory_error
from lpslam.poses import StampedPoses
from lpslam.slam.kernels.geometry import exponential, logarithm
from lpslam.slam.kernels.shutter import straighten
from lpslam.slam.map import SlamMap
from lpslam.slam.sensor import SensorModel
from lpslam.slam.shutter.readout import Correspondences, readout_between
from lpslam.slam.shutter.straightening import RollingShutter
from lpslam.slam.system import RgbdSlam
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source

Array = NDArray[np.float64]

CAMERA = PinholeCamera(640, 480, 520.0, 525.0, 320.0, 240.0)
SENSOR = SensorModel.of(CAMERA, SlamConfig())
DESK = Path(__file__).parents[4] / "shared" / "data" / "desk_rotations"

twists = st.lists(st.floats(-1.5, 1.5), min_size=6, max_size=6).map(np.array)


def seen_row_by_row(points: Array, twist: Array, readout: float) -> tuple[Array, Array]:
    """Pixels (n, 2) and depths (n,) of points in the middle row's camera frame, each at its own row's time."""
    pixels, depth = CAMERA.project(points), points[:, 2]
    for _ in range(30):
        times = ((pixels[:, 1] + 0.5) / CAMERA.height - 0.5) * readout
        moved = np.array([(exponential(t * twist) @ np.append(p, 1.0))[:3] for t, p in zip(times, points, strict=True)])
        pixels, depth = CAMERA.project(moved), moved[:, 2]
    return pixels, depth


def room(seed: int, count: int = 200) -> Array:
    """Points (n, 3) in view, metres."""
    rng = np.random.default_rng(seed)
    z = rng.uniform(0.8, 4.0, count)
    u, v = rng.uniform(40, 600, count), rng.uniform(40, 440, count)
    return np.column_stack([(u - CAMERA.cx) / CAMERA.fx * z, (v - CAMERA.cy) / CAMERA.fy * z, z])


@given(twists)
@settings(max_examples=40, deadline=None)
def test_the_logarithm_undoes_the_exponential(twist: Array) -> None:
    np.testing.assert_allclose(logarithm(exponential(twist)), twist, atol=1e-9)


@given(twists, st.floats(-0.03, 0.03))
@settings(max_examples=25, deadline=None)
def test_what_was_seen_row_by_row_is_put_where_it_was_at_the_middle_row(twist: Array, readout: float) -> None:
    points = room(1, 50)
    seen, depth = seen_row_by_row(points, twist, readout)
    pixels, straight = straighten(
        seen.astype(np.float32), depth.astype(np.float32), twist, readout, CAMERA.height, SENSOR.intrinsics
    )
    np.testing.assert_allclose(pixels, CAMERA.project(points), atol=2e-3)
    np.testing.assert_allclose(straight, points[:, 2], atol=1e-4)


def test_without_depth_the_turn_alone_is_straightened() -> None:
    points, twist = room(2, 50), np.array([0.0, 0, 0, 0.4, -1.2, 0.8])
    seen, _ = seen_row_by_row(points, twist, 0.025)
    pixels, depth = straighten(
        seen.astype(np.float32), np.zeros(50, np.float32), twist, 0.025, CAMERA.height, SENSOR.intrinsics
    )
    np.testing.assert_allclose(pixels, CAMERA.project(points), atol=2e-3)
    assert not depth.any()


@pytest.mark.parametrize("readout", [0.0, 0.012, 0.028, -0.02])
def test_the_readout_is_found_from_two_views_in_different_motion(readout: float) -> None:
    rng = np.random.default_rng(3)
    points = room(3)
    after_from_before = exponential(np.array([0.05, -0.02, 0.03, 0.03, -0.05, 0.02]))
    moved = points @ after_from_before[:3, :3].T + after_from_before[:3, 3]
    turning, back = np.array([0.1, 0, 0, 0.2, 1.4, 0.1]), np.array([0.0, 0.1, 0, -0.5, -1.0, 0.6])
    before, depth = seen_row_by_row(points, turning, readout)
    after, _ = seen_row_by_row(moved, back, readout)
    after += rng.normal(0, 0.7, after.shape)
    # One match in ten is wrong.
    after[::10] = rng.uniform(0, 480, (20, 2))
    found = readout_between(
        Correspondences(
            before.astype(np.float32),
            depth.astype(np.float32),
            turning,
            after.astype(np.float32),
            back,
            np.full(200, 1 / 0.7**2, np.float32),
        ),
        np.eye(4),
        0.0,
        SENSOR,
    )
    assert found is not None
    assert abs(found.readout - readout) < max(4 * found.sigma, 0.0005)
    assert found.sigma < 0.001
    assert found.agreeing > 160


def test_the_same_motion_in_both_views_tells_nothing() -> None:
    points, twist = room(4), np.array([0.0, 0, 0, 0.1, 1.0, 0.0])
    seen, depth = seen_row_by_row(points, twist, 0.028)
    found = readout_between(
        Correspondences(
            seen.astype(np.float32),
            depth.astype(np.float32),
            twist,
            seen.astype(np.float32),
            twist,
            np.ones(200, np.float32),
        ),
        np.eye(4),
        0.0,
        SENSOR,
    )
    assert found is None or found.sigma > ShutterConfig().largest_sigma


@pytest.mark.slow
@pytest.mark.skipif(not DESK.is_dir(), reason="shared/data is not here")
def test_a_recorded_desk_in_quick_turns_is_tracked_whole_to_the_centimetre() -> None:
    """400 frames of a Kinect in the hand; without straightening the error is three to five times as large."""
    source, truth = open_source(DESK, checks=UNCHECKED), read_ground_truth(DESK)
    assert truth is not None
    slam = RgbdSlam(source.camera)
    tracked = [slam.process(frame).is_tracked for frame in source]
    slam.finish()
    assert all(tracked)
    estimate = StampedPoses(*slam.trajectory.world_from_camera(slam.map))
    assert len(estimate) == len(tracked)
    assert absolute_trajectory_error(truth, estimate).rmse < 0.02


@pytest.mark.parametrize(("spread", "is_settled"), [(0.0004, True), (0.006, False)])
def test_a_readout_is_settled_once_what_is_left_in_doubt_is_less_than_the_least_change(
    spread: float, is_settled: bool
) -> None:
    config = ShutterConfig(settled_pairs=40)
    shutter = RollingShutter(SENSOR, SlamMap(100, SENSOR.scales), SlamConfig().tracking, config)
    shutter._gaps.append(1 / 30)
    shutter._pairs.extend((float(value), 1e6) for value in np.linspace(-spread, spread, 39))
    shutter._reconsider()
    assert not shutter.is_settled
    shutter._pairs.append((0.0, 1e6))
    shutter._reconsider()
    assert shutter.is_settled is is_settled
