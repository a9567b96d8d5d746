from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import least_squares
from slam_scenes import BASELINE_FX, CAMERA, SENSOR, points_ahead, pose_error, rigid

from lpslam.camera import inverse_transform, transform_points
from lpslam.slam.kernels.bundle import BundleProblem, adjust_bundle
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.kernels.reprojection import CHI2_DEPTH, CHI2_PIXEL

NEVER = np.zeros(1, np.bool_)


class Scene:
    """Cameras in an arc around points; the first `free` of them are to be found, the others are known."""

    def __init__(
        self,
        seed: int,
        cameras: int = 6,
        free: int = 4,
        points: int = 150,
        pixel_sigma: float = 0.0,
        disparity_sigma: float = 0.3,
    ) -> None:
        random = self.random = np.random.default_rng(seed)
        self.points = points_ahead(random, points, 2.0, 4.0)
        steps = random.uniform(-0.25, 0.25, (cameras, 6)) * [1, 1, 1, 0.3, 0.3, 0.3]
        self.poses = np.array([exponential(step) for step in steps])
        self.free = free
        seen = [[k for k in range(cameras) if random.random() < 0.8] or [0, 1] for _ in range(points)]
        self.starts = np.cumsum([0, *map(len, seen)]).astype(np.int64)
        self.keyframe = np.concatenate(seen).astype(np.int32)
        self.point = np.repeat(np.arange(points), np.diff(self.starts))
        in_camera = self.in_camera(self.poses, self.points)
        self.observations = len(in_camera)
        noise = random.normal(size=(self.observations, 3))
        self.pixels = (CAMERA.project(in_camera) + pixel_sigma * noise[:, :2]).astype(np.float32)
        exact = 0.0 if pixel_sigma == 0 else disparity_sigma
        self.disparity = (BASELINE_FX / in_camera[:, 2] + exact * noise[:, 2]).astype(np.float32)
        self.has_depth = np.ones(self.observations, np.bool_)
        self.disparity_sigma = disparity_sigma

    def in_camera(self, poses: np.ndarray, points: np.ndarray) -> np.ndarray:
        """(o, 3) the points of all observations in their cameras."""
        pose = poses[self.keyframe]
        return np.einsum("oij,oj->oi", pose[:, :3, :3], points[self.point]) + pose[:, :3, 3]

    def problem(self, poses: np.ndarray, points: np.ndarray) -> BundleProblem:
        return BundleProblem(
            poses.copy(), self.free, points.copy(), self.starts, self.keyframe, self.pixels, self.disparity,
            self.has_depth, np.ones(self.observations, np.float32),
            np.full(self.observations, 1 / self.disparity_sigma**2, np.float32),
            np.arange(self.observations, dtype=np.int64),
        )  # fmt: skip

    def disturbed(self, metres: float = 0.05, radians: float = 0.02) -> tuple[np.ndarray, np.ndarray]:
        """Poses of the free cameras, and points, off at random."""
        poses = self.poses.copy()
        for k in range(self.free):
            off = self.random.normal(size=6) * [metres, metres, metres, radians, radians, radians]
            poses[k] = exponential(off) @ poses[k]
        return poses, self.points + self.random.normal(0, metres, self.points.shape)

    def worst(self, poses: np.ndarray) -> tuple[float, float]:
        """Largest errors of the free poses, metres and radians."""
        errors = [pose_error(estimate, truth) for estimate, truth in zip(poses, self.poses, strict=True)]
        return max(e[0] for e in errors[: self.free]), max(e[1] for e in errors[: self.free])


def adjust(
    problem: BundleProblem, first: int = 10, second: int = 10, stop: np.ndarray = NEVER
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return adjust_bundle(problem, SENSOR.intrinsics, first, second, stop)


@pytest.mark.parametrize("seed", range(5))
def test_disturbed_poses_and_points_go_back_to_the_truth(seed: int) -> None:
    scene = Scene(seed)
    problem = scene.problem(*scene.disturbed())
    poses, points, inlier = adjust(problem, 20, 20)
    metres, radians = scene.worst(poses)
    # Steps end when one gains less than 1e-4 of the cost, so a trace of the disturbance of 5 cm may be left.
    assert metres < 1e-4
    assert radians < 1e-4
    assert np.abs(points - scene.points).max() < 1e-3
    assert inlier.all()
    np.testing.assert_array_equal(poses[scene.free :], scene.poses[scene.free :])


def pose_information(scene: Scene) -> np.ndarray:
    """Inverse covariance of the free poses' twists at the truth, points marginalised out, by finite differences."""
    step = 1e-6

    def residuals(x: np.ndarray) -> np.ndarray:
        poses = scene.poses.copy()
        for k in range(scene.free):
            poses[k] = exponential(x[6 * k : 6 * k + 6]) @ scene.poses[k]
        in_camera = scene.in_camera(poses, scene.points + x[6 * scene.free :].reshape(-1, 3))
        disparity = BASELINE_FX / in_camera[:, 2] / scene.disparity_sigma
        return np.concatenate([CAMERA.project(in_camera).ravel(), disparity])

    count = 6 * scene.free + scene.points.size
    jacobian = np.array([(residuals(d) - residuals(-d)) / (2 * step) for d in step * np.eye(count)])
    information = jacobian @ jacobian.T
    n = 6 * scene.free
    return information[:n, :n] - information[:n, n:] @ np.linalg.solve(information[n:, n:], information[n:, :n])


def test_the_error_is_what_the_noise_allows() -> None:
    """The squared error of the poses, weighed by their information, is that of an efficient estimate: χ² a freedom."""
    ratios = []
    for seed in range(12):
        scene = Scene(100 + seed, cameras=5, free=3, points=60, pixel_sigma=1.0)
        poses, _, inlier = adjust(scene.problem(*scene.disturbed()), 20, 20)
        assert inlier.mean() > 0.85
        twist = []
        for estimate, truth in zip(poses[: scene.free], scene.poses, strict=False):
            apart = estimate @ inverse_transform(truth)
            skew = (apart[:3, :3] - apart[:3, :3].T) / 2
            twist += [*apart[:3, 3], skew[2, 1], skew[0, 2], skew[1, 0]]
        ratios.append(np.array(twist) @ pose_information(scene) @ np.array(twist) / len(twist))
    # 216 freedoms: a mean of 1 that strays by √(2 / 216) = 0.1; the tails that are cut off add some.
    assert 0.7 < np.mean(ratios) < 1.5


def test_outliers_are_named_and_do_not_pull() -> None:
    for seed in range(5):
        scene, clean = (Scene(200 + seed, points=200, pixel_sigma=1.0) for _ in range(2))
        # One in ten pixels is somewhere else.
        wrong = np.random.default_rng(seed).random(scene.observations) < 0.1
        scene.pixels[wrong] += np.random.default_rng(seed).choice([-1, 1], (wrong.sum(), 2)) * 40
        poses, _, inlier = adjust(scene.problem(*scene.disturbed(0.02, 0.01)))
        reference, _, _ = adjust(clean.problem(*clean.disturbed(0.02, 0.01)))
        assert inlier[wrong].mean() < 0.03
        assert inlier[~wrong].mean() > 0.85
        assert scene.worst(poses)[0] < 2.0 * clean.worst(reference)[0] + 0.001


def robust_residuals(scene: Scene, poses: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Residuals whose squares are the Huber costs of pixels and of disparities."""
    in_camera = scene.in_camera(poses, points)
    pixel = scene.pixels - CAMERA.project(in_camera)
    disparity = ((scene.disparity - BASELINE_FX / in_camera[:, 2]) / scene.disparity_sigma)[scene.has_depth]
    chi2, depth2 = (pixel**2).sum(axis=1) + 1e-18, disparity**2 + 1e-18
    pixel_cost = np.where(chi2 > CHI2_PIXEL, 2 * np.sqrt(CHI2_PIXEL * chi2) - CHI2_PIXEL, chi2)
    depth_cost = np.where(depth2 > CHI2_DEPTH, 2 * np.sqrt(CHI2_DEPTH * depth2) - CHI2_DEPTH, depth2)
    return np.concatenate(
        [(pixel * np.sqrt(pixel_cost / chi2)[:, None]).ravel(), disparity * np.sqrt(depth_cost / depth2)]
    )


def test_the_robust_pass_reaches_the_minimum_that_a_general_solver_finds() -> None:
    scene = Scene(300, cameras=4, free=2, points=14, pixel_sigma=1.0)
    scene.pixels[::17] += 25.0
    scene.disparity[5::19] += 4.0
    scene.has_depth[::7] = False
    start, start_points = scene.disturbed(0.02, 0.01)

    def unpack(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        poses = start.copy()
        for k in range(scene.free):
            poses[k] = exponential(x[6 * k : 6 * k + 6]) @ start[k]
        return poses, x[6 * scene.free :].reshape(-1, 3)

    x = np.concatenate([np.zeros(6 * scene.free), start_points.ravel()])
    best = least_squares(lambda x: robust_residuals(scene, *unpack(x)), x, xtol=1e-9, ftol=1e-8, gtol=1e-8)
    poses, points, _ = adjust(scene.problem(start, start_points), 60, 0)
    reached = (robust_residuals(scene, poses, points) ** 2).sum()
    assert reached <= 2 * best.cost * (1 + 1e-3)
    assert reached >= 2 * best.cost * (1 - 1e-3)  # below the minimum there is nothing: both weigh alike
    for k in range(scene.free):
        metres, radians = pose_error(poses[k], unpack(best.x)[0][k])
        assert metres < 1e-3
        assert radians < 3e-4


def test_more_steps_never_raise_the_cost() -> None:
    scene = Scene(301, pixel_sigma=1.0)
    scene.pixels[::13] += 30.0
    start = scene.disturbed(0.1, 0.05)
    costs = [(robust_residuals(scene, *adjust(scene.problem(*start), steps, 0)[:2]) ** 2).sum() for steps in range(9)]
    assert all(later <= earlier * (1 + 1e-9) for earlier, later in pairwise(costs))
    assert costs[-1] < 0.1 * costs[0]  # what is left are the outliers


def test_missing_depths_are_never_read() -> None:
    scene = Scene(302)
    scene.has_depth[::2] = False
    scene.disparity[::2] = np.nan
    poses, points, inlier = adjust(scene.problem(*scene.disturbed()), 20, 20)
    assert scene.worst(poses)[0] < 1e-4
    assert np.isfinite(points).all()
    assert inlier.all()


def test_points_that_start_behind_a_camera_are_dropped_and_harm_nothing() -> None:
    scene = Scene(303)
    poses, points = scene.disturbed(0.01, 0.005)
    points[:10, 2] *= -1
    adjusted, moved, inlier = adjust(scene.problem(poses, points))
    assert np.isfinite(moved).all()
    assert not inlier[scene.point < 10].any()
    assert inlier[scene.point >= 10].all()
    assert scene.worst(adjusted)[0] < 1e-3


def test_a_stop_flag_that_is_up_leaves_everything_where_it_was() -> None:
    scene = Scene(304)
    problem = scene.problem(*scene.disturbed())
    poses, points, inlier = adjust(problem, stop=np.ones(1, np.bool_))
    np.testing.assert_array_equal(poses, problem.camera_from_world)
    np.testing.assert_array_equal(points, problem.points)
    assert inlier.shape == (scene.observations,)


def test_the_problem_is_not_changed() -> None:
    scene = Scene(305, pixel_sigma=1.0)
    problem = scene.problem(*scene.disturbed())
    before = [np.copy(column) for column in problem]
    adjust(problem)
    for old, new in zip(before, problem, strict=True):
        np.testing.assert_array_equal(old, new)


def empty(keyframes: int, free: int, points: int) -> BundleProblem:
    """A problem without any observation."""
    return BundleProblem(
        np.tile(np.eye(4), (keyframes, 1, 1)), free, np.ones((points, 3)), np.zeros(points + 1, np.int64),
        np.empty(0, np.int32), np.empty((0, 2), np.float32), np.empty(0, np.float32), np.empty(0, np.bool_),
        np.empty(0, np.float32), np.empty(0, np.float32), np.empty(0, np.int64),
    )  # fmt: skip


@pytest.mark.parametrize(("keyframes", "free", "points"), [(0, 0, 0), (2, 1, 0), (2, 0, 3), (2, 2, 3)])
def test_without_observations_nothing_moves(keyframes: int, free: int, points: int) -> None:
    problem = empty(keyframes, free, points)
    poses, positions, inlier = adjust(problem)
    np.testing.assert_allclose(poses, problem.camera_from_world, atol=1e-12)
    np.testing.assert_allclose(positions, problem.points, atol=1e-12)
    assert inlier.shape == (0,)


def test_depth_fixes_the_scale_that_pixels_leave_open() -> None:
    """With one fixed camera, pixels alone know the other's place but for its distance; disparities say how far."""
    scene = Scene(306, cameras=2, free=1, points=200)
    scene.poses[0] = rigid([0.3, 0, 0], [0, 0.05, 0])
    in_camera = scene.in_camera(scene.poses, scene.points)
    scene.pixels[:] = CAMERA.project(in_camera)
    scene.disparity[:] = BASELINE_FX / in_camera[:, 2]
    stretched = scene.poses.copy()
    stretched[0, :3, 3] *= 1.3
    far = transform_points(inverse_transform(scene.poses[1]), 1.3 * transform_points(scene.poses[1], scene.points))
    poses, points, _ = adjust(scene.problem(stretched, far), 40, 10)
    assert scene.worst(poses)[0] < 1e-3
    assert np.median(np.linalg.norm(points - scene.points, axis=1)) < 2e-3
