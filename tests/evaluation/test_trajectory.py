from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lpslam.errors import UserError
from lpslam.evaluation.trajectory import (
    StampedPoses,
    absolute_trajectory_error,
    align_poses,
    align_rigidly,
    share_tracked,
)
from lpslam.poses import quaternions_from_rotations, rotations_from_quaternions
from lpslam.timestamps import associate

RECORDED = Path(__file__).parents[2] / ".." / "shared" / "data" / "trajectories"


def walk(n: int = 200, seed: int = 0) -> StampedPoses:
    rng = np.random.default_rng(seed)
    poses = np.tile(np.eye(4), (n, 1, 1))
    poses[:, :3, :3] = Rotation.random(n, random_state=rng).as_matrix()
    poses[:, :3, 3] = np.cumsum(rng.normal(0, 0.05, (n, 3)), axis=0)
    return StampedPoses(np.arange(n) / 30, poses)


def moved(poses: StampedPoses, to_from: np.ndarray) -> StampedPoses:
    return StampedPoses(poses.timestamps, to_from @ poses.world_from_camera)


def some_transform(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    transform = np.eye(4)
    transform[:3, :3] = Rotation.random(random_state=rng).as_matrix()
    transform[:3, 3] = rng.normal(0, 10, 3)
    return transform


@pytest.mark.skipif(not RECORDED.is_dir(), reason="recorded trajectories are not in ../shared/data")
@pytest.mark.parametrize(
    ("estimate", "rmse", "worst"),
    [("freiburg1_xyz-rgbdslam.txt", 0.013470, 0.034760), ("freiburg1_xyz-rgbdslam_drift.txt", 0.013470, 0.034760)],
)
def test_agrees_with_evo_on_a_recorded_trajectory(estimate: str, rmse: float, worst: float) -> None:
    truth = StampedPoses.from_tum_file(RECORDED / "freiburg1_xyz-groundtruth.txt")
    result = absolute_trajectory_error(truth, StampedPoses.from_tum_file(RECORDED / estimate))
    assert result.rmse == pytest.approx(rmse, abs=1e-4)
    assert result.max == pytest.approx(worst, abs=1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_a_rigid_motion_of_the_truth_has_no_error_and_is_recovered(seed: int) -> None:
    truth, estimate_from_truth = walk(seed=seed), some_transform(seed)
    result = absolute_trajectory_error(truth, moved(truth, estimate_from_truth))
    assert result.rmse < 1e-9
    assert result.count == len(truth)
    np.testing.assert_allclose(result.truth_from_estimate @ estimate_from_truth, np.eye(4), atol=1e-9)


def test_a_camera_that_only_turns_tells_where_things_are_by_its_directions() -> None:
    rng = np.random.default_rng(3)
    poses = np.tile(np.eye(4), (100, 1, 1))
    poses[:, :3, :3] = Rotation.from_rotvec(np.outer(np.linspace(0, 3, 100), [0, 1, 0])).as_matrix()
    truth = StampedPoses(np.arange(100) / 30, poses)
    estimate = moved(truth, some_transform(3))
    estimate.world_from_camera[:, :3, 3] += rng.normal(0, 0.01, (100, 3))
    off = align_poses(truth, estimate) @ some_transform(3)
    assert np.linalg.norm(Rotation.from_matrix(off[:3, :3]).as_rotvec()) < 0.01
    assert np.linalg.norm(off[:3, 3]) < 0.01
    # Positions alone are noise: something five metres away would be metres off.
    by_positions = absolute_trajectory_error(truth, estimate).truth_from_estimate @ some_transform(3)
    assert np.linalg.norm(Rotation.from_matrix(by_positions[:3, :3]).as_rotvec()) > 0.5


def test_noise_of_known_size_is_measured() -> None:
    truth = walk(5000)
    noisy = truth.world_from_camera.copy()
    noisy[:, :3, 3] += np.random.default_rng(1).normal(0, 0.02, (len(truth), 3))
    result = absolute_trajectory_error(truth, moved(StampedPoses(truth.timestamps, noisy), some_transform(3)))
    assert result.rmse == pytest.approx(0.02 * np.sqrt(3), rel=0.03)
    assert result.median < result.mean < result.rmse < result.max


def test_scale_is_not_forgiven() -> None:
    truth = walk()
    larger = truth.world_from_camera.copy()
    larger[:, :3, 3] *= 1.1
    assert absolute_trajectory_error(truth, StampedPoses(truth.timestamps, larger)).rmse > 0.01


def test_alignment_is_never_a_reflection() -> None:
    points = np.random.default_rng(0).normal(size=(50, 3))
    transform = align_rigidly(points, points * [1, 1, -1])
    assert np.linalg.det(transform[:3, :3]) == pytest.approx(1)


def test_too_few_pairs_are_a_clear_error() -> None:
    truth = walk()
    elsewhere = StampedPoses(truth.timestamps + 1e6, truth.world_from_camera)
    with pytest.raises(UserError, match="same clock"):
        absolute_trajectory_error(truth, elsewhere)


def test_share_tracked_counts_frames_with_a_pose() -> None:
    truth = walk(100)
    estimate = StampedPoses(truth.timestamps[:90], truth.world_from_camera[:90])
    assert share_tracked(truth.timestamps, estimate) == pytest.approx(0.9)
    assert share_tracked(np.zeros(0), estimate) == 0.0


times = st.lists(st.floats(0, 1, allow_nan=False), max_size=30).map(np.array)


@given(times, times)
@settings(deadline=None)
def test_association_is_greedy_by_difference_and_one_to_one(first: np.ndarray, second: np.ndarray) -> None:
    first, second = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    rows, columns = associate(first, second, 0.02)
    assert len(set(rows.tolist())) == len(rows) == len(set(columns.tolist()))
    assert (np.abs(first[rows] - second[columns]) <= 0.02).all()
    # Nothing that could still be paired is left over.
    left, right = np.delete(first, rows), np.delete(second, columns)
    if len(left) and len(right):
        assert np.abs(left[:, None] - right[None, :]).min() > 0.02


def test_association_prefers_the_nearest_and_leaves_none_twice() -> None:
    rows, columns = associate(np.array([0.000, 0.010, 1.0]), np.array([0.009, 5.0]), 0.02)
    assert rows.tolist() == [1]
    assert columns.tolist() == [0]


@given(st.integers(0, 10_000))
@settings(deadline=None, max_examples=30)
def test_quaternions_round_trip_and_agree_with_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    half_turns = Rotation.from_rotvec(np.pi * np.eye(3))
    rotations = np.concatenate([Rotation.random(20, random_state=rng).as_matrix(), half_turns.as_matrix()])
    quaternions = quaternions_from_rotations(rotations)
    assert (quaternions[:, 3] >= 0).all()
    np.testing.assert_allclose(Rotation.from_quat(quaternions).as_matrix(), rotations, atol=1e-9)
    np.testing.assert_allclose(rotations_from_quaternions(3 * quaternions), rotations, atol=1e-9)


def test_tum_file_round_trip(tmp_path: Path) -> None:
    truth = moved(walk(), some_transform(7))
    truth.to_tum_file(tmp_path / "t.txt", ["one\ncomment"])
    back = StampedPoses.from_tum_file(tmp_path / "t.txt")
    np.testing.assert_allclose(back.timestamps, truth.timestamps, atol=1e-6)
    np.testing.assert_allclose(back.world_from_camera, truth.world_from_camera, atol=2e-6)


def test_poses_are_put_in_order_of_time() -> None:
    poses = walk(5)
    shuffled = StampedPoses(poses.timestamps[[3, 1, 0, 2, 4]], poses.world_from_camera[[3, 1, 0, 2, 4]])
    np.testing.assert_array_equal(shuffled.world_from_camera, poses.world_from_camera)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "holds no poses"),
        (b"# only a comment\n", "holds no poses"),
        (b"1 0 0 0 0 0 0\n", "line 1"),
        (b"# c\n1 0 0 0 0 0 0 1\n1 0 0 nan 0 0 0 1\n", "line 3"),
        (b"1 a b c d e f g\n", "line 1"),
        (b"1 0 0 0 0 0 0 0\n", "zero quaternion"),
        (b"\xff\xfe\x00\x01", "not a text file"),
    ],
)
def test_damaged_trajectories_are_one_clear_line(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "t.txt"
    path.write_bytes(content)
    with pytest.raises(UserError, match=words) as caught:
        StampedPoses.from_tum_file(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_missing_trajectory_and_unwritable_place(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be read"):
        StampedPoses.from_tum_file(tmp_path / "none.txt")
    with pytest.raises(UserError, match="cannot be written"):
        walk(3).to_tum_file(tmp_path / "none" / "t.txt")
