"""Points of which the direction alone is known: what they say of a pose, and how far they turn out to be."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from slam_scenes import CAMERA, SENSOR, disparities, points_ahead, pose_error, rigid

from lpslam.camera import inverse_transform, transform_points
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.kernels.pose import no_prior, optimise_pose
from lpslam.slam.kernels.rays import RaySights, add_ray_terms, judge_rays, measure_inverse

seeds = st.integers(0, 2**32 - 1)
MEAN, SIGMA = 0.1, 0.03
"""1/m: walls at ten metres, give or take."""


class Hall:
    """Walls that one camera saw first, at the origin, and another sees now; some points have depth."""

    def __init__(self, seed: int, near: int, far: int, noise: float) -> None:
        random = np.random.default_rng(seed)
        self.truth = rigid([*random.uniform(-0.4, 0.4, 3)], [*random.uniform(-0.15, 0.15, 3)])
        self.inverse = np.clip(random.normal(MEAN, SIGMA, far), 0.01, None)
        pixels = random.uniform([150, 120], [490, 360], (far, 2))
        self.bearing = CAMERA.back_project(pixels, np.ones(far))
        self.far = self.bearing / self.inverse[:, None]
        self.near = transform_points(inverse_transform(self.truth), points_ahead(random, near))
        self.pixels = (self._seen(self.far) + noise * random.normal(size=(far, 2))).astype(np.float32)
        self.near_pixels = (self._seen(self.near) + noise * random.normal(size=(near, 2))).astype(np.float32)

    def _seen(self, points: np.ndarray) -> np.ndarray:
        return CAMERA.project(transform_points(self.truth, points))

    def rays(self, inverse: np.ndarray | float, sigma: float) -> RaySights:
        count = len(self.bearing)
        return RaySights(
            np.zeros((count, 3)), self.bearing, np.full(count, inverse), np.full(count, sigma), self.pixels,
            np.ones(count, np.float32),
        )  # fmt: skip

    def optimise(self, rays: RaySights) -> tuple[np.ndarray, np.ndarray]:
        """The pose from a guess that is a little off, and which rays agree."""
        depths = transform_points(self.truth, self.near)[:, 2]
        count = len(self.near)
        guess = rigid([0.05, -0.04, 0.03], [0.02, 0.01, -0.02]) @ self.truth
        pose, _, _, agrees, _ = optimise_pose(
            guess, self.near, self.near_pixels, disparities(depths), np.ones(count, np.bool_),
            np.ones(count, np.float32), np.full(count, 1 / 0.3**2, np.float32), rays, no_prior(),
            SENSOR.intrinsics, 4, 10,
        )  # fmt: skip
        return pose, agrees


@settings(max_examples=30)
@given(seeds)
def test_rays_of_known_length_are_points(seed: int) -> None:
    hall = Hall(seed, 0, 80, 0.0)
    rays = hall.rays(hall.inverse, 1e-9)
    hessian, gradient = np.zeros((6, 6)), np.zeros(6)
    all_of_them = np.ones(80, np.bool_)
    assert add_ray_terms(hall.truth, rays, all_of_them, np.inf, SENSOR.intrinsics, hessian, gradient) < 1e-4
    assert np.linalg.eigvalsh(np.triu(hessian) + np.triu(hessian, 1).T).min() > 0
    agrees = np.zeros(80, np.bool_)
    judge_rays(hall.truth, rays, SENSOR.intrinsics, agrees)
    assert agrees.all()


@settings(max_examples=20)
@given(seeds)
def test_the_gradient_is_that_of_the_cost(seed: int) -> None:
    """By differences; the weight of the line along which a ray is not known is held, as in every Gauss-Newton step."""
    hall = Hall(seed, 0, 40, 1.0)
    rays, everyone = hall.rays(MEAN, 1e-9), np.ones(40, np.bool_)

    def cost(pose: np.ndarray) -> float:
        return add_ray_terms(pose, rays, everyone, np.inf, SENSOR.intrinsics, np.zeros((6, 6)), np.zeros(6))

    gradient = np.zeros(6)
    add_ray_terms(hall.truth, rays, everyone, np.inf, SENSOR.intrinsics, np.zeros((6, 6)), gradient)
    step = 1e-6
    by_differences = [
        (cost(exponential(step * axis) @ hall.truth) - cost(exponential(-step * axis) @ hall.truth)) / (2 * step)
        for axis in np.eye(6)
    ]
    np.testing.assert_allclose(-2.0 * gradient, by_differences, rtol=1e-4, atol=1e-2 * np.abs(gradient).max())


def test_far_points_hold_the_turn_and_leave_the_step_to_what_has_depth() -> None:
    """Twelve points with depth, eighty walls of unknown distance: taken for points they pull at the step."""
    errors: dict[str, list[tuple[float, float]]] = {"none": [], "as rays": [], "as points": []}
    for seed in range(40):
        hall = Hall(seed, 12, 80, 1.0)
        for name, rays in (
            ("none", Hall(seed, 12, 0, 1.0).rays(MEAN, SIGMA)),
            ("as rays", hall.rays(MEAN, SIGMA)),
            ("as points", hall.rays(MEAN, 1e-6)),
        ):
            errors[name].append(pose_error(hall.optimise(rays)[0], hall.truth))
    metres = {name: np.median([each[0] for each in found]) for name, found in errors.items()}
    radians = {name: np.median([each[1] for each in found]) for name, found in errors.items()}
    assert radians["as rays"] < 0.5 * radians["none"]
    assert metres["as rays"] < 0.7 * metres["none"]
    assert metres["as rays"] < 0.85 * metres["as points"]


def test_rays_that_moved_are_outliers() -> None:
    hall = Hall(3, 30, 80, 0.5)
    hall.pixels[:20] += [25.0, 25.0]
    _, agrees = hall.optimise(hall.rays(MEAN, SIGMA))
    assert agrees[:20].sum() <= 2
    assert agrees[20:].mean() > 0.85


def test_inverse_depths_are_found_as_surely_as_is_said() -> None:
    errors = []
    for seed in range(30):
        hall = Hall(seed, 0, 60, 1.0)
        mean, sigma, left = measure_inverse(
            np.tile(hall.truth, (60, 1, 1)), hall.bearing, hall.pixels, np.ones(60, np.float32),
            np.full(60, MEAN), np.full(60, SIGMA), SENSOR.intrinsics,
        )  # fmt: skip
        assert (sigma < SIGMA).all()
        assert np.isfinite(left).all()
        errors.append((mean - hall.inverse) / sigma)
    assert 0.9 < np.std(np.concatenate(errors)) < 1.1


def test_a_camera_that_only_turned_tells_no_distance() -> None:
    hall = Hall(5, 0, 20, 0.0)
    turned = rigid([0, 0, 0], [0.05, 0.1, 0.0])
    pixels = CAMERA.project(transform_points(turned, hall.far)).astype(np.float32)
    mean, sigma, left = measure_inverse(
        np.tile(turned, (20, 1, 1)), hall.bearing, pixels, np.ones(20, np.float32),
        np.full(20, MEAN), np.full(20, SIGMA), SENSOR.intrinsics,
    )  # fmt: skip
    np.testing.assert_allclose(mean, MEAN)
    np.testing.assert_allclose(sigma, SIGMA)
    assert (left < 1e-3).all()
