"""Depth that is wrong by its range: what a curve does, and whether it is found."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from slam_scenes import SENSOR, add_view, descriptors_of, rigid, view_of

from lpslam.config import DepthRangeConfig, SlamConfig
from lpslam.evaluation.trajectory import absolute_trajectory_error
from lpslam.poses import StampedPoses
from lpslam.simulation.worlds.factors import draw_world
from lpslam.simulation.worlds.source import WorldSource
from lpslam.slam.kernels import graph
from lpslam.slam.map import SlamMap
from lpslam.slam.ranges.curve import DepthChange, DepthCurve
from lpslam.slam.ranges.learning import DepthRanges
from lpslam.slam.state import EventKind
from lpslam.slam.system import RgbdSlam

FARTHEST = 8.0
KNOTS = np.arange(0.0, 8.5, 0.5)

excesses = st.lists(st.floats(-0.2, 0.2), min_size=len(KNOTS), max_size=len(KNOTS))
metres = st.lists(st.floats(0.0625, 20.0, width=32), min_size=1, max_size=50)


def depths(values: list[float]) -> np.ndarray:
    return np.array(values, np.float32)


@given(excesses, metres)
def test_readings_of_what_readings_stand_for_are_the_readings(excess: list[float], values: list[float]) -> None:
    curve = DepthCurve.straight(FARTHEST).then(KNOTS, np.array(excess))
    np.testing.assert_allclose(curve.readings(curve.true(depths(values))), depths(values), rtol=1e-3, atol=1e-3)


@given(excesses, metres)
def test_what_is_farther_never_comes_nearer(excess: list[float], values: list[float]) -> None:
    curve = DepthCurve.straight(FARTHEST).then(KNOTS, np.array(excess))
    assert (np.diff(curve.true(np.sort(depths(values)))) >= 0.0).all()


def test_a_straight_curve_changes_nothing_and_costs_nothing() -> None:
    image = np.ones((4, 5), np.float32)
    assert DepthCurve.straight(FARTHEST).true(image) is image


def test_holes_stay_holes_and_pictures_keep_their_shape() -> None:
    curve = DepthCurve.straight(FARTHEST).then(KNOTS, np.full(len(KNOTS), -0.1))
    image = np.array([[0.0, 2.0], [np.nan, 9.0]], np.float32)
    true = curve.true(image)
    assert true[0, 0] == 0.0
    assert np.isnan(true[1, 0])
    np.testing.assert_allclose(true[:, 1], image[:, 1] * np.exp(0.1), rtol=1e-3)


def test_an_excess_is_taken_off_what_a_curve_says_already() -> None:
    first = DepthCurve.straight(FARTHEST).then(KNOTS, np.full(len(KNOTS), -0.05))
    both = first.then(KNOTS, np.full(len(KNOTS), -0.05))
    np.testing.assert_allclose(both.true(depths([4.0])), 4.0 * np.exp(0.1), rtol=1e-3)


@pytest.mark.parametrize("table", [[0.0, 1.0, 0.5], [0.1, 1.0], [0.0], [0.0, np.nan], [[0.0, 1.0]]])
def test_a_table_that_does_not_rise_is_refused(table: list[float]) -> None:
    with pytest.raises(ValueError, match="does not rise"):
        DepthCurve.of(np.array(table))


# Learning ------------------------------------------------------------------------------------------------------------


def too_near(true: np.ndarray) -> np.ndarray:
    """A telephone's readings: beyond five metres they fall short."""
    return np.where(true > 5.0, 5.0 + 0.6 * (true - 5.0), true)


Read = Callable[[np.ndarray], np.ndarray]


POINTS = 300


def fill(slam_map: SlamMap, read: Read, sigma: float = 0.005) -> None:
    """Add eight keyframes that step aside before points 2 to 7.5 m ahead, whose depth is read by a function."""
    random = np.random.default_rng(3)
    count = POINTS
    z = random.uniform(2.0, 7.5, count)
    points = np.column_stack([random.uniform(-0.3, 0.5, count) * z, random.uniform(-0.3, 0.3, count) * z, z])
    descriptors = descriptors_of(random, count)
    ids = np.empty(0, np.int32)
    for k in range(8):
        pose = rigid([-0.1 * k, 0.0, -0.06 * k], [0.0, 0.0, 0.0])
        view = view_of(pose, points, descriptors)
        seen = read(view.depth.astype(np.float64)) * np.exp(sigma * random.normal(size=count))
        pixels = view.pixels + random.normal(scale=0.3, size=view.pixels.shape).astype(np.float32)
        view = view._replace(
            pixels=pixels,
            depth=seen.astype(np.float32),
            u_right=(pixels[:, 0] - SENSOR.intrinsics[4] / seen).astype(np.float32),
        )
        keyframe = add_view(slam_map, pose, view, k - 1)
        if k == 0:
            ids = np.arange(count, dtype=np.int32)
            slam_map.add_points(keyframe, ids, points)
        else:
            graph.link_all(slam_map.columns, ids, int(slam_map.columns.keyframe_slot[keyframe]))


def learned(read: Read, rounds: int = 1, **config: float) -> tuple[SlamMap, DepthChange | None]:
    """A map of a room, and what was found at last when all of its keyframes had voted so many times."""
    slam_map = SlamMap(POINTS, SENSOR.scales)
    ranges = DepthRanges(slam_map, SENSOR, FARTHEST, DepthRangeConfig(**config))
    fill(slam_map, read)
    change = None
    for _ in range(rounds):
        ranges.learn(slam_map.living_keyframes())
        change = ranges.apply() or change
    return slam_map, change


def test_what_is_read_too_near_is_put_where_it_is() -> None:
    slam_map, change = learned(too_near, rounds=3)
    assert change is not None
    # Half a metre before the farthest point: there the end of what is seen may be the end of the sensor's reach.
    true = np.array([2.5, 4.0, 5.8, 6.6, 7.0])
    np.testing.assert_allclose(slam_map.depth_curve.true(too_near(true).astype(np.float32)), true, rtol=0.025)


def test_depths_of_the_map_are_corrected_with_it() -> None:
    before = SlamMap(POINTS, SENSOR.scales)
    fill(before, too_near)
    slam_map, change = learned(too_near)
    assert change is not None
    was, is_now = before.columns.depth[:8], slam_map.columns.depth[:8]
    np.testing.assert_allclose(is_now.ravel(), change(was.ravel()), rtol=1e-5)
    assert (is_now[was > 5.8] > 1.04 * was[was > 5.8]).all()


@pytest.mark.parametrize("scale", [0.9, 1.0, 1.1])
def test_one_scale_for_all_depths_shows_no_error_of_range(scale: float) -> None:
    slam_map, change = learned(lambda true: scale * true)
    assert change is None
    assert slam_map.depth_curve.is_straight


def test_an_error_within_what_sensors_promise_is_left() -> None:
    assert learned(lambda true: true * (1.0 + 0.002 * (true - 2.0)))[1] is None


def test_depths_that_contradict_one_another_show_no_curve() -> None:
    """As where people walk by: what is read of a place differs by where they are."""
    random = np.random.default_rng(8)

    def scattered(true: np.ndarray) -> np.ndarray:
        bins = np.floor(true * 2).astype(int)
        return true * np.exp(random.normal(scale=0.2, size=int(bins.max()) + 1)[bins])

    assert learned(scattered)[1] is None


def cut_off(true: np.ndarray) -> np.ndarray:
    """What a sensor leaves of noisy readings that reaches no farther than six and a half metres."""
    random = np.random.default_rng(5)
    sigma = SENSOR.depth_sigma_at(true)
    read = true + sigma * random.normal(size=true.shape)
    for _ in range(1000):
        beyond = read > 6.5
        read[beyond] = (true + sigma * random.normal(size=true.shape))[beyond]
    return np.minimum(read, 6.5)


def test_readings_that_end_at_a_reach_are_not_taken_for_too_near() -> None:
    """Told nothing of the reach, the same readings would stand for a tenth of a metre more at its end."""
    slam_map, _ = learned(cut_off, rounds=2)
    _, believed = learned(cut_off, rounds=2, reach_readings=10_000)
    end = np.array([6.4], np.float32)
    assert believed is not None
    assert abs(float(slam_map.depth_curve.true(end)[0]) - 6.4) < 0.75 * abs(float(believed.after.true(end)[0]) - 6.4)


def test_what_all_keyframes_have_from_the_same_pixels_is_told_once() -> None:
    """As where blur puts the points of a distance a little astray: eight keyframes are not eight votes."""
    found = 0
    for seed in range(30):
        astray = np.random.default_rng(seed).normal(scale=0.01, size=20)
        _, change = learned(lambda true, astray=astray: true * np.exp(astray[np.floor(true * 2).astype(int)]))
        found += change is not None
    assert found <= 2


def test_learning_can_be_turned_off() -> None:
    assert learned(too_near, certain_gain=0.0)[1] is None


def test_keyframes_that_may_be_blurred_have_no_vote() -> None:
    """Their points lie anywhere on streaks, and all of one turn alike: dark malls were corrected by 4 % so."""
    slam_map = SlamMap(POINTS, SENSOR.scales)
    ranges = DepthRanges(slam_map, SENSOR, FARTHEST, DepthRangeConfig())
    fill(slam_map, too_near)
    slam_map.blurred.update(slam_map.living_keyframes().tolist())
    ranges.learn(slam_map.living_keyframes())
    assert ranges.apply() is None
    slam_map.blurred.clear()
    ranges.learn(slam_map.living_keyframes())
    assert ranges.apply() is not None


def test_keyframes_of_an_earlier_recording_neither_vote_nor_change() -> None:
    slam_map = SlamMap(POINTS, SENSOR.scales)
    fill(slam_map, too_near)
    before = slam_map.columns.depth.copy()
    ranges = DepthRanges(slam_map, SENSOR, FARTHEST, DepthRangeConfig())
    ranges.learn(slam_map.living_keyframes())
    assert ranges.apply() is None
    np.testing.assert_array_equal(slam_map.columns.depth, before)


def test_a_curve_is_saved_with_its_map() -> None:
    slam_map, _ = learned(too_near)
    arrays = slam_map.to_arrays()
    np.testing.assert_array_equal(SlamMap.from_arrays(arrays).depth_curve.table, slam_map.depth_curve.table)
    assert "depth_table" not in SlamMap(POINTS, SENSOR.scales).to_arrays()


@pytest.mark.slow
def test_a_telephone_that_guesses_what_is_far_keeps_its_scale() -> None:
    """A forecourt of which most lies beyond a LiDAR's five metres: the way came out 14 % too short."""
    source = WorldSource(draw_world(5261))
    slam = RgbdSlam(source.camera, SlamConfig())
    for frame in source:
        slam.process(frame)
    slam.finish()
    truth = StampedPoses(source.ground_truth.timestamps, source.ground_truth.world_from_camera)
    error = absolute_trajectory_error(truth, StampedPoses(*slam.trajectory.world_from_camera(slam.map)))
    walked = float(np.linalg.norm(np.diff(truth.world_from_camera[:, :3, 3], axis=0), axis=1).sum())
    assert error.rmse < 0.012 * walked
    assert slam.trajectory.tracked_count == len(source)
    assert EventKind.DEPTH_RANGES in [event.kind for event in slam.events]
