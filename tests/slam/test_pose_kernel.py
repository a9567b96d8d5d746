import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares
from slam_scenes import BASELINE_FX, CAMERA, SENSOR, disparities, points_ahead, pose_error, rigid

from lpslam.camera import inverse_transform, transform_points
from lpslam.slam.kernels.geometry import exponential, logarithm
from lpslam.slam.kernels.pose import PosePrior, no_prior, optimise_pose
from lpslam.slam.kernels.rays import NO_RAYS
from lpslam.slam.kernels.reprojection import CHI2_DEPTH, CHI2_PIXEL


class View:
    """Points seen by a camera at a known pose, with noise of a known size."""

    def __init__(self, seed: int, count: int, pixel_sigma: float = 0.0, disparity_sigma: float = 0.0) -> None:
        random = self.random = np.random.default_rng(seed)
        self.truth = rigid([*random.uniform(-1, 1, 3)], [*random.uniform(-1, 1, 3)])
        in_camera = points_ahead(random, count)
        self.points = transform_points(inverse_transform(self.truth), in_camera)
        noise = random.normal(0, 1, (count, 3))
        self.pixels = (CAMERA.project(in_camera) + pixel_sigma * noise[:, :2]).astype(np.float32)
        self.disparity = disparities(in_camera[:, 2]) + (disparity_sigma * noise[:, 2]).astype(np.float32)
        self.has_depth = np.ones(count, np.bool_)
        self.pixel_information = np.full(count, 1 / max(pixel_sigma, 1.0) ** 2, np.float32)
        self.disparity_information = np.full(count, 1 / (disparity_sigma or 0.3) ** 2, np.float32)

    def optimise(
        self, guess: np.ndarray, rounds: int = 4, iterations: int = 10
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        pose, inlier, depth_inlier, _, information = optimise_pose(
            guess, self.points, self.pixels, self.disparity, self.has_depth, self.pixel_information,
            self.disparity_information, NO_RAYS, no_prior(), SENSOR.intrinsics, rounds, iterations,
        )  # fmt: skip
        return pose, inlier, depth_inlier, information

    def nearby(self, metres: float = 0.08, radians: float = 0.05) -> np.ndarray:
        """A first guess off by so much in a random direction."""
        off = self.random.normal(size=6)
        off[:3] *= metres / np.linalg.norm(off[:3])
        off[3:] *= radians / np.linalg.norm(off[3:])
        return exponential(off) @ self.truth


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(6, 200))
def test_without_noise_the_pose_is_found_exactly(seed: int, count: int) -> None:
    view = View(seed, count)
    pose, inlier, depth_inlier, _ = view.optimise(view.nearby())
    metres, radians = pose_error(pose, view.truth)
    # Pixels are stored as float32: 3e-5 of a pixel at 640.
    assert metres < 1e-5
    assert radians < 1e-5
    assert inlier.all()
    assert depth_inlier.all()
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)


def test_the_error_is_what_the_noise_allows_and_the_information_says() -> None:
    """Over many draws the squared error, weighed by the information matrix, has the mean of χ² with six freedoms."""
    chi2, metres = [], []
    for seed in range(60):
        view = View(seed, 300, pixel_sigma=1.0, disparity_sigma=0.3)
        view.pixel_information[:] = 1.0
        pose, _, _, information = view.optimise(view.nearby())
        apart = view.truth @ inverse_transform(pose)
        rotation = apart[:3, :3] - apart[:3, :3].T
        twist = np.array([*apart[:3, 3], rotation[2, 1] / 2, rotation[0, 2] / 2, rotation[1, 0] / 2])
        chi2.append(twist @ information @ twist)
        metres.append(np.linalg.norm(apart[:3, 3]))
    # A mean of 60 draws of χ²₆ strays by √12 / √60 = 0.45. Cutting the tails off as outliers adds a little.
    assert 6 - 1.5 < np.mean(chi2) < 6 + 2.5
    # One pixel at 3 m is 6 mm; 300 points leave about a millimetre.
    assert np.mean(metres) < 0.003


@pytest.mark.parametrize("share", [0.1, 0.3, 0.45])
def test_outliers_do_not_move_the_pose_and_are_named(share: float) -> None:
    errors = []
    for seed in range(20):
        view = View(1000 + seed, 300, pixel_sigma=1.0, disparity_sigma=0.3)
        wrong = view.random.random(300) < share
        moved = view.random.uniform([0, 0], [CAMERA.width, CAMERA.height], (300, 2)).astype(np.float32)
        wrong &= np.linalg.norm(moved - view.pixels, axis=1) > 20
        view.pixels[wrong] = moved[wrong]
        clean = View(1000 + seed, 300, pixel_sigma=1.0, disparity_sigma=0.3)
        pose, inlier, _, _ = view.optimise(view.nearby(0.05, 0.03))
        without, _, _, _ = clean.optimise(clean.nearby(0.05, 0.03))
        errors.append([*pose_error(pose, view.truth), *pose_error(without, clean.truth)])
        assert not (inlier & wrong).any()
        assert (inlier & ~wrong).sum() >= 0.88 * (~wrong).sum()  # 95 % by the threshold's definition
    metres, radians, clean_metres, clean_radians = np.mean(errors, axis=0)
    # Fewer good points and a stray one or two near the threshold: the error grows as 1 / √(1 − share), with room.
    assert metres < 1.5 * clean_metres / np.sqrt(1 - share)
    assert radians < 1.5 * clean_radians / np.sqrt(1 - share)


def test_a_wrong_depth_costs_the_depth_and_not_the_pixel() -> None:
    view = View(7, 300, pixel_sigma=0.5, disparity_sigma=0.3)
    wrong = view.random.random(300) < 0.3
    view.disparity[wrong] += 6.0
    pose, inlier, depth_inlier, _ = view.optimise(view.nearby())
    assert not depth_inlier[wrong].any()
    assert inlier[wrong].mean() > 0.9
    assert depth_inlier[~wrong].mean() > 0.85
    metres, radians = pose_error(pose, view.truth)
    assert metres < 0.004
    assert radians < 0.001


def test_depths_that_are_missing_are_never_read() -> None:
    view = View(8, 200, pixel_sigma=0.5)
    view.has_depth[::2] = False
    view.disparity[::2] = np.nan
    pose, inlier, depth_inlier, information = view.optimise(view.nearby())
    assert np.isfinite(pose).all()
    assert np.isfinite(information).all()
    assert inlier.mean() > 0.9
    assert not depth_inlier[::2].any()
    assert pose_error(pose, view.truth)[0] < 0.004

    view.has_depth[:] = False
    view.disparity[:] = np.nan
    pose, inlier, depth_inlier, _ = view.optimise(view.nearby())
    assert not depth_inlier.any()
    assert inlier.mean() > 0.9
    assert pose_error(pose, view.truth)[0] < 0.006


def test_depth_holds_the_distance_that_pixels_of_a_far_narrow_patch_cannot() -> None:
    random = np.random.default_rng(9)
    errors = {True: [], False: []}
    for _ in range(20):
        in_camera = CAMERA.back_project(random.uniform([280, 200], [360, 280], (60, 2)), random.uniform(2.95, 3.05, 60))
        pixels = (CAMERA.project(in_camera) + random.normal(0, 1, (60, 2))).astype(np.float32)
        # A centimetre of noise at 3 m.
        disparity = disparities(in_camera[:, 2]) + (BASELINE_FX / 9 * 0.01 * random.normal(size=60)).astype(np.float32)
        information = np.full(60, 1 / (BASELINE_FX / 9 * 0.01) ** 2, np.float32)
        for with_depth, into in errors.items():
            pose, *_ = optimise_pose(
                rigid([0.03, 0.0, 0.05], [0, 0.01, 0]), in_camera, pixels, disparity, np.full(60, with_depth),
                np.ones(60, np.float32), information, NO_RAYS, no_prior(), SENSOR.intrinsics, 4, 10,
            )  # fmt: skip
            into.append(abs(pose[2, 3]))
    assert np.median(errors[True]) < 0.004  # 1 cm over √60, with room
    assert np.median(errors[True]) < 0.5 * np.median(errors[False])


# What else tells the pose --------------------------------------------------------------------------------------------


def with_prior(view: View, told: np.ndarray, information: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The pose and its information, beside a pose (4×4) that something else tells with an information (6, 6)."""
    pose, _, _, _, surely = optimise_pose(
        view.nearby(0.02, 0.01), view.points, view.pixels, view.disparity, view.has_depth, view.pixel_information,
        view.disparity_information, NO_RAYS, PosePrior(inverse_transform(told), information), SENSOR.intrinsics, 4, 30,
    )  # fmt: skip
    return pose, surely


def test_what_is_told_surely_holds_a_pose_that_few_points_leave_open() -> None:
    alone, beside = [], []
    for seed in range(20):
        view = View(seed, 8, pixel_sigma=2.0)
        told = exponential(view.random.normal(0, 1e-3, 6)) @ view.truth
        alone.append(pose_error(view.optimise(view.nearby(0.02, 0.01))[0], view.truth)[0])
        beside.append(pose_error(with_prior(view, told, np.eye(6) * 1e6)[0], view.truth)[0])
    assert np.median(beside) < 0.004  # 1 mm in three directions, with room
    assert np.median(beside) < 0.5 * np.median(alone)


def test_points_and_what_is_told_are_weighed_by_how_sure_they_are() -> None:
    """Near the optimum of both the step to it is the mean of the two, weighed by their information."""
    view = View(3, 150, pixel_sigma=0.5)
    points_alone, _, _, information = view.optimise(view.truth)
    off = np.array([0.002, -0.001, 0.001, 2e-4, -3e-4, 1e-4])
    told = exponential(off) @ points_alone
    pose, _ = with_prior(view, told, information)
    moved = logarithm(pose @ inverse_transform(points_alone))
    # Judged anew, a few points at the gate change sides.
    np.testing.assert_allclose(moved, off / 2, atol=4e-4)


def test_what_is_told_far_from_all_points_hardly_pulls() -> None:
    view = View(4, 150, pixel_sigma=0.5)
    told = exponential(np.array([0.3, 0.0, 0.0, 0.0, 0.0, 0.0])) @ view.truth
    pose, _ = with_prior(view, told, np.eye(6) * 1e4)
    assert pose_error(pose, view.optimise(view.truth)[0])[0] < 0.004


def test_points_behind_the_camera_are_outliers_and_harmless() -> None:
    view = View(10, 200, pixel_sigma=0.5)
    behind = np.zeros(200, np.bool_)
    behind[:60] = True
    in_camera = transform_points(view.truth, view.points)
    in_camera[behind, 2] *= -1
    view.points = transform_points(inverse_transform(view.truth), in_camera)
    pose, inlier, depth_inlier, _ = view.optimise(view.nearby())
    assert not inlier[behind].any()
    assert not depth_inlier[behind].any()
    assert inlier[~behind].mean() > 0.9
    assert pose_error(pose, view.truth)[0] < 0.004


@pytest.mark.parametrize("count", [0, 1, 2])
def test_too_few_points_leave_the_guess_and_claim_nothing(count: int) -> None:
    view = View(11, count)
    guess = view.nearby()
    pose, inlier, depth_inlier, _ = view.optimise(guess)
    np.testing.assert_array_equal(pose, guess)
    assert inlier.shape == depth_inlier.shape == (count,)
    assert not inlier.any()
    assert not depth_inlier.any()


def test_all_points_at_one_place_do_not_break_the_solver() -> None:
    view = View(12, 20)
    view.points[:] = view.points[0]
    view.pixels[:] = view.pixels[0]
    view.disparity[:] = view.disparity[0]
    pose, _, _, _ = view.optimise(view.nearby())
    assert np.isfinite(pose).all()
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-9)


def test_nothing_but_outliers_gives_few_inliers() -> None:
    for seed in range(10):
        view = View(2000 + seed, 200)
        view.pixels[:] = view.random.uniform([0, 0], [CAMERA.width, CAMERA.height], (200, 2))
        pose, inlier, _, _ = view.optimise(view.nearby())
        assert np.isfinite(pose).all()
        assert inlier.sum() < 20


def test_the_arguments_are_left_as_they_were() -> None:
    view = View(13, 50, pixel_sigma=1.0)
    guess = view.nearby()
    before = [guess.copy(), view.points.copy(), view.pixels.copy(), view.disparity.copy(), view.has_depth.copy()]
    view.optimise(guess)
    for old, new in zip(before, [guess, view.points, view.pixels, view.disparity, view.has_depth], strict=True):
        np.testing.assert_array_equal(old, new)


def test_two_rounds_agree_with_a_general_solver() -> None:
    """SciPy minimises the same Huber cost, then the plain one over what the first kept."""
    view = View(14, 80, pixel_sigma=1.0, disparity_sigma=0.3)
    view.pixels[:16] += 30.0

    def residuals(twist: np.ndarray) -> np.ndarray:
        in_camera = transform_points(exponential(twist) @ view.truth, view.points)
        pixel = view.pixels - CAMERA.project(in_camera)
        disparity = (view.disparity - BASELINE_FX / in_camera[:, 2]) * np.sqrt(view.disparity_information)
        chi2 = (pixel**2).sum(axis=1)
        huber = np.where(chi2 > CHI2_PIXEL, 2 * np.sqrt(CHI2_PIXEL * chi2) - CHI2_PIXEL, chi2)
        depth2 = disparity**2
        depth = np.where(depth2 > CHI2_DEPTH, 2 * np.sqrt(CHI2_DEPTH * depth2) - CHI2_DEPTH, depth2)
        return np.concatenate([(pixel * np.sqrt(huber / chi2)[:, None]).ravel(), disparity * np.sqrt(depth / depth2)])

    best = least_squares(residuals, np.zeros(6), xtol=1e-12, ftol=1e-12, gtol=1e-12)
    pose, *_ = optimise_pose(
        view.nearby(0.02, 0.01), view.points, view.pixels, view.disparity, view.has_depth, view.pixel_information,
        view.disparity_information, NO_RAYS, no_prior(), SENSOR.intrinsics, 2, 40,
    )  # fmt: skip
    robust = exponential(best.x) @ view.truth
    kept = np.linalg.norm(view.pixels - CAMERA.project(transform_points(robust, view.points)), axis=1) ** 2 < CHI2_PIXEL
    assert kept[:16].sum() == 0
    in_view = transform_points(robust, view.points)
    depth2 = (view.disparity - BASELINE_FX / in_view[:, 2]) ** 2 * view.disparity_information

    def plain(twist: np.ndarray) -> np.ndarray:
        in_camera = transform_points(exponential(twist) @ view.truth, view.points)
        pixel = (view.pixels - CAMERA.project(in_camera))[kept]
        disparity = (view.disparity - BASELINE_FX / in_camera[:, 2]) * np.sqrt(view.disparity_information)
        return np.concatenate([pixel.ravel(), disparity[kept & (depth2 <= CHI2_DEPTH)]])

    final = exponential(least_squares(plain, best.x, xtol=1e-12, ftol=1e-12, gtol=1e-12).x) @ view.truth
    metres, radians = pose_error(pose, final)
    assert metres < 1e-5
    assert radians < 1e-5
