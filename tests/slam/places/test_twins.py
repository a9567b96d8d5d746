"""A row of fronts all alike: a view fits the map at more than one place."""

import numpy as np
import pytest
from slam_scenes import SENSOR, add_view, descriptors_of, flip_bits, rigid, view_of

from lpslam.camera import inverse_transform
from lpslam.config import LocatingConfig, TrackingConfig
from lpslam.slam.features import Features
from lpslam.slam.map import SlamMap
from lpslam.slam.places.located import Expected, Located
from lpslam.slam.places.locating import Locator
from lpslam.slam.places.parts import Parts

FRONT, FRONTS, POINTS = 2.5, 4, 160
"""Metres from one front to the next, how many there are, and points on each."""


class Row:
    """A row of fronts along x, 4 m before the camera, all alike or none; the first three are mapped."""

    def __init__(self, seed: int, *, is_alike: bool) -> None:
        self.random = np.random.default_rng(seed)
        corners = np.column_stack([self.random.uniform([0, -1.2], [FRONT, 1.2], (POINTS, 2)), np.full(POINTS, 4.0)])
        painted = descriptors_of(self.random, POINTS)
        self.points = np.stack([corners + np.array([front * FRONT, 0.0, 0.0]) for front in range(FRONTS)])
        self.descriptors = np.stack([painted if is_alike else descriptors_of(self.random, POINTS) for _ in self.points])
        self.map = SlamMap(3 * POINTS, SENSOR.scales)
        keyframe = add_view(self.map, np.eye(4), self.seen(0.0, [0, 1, 2]), -1)
        self.map.add_points(keyframe, np.arange(3 * POINTS, dtype=np.int32), self.points[:3].reshape(-1, 3))
        self.locator = Locator(self.map, SENSOR, TrackingConfig(), LocatingConfig())

    def seen(self, x: float, fronts: list[int]) -> Features:
        """What a camera at x sees of some fronts: some keypoints look more like what was painted than others."""
        flips = self.random.integers(0, 60, len(fronts) * POINTS)
        painted = self.descriptors[fronts].reshape(-1, 4)
        seen = [flip_bits(self.random, row[None], int(n)) for row, n in zip(painted, flips, strict=True)]
        return view_of(standing_at(x), self.points[fronts].reshape(-1, 3), np.concatenate(seen))


def standing_at(x: float) -> np.ndarray:
    """Camera from world of a camera that looks at the row."""
    return inverse_transform(rigid([x, 0.0, 0.0], [0, 0, 0]))


def located_at(x: float, features: Features) -> Located:
    nothing = np.full(features.rows, -1, np.int32)
    expected = Expected(nothing[:0], np.zeros((0, 2), np.float32), nothing[:0])
    parts = Parts.of(np.zeros((0, 2), np.float32), np.zeros(0, np.bool_), SENSOR.image_size)
    return Located(0, standing_at(x), nothing, 100, expected, parts, 1.0, 0.8)


@pytest.mark.parametrize("seed", range(5))
def test_before_fronts_all_alike_a_part_of_the_view_fits_the_map_elsewhere(seed: int) -> None:
    """The last front is not mapped: a view of it and the one before it is taken for the two before."""
    row = Row(seed, is_alike=True)
    features = row.seen(3.0 * FRONT, [2, 3])
    elsewhere = row.locator.fit_elsewhere(features, located_at(2.0 * FRONT, features))
    assert elsewhere is not None
    fronts_apart = (elsewhere.camera_from_world[0, 3] + 2.0 * FRONT) / FRONT
    assert fronts_apart == pytest.approx(round(fronts_apart), abs=0.02)
    assert round(fronts_apart) != 0


@pytest.mark.parametrize("seed", range(5))
def test_where_nothing_repeats_what_disagrees_fits_nowhere(seed: int) -> None:
    row = Row(seed, is_alike=False)
    features = row.seen(2.0 * FRONT, [1, 2])
    assert row.locator.fit_elsewhere(features, located_at(2.0 * FRONT, features)) is None


def test_what_is_nearer_than_a_rival_is_no_other_place() -> None:
    """What a rolling shutter bends disagrees with the whole, and agrees on a pose beside it."""
    row = Row(0, is_alike=True)
    features = row.seen(3.0 * FRONT, [2, 3])
    near = Locator(row.map, SENSOR, TrackingConfig(), LocatingConfig(rival_distance=FRONTS * FRONT))
    assert near.fit_elsewhere(features, located_at(2.0 * FRONT, features)) is None
