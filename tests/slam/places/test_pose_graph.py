import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares
from slam_scenes import pose_error, rigid, rotation_angle, twists

from lpslam.camera import inverse_transform
from lpslam.slam import carrying
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.kernels.graph import covisible_pairs
from lpslam.slam.places import pose_graph

LEVER = 3.0


def logarithm(transform: np.ndarray) -> np.ndarray:
    return np.asarray(pose_graph.logarithms(transform[None])[0])


def ring(seed: int, poses: int, drift: float, reach: int = 3) -> tuple[np.ndarray, pose_graph.PoseGraph]:
    """A walk around a circle whose steps drift, and its graph: all relative poses as walked, and one true tie."""
    random = np.random.default_rng(seed)
    step = rigid([0.2, 0, 0.02], [0, 2 * np.pi / poses, 0])
    truth, walked = [np.eye(4)], [np.eye(4)]
    for _ in range(poses - 1):
        truth.append(step @ truth[-1])
        walked.append(exponential(random.normal(0, drift, 6) / [1, 1, 1, 3, 3, 3]) @ step @ walked[-1])
    pairs = [(a, b) for a in range(poses) for b in range(max(0, a - reach), a)]
    measured = [walked[a] @ inverse_transform(walked[b]) for a, b in pairs]
    pairs.append((poses - 1, 0))
    measured.append(truth[-1] @ inverse_transform(truth[0]))
    weights = np.append(np.ones(len(pairs) - 1), 1000.0)
    is_fixed = np.arange(poses) == 0
    graph = pose_graph.PoseGraph(
        np.array(walked), is_fixed, np.array(pairs, np.int32), np.array(measured), weights.astype(np.float64)
    )
    return np.array(truth), graph


@given(twists())
def test_logarithm_is_the_inverse_of_the_exponential(twist: np.ndarray) -> None:
    np.testing.assert_allclose(logarithm(exponential(twist)), twist, atol=1e-6)


@given(twists(), st.floats(1e-12, 1e-2))
def test_logarithm_of_small_turns(twist: np.ndarray, scale: float) -> None:
    twist = twist * [1, 1, 1, scale, scale, scale]
    np.testing.assert_allclose(logarithm(exponential(twist)), twist, atol=1e-8)


@given(st.integers(0, 1000))
def test_poses_that_agree_stay(seed: int) -> None:
    truth, graph = ring(seed, 12, 0.0)
    np.testing.assert_allclose(pose_graph.optimise_poses(graph, 10, LEVER), truth, atol=1e-8)


@given(st.integers(0, 1000))
def test_edges_that_agree_are_met_from_anywhere_near(seed: int) -> None:
    truth, graph = ring(seed, 12, 0.0)
    random = np.random.default_rng(seed)
    astray = np.array([exponential(random.normal(0, 0.1, 6)) @ pose for pose in truth])
    astray[0] = truth[0]
    np.testing.assert_allclose(
        pose_graph.optimise_poses(graph._replace(camera_from_world=astray), 20, LEVER), truth, atol=1e-6
    )


def test_the_optimum_is_that_of_a_general_solver() -> None:
    _, graph = ring(3, 8, 0.01)
    poses = pose_graph.optimise_poses(graph, 50, LEVER)
    scale = np.array([1, 1, 1, LEVER, LEVER, LEVER])

    def residuals(twists_of_all: np.ndarray) -> np.ndarray:
        moved = [graph.camera_from_world[0]]
        for twist, pose in zip(twists_of_all.reshape(-1, 6), graph.camera_from_world[1:], strict=True):
            moved.append(exponential(twist) @ pose)
        parts = []
        for (a, b), measured, weight in zip(graph.pairs, graph.a_from_b, graph.weights, strict=True):
            off = moved[a] @ inverse_transform(moved[b]) @ inverse_transform(measured)
            parts.append(np.sqrt(weight) * scale * logarithm(off))
        return np.concatenate(parts)

    best = least_squares(residuals, np.zeros(6 * (len(poses) - 1)), xtol=1e-12, ftol=1e-12, gtol=1e-12)
    for twist, before, after in zip(best.x.reshape(-1, 6), graph.camera_from_world[1:], poses[1:], strict=True):
        metres, radians = pose_error(after, exponential(twist) @ before)
        assert metres < 1e-4
        assert radians < 1e-4


def test_a_tie_takes_the_drift_out_of_the_way() -> None:
    truth, graph = ring(5, 150, 0.003)
    poses = pose_graph.optimise_poses(graph, 20, LEVER)
    before, after = (
        np.array([pose_error(pose, true)[0] for pose, true in zip(some, truth, strict=True)])
        for some in (graph.camera_from_world, poses)
    )
    assert before[-1] > 0.05
    assert after[-1] < 0.002
    assert np.sqrt(np.mean(after**2)) < 0.7 * np.sqrt(np.mean(before**2))
    np.testing.assert_array_equal(poses[0], truth[0])


def test_what_is_fixed_stays_to_the_bit_and_stop_ends_it() -> None:
    _, graph = ring(6, 20, 0.01)
    fixed = graph.is_fixed.copy()
    fixed[7] = True
    poses = pose_graph.optimise_poses(graph._replace(is_fixed=fixed), 5, LEVER)
    np.testing.assert_array_equal(poses[[0, 7]], graph.camera_from_world[[0, 7]])
    assert not np.allclose(poses[8], graph.camera_from_world[8])
    stopped = pose_graph.optimise_poses(graph, 5, LEVER, np.ones(1, np.bool_))
    np.testing.assert_array_equal(stopped, graph.camera_from_world)
    everything = pose_graph.optimise_poses(graph._replace(is_fixed=np.ones(20, np.bool_)), 5, LEVER)
    np.testing.assert_array_equal(everything, graph.camera_from_world)


def test_rotations_stay_rotations() -> None:
    _, graph = ring(8, 60, 0.02)
    for pose in pose_graph.optimise_poses(graph, 20, LEVER):
        np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)


@given(st.integers(0, 10_000), st.integers(1, 4))
def test_covisible_pairs_are_those_that_share_enough(seed: int, least: int) -> None:
    random = np.random.default_rng(seed)
    keyframes, capacity, points = 7, 6, 9
    keyframe_slot = np.where(random.random(keyframes) < 0.8, random.permutation(keyframes), -1).astype(np.int32)
    slot_keyframe = np.full(keyframes, -1, np.int32)
    living = np.flatnonzero(keyframe_slot >= 0)
    slot_keyframe[keyframe_slot[living]] = living
    point, following = (np.full((keyframes, capacity), -1, np.int32) for _ in range(2))
    head = np.full(points, -1, np.int32)
    seen: dict[int, set[int]] = {}
    for k in living:
        chosen = random.permutation(points)[: random.integers(0, capacity + 1)]
        seen[int(k)] = set(chosen.tolist())
        for feature, p in enumerate(chosen):
            point[keyframe_slot[k], feature] = p
            following[keyframe_slot[k], feature] = head[p]
            head[p] = keyframe_slot[k] * capacity + feature
    pairs = covisible_pairs(head, point, following, keyframe_slot, slot_keyframe, least)
    expected = {(a, b) for a in seen for b in seen if a < b and len(seen[a] & seen[b]) >= least}
    assert {(int(a), int(b)) for a, b in pairs} == expected
    assert len(pairs) == len(expected)


@given(st.integers(0, 1000))
def test_keyframes_without_a_new_pose_are_rigid_with_their_parents(seed: int) -> None:
    random = np.random.default_rng(seed)
    poses = np.array([exponential(random.normal(0, 1, 6)) for _ in range(6)])
    parent = np.array([-1, 0, 1, 1, 3, -1], np.int32)
    moved = np.array([0, 1, 2], np.int32)
    targets = np.array([exponential(random.normal(0, 0.2, 6)) @ pose for pose in poses[moved]])
    new_from_old = carrying.corrections(poses, parent, moved, targets)
    after = poses.copy()
    carrying.carry_keyframes(after, new_from_old)
    np.testing.assert_allclose(after[moved], targets, atol=1e-9)
    for child in (3, 4):
        before = poses[child] @ inverse_transform(poses[parent[child]])
        np.testing.assert_allclose(after[child] @ inverse_transform(after[parent[child]]), before, atol=1e-9)
    np.testing.assert_array_equal(after[5], poses[5])


@given(st.integers(0, 1000))
def test_points_and_normals_stay_as_their_first_keyframe_sees_them(seed: int) -> None:
    random = np.random.default_rng(seed)
    poses = np.array([exponential(random.normal(0, 1, 6)) for _ in range(3)])
    targets = np.array([exponential(random.normal(0, 0.2, 6)) @ pose for pose in poses])
    position, normal = random.normal(size=(8, 3)), random.normal(size=(8, 3)).astype(np.float32)
    first = random.integers(0, 3, 8).astype(np.int32)
    new_position, new_normal = position.copy(), normal.copy()
    new_from_old = carrying.corrections(poses, np.array([-1, 0, 1], np.int32), np.arange(3, dtype=np.int32), targets)
    carrying.carry_points(new_position, new_normal, first, new_from_old)
    for p, k in enumerate(first):
        before = poses[k, :3, :3] @ position[p] + poses[k, :3, 3]
        np.testing.assert_allclose(targets[k, :3, :3] @ new_position[p] + targets[k, :3, 3], before, atol=1e-9)
        np.testing.assert_allclose(targets[k, :3, :3] @ new_normal[p], poses[k, :3, :3] @ normal[p], atol=1e-5)
    assert rotation_angle(new_from_old[0, :3, :3]) >= 0
