from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from slam_scenes import (
    LOOKING_AHEAD,
    SENSOR,
    add_view,
    check_graph,
    descriptors_of,
    features_at,
    pose_error,
    rigid,
    twists,
)

from lpslam.camera import inverse_transform, transform_points
from lpslam.slam.features import Features
from lpslam.slam.kernels import graph
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.map import SlamMap
from lpslam.slam.state import TrackedFrame, TrackingState
from lpslam.slam.trajectory import Trajectory

FEATURES = 10


def features(random: np.random.Generator, count: int = FEATURES) -> Features:
    pixels = random.uniform(0, [640, 480], (count, 2))
    depths = np.where(random.random(count) < 0.8, random.uniform(0.5, 6, count), 0.0)
    octaves = random.integers(0, 8, count)
    return features_at(pixels, depths, descriptors_of(random, count), octaves, random.uniform(0, 6, count))


def walked(seed: int, keyframes: int = 6, points_each: int = 5) -> SlamMap:
    """A map of keyframes along a path, each the child of the one before, with points that the next one sees too."""
    random = np.random.default_rng(seed)
    slam_map = SlamMap(FEATURES, SENSOR.scales)
    pose = inverse_transform(LOOKING_AHEAD)
    for k in range(keyframes):
        pose = rigid([*random.normal(0, 0.1, 3)], [*random.normal(0, 0.1, 3)]) @ pose
        keyframe = add_view(slam_map, pose, features(random), k - 1)
        slot = int(slam_map.columns.keyframe_slot[keyframe])
        if k:
            for i in range(points_each):
                graph.link(slam_map.columns, slam_map.point_count - points_each + i, slot, FEATURES - 1 - i)
        slam_map.add_points(keyframe, np.arange(points_each, dtype=np.int32), random.normal(size=(points_each, 3)))
    check_graph(slam_map)
    return slam_map


def assert_equal_maps(one: SlamMap, other: SlamMap) -> None:
    first, second = one.to_arrays(), other.to_arrays()
    assert first.keys() == second.keys()
    for name, array in first.items():
        assert array.dtype == second[name].dtype, name
        np.testing.assert_array_equal(array, second[name], err_msg=name)


# Growth ------------------------------------------------------------------------------------------------------------


def test_the_map_grows_beyond_its_first_capacity_and_forgets_nothing() -> None:
    random = np.random.default_rng(0)
    slam_map = SlamMap(200, SENSOR.scales)
    views, poses, places = [], [], []
    for k in range(150):
        views.append(features(random, 200))
        poses.append(rigid([*random.normal(size=3)], [*random.normal(size=3)]))
        places.append(random.normal(size=(120, 3)))
        assert add_view(slam_map, poses[k], views[k], k - 1) == k
        assert slam_map.add_points(k, np.arange(120, dtype=np.int32), places[k]) == 120 * k
    assert slam_map.keyframe_count == 150 > 2 * 64
    assert slam_map.point_count == 18_000 > 2 * 8192
    m = slam_map.columns
    for k in range(150):
        slot = m.keyframe_slot[k]
        np.testing.assert_array_equal(slam_map.camera_from_world(k), poses[k])
        np.testing.assert_array_equal(m.pixels[slot, :200], views[k].pixels)
        np.testing.assert_array_equal(m.descriptor[slot, :200], views[k].descriptor)
        np.testing.assert_array_equal(m.has_depth[slot, :200], views[k].has_depth)
        np.testing.assert_array_equal(m.point[slot, :120], np.arange(120 * k, 120 * (k + 1)))
        assert (m.point[slot, 120:] == -1).all()
    np.testing.assert_array_equal(slam_map.point_positions(), np.concatenate(places))
    np.testing.assert_array_equal(slam_map.timestamps(), np.arange(150.0))
    assert (m.first_keyframe[: slam_map.point_count] == np.repeat(np.arange(150), 120)).all()


def test_too_many_keypoints_are_refused_and_leave_the_map_as_it_was() -> None:
    slam_map = walked(0)
    before = slam_map.to_arrays()
    with pytest.raises(ValueError, match="11 keypoints"):
        add_view(slam_map, np.eye(4), features(np.random.default_rng(0), 11), 0)
    for name, array in slam_map.to_arrays().items():
        np.testing.assert_array_equal(array, before[name], err_msg=name)


# Keyframes that go -------------------------------------------------------------------------------------------------


def test_a_removed_keyframe_keeps_its_place_relative_to_its_parent_through_any_chain() -> None:
    slam_map = walked(1)
    truth = [slam_map.camera_from_world(k).copy() for k in range(6)]
    for gone in (3, 2, 4):  # 3's parent goes after it; 4 was 3's child
        slam_map.remove_keyframe(gone)
        check_graph(slam_map)
        assert not slam_map.is_alive(gone)
        for k in range(6):
            np.testing.assert_allclose(slam_map.camera_from_world(k), truth[k], atol=1e-12)
    assert slam_map.living_keyframes().tolist() == [0, 1, 5]
    assert slam_map.to_arrays()["parent"][5] == 1
    correction = rigid([0.3, -0.2, 0.1], [0.1, 0.2, -0.3])
    slam_map.columns.camera_from_world[1] = correction @ truth[1]
    for k in (2, 3, 4):
        expected = truth[k] @ inverse_transform(truth[1]) @ correction @ truth[1]
        np.testing.assert_allclose(slam_map.camera_from_world(k), expected, atol=1e-12)
        np.testing.assert_allclose(slam_map.world_from_keyframe(k), inverse_transform(expected), atol=1e-12)
    for k in (0, 5):
        np.testing.assert_array_equal(slam_map.camera_from_world(k), truth[k])


def test_a_slot_is_used_again_and_an_id_never() -> None:
    slam_map = walked(2)
    slot = int(slam_map.columns.keyframe_slot[3])
    slam_map.remove_keyframe(3)
    random = np.random.default_rng(2)
    view = features(random, 4)
    new = add_view(slam_map, np.eye(4), view, 5)
    m = slam_map.columns
    assert new == 6
    assert m.keyframe_slot[new] == slot
    assert m.feature_count[slot] == 4
    assert (m.point[slot] == -1).all()
    assert (m.next_observation[slot] == -1).all()
    check_graph(slam_map)


def test_points_that_only_a_removed_keyframe_saw_die_with_it() -> None:
    slam_map = walked(3)
    m = slam_map.columns
    own = np.arange(25, 30)  # the last keyframe's
    slam_map.remove_keyframe(5)
    assert not m.point_alive[own].any()
    assert m.point_alive[:25].all()
    assert len(slam_map.point_positions()) == 25


@pytest.mark.parametrize("keyframe", [0, 2])
def test_the_root_and_what_is_gone_cannot_be_removed(keyframe: int) -> None:
    """The root carries the world frame: nothing is left to tell its pose by."""
    slam_map = walked(4)
    slam_map.remove_keyframe(2)
    before = slam_map.to_arrays()
    with pytest.raises(ValueError, match=f"keyframe {keyframe}"):
        slam_map.remove_keyframe(keyframe)
    for name, array in slam_map.to_arrays().items():
        np.testing.assert_array_equal(array, before[name], err_msg=name)


def test_a_removed_keyframe_shares_no_points() -> None:
    slam_map = walked(5)
    slam_map.remove_keyframe(3)
    assert slam_map.covisible(3, 1).tolist() == []
    assert slam_map.covisible(1, 1).tolist() == [0, 2]


# Change of world ---------------------------------------------------------------------------------------------------


@given(twists(distance=10.0), st.integers(0, 100))
def test_a_change_of_world_leaves_what_every_camera_sees(twist: np.ndarray, seed: int) -> None:
    slam_map = walked(seed)
    slam_map.remove_keyframe(3)
    new_from_old = exponential(twist)
    seen = [transform_points(slam_map.camera_from_world(k), slam_map.point_positions()) for k in range(6)]
    old_poses = [slam_map.world_from_keyframe(k) for k in range(6)]
    m = slam_map.columns
    facing = m.normal[: slam_map.point_count].copy()
    slam_map.transform(new_from_old)
    for k in range(6):
        now = transform_points(slam_map.camera_from_world(k), slam_map.point_positions())
        np.testing.assert_allclose(now, seen[k], atol=1e-9)
        np.testing.assert_allclose(slam_map.world_from_keyframe(k), new_from_old @ old_poses[k], atol=1e-9)
    np.testing.assert_allclose(m.normal[: slam_map.point_count], facing @ new_from_old[:3, :3].T, atol=1e-6)
    slam_map.transform(inverse_transform(new_from_old))
    for k in range(6):
        np.testing.assert_allclose(slam_map.world_from_keyframe(k), old_poses[k], atol=1e-8)


# Arrays ------------------------------------------------------------------------------------------------------------


@settings(max_examples=20)
@given(st.integers(0, 1000), st.lists(st.integers(1, 79), max_size=30, unique=True), st.sampled_from([1, 6, 80]))
def test_a_map_read_back_from_its_arrays_is_equal_and_goes_on_alike(seed: int, gone: list[int], keyframes: int) -> None:
    slam_map = walked(seed, keyframes)
    for keyframe in gone:
        if keyframe < keyframes:
            slam_map.remove_keyframe(keyframe)
    again = SlamMap.from_arrays({name: array.copy() for name, array in slam_map.to_arrays().items()})
    assert_equal_maps(slam_map, again)
    check_graph(again)
    for k in range(keyframes):
        np.testing.assert_array_equal(slam_map.camera_from_world(k), again.camera_from_world(k))
    for one in (slam_map, again):
        random = np.random.default_rng(seed)
        for _ in range(70):
            keyframe = add_view(one, np.eye(4), features(random), 0)
            one.add_points(keyframe, np.arange(5, dtype=np.int32), random.normal(size=(5, 3)))
        one.remove_keyframe(keyframe - 1)
        check_graph(one)
    assert_equal_maps(slam_map, again)


def test_the_arrays_of_an_empty_map_can_be_read_back() -> None:
    again = SlamMap.from_arrays(SlamMap(7, SENSOR.scales).to_arrays())
    assert again.keyframe_count == again.point_count == 0
    assert len(again.living_keyframes()) == len(again.living_points()) == 0
    assert again.point_positions().shape == (0, 3)
    add_view(again, np.eye(4), features(np.random.default_rng(0), 7), -1)


def test_arrays_are_copies() -> None:
    slam_map = walked(6)
    arrays = slam_map.to_arrays()
    for array in arrays.values():
        array[:] = 0
    check_graph(slam_map)
    assert slam_map.scales[-1] == SENSOR.scales[-1]


@pytest.mark.parametrize("name", sorted(walked(0).to_arrays()))
def test_a_missing_or_misshapen_column_is_refused(name: str) -> None:
    arrays = walked(0).to_arrays()
    if name != "inverse_sigma":
        with pytest.raises((KeyError, ValueError)):
            SlamMap.from_arrays({key: array for key, array in arrays.items() if key != name})
    wrong: list[np.ndarray] = [arrays[name][..., None]]
    if name not in ("scales", "free_slots", "loop_edges"):  # these may have any length, and the first two any numbers
        wrong += [arrays[name].astype(np.complex128), arrays[name][:-1]]
    for bad in wrong:
        with pytest.raises(ValueError, match=r"."):
            SlamMap.from_arrays({**arrays, name: bad})


@pytest.mark.parametrize(
    ("name", "row", "value"),
    [
        ("keyframe_slot", 2, 6),
        ("keyframe_slot", 2, 1_000_000),
        ("keyframe_slot", 2, -7),
        ("keyframe_slot", 2, 1),  # two keyframes in one slot
        ("slot_keyframe", 2, 6),
        ("slot_keyframe", 2, 1),
        ("feature_count", 2, FEATURES + 1),
        ("feature_count", 2, -1),
        ("octave", (2, 3), 8),
        ("octave", (2, 3), 255),
        ("point", (2, 3), 30),
        ("point", (2, 3), -2),
        ("point", (2, 3), 0),  # a point that does not list it
        ("head", 4, 60),
        ("head", 4, -2),
        ("head", 4, -1),  # a list that lost its head
        ("next_observation", (2, 3), 60),
        ("next_observation", (0, 0), 0),  # a circle
        ("observations", 4, 77),
        ("first_keyframe", 4, 6),
        ("parent", 3, 3),  # its own parent: the chain of a removed keyframe would not end
        ("parent", 3, 4),
        ("parent", 3, -2),
        ("free_slots", 0, 2),
        ("free_slots", 0, 6),
        ("scales", 3, 0.0),
        ("scales", 3, np.nan),
        ("camera_from_world", (2, 0, 0), np.nan),
        ("position", (4, 1), np.inf),
    ],
)
def test_numbers_that_would_lead_out_of_the_map_are_refused(name: str, row: Any, value: float) -> None:
    """Kernels trust these columns: a wrong row number would read foreign memory."""
    slam_map = walked(0)
    slam_map.remove_keyframe(5)
    arrays = slam_map.to_arrays()
    SlamMap.from_arrays(arrays)
    arrays[name][row] = value
    with pytest.raises(ValueError, match=r"."):
        SlamMap.from_arrays(arrays)


# The trajectory ----------------------------------------------------------------------------------------------------


def follow(slam_map: SlamMap, frames: int = 40) -> tuple[Trajectory, np.ndarray]:
    """Frames around keyframes, every seventh lost; with the true poses of the tracked ones."""
    random = np.random.default_rng(9)
    trajectory, poses = Trajectory(), []
    for index in range(frames):
        if index % 7 == 3:
            trajectory.append(TrackedFrame(index, index / 30, TrackingState.LOST, 2, None, None, 0, False, "0 matched"))
            continue
        keyframe = index % slam_map.keyframe_count
        near = exponential(random.normal(0, 0.1, 6))
        poses.append(slam_map.world_from_keyframe(keyframe) @ near)
        state = TrackingState.WEAK if index % 5 == 0 else TrackingState.TRACKING
        trajectory.append(TrackedFrame(index, index / 30, state, keyframe, near, poses[-1], 99, False))
    return trajectory, np.array(poses)


def test_the_trajectory_holds_tracked_frames_where_they_were() -> None:
    slam_map = walked(7)
    trajectory, truth = follow(slam_map)
    timestamps, poses = trajectory.world_from_camera(slam_map)
    assert len(trajectory) == 40
    assert trajectory.tracked_count == len(truth) == len(timestamps) == 34
    np.testing.assert_allclose(timestamps, [i / 30 for i in range(40) if i % 7 != 3])
    np.testing.assert_allclose(poses, truth, atol=1e-12)


def test_every_correction_reaches_the_frames_through_their_keyframes() -> None:
    slam_map = walked(7)
    trajectory, truth = follow(slam_map)
    slam_map.remove_keyframe(4)
    correction = rigid([0.5, 0.1, -0.2], [0.1, -0.2, 0.3])
    slam_map.columns.camera_from_world[3] = slam_map.columns.camera_from_world[3] @ inverse_transform(correction)
    _, poses = trajectory.world_from_camera(slam_map)
    hung_on = np.array([i % 6 for i in range(40) if i % 7 != 3])
    for keyframe, pose, old in zip(hung_on, poses, truth, strict=True):
        expected = correction @ old if keyframe in (3, 4) else old  # 4 was 3's child
        assert pose_error(pose, expected)[0] < 1e-9
    slam_map.transform(correction)
    _, moved = trajectory.world_from_camera(slam_map)
    np.testing.assert_allclose(moved, correction @ poses, atol=1e-9)


def test_a_trajectory_read_back_from_its_arrays_is_equal() -> None:
    slam_map = walked(7)
    trajectory, _ = follow(slam_map)
    arrays = trajectory.to_arrays()
    again = Trajectory.from_arrays(arrays)
    for name, array in again.to_arrays().items():
        assert array.dtype == arrays[name].dtype
        np.testing.assert_array_equal(array, arrays[name], err_msg=name)
    for one, other in zip(trajectory.world_from_camera(slam_map), again.world_from_camera(slam_map), strict=True):
        np.testing.assert_array_equal(one, other)
    assert again.tracked_count == trajectory.tracked_count


def test_an_empty_or_wholly_lost_trajectory_has_no_poses() -> None:
    slam_map = walked(7)
    for trajectory in (Trajectory(), Trajectory.from_arrays(Trajectory().to_arrays())):
        timestamps, poses = trajectory.world_from_camera(slam_map)
        assert timestamps.shape == (0,)
        assert poses.shape == (0, 4, 4)
        trajectory.append(TrackedFrame(0, 0.0, TrackingState.INITIALISING, -1, None, None, 0, False, "no depth"))
        assert trajectory.tracked_count == 0
        assert trajectory.world_from_camera(slam_map)[1].shape == (0, 4, 4)


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        ("state", lambda a: a[:-1]),
        ("keyframe_from_camera", lambda a: a[:, :3]),
        ("timestamp", lambda a: a[:5]),
        ("state", lambda a: a + 9),
    ],
)
def test_columns_that_are_no_trajectory_are_refused(name: str, damage: Any) -> None:
    arrays = follow(walked(7))[0].to_arrays()
    arrays[name] = damage(arrays[name])
    with pytest.raises(ValueError, match=r"."):
        Trajectory.from_arrays(arrays)


def test_a_map_without_uncertain_distances_has_sure_points() -> None:
    arrays = walked(0).to_arrays()
    del arrays["inverse_sigma"]
    again = SlamMap.from_arrays(arrays)
    assert not again.columns.inverse_sigma.any()


@pytest.mark.parametrize("sigma", [-0.1, np.nan, np.inf])
def test_an_impossible_uncertainty_is_refused(sigma: float) -> None:
    arrays = walked(0).to_arrays()
    arrays["inverse_sigma"][3] = sigma
    with pytest.raises(ValueError, match="inverse_sigma"):
        SlamMap.from_arrays(arrays)
