import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from lpslam.text.placing.triangulation import angles, meetings, middles, triangulate

Array = NDArray[np.float64]

seeds = st.integers(0, 2**32 - 1)


def scene(seed: int, views: int) -> tuple[Array, Array, Array]:
    """A point 2 to 15 m ahead, camera centres in a metre or so, and the directions to the point."""
    random = np.random.default_rng(seed)
    point = np.array([*random.uniform(-1.5, 1.5, 2), random.uniform(2.0, 15.0)])
    origins = random.uniform(-1.0, 1.0, (views, 3)) * (1.0, 0.3, 0.5)
    directions = point - origins
    return point, origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def turned(directions: Array, noise: float, random: np.random.Generator) -> Array:
    """The directions, each off by so many radians in both ways across."""
    aside = random.normal(0.0, noise, directions.shape)
    aside -= (aside * directions).sum(axis=1, keepdims=True) * directions
    return np.asarray((directions + aside) / np.linalg.norm(directions + aside, axis=1, keepdims=True), np.float64)


@given(seeds, st.integers(2, 12))
def test_true_directions_meet_in_the_point(seed: int, views: int) -> None:
    point, origins, directions = scene(seed, views)
    place = triangulate(origins, directions, np.full(views, 0.005), np.ones(views))
    assert place is not None
    assert place.position == pytest.approx(point, abs=1e-5)
    assert place.misfit == pytest.approx(0.0, abs=1e-6)


@given(seeds)
def test_turning_and_moving_everything_turns_and_moves_the_point_and_its_covariance(seed: int) -> None:
    random = np.random.default_rng(seed)
    _, origins, directions = scene(seed, 6)
    directions = turned(directions, 0.005, random)
    rotation = np.linalg.qr(random.normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    shift = random.uniform(-5.0, 5.0, 3)
    noise, shares = np.full(6, 0.005), np.ones(6)
    place = triangulate(origins, directions, noise, shares)
    moved = triangulate(origins @ rotation.T + shift, directions @ rotation.T, noise, shares)
    if place is None or moved is None:
        assert place is moved is None
        return
    assert moved.position == pytest.approx(rotation @ place.position + shift, rel=1e-5, abs=1e-5)
    assert moved.covariance == pytest.approx(rotation @ place.covariance @ rotation.T, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize(("baseline", "distance"), [(0.5, 3.0), (1.0, 8.0), (2.0, 12.0)])
def test_the_error_is_as_large_as_the_covariance_says(baseline: float, distance: float) -> None:
    random = np.random.default_rng(3)
    origins = np.column_stack([np.linspace(0, baseline, 8), np.zeros(8), np.zeros(8)])
    point = np.array([0.4, -0.3, distance])
    directions = (point - origins) / np.linalg.norm(point - origins, axis=1, keepdims=True)
    errors = []
    for _ in range(400):
        place = triangulate(origins, turned(directions, 0.004, random), np.full(8, 0.004), np.ones(8))
        assert place is not None
        offset = place.position - point
        errors.append(float(offset @ np.linalg.solve(place.covariance, offset)))
    # Of three degrees of freedom: 3 in the mean, a little less since the covariance is never narrowed.
    assert 2.0 < float(np.mean(errors)) < 3.3


@given(seeds, st.floats(1.5, 4.0))
def test_a_longer_way_between_the_views_makes_it_surer(seed: int, factor: float) -> None:
    point, origins, _ = scene(seed, 5)
    uncertainties = []
    for scale in (1.0, factor):
        offsets = point - origins * scale * 0.2
        directions = offsets / np.linalg.norm(offsets, axis=1, keepdims=True)
        place = triangulate(origins * scale * 0.2, directions, np.full(5, 0.005), np.ones(5))
        assert place is not None
        uncertainties.append(place.uncertainty)
    assert uncertainties[1] < uncertainties[0]


def test_views_that_count_together_as_one_are_no_surer_than_one() -> None:
    _, origins, directions = scene(5, 4)
    one = triangulate(origins, directions, np.full(4, 0.005), np.ones(4))
    often = triangulate(
        np.repeat(origins, 10, axis=0), np.repeat(directions, 10, axis=0), np.full(40, 0.005), np.full(40, 0.1)
    )
    assert one is not None
    assert often is not None
    assert often.uncertainty == pytest.approx(one.uncertainty)


def test_what_is_known_of_the_distance_enters_with_its_certainty() -> None:
    origins = np.array([[0.0, 0.0, 0.0], [0.02, 0.0, 0.0]])
    point = np.array([0.0, 0.0, 5.0])
    directions = (point - origins) / np.linalg.norm(point - origins, axis=1, keepdims=True)
    noise, shares = np.full(2, 0.005), np.ones(2)
    alone = triangulate(origins, directions, noise, shares)
    information = np.diag([0.0, 0.0, 1.0 / 0.1**2])
    helped = triangulate(origins, directions, noise, shares, (information, information @ np.array([0.0, 0.0, 5.2])))
    assert alone is not None
    assert helped is not None
    assert alone.uncertainty > 1.0
    assert helped.uncertainty == pytest.approx(0.1, rel=0.05)
    assert helped.position[2] == pytest.approx(5.2, abs=0.02)


def test_directions_that_part_do_not_meet() -> None:
    origins = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    directions = np.array([[-0.2, 0.0, 1.0], [0.2, 0.0, 1.0]]) / np.sqrt(1.04)
    assert triangulate(origins, directions, np.full(2, 0.01), np.ones(2)) is None
    assert len(meetings(origins, directions, np.full(2, 0.01), np.array([0]), np.array([1]))) == 0
    same = np.repeat(directions[:1], 2, axis=0)
    assert triangulate(origins * 0.0, same, np.full(2, 0.01), np.ones(2)) is None


@given(seeds)
def test_two_true_directions_meet_in_the_point(seed: int) -> None:
    point, origins, directions = scene(seed, 2)
    met = meetings(origins, directions, np.full(2, 1e-6), np.array([0]), np.array([1]))
    assert len(met) == 0 or met[0] == pytest.approx(point, abs=1e-4)
    assert angles(point, origins, directions) == pytest.approx([0.0, 0.0], abs=1e-6)
    assert angles(-10.0 * point, origins, directions) == pytest.approx([np.pi / 2, np.pi / 2])


@given(seeds)
def test_the_middle_of_a_rectangle_is_where_its_diagonals_cross(seed: int) -> None:
    random = np.random.default_rng(seed)
    rotation = np.linalg.qr(random.normal(size=(3, 3)))[0]
    middle = np.array([*random.uniform(-0.5, 0.5, 2), random.uniform(2.0, 6.0)])
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * (0.4, 0.1, 0.0) @ rotation.T + middle
    rays = corners / np.linalg.norm(corners, axis=1, keepdims=True)
    if abs(rotation[:, 2] @ middle) < 0.2:
        return
    assert middles(rays[None])[0] == pytest.approx(middle / np.linalg.norm(middle), abs=1e-6)
