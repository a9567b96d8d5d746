import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage

from lpslam.config import InstanceConfig
from lpslam.text.placing.columns import WorldSightings
from lpslam.text.placing.instances import split_places, trimmed_position
from lpslam.text.types import Placement, TextObservation

CONFIG = InstanceConfig()
NORTH, SOUTH = np.array([0.0, 1.0, 0.0]), np.array([0.0, -1.0, 0.0])


def cloud(centre: tuple[float, float, float], count: int, seed: int = 0) -> NDArray[np.float64]:
    return np.array(centre) + np.random.default_rng(seed).normal(scale=0.05, size=(count, 3))


@given(st.integers(1, 60), st.integers(0, 6))
def test_each_round_drops_a_fifth_and_never_all(count: int, rounds: int) -> None:
    _, kept = trimmed_position(cloud((0, 0, 0), count), rounds, 0.2)
    expected = count
    for _ in range(rounds):
        expected -= int(expected * 0.2)
    assert len(kept) == expected >= 1
    assert len(set(kept.tolist())) == len(kept)


def test_one_round_is_the_mean_without_the_farthest_fifth() -> None:
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [50, 0, 0]])
    position, kept = trimmed_position(positions, 1, 0.2)
    assert kept.tolist() == [0, 1, 2, 3]
    assert position == pytest.approx([1.5, 0, 0])


def test_outliers_are_trimmed_away() -> None:
    positions = np.vstack([cloud((1, 2, 3), 17), cloud((4, 2, 3), 3, seed=1)])
    assert np.linalg.norm(trimmed_position(positions, 3, 0.2)[0] - [1, 2, 3]) < 0.04
    assert np.linalg.norm(positions.mean(axis=0) - [1, 2, 3]) > 0.4


@given(st.integers(2, 12), st.floats(0.05, 2.0), st.integers(0, 1000))
def test_places_are_those_of_average_linkage(count: int, extent: float, seed: int) -> None:
    positions = np.random.default_rng(seed).uniform(0.0, extent * CONFIG.place_distance, (count, 3))
    labels = fcluster(linkage(positions, "average"), CONFIG.place_distance, "distance")
    places = split_places(positions, np.tile(NORTH, (count, 1)), np.arange(count), CONFIG)
    assert {tuple(rows) for rows in places} == {tuple(np.flatnonzero(labels == each)) for each in set(labels)}


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_observations_all_stay(count: int) -> None:
    positions = cloud((1, 2, 3), count)
    position, kept = trimmed_position(positions, 5, 0.2)
    assert len(kept) == count
    assert position == pytest.approx(positions.mean(axis=0))


def test_a_class_at_three_places_is_split() -> None:
    positions = np.vstack([cloud((0, 0, 1), 6), cloud((9, 0, 1), 1), cloud((0, 5, 1), 4)])
    order = np.random.default_rng(3).permutation(11)
    frames = np.arange(11)
    places = split_places(positions[order], np.tile(NORTH, (11, 1)), frames, CONFIG)
    groups = [set(order[rows].tolist()) for rows in places]
    assert sorted(groups, key=min) == [set(range(6)), {6}, set(range(7, 11))]
    assert [rows[0] for rows in places] == sorted(rows[0] for rows in places)


def test_two_sides_of_a_hanging_sign_are_one_place() -> None:
    positions = np.vstack([cloud((0, 0.1, 2), 5), cloud((0, -0.1, 2), 5)])
    normals = np.vstack([np.tile(NORTH, (5, 1)), np.tile(SOUTH, (5, 1))])
    assert len(split_places(positions, normals, np.arange(10), CONFIG)) == 1


def test_two_faces_of_a_pillar_are_two_places() -> None:
    positions = np.vstack([cloud((0, 0.3, 2), 5), cloud((0, -0.3, 2), 5)])
    normals = np.vstack([np.tile(NORTH, (5, 1)), np.tile(SOUTH, (5, 1))])
    places = split_places(positions, normals, np.arange(10), CONFIG)
    assert [rows.tolist() for rows in places] == [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]


def test_slightly_different_normals_are_one_place() -> None:
    turned = np.array([0.4, 0.9, 0.0]) / np.hypot(0.4, 0.9)
    normals = np.vstack([np.tile(NORTH, (5, 1)), np.tile(turned, (5, 1))])
    assert len(split_places(cloud((0, 0, 2), 10), normals, np.arange(10), CONFIG)) == 1


def test_what_one_frame_shows_twice_stands_twice() -> None:
    positions = np.vstack([cloud((0, 0, 2), 5), cloud((0.6, 0, 2), 5, seed=1)])
    normals = np.tile(NORTH, (10, 1))
    assert len(split_places(positions, normals, np.arange(10), CONFIG)) == 1
    together = np.tile(np.arange(5), 2)
    places = split_places(positions, normals, together, CONFIG)
    assert [rows.tolist() for rows in places] == [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]


def test_how_a_text_faces_tells_no_two_apart_within_a_frame() -> None:
    positions = np.repeat([[0.0, 0.0, 2.0], [0.0, 0.0, 2.1]], 5, axis=0)
    turns = np.tile(np.linspace(-0.9, 0.9, 5), 2)
    normals = np.column_stack([np.sin(turns), np.cos(turns), np.zeros(10)])
    frames = np.tile(np.arange(5), 2)
    places = split_places(positions, normals, frames, CONFIG)
    assert [rows.tolist() for rows in places] == [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]


def test_observations_move_with_their_keyframes() -> None:
    placement = Placement((0.0, 0.0, 2.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 0.5, 0.1, 0.01)
    observations = [TextObservation(frame, 0.0, frame % 2, "EXIT", 0.9, placement, 24.0) for frame in range(4)]
    poses = {0: np.eye(4), 1: np.eye(4)}
    poses[1][:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    poses[1][:3, 3] = [5, 0, 0]
    placed = WorldSightings.of(observations, poses.__getitem__)
    assert placed.positions[0] == pytest.approx([0, 0, 2])
    assert placed.positions[3] == pytest.approx([7, 0, 0])
    assert placed.normals[1] == pytest.approx([-1, 0, 0])
    assert placed.baselines[1] == pytest.approx([0, 0, -1])


@given(st.lists(st.integers(0, 5), max_size=12), st.booleans())
def test_some_rows_of_all_columns_are_those_of_the_same_sightings(rows: list[int], as_mask: bool) -> None:
    observations = [
        TextObservation(
            row, 0.1 * row, row % 2, "AB"[row % 2], 0.9, Placement((row, 0, 2), (0, 0, -1), (1, 0, 0), row, 1, row), row
        )
        for row in range(6)
    ]
    placed = WorldSightings.of(observations, lambda keyframe: np.eye(4))
    chosen = np.isin(np.arange(6), rows) if as_mask else np.array(rows, np.intp)
    numbers = np.arange(6)[chosen].tolist()
    some = placed[chosen]
    assert len(some) == len(numbers)
    assert some.positions[:, 0].tolist() == some.sizes[:, 0].tolist() == some.frames.tolist() == numbers
    assert [each.letter_height for each in some.observations] == numbers
    assert sum(some.variants.values()) == len(numbers)
    assert some.normals.shape == some.baselines.shape == (len(numbers), 3)
