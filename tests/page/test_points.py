"""The points of a page: one a cube, where they were seen, and every beginning of them shows the whole room."""

import numpy as np
import pytest

from lpslam.config import PageConfig
from lpslam.page.points import PackedPoints, filled_cloud, packed_points
from lpslam.page.record import room_points
from small_maps import WORLD_FROM_CAMERA, small_map, with_floor

CONFIG = PageConfig()


def placed(packed: PackedPoints) -> np.ndarray:
    """(n, 3) metres."""
    return packed.low + packed.rows[:, :3] / 65535 * packed.size


def wall(count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Points on a wall of 4 m by 2 m, red at its left and blue at its right."""
    points = np.random.default_rng(seed).uniform([0, 0, 0], [4, 0, 2], (count, 3))
    colours = np.where(points[:, :1] < 2, [[250, 10, 10]], [[10, 10, 250]]).astype(np.uint8)
    return points, colours


def test_points_and_colours_are_where_they_were_seen() -> None:
    points, colours = wall(3000)
    packed = packed_points(points, colours, 10**6, CONFIG)
    assert len(packed) < 3000
    apart = np.abs(placed(packed)[:, None] - points[None]).max(axis=2)
    assert apart.min(axis=1).max() < CONFIG.cube
    red, blue = packed.rows[:, 3] >> 11, packed.rows[:, 3] & 31
    assert (red > blue)[placed(packed)[:, 0] < 1.95].all()
    assert (red < blue)[placed(packed)[:, 0] > 2.05].all()
    np.testing.assert_allclose(red[placed(packed)[:, 0] < 1.95] / 31, 250 / 255, atol=1 / 31)


def test_every_beginning_is_spread_over_the_whole_room() -> None:
    points, colours = wall(40000)
    # One half was looked at ten times as long.
    points[:36000, 0] *= 0.5
    packed = packed_points(points, colours, 10**6, CONFIG)
    for share in (0.02, 0.05, 0.08):
        first = placed(packed)[: int(len(packed) * share)]
        counts, _, _ = np.histogram2d(first[:, 0], first[:, 2], bins=(4, 2), range=((0, 4), (0, 2)))
        assert counts.min() > 0.6 * counts.mean(), (share, counts)


def test_what_there_is_no_room_for_is_left_out_evenly() -> None:
    packed = packed_points(*wall(20000), 500, CONFIG)
    assert len(packed) == 500
    counts, _ = np.histogram(placed(packed)[:, 0], bins=4, range=(0, 4))
    assert counts.min() > 90
    # 500 on 8 square metres lie 13 cm apart.
    assert packed.spacing == pytest.approx(0.126, rel=0.25)


def test_a_stray_point_costs_the_others_no_precision() -> None:
    points, colours = wall(5000)
    points[0] = 1e5
    packed = packed_points(points, colours, 10**6, CONFIG)
    assert packed.size.max() < 7


def test_the_bytes_are_what_the_page_reads() -> None:
    packed = packed_points(*wall(500), 100, CONFIG)
    content = packed.content()
    head = np.frombuffer(content[:32], "<f4")
    np.testing.assert_allclose(head, [100, *packed.low, *packed.size, packed.spacing], rtol=1e-6)
    np.testing.assert_array_equal(np.frombuffer(content[32:], "<u2").reshape(-1, 4), packed.rows)
    assert len(packed_points(np.empty((0, 3)), np.empty((0, 3), np.uint8), 9, CONFIG).content()) == 32


def test_between_readings_of_one_surface_there_are_points_and_over_edges_none() -> None:
    world = with_floor(small_map())
    assert world.scans is not None
    depth = np.full((240, 320), 2.0, np.float32)
    depth[:, 160:] = 4.0
    world.scans.take(0, np.full((240, 320, 3), 90, np.uint8), depth)
    points, colours = filled_cloud(world.scans, lambda keyframe: WORLD_FROM_CAMERA)
    few, _ = world.coloured_cloud()
    assert len(points) > 3.5 * len(few)
    assert set(np.round(points[:, 0], 3)) == {2.0, 4.0}
    assert (colours == 90).all()
    assert len(filled_cloud(world.scans, lambda keyframe: None)[0]) == 0


def test_a_map_without_scans_shows_its_own_points() -> None:
    world = small_map()
    assert len(room_points(world, 100, CONFIG)) == len(world.cloud())
