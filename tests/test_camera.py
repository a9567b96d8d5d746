from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.errors import UserError

CAMERA = PinholeCamera(width=640, height=480, fx=525.0, fy=520.0, cx=318.2, cy=243.7)
# The calibrations that the TUM benchmark publishes for its first two cameras: strong and mild distortion.
FREIBURG1 = PinholeCamera(
    640, 480, 517.306408, 516.469215, 318.643040, 255.313989, (0.262383, -0.953104, -0.005358, 0.002628, 1.163314)
)
FREIBURG2 = PinholeCamera(
    640, 480, 520.908620, 521.007327, 325.141442, 249.701764, (0.231222, -0.784899, -0.003257, -0.000105, 0.917205)
)

cameras = st.builds(
    PinholeCamera,
    width=st.integers(1, 4000),
    height=st.integers(1, 4000),
    fx=st.floats(50, 3000),
    fy=st.floats(50, 3000),
    cx=st.floats(-100, 4000),
    cy=st.floats(-100, 4000),
)
seeds = st.integers(0, 2**32 - 1)


def random_rigid(random: np.random.Generator) -> np.ndarray:
    rotation, _ = np.linalg.qr(random.normal(size=(3, 3)))
    transform = np.eye(4)
    transform[:3, :3] = rotation * np.sign(np.linalg.det(rotation))
    transform[:3, 3] = random.uniform(-10, 10, 3)
    return transform


def distort(camera: PinholeCamera, pixels: np.ndarray) -> np.ndarray:
    """Where a lens with Brown-Conrady distortion moves ideal pixels (n, 2), by the definition."""
    k1, k2, p1, p2, k3 = camera.distortion
    x, y = (pixels[:, 0] - camera.cx) / camera.fx, (pixels[:, 1] - camera.cy) / camera.fy
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2 + k3 * r2**3
    xd = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    yd = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.column_stack([camera.fx * xd + camera.cx, camera.fy * yd + camera.cy])


@given(cameras, seeds)
def test_projecting_what_was_lifted_gives_the_pixels_back(camera: PinholeCamera, seed: int) -> None:
    random = np.random.default_rng(seed)
    pixels = random.uniform(0, [camera.width, camera.height], (20, 2))
    depths = random.uniform(0.1, 20, 20)
    lifted = camera.back_project(pixels, depths)
    np.testing.assert_array_equal(lifted[:, 2], depths)
    np.testing.assert_allclose(camera.project(lifted), pixels, atol=1e-8)


@given(cameras, seeds)
def test_lifting_what_was_projected_gives_the_points_back(camera: PinholeCamera, seed: int) -> None:
    random = np.random.default_rng(seed)
    points = random.uniform([-5, -5, 0.1], [5, 5, 20], (20, 3))
    np.testing.assert_allclose(camera.back_project(camera.project(points), points[:, 2]), points, atol=1e-8)
    homogeneous = points @ camera.matrix.T
    np.testing.assert_allclose(camera.project(points), homogeneous[:, :2] / homogeneous[:, 2:], rtol=1e-9, atol=1e-8)


def test_axes_and_pixels_point_the_same_way() -> None:
    centre, right, below = CAMERA.project(np.array([[0, 0, 2.0], [0.1, 0, 2], [0, 0.1, 2]]))
    np.testing.assert_allclose(centre, [318.2, 243.7])
    np.testing.assert_allclose(right - centre, [26.25, 0])
    np.testing.assert_allclose(below - centre, [0, 26])


@pytest.mark.parametrize("camera", [FREIBURG1, FREIBURG2], ids=["freiburg1", "freiburg2"])
def test_undistorting_takes_the_lens_away_to_a_millionth_of_a_pixel(camera: PinholeCamera) -> None:
    ideal = np.stack(np.meshgrid(np.arange(0.0, 640, 13), np.arange(0.0, 480, 13)), axis=-1).reshape(-1, 2)
    raw = distort(camera, ideal)
    inside = ((raw >= 0) & (raw <= [639, 479])).all(axis=1)
    assert inside.sum() > 1500
    assert np.abs(raw - ideal)[inside].max() > 3  # the lens does move pixels
    np.testing.assert_allclose(camera.undistort(raw[inside]), ideal[inside], atol=1e-6)


@pytest.mark.parametrize("camera", [CAMERA, FREIBURG1, FREIBURG2], ids=["rectified", "freiburg1", "freiburg2"])
@given(seed=seeds)
def test_distorting_is_the_definition_and_undistorting_its_inverse(camera: PinholeCamera, seed: int) -> None:
    ideal = np.random.default_rng(seed).uniform([0, 0], [639, 479], (40, 2))
    raw = camera.distort(ideal)
    np.testing.assert_allclose(raw, distort(camera, ideal), atol=1e-9)
    inside = ((raw >= 0) & (raw <= [639, 479])).all(axis=1)
    np.testing.assert_allclose(camera.undistort(raw[inside]), ideal[inside], atol=1e-6)
    np.testing.assert_allclose(camera.distort(camera.undistort(raw[inside])), raw[inside], atol=1e-6)


mild_lenses = st.tuples(
    st.floats(-0.3, 0.3), st.floats(-0.1, 0.1), st.floats(-0.005, 0.005), st.floats(-0.005, 0.005), st.just(0.0)
)


@given(mild_lenses, seeds)
def test_any_usual_lens_is_put_on_and_taken_off_again(
    distortion: tuple[float, float, float, float, float], seed: int
) -> None:
    camera = replace(CAMERA, distortion=distortion)
    ideal = np.random.default_rng(seed).uniform([60, 45], [580, 435], (40, 2))
    np.testing.assert_allclose(camera.undistort(camera.distort(ideal)), ideal, atol=1e-4)
    # The principal ray is where it was.
    np.testing.assert_allclose(camera.distort(np.array([[camera.cx, camera.cy]])), [[camera.cx, camera.cy]], atol=1e-9)


def test_a_rectified_camera_leaves_pixels_alone() -> None:
    pixels = np.array([[0.0, 0.0], [639.0, 479.0]])
    assert not CAMERA.is_distorted
    assert FREIBURG1.is_distorted
    np.testing.assert_array_equal(CAMERA.undistort(pixels), pixels)


@pytest.mark.parametrize("camera", [CAMERA, FREIBURG1])
def test_no_points_are_no_trouble(camera: PinholeCamera) -> None:
    none = np.empty((0, 2))
    assert camera.undistort(none).shape == (0, 2)
    assert camera.distort(none).shape == (0, 2)
    assert camera.back_project(none, np.empty(0)).shape == (0, 3)
    assert camera.project(np.empty((0, 3))).shape == (0, 2)


@given(seeds)
def test_inverting_a_rigid_transform(seed: int) -> None:
    random = np.random.default_rng(seed)
    a, b = random_rigid(random), random_rigid(random)
    points = random.uniform(-10, 10, (10, 3))
    np.testing.assert_allclose(a @ inverse_transform(a), np.eye(4), atol=1e-12)
    np.testing.assert_array_equal(inverse_transform(a)[3], [0, 0, 0, 1])
    np.testing.assert_allclose(inverse_transform(inverse_transform(a)), a, atol=1e-12)
    np.testing.assert_allclose(inverse_transform(a @ b), inverse_transform(b) @ inverse_transform(a), atol=1e-11)
    np.testing.assert_allclose(transform_points(inverse_transform(a), transform_points(a, points)), points, atol=1e-11)
    np.testing.assert_allclose(
        transform_points(a @ b, points), transform_points(a, transform_points(b, points)), atol=1e-11
    )


@pytest.mark.parametrize("label", ["width", "height", "fx", "fy", "depth_scale", "fps"])
@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf")])
def test_what_no_camera_can_be_is_refused_by_name(label: str, value: float) -> None:
    good = {"width": 640, "height": 480, "fx": 525.0, "fy": 520.0, "cx": 318.2, "cy": 243.7}
    with pytest.raises(UserError, match=rf"{label} is {value!r}") as refusal:
        PinholeCamera(**{**good, label: value})
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("label", ["cx", "cy"])
def test_a_principal_point_may_lie_anywhere_but_must_be_a_number(label: str) -> None:
    good = {"width": 640, "height": 480, "fx": 525.0, "fy": 520.0, "cx": 318.2, "cy": 243.7}
    PinholeCamera(**{**good, label: -20.0})
    with pytest.raises(UserError, match=label):
        PinholeCamera(**{**good, label: float("nan")})


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1e308])
def test_distortion_must_be_numbers(value: float) -> None:
    with pytest.raises(UserError, match="distortion"):
        PinholeCamera(640, 480, 525.0, 520.0, 318.2, 243.7, (0.1, value, 0.0, 0.0, 0.0))
