"""Surfaces and shades alone: a camera's step between two images, and what says that it is told."""

import cv2
import numpy as np
import pytest
from corner_room import CAMERA, CORNER, WALL, Planes, shot
from hypothesis import given, settings
from slam_scenes import pose_error, rigid, twists

from lpslam.camera import PinholeCamera, inverse_transform
from lpslam.config import SlamConfig, SurfaceConfig
from lpslam.slam.kernels.dense import align_terms
from lpslam.slam.kernels.geometry import exponential, logarithm
from lpslam.slam.sensor import SensorModel
from lpslam.slam.tracking.surfaces import SmallImages, Surfaces, sloped, without_holes

SENSOR = SensorModel.of(CAMERA, SlamConfig())
CONFIG = SurfaceConfig()
SURFACES = Surfaces(CAMERA, SENSOR, CONFIG)


def small(planes: Planes, camera_from_world: np.ndarray, contrast: float = 12.0, noise: float = 0.0) -> np.ndarray:
    """The small image (2, h, w) of a shot, with depth that strays by so many times what the sensor's does."""
    gray, depth = shot(planes, camera_from_world, contrast)
    sigma = noise * (SENSOR.depth_sigma + SENSOR.depth_sigma_quadratic * depth**2)
    strayed = np.random.default_rng(2).normal(depth, sigma)
    return SURFACES.images.reference(gray, np.where(depth > 0, strayed, 0.0).astype(np.float32))


REFERENCE = small(CORNER, np.eye(4))
SHADELESS = small(CORNER, np.eye(4), 0.0)


# Steps of a camera ---------------------------------------------------------------------------------------------------


@settings(max_examples=12)
@given(twists(distance=0.05, angle=0.08))  # farther than six sigmas of the guess is not believed
def test_a_step_before_a_corner_is_told_to_millimetres(twist: np.ndarray) -> None:
    moved = exponential(twist)
    aligned = SURFACES.align(REFERENCE, small(CORNER, moved, noise=0.5), np.eye(4), 1 / 30)
    assert aligned is not None
    assert aligned.holds
    metres, radians = pose_error(aligned.image_from_reference, moved)
    assert metres < 0.005
    assert np.degrees(radians) < 0.3


@settings(max_examples=15)
@given(twists(distance=0.04, angle=0.05))
def test_three_planes_without_any_shade_tell_it_by_themselves(twist: np.ndarray) -> None:
    moved = exponential(twist)
    aligned = SURFACES.align(SHADELESS, small(CORNER, moved, 0.0), np.eye(4), 1 / 30)
    assert aligned is not None
    assert aligned.holds
    metres, radians = pose_error(aligned.image_from_reference, moved)
    assert metres < 0.006
    assert np.degrees(radians) < 0.3


@pytest.mark.parametrize("rate", [30, 60, 120])
def test_readings_with_less_noise_than_supposed_tell_smaller_steps(rate: int) -> None:
    """The faster the frames, the less the guess leaves open: a sensor that is good tells it still, in the dark."""
    moved = rigid([0.002, -0.001, 0.002], [0.001, 0.002, 0.0])
    aligned = SURFACES.align(SHADELESS, small(CORNER, moved, 0.0, noise=0.1), np.eye(4), 1 / rate)
    assert aligned is not None
    assert aligned.holds
    assert pose_error(aligned.image_from_reference, moved)[0] < 0.001


def test_a_camera_that_exposes_longer_moves_no_farther() -> None:
    moved = rigid([0.03, -0.01, 0.02], [0.01, -0.02, 0.01])
    brighter = small(CORNER, moved)
    brighter[0] += 30.0
    aligned = SURFACES.align(REFERENCE, brighter, np.eye(4), 1 / 30)
    assert aligned is not None
    assert aligned.holds
    assert pose_error(aligned.image_from_reference, moved)[0] < 0.005


@pytest.mark.parametrize("noise", [0.0, 0.3, 1.0])
def test_a_wall_alone_without_shades_holds_nothing_and_leaves_the_guess_along_it(noise: float) -> None:
    """Also where slopes are a little noise: with the noise that is supposed, they add up to what a corner tells."""
    guess = rigid([0.02, -0.01, 0.0], [0.0, 0.0, 0.01])
    aligned = SURFACES.align(small(WALL, np.eye(4), 0.0), small(WALL, np.eye(4), 0.0, noise), guess, 1 / 30)
    assert aligned is not None
    assert not aligned.holds
    metres, radians = pose_error(aligned.image_from_reference, guess)
    assert metres < 0.01
    assert np.degrees(radians) < 0.4


def test_a_wall_with_a_spot_of_light_tells_how_the_camera_turns_away_from_it() -> None:
    """The spot is like itself and round: it says nothing of a roll, and takes nothing of what the wall says."""
    fx, _, cx, cy = SURFACES.images.intrinsics
    moved = rigid([0.0, 0.0, 0.0], [0.0, 0.03, 0.0])
    images = small(WALL, np.eye(4), 0.0, noise=0.3), small(WALL, moved, 0.0, noise=0.3)
    rows, columns = np.indices(images[0][0].shape)
    for image, across in zip(images, (cx, cx + fx * np.tan(0.03)), strict=True):
        image[0] = 3.0 * np.exp(-0.5 * ((columns - across) ** 2 + (rows - cy) ** 2) / 6.0**2)
    aligned = SURFACES.align(*images, np.eye(4), 1 / 10)
    assert aligned is not None
    assert aligned.likeness > CONFIG.least_likeness
    assert aligned.tells_turn
    assert not aligned.holds
    astray = logarithm(aligned.image_from_reference @ inverse_transform(moved))
    assert np.abs(astray[:5]).max() < 0.005  # all but the roll


def test_a_wall_with_shades_holds() -> None:
    moved = rigid([0.02, -0.01, 0.01], [0.0, 0.01, 0.01])
    aligned = SURFACES.align(small(WALL, np.eye(4)), small(WALL, moved, noise=0.5), np.eye(4), 1 / 30)
    assert aligned is not None
    assert aligned.holds
    assert pose_error(aligned.image_from_reference, moved)[0] < 0.005


def test_another_place_does_not_hold() -> None:
    aligned = SURFACES.align(REFERENCE, small(WALL, np.eye(4)), np.eye(4), 1 / 30)
    assert aligned is None or not aligned.holds


def test_a_view_that_was_left_is_not_aligned() -> None:
    turned = rigid([0, 0, 0], [0, 1.2, 0])
    assert SURFACES.align(REFERENCE, small(CORNER, turned), turned, 1 / 30) is None


# Depth that is none ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("reading", [0.0, np.nan, np.inf, -np.inf, -1.0])
@pytest.mark.parametrize("share", [0.3, 1.0])
def test_depth_that_is_none_is_left_out(reading: float, share: float) -> None:
    moved = rigid([0.02, 0.01, -0.01], [0.01, 0.02, 0.0])
    images = []
    for pose in (np.eye(4), moved):
        gray, depth = shot(CORNER, pose, 12.0)
        rows = np.random.default_rng(3).permutation(CAMERA.height // 40)[: round(share * CAMERA.height / 40)]
        for row in rows:
            depth[40 * row : 40 * row + 40] = reading
        images.append(SURFACES.images.reference(gray, depth))
    aligned = SURFACES.align(images[0], images[1], np.eye(4), 1 / 30)
    if share == 1.0:
        assert aligned is None or not aligned.holds
    else:
        assert aligned is not None
        assert pose_error(aligned.image_from_reference, moved)[0] < 0.006


# Small images ---------------------------------------------------------------------------------------------------------


def test_a_surface_that_is_full_of_holes_tells_the_step() -> None:
    moved = exponential(np.array([0.01, -0.005, 0.01, 0.01, 0.02, -0.01]))
    images = []
    for seed, pose in enumerate((np.eye(4), moved)):
        gray, depth = shot(CORNER, pose, 12.0)
        # Specks of a few pixels, as a dark or shiny surface has: four in ten readings are missing.
        specks = cv2.GaussianBlur(np.random.default_rng(seed).normal(size=depth.shape), (0, 0), 2.0)
        holed = np.where(specks > np.quantile(specks, 0.4), depth, 0.0)
        images.append(SURFACES.images.reference(gray, holed.astype(np.float32)))
    aligned = SURFACES.align(*images, np.eye(4), 1 / 30)
    assert aligned is not None
    assert aligned.holds
    assert pose_error(aligned.image_from_reference, moved)[0] < 0.005


def test_no_hole_is_filled_across_an_edge() -> None:
    depth = np.full((6, 6), 2.0, np.float32)
    depth[:, 3:] = 3.0
    depth[2, 1] = depth[2, 3] = depth[4, 5] = 0.0
    filled = without_holes(depth, 0.1)
    assert filled[2, 1] == pytest.approx(2.0)
    assert filled[2, 3] == 0.0
    assert filled[4, 5] == pytest.approx(3.0)
    assert np.array_equal(filled[depth > 0], depth[depth > 0])


def test_small_images_see_along_the_same_rays() -> None:
    _, depth = shot(CORNER, np.eye(4), 0.0)
    fx, fy, cx, cy = SURFACES.images.intrinsics
    v, u = np.mgrid[: REFERENCE.shape[1], : REFERENCE.shape[2]]
    points = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones(u.shape)]) * SHADELESS[1]
    offs = np.array([np.tensordot(normal, points, 1) - distance * normal[2] for normal, distance in CORNER])
    assert np.median(np.abs(offs).min(axis=0)) < 0.01
    assert SHADELESS[1].max() <= depth.max()


def test_a_lens_is_taken_out() -> None:
    lens = PinholeCamera(320, 240, 262.0, 261.0, 158.4, 121.2, (0.2, -0.3, 0.001, -0.002, 0.1))
    straight, bent = (SmallImages(camera, CONFIG.width, CONFIG.around, CONFIG.edge) for camera in (CAMERA, lens))
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    raw = np.column_stack([u.ravel(), v.ravel()]).astype(np.float64)
    ideal = lens.undistort(raw)
    ramp = np.ones(u.shape, np.float32)
    gray = np.clip(0.6 * ideal[:, 0], 0, 255).reshape(u.shape).round().astype(np.uint8)
    expected = straight.reference(np.clip(0.6 * u, 0, 255).round().astype(np.uint8), ramp)
    inner = np.s_[6:-6, 6:-6]
    assert np.abs(bent.reference(gray, ramp)[0] - expected[0])[inner].max() <= 1.0


def test_depth_has_no_slope_across_an_edge() -> None:
    image = np.stack([np.zeros((20, 30), np.float32), np.full((20, 30), 1.0, np.float32)])
    image[1, :, 15:] = 2.0
    image[1, 5, 5] = 0.0
    smooth = sloped(image, 0.1)[..., 3]
    assert np.isnan(smooth[:, 14:16]).all()
    assert np.isnan(smooth[4:7, 4:7]).all()
    assert np.isfinite(smooth[:, 17:]).all()
    ramp = np.stack([np.zeros((20, 30)), 1.0 + 0.01 * np.tile(np.arange(30.0), (20, 1))]).astype(np.float32)
    assert sloped(ramp, 0.1)[1:-1, 1:-1, 4] == pytest.approx(0.01, abs=1e-5)


# The kernel's derivative ----------------------------------------------------------------------------------------------

SHADE_SLOPES, DEPTH_SLOPES, BRIGHTER, SHADE_SIGMA, RIM = (0.4, -0.3), (0.006, 0.004), 1.5, 4.0, 8
"""Of images that are planes in their pixels, as the kernel takes those between four of them."""


def plane(slopes: tuple[float, float], middle: float, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.asarray(middle + slopes[0] * u + slopes[1] * v)


def level_images() -> tuple[np.ndarray, np.ndarray]:
    """A reference without depth at its rim, so that all of it stays in view, and the image that lies on it."""
    height, width = REFERENCE.shape[1:]
    v, u = np.mgrid[:height, :width].astype(np.float64)
    shades, depth = plane(SHADE_SLOPES, 100.0, u, v), plane(DEPTH_SLOPES, 2.0, u, v)
    flat = [np.full_like(u, slope) for slope in (*SHADE_SLOPES, *DEPTH_SLOPES)]
    image = np.stack([shades, *flat[:2], depth, *flat[2:]], axis=-1).astype(np.float32)
    is_inner = np.zeros(u.shape, np.bool_)
    is_inner[RIM:-RIM, RIM:-RIM] = True
    return np.stack([shades, np.where(is_inner, depth, 0.0)]).astype(np.float32), image


def terms(pose: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[int, int, int]]:
    """Hessian, gradient and counts at a pose."""
    reference, image = level_images()
    hessian, gradient, residuals = np.empty((6, 6)), np.empty(6), np.empty((2, reference[0].size))
    noise = (SENSOR.depth_sigma, SENSOR.depth_sigma_quadratic)
    counts = align_terms(
        reference, image, SURFACES.images.intrinsics, pose, (BRIGHTER, SHADE_SIGMA), noise, 1,
        hessian, gradient, residuals,
    )  # fmt: skip
    return hessian, gradient, counts


def cost(pose: np.ndarray, weighed_at: np.ndarray) -> float:
    """Half the squared residuals of a pose, by the definition, with the depths' sigmas at another one."""
    reference, _ = level_images()
    fx, fy, cx, cy = SURFACES.images.intrinsics
    v, u = np.nonzero(reference[1])
    depth = reference[1][v, u].astype(np.float64)
    points = np.column_stack([(u - cx) / fx * depth, (v - cy) / fy * depth, depth])
    x, y, z = (points @ pose[:3, :3].T + pose[:3, 3]).T
    there = fx * x / z + cx, fy * y / z + cy
    shades = (plane(SHADE_SLOPES, 100.0, *there) + BRIGHTER - reference[0][v, u]) / SHADE_SIGMA
    sigma = SENSOR.depth_sigma + SENSOR.depth_sigma_quadratic * (points @ weighed_at[2, :3] + weighed_at[2, 3]) ** 2
    depths = (plane(DEPTH_SLOPES, 2.0, *there) - z) / sigma
    return 0.5 * float((shades**2).sum() + (depths**2).sum())


@settings(max_examples=20)
@given(twists(distance=0.004, angle=0.002))
def test_the_gradient_is_that_of_the_cost_and_the_hessian_that_of_the_gradient(twist: np.ndarray) -> None:
    pose, step = exponential(twist), 1e-5
    hessian, gradient, counts = terms(pose)
    assert set(counts) == {int((level_images()[0][1] > 0).sum())}
    slope, curvature = np.empty(6), np.empty((6, 6))
    for axis, offset in enumerate(step * np.eye(6)):
        ahead, behind = exponential(offset) @ pose, exponential(-offset) @ pose
        slope[axis] = (cost(ahead, pose) - cost(behind, pose)) / (2 * step)
        curvature[axis] = (terms(ahead)[1] - terms(behind)[1]) / (2 * step)
    assert gradient == pytest.approx(slope, rel=1e-3, abs=1e-4 * np.abs(slope).max() + 0.1)
    upper = np.triu_indices(6)
    assert hessian[upper] == pytest.approx(curvature[upper], rel=0.1, abs=0.03 * float(np.abs(curvature).max()))


# Faint patterns -------------------------------------------------------------------------------------------------------


def test_grain_on_a_wall_tells_the_way_though_the_lens_stands_still() -> None:
    """Two grey values of grain under as much noise, and forty of a lens that darkens: the latter moves with nothing."""
    random, grain = np.random.default_rng(8), np.random.default_rng(9).standard_normal((700, 800)).astype(np.float32)
    pattern = cv2.GaussianBlur(grain, (0, 0), 6.0)
    pattern *= 2.0 / pattern.std()
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    lens = 120.0 - 20.0 * (((u - 160) / 160.0) ** 2 + ((v - 120) / 120.0) ** 2)

    def picture(pose: np.ndarray) -> np.ndarray:
        _, depth = shot(WALL, pose, 0.0)
        rays = CAMERA.back_project(
            np.column_stack([u.ravel(), v.ravel()]).astype(np.float64), depth.ravel().astype(float)
        )
        points = (rays - pose[:3, 3]) @ pose[:3, :3]
        at = (points[:, :2] * 262.0 / 1.5 + [400.0, 350.0]).astype(np.float32).reshape(*depth.shape, 2)
        seen = lens + cv2.remap(pattern, at[..., 0], at[..., 1], cv2.INTER_LINEAR)
        noisy = (seen + random.normal(0, 2.0, seen.shape)).clip(0, 255).round().astype(np.uint8)
        return SURFACES.images.reference(noisy, depth)

    moved = rigid([0.03, -0.02, 0.0], [0.0, 0.0, 0.02])
    aligned = SURFACES.align(picture(np.eye(4)), picture(moved), np.eye(4), 1 / 30)
    assert aligned is not None
    assert aligned.holds
    assert aligned.is_proven
    assert pose_error(aligned.image_from_reference, moved)[0] < 0.006
