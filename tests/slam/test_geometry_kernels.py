import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from slam_scenes import descriptors_of, hamming_table, rigid, rotation_angle, twists

from lpslam.camera import inverse_transform
from lpslam.slam.kernels.geometry import exponential, hamming, orthonormalise
from lpslam.slam.mapping.levelling import level_rotation


def generator(twist: np.ndarray) -> np.ndarray:
    """The 4×4 matrix whose matrix exponential is the motion of a twist, by definition."""
    x, y, z = twist[3:]
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    matrix[:3, 3] = twist[:3]
    return matrix


@given(twists(distance=10.0, angle=6.2))
def test_the_exponential_is_the_matrix_exponential(twist: np.ndarray) -> None:
    np.testing.assert_allclose(exponential(twist), expm(generator(twist)), atol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 9.9e-7, 1.01e-6, 1e-5, 1e-3, math.pi - 1e-9, math.pi])
def test_the_exponential_is_smooth_where_its_series_begins_and_at_half_a_turn(angle: float) -> None:
    for axis in ([1.0, 0, 0], [0, 0.6, -0.8]):
        twist = np.array([3.0, -2.0, 1.0, *(angle * np.array(axis))])
        np.testing.assert_allclose(exponential(twist), expm(generator(twist)), atol=1e-9)


@given(twists(), twists(), twists())
def test_motions_form_a_group(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> None:
    x, y, z = exponential(a), exponential(b), exponential(c)
    np.testing.assert_allclose((x @ y) @ z, x @ (y @ z), atol=1e-9)
    np.testing.assert_allclose(inverse_transform(x), exponential(-a), atol=1e-9)


@given(twists(), st.floats(-1, 1), st.floats(-1, 1))
def test_motions_along_one_twist_add_up(twist: np.ndarray, s: float, t: float) -> None:
    np.testing.assert_allclose(exponential(s * twist) @ exponential(t * twist), exponential((s + t) * twist), atol=1e-9)


@given(twists(), st.integers(0, 2**32 - 1), st.floats(0, 1e-3))
def test_orthonormalising_gives_a_rotation_near_the_drifted_one(twist: np.ndarray, seed: int, drift: float) -> None:
    drifted = exponential(twist)
    drifted[:3, :3] += np.random.default_rng(seed).uniform(-drift, drift, (3, 3))
    mended = drifted.copy()
    orthonormalise(mended)
    np.testing.assert_allclose(mended[:3, :3] @ mended[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(mended[:3, :3]) == pytest.approx(1.0, abs=1e-12)
    assert np.abs(mended - drifted).max() <= 6 * drift + 1e-12
    np.testing.assert_array_equal(mended[:3, 3], drifted[:3, 3])
    np.testing.assert_array_equal(mended[3], [0, 0, 0, 1])
    again = mended.copy()
    orthonormalise(again)
    np.testing.assert_allclose(again, mended, atol=1e-14)


def test_a_hundred_thousand_small_products_stay_rigid_when_pulled_back() -> None:
    step = rigid([0.01, 0, 0], [0.001, 0.002, -0.001])
    pose = np.eye(4)
    for _ in range(100_000):
        pose = pose @ step
        orthonormalise(pose)
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
    expected = exponential(1e5 * np.array([0.01, 0, 0, 0.001, 0.002, -0.001]))
    assert rotation_angle(pose[:3, :3] @ expected[:3, :3].T) < 1e-6


@given(st.integers(0, 2**32 - 1))
def test_hamming_counts_differing_bits(seed: int) -> None:
    a, b = descriptors_of(np.random.default_rng(seed), 2)
    assert hamming(a, b) == hamming_table(a[None], b[None])[0, 0] == hamming(b, a)
    assert hamming(a, a) == 0
    assert hamming(a, ~a) == 256


@settings(max_examples=200)
@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-0.95, 1), st.floats(0.1, 10))
def test_levelling_is_the_smallest_turn_that_puts_up_on_top(x: float, y: float, cosine: float, length: float) -> None:
    sine = math.sqrt(1 - cosine**2)
    heading = math.atan2(y, x)
    up = np.array([sine * math.cos(heading), sine * math.sin(heading), cosine])
    turn = level_rotation(length * up)
    np.testing.assert_allclose(turn[:3, :3] @ up, [0, 0, 1], atol=1e-9)
    np.testing.assert_allclose(turn[:3, :3] @ turn[:3, :3].T, np.eye(3), atol=1e-9)
    assert np.linalg.det(turn[:3, :3]) == pytest.approx(1.0)
    assert rotation_angle(turn[:3, :3]) == pytest.approx(math.acos(cosine), abs=1e-6)
    np.testing.assert_array_equal(turn[:3, 3], 0)
