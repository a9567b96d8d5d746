import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lpslam.calibration.lens import by_small_turn, gap, lens_of, project, with_lens
from lpslam.camera import PinholeCamera

CAMERA = PinholeCamera(640, 480, 548.0, 549.5, 326.0, 233.0, (-0.08, 0.03, 0.001, -0.0015, 0.02))
RNG = np.random.default_rng(0)
POINTS = np.column_stack([RNG.uniform(-1, 1, 50), RNG.uniform(-0.8, 0.8, 50), RNG.uniform(1.5, 4, 50)])
DRAG = RNG.normal(0, 100, (50, 2))


def test_projecting_is_the_cameras() -> None:
    pixels = project(POINTS, lens_of(CAMERA), np.zeros((50, 2))).pixels
    assert np.allclose(pixels, CAMERA.distort(CAMERA.project(POINTS)), atol=1e-9)
    assert with_lens(CAMERA, lens_of(CAMERA)) == CAMERA


@given(seed=st.integers(0, 1000))
def test_derivatives_are_those_of_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    lens = lens_of(CAMERA) + np.append(rng.normal(0, 1, 4), rng.normal(0, 0.02, 6))
    found = project(POINTS, lens, DRAG)
    for column in range(10):
        step = np.zeros(10)
        step[column] = 1e-6
        ahead, behind = (project(POINTS, lens + sign * step, DRAG).pixels for sign in (1, -1))
        assert np.allclose((ahead - behind) / 2e-6, found.by_lens[:, :, column], atol=1e-3)
    for axis in range(3):
        step = np.zeros(3)
        step[axis] = 1e-6
        ahead, behind = (project(POINTS + sign * step, lens, DRAG).pixels for sign in (1, -1))
        assert np.allclose((ahead - behind) / 2e-6, found.by_point[:, :, axis], atol=1e-3)


def test_a_small_turn_moves_points_by_the_cross_product() -> None:
    turn = np.array([0.01, -0.02, 0.03])
    assert np.allclose(by_small_turn(POINTS) @ turn, np.cross(turn, POINTS))


def test_the_gap_is_nought_between_equals_and_leaves_turns_out() -> None:
    assert gap(CAMERA, CAMERA).max() < 1e-3
    shifted = with_lens(CAMERA, lens_of(CAMERA) + 3.0 * np.eye(10)[2])
    # A principal point 3 px off is nearly a turn; a focal length 1 % off is none.
    assert gap(CAMERA, shifted).mean() < 1.5
    longer = with_lens(CAMERA, lens_of(CAMERA) * [1.01, 1.01, 1, 1, 1, 1, 1, 1, 1, 1])
    assert 1.5 < gap(CAMERA, longer).mean() < 3
