import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from slam_scenes import (
    CAMERA,
    LOOKING_AHEAD,
    SENSOR,
    add_view,
    check_graph,
    descriptors_of,
    features_at,
    flip_bits,
    hamming_table,
    observations_of,
    points_ahead,
    rigid,
    view_of,
)

from lpslam.camera import inverse_transform, transform_points
from lpslam.slam.features import Features
from lpslam.slam.kernels import bundle, fusing, graph, local_bundle
from lpslam.slam.map import SlamMap

FEATURES = 12
seeds = st.integers(0, 2**32 - 1)


def some_features(random: np.random.Generator, count: int = FEATURES) -> Features:
    pixels = random.uniform(0, [CAMERA.width, CAMERA.height], (count, 2))
    octaves = random.integers(0, 8, count)
    return features_at(pixels, random.uniform(0.5, 6, count), descriptors_of(random, count), octaves)


def observed_map(seed: int, keyframes: int = 4, points: int = 60) -> tuple[SlamMap, np.ndarray, np.ndarray]:
    """A map in which every keyframe sees every point, without noise; with the points' ids and places."""
    random = np.random.default_rng(seed)
    in_first = points_ahead(random, points, 2.0, 4.0)
    places = transform_points(LOOKING_AHEAD, in_first)
    descriptors = descriptors_of(random, points)
    slam_map = SlamMap(points + 20, SENSOR.scales)
    ids = np.empty(0, np.int32)
    for k in range(keyframes):
        turn = rigid([0.05 * k, -0.02 * k, 0.03 * k], [0.01 * k, 0.02 * k, 0])
        pose = turn @ inverse_transform(LOOKING_AHEAD)
        keyframe = add_view(slam_map, pose, view_of(pose, places, descriptors), k - 1)
        if k == 0:
            first = slam_map.add_points(keyframe, np.arange(points, dtype=np.int32), places)
            ids = np.arange(first, first + points, dtype=np.int32)
        else:
            for feature, point in enumerate(ids):
                graph.link(slam_map.columns, int(point), int(slam_map.columns.keyframe_slot[keyframe]), feature)
    graph.refresh_points(slam_map.columns, ids, SENSOR.scales)
    return slam_map, ids, places


# Linked lists ------------------------------------------------------------------------------------------------------


@settings(max_examples=60)
@given(seeds, st.lists(st.integers(0, 99), min_size=1, max_size=120))
def test_the_lists_stay_whole_whatever_is_linked_unlinked_merged_and_removed(seed: int, steps: list[int]) -> None:
    random = np.random.default_rng(seed)
    slam_map = SlamMap(FEATURES, SENSOR.scales)
    pose = inverse_transform(LOOKING_AHEAD)
    add_view(slam_map, pose, some_features(random), -1)
    slam_map.add_points(0, np.arange(5, dtype=np.int32), random.normal(size=(5, 3)))
    expected = {point: {(0, point)} for point in range(5)}  # point: {(keyframe, keypoint)}

    def owner(keyframe: int, feature: int) -> int:
        return next((p for p, seen in expected.items() if (keyframe, feature) in seen), -1)

    for step in steps:
        m = slam_map.columns
        living = slam_map.living_keyframes()
        keyframe, feature = int(random.choice(living)), int(random.integers(FEATURES))
        slot = int(m.keyframe_slot[keyframe])
        alive = [p for p, seen in expected.items() if seen]
        if step < 12:
            add_view(slam_map, pose, some_features(random, int(random.integers(1, FEATURES + 1))), int(living[0]))
        elif step < 24:
            free = [f for f in range(int(m.feature_count[slot])) if owner(keyframe, f) < 0][:3]
            first = slam_map.add_points(keyframe, np.array(free, np.int32), random.normal(size=(len(free), 3)))
            expected |= {first + i: {(keyframe, f)} for i, f in enumerate(free)}
        elif step < 62 and alive:
            point = int(random.choice(alive))
            seen_already = any(k == keyframe for k, _ in expected[point])
            assert graph.observed_in(m, point, slot) == seen_already
            if not seen_already and feature < m.feature_count[slot] and owner(keyframe, feature) < 0:
                graph.link(m, point, slot, feature)
                expected[point].add((keyframe, feature))
        elif step < 76:
            graph.unlink(m, slot, feature)
            if owner(keyframe, feature) >= 0:
                expected[owner(keyframe, feature)].discard((keyframe, feature))
        elif step < 82 and alive:
            point = int(random.choice(alive))
            graph.remove_point(m, point)
            expected[point] = set()
        elif step < 93 and len(alive) > 1:
            gone, kept = (int(p) for p in random.choice(alive, 2, replace=False))
            graph.merge_points(m, gone, kept)
            known = {k for k, _ in expected[kept]}
            expected[kept] |= {(k, f) for k, f in expected[gone] if k not in known}
            expected[gone] = set()
        elif step >= 93 and keyframe != 0:
            slam_map.remove_keyframe(keyframe)
            for seen in expected.values():
                seen -= {(k, f) for k, f in seen if k == keyframe}
        check_graph(slam_map)
    m = slam_map.columns
    for point, seen in expected.items():
        assert {(int(m.slot_keyframe[s]), f) for s, f in observations_of(m, point)} == seen
    assert slam_map.living_points().tolist() == [p for p, seen in expected.items() if seen]


def test_merging_adds_up_how_often_a_point_was_looked_for_and_found() -> None:
    slam_map, ids, _ = observed_map(0, points=4)
    m = slam_map.columns
    m.visible[ids[:2]], m.found[ids[:2]] = [10, 7], [4, 5]
    graph.merge_points(m, int(ids[0]), int(ids[1]))
    assert (m.visible[ids[1]], m.found[ids[1]]) == (17, 9)
    check_graph(slam_map)


@given(seeds)
def test_covisibility_counts_shared_points(seed: int) -> None:
    slam_map, ids, _ = observed_map(seed, points=20)
    m = slam_map.columns
    random = np.random.default_rng(seed)
    for keyframe in range(1, 4):
        for feature in np.flatnonzero(random.random(20) < 0.4):
            graph.unlink(m, int(m.keyframe_slot[keyframe]), int(feature))
    seen = [set(m.point[m.keyframe_slot[k]].tolist()) - {-1} for k in range(4)]
    rows = np.append(ids, -1).astype(np.int32)
    np.testing.assert_array_equal(graph.count_shared_points(m, rows, 4), [len(points) for points in seen])
    for keyframe in range(4):
        shared = {k: len(seen[keyframe] & seen[k]) for k in range(4) if k != keyframe}
        ranked = sorted((k for k in shared if shared[k] >= 10), key=lambda k: (-shared[k], k))
        assert slam_map.covisible(keyframe, 10).tolist() == ranked
    both = graph.points_of(m, np.array([1, 2], np.int32), slam_map.point_count)
    assert len(both) == len(set(both.tolist()))
    assert set(both.tolist()) == seen[1] | seen[2]


# What a point derives from its observations ------------------------------------------------------------------------


def test_a_point_faces_its_observers_and_knows_their_distances() -> None:
    slam_map, ids, places = observed_map(1)
    m = slam_map.columns
    random = np.random.default_rng(1)
    m.octave[:4, : len(ids)] = random.integers(0, 8, (4, len(ids)))
    graph.refresh_points(m, ids, SENSOR.scales)
    centres = np.array([slam_map.world_from_keyframe(k)[:3, 3] for k in range(4)])
    to_observers = centres[None] - places[:, None]
    distance = np.linalg.norm(to_observers, axis=2)
    normal = (to_observers / distance[:, :, None]).sum(axis=1)
    np.testing.assert_allclose(m.normal[ids], normal / np.linalg.norm(normal, axis=1, keepdims=True), atol=1e-6)
    at_finest = distance * SENSOR.scales[m.octave[:4, : len(ids)]].T
    np.testing.assert_allclose(m.distance_range[ids, 1], at_finest.max(axis=1), rtol=1e-6)
    # From there on down to where even the coarsest level is too fine.
    assert (m.distance_range[ids, 0] <= at_finest.max(axis=1) / SENSOR.scales[-1] * (1 + 1e-6)).all()
    assert (m.distance_range[ids, 0] > 0).all()


def test_the_descriptor_is_the_one_nearest_to_all_others() -> None:
    slam_map, ids, _ = observed_map(2, keyframes=5)
    m = slam_map.columns
    random = np.random.default_rng(2)
    for feature in range(len(ids)):
        common = descriptors_of(random, 1)
        m.descriptor[:5, feature] = np.concatenate([flip_bits(random, common, bits) for bits in (4, 8, 15, 60, 120)])
    graph.refresh_points(m, ids, SENSOR.scales)
    for feature, point in enumerate(ids):
        medians = np.median(hamming_table(m.descriptor[:5, feature], m.descriptor[:5, feature]), axis=1)
        chosen = hamming_table(m.point_descriptor[[point]], m.descriptor[:5, feature])[0]
        assert chosen.min() == 0
        assert medians[chosen.argmin()] == medians.min()


# Adjustment through the graph --------------------------------------------------------------------------------------


def test_a_bundle_gathers_free_keyframes_first_and_holds_what_it_must() -> None:
    slam_map, ids, _ = observed_map(3)
    lonely = slam_map.add_points(3, np.empty(0, np.int32), np.empty((0, 3)))
    assert lonely == len(ids)
    free = np.array([2, 0], np.int32)
    problem, keyframes, points = local_bundle.gather_bundle(
        slam_map.columns, free, slam_map.keyframe_count, slam_map.point_count, SENSOR.pixel_information, 0
    )
    assert problem.free_count == 1
    assert keyframes[0] == 2
    assert sorted(keyframes.tolist()) == [0, 1, 2, 3]
    assert sorted(points.tolist()) == ids.tolist()
    np.testing.assert_array_equal(np.diff(problem.starts), 4)
    m = slam_map.columns
    for row, point in enumerate(points):
        for o in range(problem.starts[row], problem.starts[row + 1]):
            slot, feature = divmod(int(problem.observation[o]), m.point.shape[1])
            assert m.point[slot, feature] == point
            assert keyframes[problem.keyframe[o]] == m.slot_keyframe[slot]
            np.testing.assert_array_equal(problem.pixels[o], m.pixels[slot, feature])
            assert problem.disparity[o] == m.pixels[slot, feature, 0] - m.u_right[slot, feature]
    np.testing.assert_array_equal(problem.points, m.position[points])
    np.testing.assert_array_equal(problem.camera_from_world, m.camera_from_world[keyframes])


def test_an_adjustment_through_the_graph_mends_the_map_and_takes_lone_points_along() -> None:
    slam_map, ids, places = observed_map(4)
    m = slam_map.columns
    lone_pixels = np.array([[100.0, 100.0], [500.0, 300.0]])
    slot = int(m.keyframe_slot[3])
    m.pixels[slot, len(ids) : len(ids) + 2] = lone_pixels
    m.feature_count[slot] = len(ids) + 2
    in_camera = CAMERA.back_project(lone_pixels, np.array([2.0, 3.0]))
    truth = slam_map.camera_from_world(3).copy()
    m.camera_from_world[3] = rigid([0.04, -0.03, 0.05], [0.02, -0.01, 0.015]) @ truth
    first = slam_map.add_points(
        3,
        np.arange(len(ids), len(ids) + 2, dtype=np.int32),
        transform_points(slam_map.world_from_keyframe(3), in_camera),
    )
    m = slam_map.columns
    wrong = int(m.keyframe_slot[1]), 5
    m.pixels[wrong] += 60.0
    m.position[ids] += np.random.default_rng(4).normal(0, 0.02, (len(ids), 3))
    problem, keyframes, points = local_bundle.gather_bundle(
        m, np.array([3], np.int32), slam_map.keyframe_count, slam_map.point_count, SENSOR.pixel_information, 0
    )
    assert first not in points  # seen once: nothing to adjust by
    poses, positions, inlier = bundle.adjust_bundle(problem, SENSOR.intrinsics, 20, 20, np.zeros(1, np.bool_))
    dropped = local_bundle.apply_bundle(m, problem, keyframes, points, poses, positions, inlier, SENSOR.scales)
    assert dropped == 1
    assert m.point[wrong] == -1
    assert m.observations[ids[5]] == 3
    check_graph(slam_map)
    np.testing.assert_allclose(slam_map.camera_from_world(3), truth, atol=2e-4)
    np.testing.assert_allclose(m.position[ids], places, atol=2e-3)
    # Still where their keyframe saw them.
    moved = transform_points(slam_map.camera_from_world(3), m.position[first : first + 2])
    np.testing.assert_allclose(moved, in_camera, atol=1e-9)


def test_redundance_is_the_share_of_close_points_that_enough_others_see_as_finely() -> None:
    slam_map, _, _ = observed_map(5, keyframes=5, points=40)
    m = slam_map.columns
    assert graph.redundant_share(m, 2, 3, 10.0) == 1.0
    for keyframe in (0, 1):
        for feature in range(10):
            graph.unlink(m, int(m.keyframe_slot[keyframe]), feature)  # two others are left to see these
    assert graph.redundant_share(m, 2, 3, 10.0) == 0.75
    for keyframe in (0, 1):
        m.octave[m.keyframe_slot[keyframe], 10:20] = 3  # seen, but more coarsely by more than a level
    assert graph.redundant_share(m, 2, 3, 10.0) == 0.5
    m.depth[m.keyframe_slot[2], 20:40] = 11.0
    assert graph.redundant_share(m, 2, 3, 10.0) == 0.0
    m.has_depth[m.keyframe_slot[2]] = False
    assert graph.redundant_share(m, 2, 3, 10.0) == 0.0


# Fusing ------------------------------------------------------------------------------------------------------------


def two_halves(seed: int, points: int = 80) -> tuple[SlamMap, np.ndarray, np.ndarray]:
    """Two keyframes that see the same places but made points of their own of them, two millimetres apart."""
    random = np.random.default_rng(seed)
    places = transform_points(LOOKING_AHEAD, points_ahead(random, points, 2.0, 4.0))
    descriptors = descriptors_of(random, points)
    slam_map = SlamMap(points, SENSOR.scales)
    ids = []
    for k in range(2):
        pose = rigid([0.06 * k, 0, 0.02 * k], [0, 0.02 * k, 0]) @ inverse_transform(LOOKING_AHEAD)
        add_view(slam_map, pose, view_of(pose, places, flip_bits(random, descriptors, 10)), k - 1)
        own = places + random.normal(0, 0.002 / 3**0.5, places.shape)
        first = slam_map.add_points(k, np.arange(points, dtype=np.int32), own)
        ids.append(np.arange(first, first + points, dtype=np.int32))
    return slam_map, ids[0], ids[1]


def fuse(slam_map: SlamMap, points: np.ndarray, keyframe: int, max_distance: int = 50) -> int:
    return fusing.fuse_points(
        slam_map.columns, points, keyframe, SENSOR.intrinsics, SENSOR.image_size, SENSOR.scales,
        SENSOR.pixel_information, 3.0, max_distance,
    )  # fmt: skip


def test_duplicates_are_fused_into_one_point_each() -> None:
    slam_map, first, second = two_halves(6)
    fused = fuse(slam_map, first, 1)
    assert fused >= 0.95 * len(first)  # the few whose noise lies in the tail stay apart
    check_graph(slam_map)
    assert len(slam_map.living_points()) == 2 * len(first) - fused
    m = slam_map.columns
    same = m.point[0] == m.point[1]  # keypoint by keypoint the same place
    assert same.sum() == fused
    np.testing.assert_array_equal(m.observations[m.point[0, same]], 2)
    assert fuse(slam_map, first, 1) == 0
    assert fuse(slam_map, second, 0) == 0


def test_a_keypoint_without_a_point_is_linked() -> None:
    slam_map, first, second = two_halves(7)
    for point in second:
        graph.remove_point(slam_map.columns, int(point))
    assert fuse(slam_map, first, 1) >= 0.95 * len(first)
    check_graph(slam_map)
    linked = slam_map.columns.point[1]
    np.testing.assert_array_equal(linked[linked >= 0], first[linked >= 0])


def test_the_point_that_more_keyframes_see_survives() -> None:
    slam_map, first, second = two_halves(8)
    pose = slam_map.camera_from_world(0)
    places = slam_map.columns.position[first]
    third = add_view(slam_map, pose, view_of(pose, places, slam_map.columns.point_descriptor[first]), 1)
    for feature, point in enumerate(first):
        graph.link(slam_map.columns, int(point), int(slam_map.columns.keyframe_slot[third]), feature)
    fused = fuse(slam_map, second, 0)
    assert fused >= 0.95 * len(second)
    check_graph(slam_map)
    m = slam_map.columns
    assert m.point_alive[first].all()
    assert m.point_alive[second].sum() == len(second) - fused
    assert (m.observations[first] == 3).sum() == fused


def test_different_things_are_not_fused() -> None:
    slam_map, first, _ = two_halves(9)
    m = slam_map.columns
    before = m.point.copy()
    random = np.random.default_rng(9)
    look = m.point_descriptor[first].copy()
    m.point_descriptor[first] = descriptors_of(random, len(first))  # looks like nothing there
    assert fuse(slam_map, first, 1) == 0
    m.point_descriptor[first] = look
    places = m.position[first].copy()
    m.position[first] += 0.1  # 15 pixels and more away
    assert fuse(slam_map, first, 1) <= 2
    check_graph(slam_map)
    assert (m.point[1] == before[1]).mean() > 0.95
    slam_map, first, _ = two_halves(9)
    m = slam_map.columns
    centre = slam_map.world_from_keyframe(1)[:3, 3]
    m.position[first] = centre + 1.25 * (places - centre)  # on the same rays, a quarter farther
    assert fuse(slam_map, first, 1) <= 8
    m.position[first] = centre - (places - centre)  # behind
    assert fuse(slam_map, first, 1) == 0
    m.position[first] = places
    m.normal[first] *= -1  # seen from the other side
    m.point_alive[first[:5]] = True
    assert fuse(slam_map, first[slam_map.columns.point_alive[first]], 1) == 0
