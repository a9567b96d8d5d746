import time
from threading import Timer

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from slam_scenes import SENSOR

from lpslam.camera import inverse_transform
from lpslam.slam.kernels.bundle import BundleProblem, adjust_bundle
from lpslam.slam.kernels.geometry import exponential, median, move, multiply, orthonormalise
from lpslam.slam.kernels.linear import solve_blocks, solve_positive

NEVER = np.zeros(1, np.bool_)


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), size=st.integers(1, 30), gaps=st.floats(0.0, 1.0))
def test_a_positive_system_is_solved_with_or_without_gaps(seed: int, size: int, gaps: float) -> None:
    random = np.random.default_rng(seed)
    factor = random.normal(size=(size, size)) * (random.random((size, size)) > gaps)
    matrix = factor @ factor.T + 0.1 * np.eye(size)
    right = random.normal(size=size)
    solution = right.copy()
    upper = np.triu(matrix) + np.tril(np.full((size, size), np.nan), -1)
    assert solve_positive(upper, solution)
    np.testing.assert_allclose(matrix @ solution, right, atol=1e-9)


def test_a_system_that_is_not_positive_is_refused() -> None:
    assert not solve_positive(np.array([[1.0, 2.0], [2.0, 1.0]]), np.ones(2))
    assert not solve_positive(np.zeros((6, 6)), np.ones(6))
    assert not solve_positive(np.full((3, 3), np.nan), np.ones(3))


def chain_of_blocks(random: np.random.Generator, count: int, reach: int) -> tuple[np.ndarray, ...]:
    """A positive system whose rows of blocks are tied to the next few: blocks, rows, columns and it as a matrix."""
    matrix = np.zeros((6 * count, 6 * count))
    for k in range(count):
        for other in range(k, min(k + reach + 1, count)):
            part = random.normal(size=(6, 12))
            index = np.r_[6 * k : 6 * k + 6, 6 * other : 6 * other + 6]
            matrix[np.ix_(index, index)] += part.T @ part
    matrix += 0.5 * np.eye(6 * count)
    pairs = [(k, other) for k in range(count) for other in range(k, min(k + reach + 1, count))]
    blocks = np.array([matrix[6 * a : 6 * a + 6, 6 * b : 6 * b + 6] for a, b in pairs])
    rows, columns = np.array(pairs, np.int32).T.copy()
    return blocks, rows, columns, matrix


@settings(deadline=None, max_examples=10)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 15), reach=st.integers(0, 4))
def test_conjugate_gradients_agree_with_numpy(seed: int, count: int, reach: int) -> None:
    random = np.random.default_rng(seed)
    blocks, rows, columns, matrix = chain_of_blocks(random, count, reach)
    right = random.normal(size=(count, 6))
    solution = solve_blocks(blocks, rows, columns, right, 1e-12, 2000, NEVER)
    np.testing.assert_allclose(solution.reshape(-1), np.linalg.solve(matrix, right.reshape(-1)), rtol=1e-6, atol=1e-8)


def test_conjugate_gradients_stop_when_told() -> None:
    blocks, rows, columns, _ = chain_of_blocks(np.random.default_rng(0), 5, 1)
    solution = solve_blocks(blocks, rows, columns, np.ones((5, 6)), 1e-12, 100, np.ones(1, np.bool_))
    np.testing.assert_array_equal(solution, 0.0)


@settings(deadline=None, max_examples=50)
@given(values=st.lists(st.floats(-3, 3), min_size=12, max_size=12))
def test_transforms_form_a_group(values: list[float]) -> None:
    a, b = exponential(np.array(values[:6])), exponential(np.array(values[6:]))
    np.testing.assert_allclose(multiply(a, b), a @ b, atol=1e-12)
    np.testing.assert_allclose(multiply(a, inverse_transform(a)), np.eye(4), atol=1e-12)
    np.testing.assert_allclose(multiply(exponential(-np.array(values[:6])), a), np.eye(4), atol=1e-9)
    moved = a.copy()
    move(moved, np.array(values[6:]))
    np.testing.assert_allclose(moved, b @ a, atol=1e-12)
    drifted = a + 1e-6 * np.outer([1, -1, 1, 0], [1, 1, -1, 0])
    orthonormalise(drifted)
    np.testing.assert_allclose(drifted[:3, :3] @ drifted[:3, :3].T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(drifted, a, atol=1e-5)


def corridor(keyframes: int, noise: float, seed: int = 0) -> tuple[BundleProblem, np.ndarray]:
    """A closed round of keyframes that look along the way, each point seen by several; the last row holds the frame.

    Returns:
        The problem, with drifted poses, and the true poses.
    """
    random = np.random.default_rng(seed)
    per, seen, radius = 60, 5, keyframes * 0.25 / (2 * np.pi)
    angle = 2 * np.pi * (np.arange(keyframes) + 1) / keyframes
    zero, one = np.zeros(keyframes), np.ones(keyframes)
    axes = np.stack(
        [
            np.column_stack([np.cos(angle), np.sin(angle), zero]),
            np.column_stack([zero, zero, -one]),
            np.column_stack([-np.sin(angle), np.cos(angle), zero]),
        ],
        axis=1,
    )
    truth = np.tile(np.eye(4), (keyframes, 1, 1))
    truth[:, :3, :3] = axes
    truth[:, :3, 3] = -np.einsum("nij,nj->ni", axes, radius * axes[:, 0])
    walk = np.cumsum(random.normal(size=(keyframes, 6)), axis=0)
    walk -= np.linspace(0, 1, keyframes)[:, None] * walk[-1]
    drifted = np.array([exponential(1e-3 * t) @ pose for t, pose in zip(walk, truth, strict=True)])
    first = np.repeat(np.arange(keyframes), per)
    in_first = random.uniform([-1.5, -1.0, 2.5], [1.5, 1.0, 5.0], (len(first), 3))
    points = np.einsum("nji,nj->ni", truth[first, :3, :3], in_first - truth[first, :3, 3])
    guess = np.einsum("nji,nj->ni", drifted[first, :3, :3], in_first - drifted[first, :3, 3])
    back = np.sort(np.argsort(random.random((len(first), seen + 2)), axis=1)[:, :seen], axis=1)
    keyframe, point = ((first[:, None] - back) % keyframes).reshape(-1), np.repeat(np.arange(len(first)), seen)
    x, y, z = (np.einsum("nij,nj->ni", truth[keyframe, :3, :3], points[point]) + truth[keyframe, :3, 3]).T
    fx, fy, cx, cy, bf = SENSOR.intrinsics
    pixels = np.column_stack([fx * x / z + cx, fy * y / z + cy]) + noise * random.normal(size=(len(z), 2))
    disparity = bf / z + 0.3 * noise * random.normal(size=len(z))
    count = len(keyframe)
    problem = BundleProblem(
        drifted, keyframes - 1, guess, np.arange(0, count + 1, seen), keyframe.astype(np.int32),
        pixels.astype(np.float32), disparity.astype(np.float32), np.ones(count, np.bool_),
        np.ones(count, np.float32), np.full(count, 1 / 0.3**2, np.float32), np.arange(count),
    )  # fmt: skip
    return problem, truth


@pytest.mark.parametrize("keyframes", [4, 30, 120])
def test_many_keyframes_are_adjusted_to_where_few_would_be(keyframes: int) -> None:
    problem, _ = corridor(keyframes, 0.5)
    directly = adjust_bundle(problem, SENSOR.intrinsics, 6, 6, NEVER, keyframes)
    by_gradients = adjust_bundle(problem, SENSOR.intrinsics, 6, 6, NEVER, 0)
    np.testing.assert_allclose(by_gradients[0], directly[0], atol=2e-5)
    np.testing.assert_allclose(by_gradients[1], directly[1], atol=1e-4)
    assert (by_gradients[2] != directly[2]).mean() < 1e-3
    # The frame is held to the bit.
    np.testing.assert_array_equal(by_gradients[0][-1], problem.camera_from_world[-1])


def test_drift_round_a_long_loop_is_undone() -> None:
    problem, truth = corridor(200, 0.0)
    poses, _, inlier = adjust_bundle(problem, SENSOR.intrinsics, 10, 10, NEVER)
    before = np.linalg.norm((problem.camera_from_world - truth)[:, :3, 3], axis=1)
    after = np.linalg.norm((poses - truth)[:, :3, 3], axis=1)
    assert before.max() > 0.05
    assert after.max() < 2e-3
    assert inlier.all()


def test_a_large_adjustment_ends_soon_after_it_is_told_to() -> None:
    problem, _ = corridor(900, 0.5)
    adjust_bundle(problem, SENSOR.intrinsics, 1, 0, np.ones(1, np.bool_))
    stop = np.zeros(1, np.bool_)
    timer = Timer(0.2, lambda: stop.__setitem__(0, True))
    started = time.process_time()
    timer.start()
    adjust_bundle(problem, SENSOR.intrinsics, 200, 200, stop)
    timer.cancel()
    # Seconds of computing, so that a busy machine does not fail it.
    assert time.process_time() - started < 2.0


@settings(deadline=None, max_examples=50)
@given(values=st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30))
def test_the_median_is_numpys(values: list[float]) -> None:
    assert median(np.array([*values, 0.0]), len(values)) == np.median(values)
