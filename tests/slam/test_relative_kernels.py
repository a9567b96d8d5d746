import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from slam_scenes import SENSOR

from lpslam.camera import inverse_transform
from lpslam.slam.kernels.bundle import BundleProblem, adjust_bundle
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.kernels.relative import RelativeProblem, add_relative_terms, relative_cost

NEVER = np.zeros(1, np.bool_)


def random_problem(random: np.random.Generator, off: float) -> tuple[RelativeProblem, np.ndarray]:
    """Two relative poses among three keyframes that they fit but for `off`, and their poses."""
    poses = np.array([exponential(random.normal(size=6)) for _ in range(3)])
    pairs = np.array([[0, 1], [2, 1]], np.int32)
    a_from_b = np.array([poses[a] @ inverse_transform(poses[b]) for a, b in pairs])
    a_from_b = np.array([each @ exponential(off * random.normal(size=6)) for each in a_from_b])
    factors = random.normal(size=(2, 6, 6))
    return RelativeProblem(pairs, a_from_b, factors @ factors.transpose(0, 2, 1)), poses


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_normal_equations_are_the_derivative_of_the_cost(seed: int) -> None:
    random = np.random.default_rng(seed)
    relative, poses = random_problem(random, 1e-4)
    hessian, drawn, pairs = np.zeros((3, 6, 6)), np.zeros((3, 6)), np.empty((2, 6, 6))
    add_relative_terms(relative, poses, np.zeros((3, 3), np.int32), hessian, drawn, pairs)
    step = 1e-5 * random.normal(size=(3, 6))
    changes = []
    for sign in (1.0, -1.0):
        moved = np.array([exponential(sign * twist) @ pose for twist, pose in zip(step, poses, strict=True)])
        changes.append(relative_cost(relative, moved))
    np.testing.assert_allclose((changes[0] - changes[1]) / 4, -np.sum(drawn * step), rtol=1e-2, atol=1e-10)
    full = sum(s @ (np.triu(h) + np.triu(h, 1).T) @ s for s, h in zip(step, hessian, strict=True))
    full += 2 * step[0] @ pairs[0] @ step[1] + 2 * step[1] @ pairs[1] @ step[2]
    second = (changes[0] + changes[1]) / 2 - relative_cost(relative, poses)
    np.testing.assert_allclose(second, full, rtol=2e-2, atol=1e-12)


def turned_camera(noise: float) -> tuple[BundleProblem, np.ndarray]:
    """Two keyframes, the first held, that share eight points seen badly; and their true poses."""
    random = np.random.default_rng(3)
    truth = np.array([exponential(np.array([0.05, 0.0, 0.02, 0.0, 0.1, 0.0])), np.eye(4)])
    points = random.uniform([-1.0, -0.8, 2.0], [1.0, 0.8, 4.0], (8, 3))
    fx, fy, cx, cy, bf = SENSOR.intrinsics
    rows = np.tile(np.array([0, 1], np.int32), 8)
    seen = np.einsum("nij,nj->ni", truth[rows, :3, :3], np.repeat(points, 2, axis=0)) + truth[rows, :3, 3]
    pixels = np.column_stack([fx * seen[:, 0] / seen[:, 2] + cx, fy * seen[:, 1] / seen[:, 2] + cy])
    pixels[rows == 0] += noise
    problem = BundleProblem(
        truth.copy(), 1, points, np.arange(0, 17, 2), rows, pixels.astype(np.float32),
        (bf / seen[:, 2]).astype(np.float32), np.ones(16, np.bool_), np.full(16, 0.1, np.float32),
        np.ones(16, np.float32), np.arange(16),
    )  # fmt: skip
    return problem, truth


def test_a_sure_relative_pose_outweighs_blurred_points() -> None:
    problem, truth = turned_camera(noise=4.0)
    alone, _, _ = adjust_bundle(problem, SENSOR.intrinsics, 10, 0, NEVER)
    a_from_b = (truth[1] @ inverse_transform(truth[0]))[None]
    known = RelativeProblem(np.array([[1, 0]], np.int32), a_from_b, 1e7 * np.eye(6)[None])
    together, _, _ = adjust_bundle(problem, SENSOR.intrinsics, 10, 0, NEVER, relative=known)
    off_alone, off_together = (np.abs(poses[0] - truth[0]).max() for poses in (alone, together))
    assert off_together < 0.1 * off_alone


def test_a_false_relative_pose_does_not_carry_the_points_away() -> None:
    problem, truth = turned_camera(noise=0.0)
    false = (truth[1] @ inverse_transform(truth[0]) @ exponential(np.array([0.5, 0, 0, 0, 0, 0])))[None]
    known = RelativeProblem(np.array([[1, 0]], np.int32), false, 1e2 * np.eye(6)[None])
    together, _, _ = adjust_bundle(problem, SENSOR.intrinsics, 10, 0, NEVER, relative=known)
    assert np.abs(together[0] - truth[0]).max() < 0.1
