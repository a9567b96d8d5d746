"""Which keyframes hold an adjustment, so that it has a frame."""

import numpy as np
import pytest
from slam_scenes import SENSOR, add_view, descriptors_of, points_ahead, pose_error, rigid, view_of

from lpslam.camera import inverse_transform
from lpslam.slam.adjusting import Adjuster
from lpslam.slam.kernels import graph
from lpslam.slam.map import SlamMap

APART = 2
"""Keyframes of the first group; those of the second share no point with them."""

SEEN = 80


def truth(keyframe: int) -> np.ndarray:
    """Camera from world of a keyframe: they step aside, the second group elsewhere."""
    return rigid([0.15 * keyframe + (3.0 if keyframe >= APART else 0.0), 0.0, 0.0], [0.0, 0.02 * keyframe, 0.0])


@pytest.fixture
def two_groups() -> SlamMap:
    """A map whose keyframes 0 and 1 see some points, and 2 to 4 others: only surfaces have led from 1 to 2."""
    random = np.random.default_rng(4)
    slam_map = SlamMap(SEEN, SENSOR.scales)
    for group in (range(APART), range(APART, APART + 3)):
        in_world = points_ahead(random, SEEN, 1.5, 3.5)
        first = truth(group.start)
        in_world = (in_world - first[:3, 3]) @ first[:3, :3]
        descriptors = descriptors_of(random, SEEN)
        ids = np.empty(0, np.int32)
        for keyframe in group:
            added = add_view(slam_map, truth(keyframe), view_of(truth(keyframe), in_world, descriptors), keyframe - 1)
            if keyframe == group.start:
                start = slam_map.add_points(added, np.arange(SEEN, dtype=np.int32), in_world)
                ids = np.arange(start, start + SEEN, dtype=np.int32)
            else:
                graph.link_all(slam_map.columns, ids, int(slam_map.columns.keyframe_slot[added]))
        graph.refresh_points(slam_map.columns, ids, SENSOR.scales)
    return slam_map


def rows(*keyframes: int) -> np.ndarray:
    return np.array(keyframes, np.int32)


def test_keyframes_that_nobody_else_sees_hold_by_their_oldest(two_groups: SlamMap) -> None:
    gathered = Adjuster(two_groups, SENSOR).gather(rows(4, 2, 3))
    assert sorted(gathered.free.tolist()) == [3, 4]
    assert sorted(gathered.keyframes.tolist()) == [2, 3, 4]
    assert len(gathered.points) == SEEN


def test_an_onlooker_holds_and_nobody_else_has_to(two_groups: SlamMap) -> None:
    gathered = Adjuster(two_groups, SENSOR).gather(rows(3, 4))
    assert sorted(gathered.free.tolist()) == [3, 4]
    assert sorted(gathered.keyframes.tolist()) == [2, 3, 4]


def test_a_root_holds_whoever_is_older_elsewhere(two_groups: SlamMap) -> None:
    gathered = Adjuster(two_groups, SENSOR).gather(rows(0, 1))
    assert gathered.free.tolist() == [1]


def test_nothing_or_what_is_gone_is_no_problem(two_groups: SlamMap) -> None:
    adjuster = Adjuster(two_groups, SENSOR)
    assert len(adjuster.gather(rows()).free) == 0
    two_groups.remove_keyframe(3)
    assert sorted(adjuster.gather(rows(2, 3, 4)).free.tolist()) == [4]


def test_a_keyframe_alone_stays(two_groups: SlamMap) -> None:
    for keyframe in (4, 3):
        two_groups.remove_keyframe(keyframe)
    before = two_groups.camera_from_world(2).copy()
    Adjuster(two_groups, SENSOR).adjust(rows(2), (3, 3), np.zeros(1, np.bool_))
    np.testing.assert_array_equal(two_groups.camera_from_world(2), before)


def test_adjusting_them_mends_the_others_and_leaves_the_oldest(two_groups: SlamMap) -> None:
    two_groups.columns.camera_from_world[3] = rigid([0.02, 0.01, -0.02], [0.0, 0.01, 0.0]) @ truth(3)
    two_groups.columns.camera_from_world[4] = rigid([-0.02, 0.0, 0.01], [0.01, 0.0, 0.0]) @ truth(4)
    Adjuster(two_groups, SENSOR).adjust(rows(2, 3, 4), (6, 6), np.zeros(1, np.bool_))
    np.testing.assert_array_equal(two_groups.camera_from_world(2), truth(2))
    for keyframe in (3, 4):
        metres, radians = pose_error(
            inverse_transform(two_groups.camera_from_world(keyframe)), inverse_transform(truth(keyframe))
        )
        assert metres < 0.002
        assert radians < 0.001


@pytest.mark.parametrize(("aside", "is_torn"), [(0.05, False), (1.5, True)])
def test_a_keyframe_is_not_torn_away_by_the_few_points_that_look_like_its_own(aside: float, is_torn: bool) -> None:
    few = 13
    random = np.random.default_rng(7)
    slam_map, in_world = SlamMap(SEEN, SENSOR.scales), points_ahead(random, SEEN, 1.5, 3.5)
    descriptors = descriptors_of(random, SEEN)
    for keyframe in range(2):
        add_view(slam_map, truth(keyframe), view_of(truth(keyframe), in_world, descriptors), keyframe - 1)
    ids = slam_map.add_points(0, np.arange(SEEN, dtype=np.int32), in_world) + np.arange(SEEN, dtype=np.int32)
    graph.link_all(slam_map.columns, ids, int(slam_map.columns.keyframe_slot[1]))
    # The next keyframe is where tracking says; what it sees of the map is the front beside, which looks the same.
    pose, beside = (
        truth(1) @ rigid([0.1, 0.0, 0.0], [0.0, 0.0, 0.0]),
        truth(1) @ rigid([0.1 + aside, 0.0, 0.0], [0.0, 0.0, 0.0]),
    )
    added = add_view(slam_map, pose, view_of(beside, in_world[:few], descriptors[:few]), 1)
    graph.link_all(slam_map.columns, ids[:few], int(slam_map.columns.keyframe_slot[added]))
    graph.refresh_points(slam_map.columns, ids, SENSOR.scales)
    Adjuster(slam_map, SENSOR).adjust(rows(added), (10, 10), np.zeros(1, np.bool_))
    metres, _ = pose_error(slam_map.camera_from_world(added), pose if is_torn else beside)
    assert metres < 0.02
