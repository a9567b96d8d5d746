import numpy as np
import pytest
from loop_scenes import KEYFRAMES_A_ROUND, Walk, World, around
from slam_scenes import SENSOR, check_graph, pose_error, rigid

from lpslam.camera import inverse_transform
from lpslam.config import SlamConfig
from lpslam.slam.integrity import refuse_broken_columns
from lpslam.slam.kernels import fusing
from lpslam.slam.map import SlamMap
from lpslam.slam.places.loop_correction import LoopCorrector, Tie

GO = np.zeros(1, np.bool_)
OFF = rigid([0.1, -0.05, 0.08], [0.01, 0.03, -0.02])


def walked(keyframes: int = 14, seed: int = 0) -> Walk:
    walk = Walk(World.of(np.random.default_rng(seed)), seed, 0.001)
    for k in range(keyframes):
        walk.step(around(k * 2 * np.pi / KEYFRAMES_A_ROUND))
    return walk


def corrector(slam_map: SlamMap) -> LoopCorrector:
    config = SlamConfig()
    return LoopCorrector(slam_map, SENSOR, config.loops, config.mapping)


def tie(slam_map: SlamMap, keyframe: int, candidate: int, off: np.ndarray) -> Tie:
    """A keyframe that should be somewhere else, without matches."""
    nothing = np.full(slam_map.features(keyframe).rows, -1, np.int32)
    return Tie(keyframe, candidate, off @ slam_map.camera_from_world(keyframe), nothing)


def test_the_tied_keyframe_comes_to_where_it_was_located() -> None:
    slam_map = walked().map
    tied = tie(slam_map, 13, 0, OFF)
    gathered = corrector(slam_map).gather([tied])
    poses = corrector(slam_map).solve(gathered, GO)
    metres, radians = pose_error(poses[-1], tied.camera_from_world)
    assert metres < 0.005
    assert radians < 0.002
    # Solving changes nothing yet.
    np.testing.assert_array_equal(gathered.camera_from_world, slam_map.columns.camera_from_world[:14])
    assert slam_map.version == 0
    assert corrector(slam_map).apply(gathered, poses)
    np.testing.assert_allclose(slam_map.camera_from_world(13), poses[-1], atol=1e-9)
    assert slam_map.loop_edges == [(13, 0)]
    assert slam_map.version == 1


def test_points_stay_as_their_first_keyframe_sees_them() -> None:
    slam_map = walked().map
    m = slam_map.columns
    points = slam_map.living_points()

    def seen() -> np.ndarray:
        poses = m.camera_from_world[m.first_keyframe[points]]
        return np.einsum("nij,nj->ni", poses[:, :3, :3], m.position[points]) + poses[:, :3, 3]

    before, was = seen(), m.position[points].copy()
    gathered = corrector(slam_map).gather([tie(slam_map, 13, 0, OFF)])
    assert corrector(slam_map).apply(gathered, corrector(slam_map).solve(gathered, GO))
    np.testing.assert_allclose(seen(), before, atol=1e-9)
    assert np.abs(m.position[points] - was).max() > 0.05


def test_what_comes_meanwhile_is_carried_along() -> None:
    walk = walked()
    slam_map = walk.map
    gathered = corrector(slam_map).gather([tie(slam_map, 13, 0, OFF)])
    new = walk.step(around(14 * 2 * np.pi / KEYFRAMES_A_ROUND))
    own = np.flatnonzero(slam_map.columns.first_keyframe[: slam_map.point_count] == new)
    relative = slam_map.camera_from_world(new) @ slam_map.world_from_keyframe(13)
    of_points = slam_map.columns.position[own] @ slam_map.camera_from_world(new)[:3, :3].T
    of_points += slam_map.camera_from_world(new)[:3, 3]
    slam_map.remove_keyframe(5)
    assert corrector(slam_map).apply(gathered, corrector(slam_map).solve(gathered, GO))
    after = slam_map.camera_from_world(new)
    np.testing.assert_allclose(after @ slam_map.world_from_keyframe(13), relative, atol=1e-9)
    np.testing.assert_allclose(slam_map.columns.position[own] @ after[:3, :3].T + after[:3, 3], of_points, atol=1e-9)
    check_graph(slam_map)


def test_a_world_that_changed_meanwhile_is_left_alone() -> None:
    slam_map = walked().map
    steps = corrector(slam_map)
    tied = tie(slam_map, 13, 0, OFF)
    gathered = steps.gather([tied])
    poses = steps.solve(gathered, GO)
    slam_map.transform(rigid([1, 2, 3], [0, 0, 1]))
    before = slam_map.to_arrays()
    assert not steps.apply(gathered, poses)
    assert not steps.close([tied], 0, GO)
    assert not steps.merge([tied], 0, GO)
    for name, array in slam_map.to_arrays().items():
        np.testing.assert_array_equal(array, before[name], err_msg=name)


def test_a_full_adjustment_makes_a_crooked_map_straight() -> None:
    walk = walked(20, seed=3)
    crooked = walk.errors()[-1]
    assert crooked > 0.003
    assert corrector(walk.map).adjust_fully(0, GO)
    assert walk.errors()[-1] < 0.7 * crooked
    np.testing.assert_array_equal(walk.map.camera_from_world(0), walk.truth[0])
    assert walk.map.version == 1
    check_graph(walk.map)
    assert not corrector(walk.map).adjust_fully(0, np.ones(1, np.bool_))


@pytest.mark.parametrize("near", [3, 9])
def test_two_submaps_become_one_tree(near: int) -> None:
    walk = walked(6)
    slam_map = walk.map
    root = walk.step(around(2.0), anew_at=around(1.0))
    walk.step(around(2.1))
    assert slam_map.submaps().tolist() == [0] * 6 + [1] * 2
    slam_map.remove_keyframe(3)
    slam_map.join(0, 1, near)
    assert slam_map.submaps().tolist() == [0] * 8
    # Keyframe 3 is gone and keyframe 9 does not exist: another one that lives is the parent.
    assert slam_map.is_alive(int(slam_map.parents()[root]))
    assert slam_map.parents()[root] < 6
    refuse_broken_columns(slam_map.to_arrays())


def test_joining_into_the_younger_submap_keeps_its_label_as_home() -> None:
    walk = walked(6)
    slam_map = walk.map
    slam_map.home = 1
    root = walk.step(around(2.0), anew_at=around(1.0))
    slam_map.join(1, 0, 4)
    assert slam_map.home == 1
    assert slam_map.parents()[root] == 4
    assert slam_map.is_root(0)
    refuse_broken_columns(slam_map.to_arrays())


def test_keypoints_take_over_other_points() -> None:
    slam_map = walked(3).map
    m = slam_map.columns
    slot = int(m.keyframe_slot[2])
    of_last = m.point[slot, : m.feature_count[slot]].copy()
    others = np.flatnonzero(m.point_alive[: slam_map.point_count] & (m.first_keyframe[: slam_map.point_count] == 0))
    others = others[~np.isin(others, of_last)][:5].astype(np.int32)
    wanted = np.full(len(of_last), -1, np.int32)
    wanted[:5] = others
    gone = of_last[:5]
    fusing.replace_points(m, slot, wanted)
    np.testing.assert_array_equal(m.point[slot, :5], others)
    assert not m.point_alive[gone].any()
    check_graph(slam_map)


def test_loops_are_kept_with_the_map_and_must_make_sense() -> None:
    walk = walked(6)
    walk.map.loop_edges.append((5, 0))
    arrays = walk.map.to_arrays()
    assert SlamMap.from_arrays(arrays).loop_edges == [(5, 0)]
    for wrong in ([[6, 0]], [[0, -1]]):
        with pytest.raises(ValueError, match="loop_edges"):
            SlamMap.from_arrays({**arrays, "loop_edges": np.array(wrong, np.int32)})
    with pytest.raises(ValueError, match="loop_edges"):
        SlamMap.from_arrays({**arrays, "loop_edges": np.array([[0, 1]], np.int64)})


def test_the_way_back_of_a_tie_is_the_correction() -> None:
    slam_map = walked(4).map
    tied = tie(slam_map, 3, 0, OFF)
    moved = slam_map.camera_from_world(3) @ inverse_transform(tied.old_from_new_world(slam_map))
    np.testing.assert_allclose(moved, tied.camera_from_world, atol=1e-12)
