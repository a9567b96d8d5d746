"""A room from above: surfaces without gaps between readings, the highest on top, and nothing where nothing was seen."""

import numpy as np
import pytest

from lpslam.ground.raster import RoomImage, room_image

RED, BLUE = (200, 30, 20), (20, 40, 210)


def at(image: RoomImage, x: float, y: float) -> tuple[int, ...]:
    """The colour at a place."""
    left, right, bottom, top = image.extent
    rows, columns = image.rgba.shape[:2]
    row, column = int((top - y) / (top - bottom) * rows), int((x - left) / (right - left) * columns)
    return tuple(image.rgba[row, column].tolist())


def plane(x: tuple[float, float], y: tuple[float, float], z: float, apart: float) -> np.ndarray:
    across = np.stack(np.meshgrid(np.arange(*x, apart), np.arange(*y, apart)), axis=-1).reshape(-1, 2)
    return np.column_stack([across, np.full(len(across), z)])


def test_a_table_hides_the_floor_and_neither_has_holes() -> None:
    floor, table = plane((0, 4), (0, 2), 0.0, 0.07), plane((1, 2), (0.5, 1.5), 0.8, 0.05)
    cloud = np.concatenate([floor, table])
    colours = np.concatenate([np.tile(RED, (len(floor), 1)), np.tile(BLUE, (len(table), 1))]).astype(np.uint8)
    image = room_image(cloud, colours, None)
    assert image is not None
    for x, y, colour in ((3.0, 1.0, RED), (3.031, 1.337, RED), (1.5, 1.0, BLUE), (1.333, 0.777, BLUE)):
        *shown, alpha = at(image, x, y)
        assert alpha == 255
        assert np.abs(np.array(shown) - colour).max() < 20, (x, y, shown)
    assert image.extent == pytest.approx((-0.3, 4.3, -0.3, 2.3), abs=0.15)


def test_what_nobody_has_seen_and_lone_points_are_left_out() -> None:
    cloud = np.concatenate([plane((0, 1), (0, 1), 0.0, 0.04), plane((2, 3), (0, 1), 0.0, 0.04), [[1.5, 0.5, 0.0]]])
    image = room_image(cloud, np.full((len(cloud), 3), 90, np.uint8), None)
    assert image is not None
    assert at(image, 0.5, 0.5)[3] == at(image, 2.5, 0.5)[3] == 255
    assert at(image, 1.5, 0.5)[3] == at(image, 1.25, 0.5)[3] == 0
    assert room_image(np.empty((0, 3)), np.empty((0, 3), np.uint8), None) is None
