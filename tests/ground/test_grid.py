"""What is ground and what stands in the way, in rooms of boxes."""

import numpy as np
import pytest
from rooms import CAMERA, FLOOR, Box, depth_of, looking

from lpslam.config import GroundConfig
from lpslam.ground.floor import depth_noise
from lpslam.ground.grid import FREE, OCCUPIED, UNKNOWN, Grid, build_grid, build_grids
from lpslam.ground.scans import Scans

RGB = np.zeros((CAMERA.height, CAMERA.width, 3), np.uint8)
CONFIG = GroundConfig()
WALLS = [
    Box((4.0, -4.0, 0.0), (4.2, 4.0, 3.0)), Box((-4.2, -4.0, 0.0), (-4.0, 4.0, 3.0)),
    Box((-4.0, 4.0, 0.0), (4.0, 4.2, 3.0)), Box((-4.0, -4.2, 0.0), (4.0, -4.0, 3.0)),
]  # fmt: skip
POSES = [looking((0.6 * np.cos(yaw), 0.6 * np.sin(yaw)), float(yaw)) for yaw in np.arange(0.0, 6.2, 0.4)]


def seen(things: list[Box], poses: list[np.ndarray] = POSES, noise: float = 0.001) -> Grid | None:
    scans = Scans(CAMERA, CONFIG.width)
    for at, pose in enumerate(poses):
        scans.take(at, RGB, depth_of([FLOOR, *things], pose, noise, at))
    return build_grid(scans, lambda keyframe: poses[keyframe], CONFIG)


def grid_of(things: list[Box], poses: list[np.ndarray] = POSES, noise: float = 0.001) -> Grid:
    grid = seen(things, poses, noise)
    assert grid is not None
    return grid


def values(grid: Grid, low: tuple[float, float], high: tuple[float, float]) -> np.ndarray:
    """Of all cells whose middles lie in a rectangle."""
    (top, left), (bottom, right) = grid.cell(np.array(low)), grid.cell(np.array(high))
    return grid.values[top : bottom + 1, left : right + 1]


@pytest.mark.parametrize("noise", [0.0, 0.0015, 0.004])
def test_a_room_has_free_ground_and_walls(noise: float) -> None:
    grid = grid_of(WALLS, noise=noise)
    # Below the camera nothing is in view.
    for low, high in (((-3.8, -3.8), (-1.6, 3.8)), ((1.6, -3.8), (3.8, 3.8))):
        assert (values(grid, low, high) == FREE).mean() > 0.98
    assert not (values(grid, (-3.8, -3.8), (3.8, 3.8)) == OCCUPIED).any()
    for wall in WALLS:
        along = np.linspace(-3.5, 3.5, 40)
        places = [(wall.low[0], y) if wall.low[0] in (4.0,) else (wall.high[0], y) for y in along]
        if wall.high[0] - wall.low[0] > 1.0:
            places = [(x, wall.low[1] if wall.low[1] > 0 else wall.high[1]) for x in along]
        found = [values(grid, (x - 0.1, y - 0.1), (x + 0.1, y + 0.1)) for x, y in places]
        assert np.mean([(each == OCCUPIED).any() for each in found]) > 0.9
    outside = values(grid, (4.35, -2.0), (4.6, 2.0))
    assert not (outside == FREE).any()


@pytest.mark.parametrize(("height", "is_in_the_way"), [(0.02, False), (0.15, True), (0.8, True)])
def test_what_is_higher_than_a_threshold_is_in_the_way(height: float, is_in_the_way: bool) -> None:
    grid = grid_of([*WALLS, Box((2.4, -0.3, 0.0), (3.0, 0.3, height))])
    there = values(grid, (2.45, -0.2), (2.95, 0.2))
    if is_in_the_way:
        assert (there == OCCUPIED).any()
        assert not (values(grid, (2.4, -0.2), (2.5, 0.2)) == FREE).any()
    else:
        assert (there == FREE).mean() > 0.95


def test_below_a_lamp_is_ground_and_below_a_table_is_none() -> None:
    lamp = Box((1.5, -0.5, 2.0), (2.5, 0.5, 2.3))
    table = Box((-2.5, -0.5, 0.70), (-1.5, 0.5, 0.75))
    grid = grid_of([*WALLS, lamp, table])
    assert (values(grid, (1.6, -0.4), (2.4, 0.4)) == FREE).mean() > 0.95
    assert (values(grid, (-2.4, -0.4), (-1.6, 0.4)) == OCCUPIED).mean() > 0.5


def test_a_ramp_is_ground_and_steps_down_are_not() -> None:
    ramp = [Box((1.5 + 0.1 * step, -1.0, -0.5), (1.62 + 0.1 * step, 1.0, 0.009 * step)) for step in range(20)]
    grid = grid_of([*WALLS, *ramp])
    assert (values(grid, (1.7, -0.8), (3.2, 0.8)) == FREE).mean() > 0.9


def test_who_walked_away_is_forgotten_and_who_stands_is_not() -> None:
    someone = Box((1.8, -0.25, 0.0), (2.2, 0.25, 1.8))
    scans, poses = Scans(CAMERA, CONFIG.width), [looking((0.0, 0.1 * at), 0.0) for at in range(14)]
    for at, pose in enumerate(poses):
        things = [FLOOR, *WALLS, someone] if at < 3 else [FLOOR, *WALLS]
        scans.take(at, RGB, depth_of(things, pose, 0.001, at))
    there = build_grid(scans, lambda keyframe: poses[keyframe], CONFIG)
    before = build_grid(scans, lambda keyframe: poses[keyframe] if keyframe < 3 else None, CONFIG)
    assert there is not None
    assert before is not None
    assert (values(before, (1.8, -0.2), (1.9, 0.2)) == OCCUPIED).any()
    assert (values(there, (1.7, -0.3), (2.3, 0.3)) == FREE).all()


def test_it_moves_with_its_keyframes() -> None:
    moved = np.eye(4)
    moved[:2, 3] = 10.0, -5.0
    scans = Scans(CAMERA, CONFIG.width)
    for at, pose in enumerate(POSES):
        scans.take(at, RGB, depth_of([FLOOR, *WALLS], pose, 0.001, at))
    here = build_grid(scans, lambda keyframe: POSES[keyframe], CONFIG)
    there = build_grid(scans, lambda keyframe: moved @ POSES[keyframe], CONFIG)
    assert here is not None
    assert there is not None
    assert np.subtract(there.origin, here.origin) == pytest.approx([10.0, -5.0], abs=1e-6)
    assert (here.values == there.values).mean() > 0.99


def test_without_a_floor_or_a_place_there_is_no_ground() -> None:
    up = [looking((0.0, 0.0), yaw, down=-0.6) for yaw in np.arange(0.0, 6.2, 0.4)]
    assert seen(WALLS, up) is None
    scans = Scans(CAMERA, CONFIG.width)
    assert build_grid(scans, lambda keyframe: np.eye(4), CONFIG) is None
    scans.take(0, RGB, depth_of([FLOOR], POSES[0]))
    assert build_grid(scans, lambda keyframe: None, CONFIG) is None
    far = POSES[0].copy()
    far[0, 3] = np.nan
    assert build_grid(scans, lambda keyframe: far, CONFIG) is None


def test_a_map_that_is_torn_apart_has_no_grid_of_gigabytes() -> None:
    scans, poses = Scans(CAMERA, CONFIG.width), [POSES[0], POSES[1].copy()]
    poses[1][0, 3] = 1e6
    for at in range(2):
        scans.take(at, RGB, depth_of([FLOOR], POSES[at]))
    assert build_grid(scans, lambda keyframe: poses[keyframe], CONFIG) is None


def test_cells_and_places_agree() -> None:
    grid = Grid(np.zeros((4, 6), np.int8), (-1.0, 2.0), 0.5)
    assert grid.cell(np.array([-1.0, 2.0])) == (0, 0)
    assert grid.cell(np.array([1.9, 3.9, 7.0])) == (3, 5)
    assert grid.middles(np.array([[3, 5]])).tolist() == [[1.75, 3.75]]
    assert grid.at(np.array([9.0, 9.0])) == UNKNOWN


def test_a_counter_that_is_seen_more_often_than_the_floor_is_not_the_floor() -> None:
    counter = Box((0.7, -3.0, 0.9), (1.5, 3.0, 0.95))
    before = [looking((0.0, 0.2 * at), 0.0, 1.4, 0.6) for at in range(-9, 10)]
    aside = [looking((0.0, 0.3 * at), np.pi, 1.4, 0.5) for at in range(-1, 2)]
    grid = grid_of([*WALLS, counter], before + aside)
    assert (values(grid, (0.75, -1.5), (1.4, 1.5)) == OCCUPIED).mean() > 0.7
    assert (values(grid, (-3.0, -0.8), (-1.5, 0.8)) == FREE).mean() > 0.9


def test_ground_beside_a_wall_that_was_only_looked_over_is_not_free() -> None:
    # The bench stands below the view: nobody has seen it, nor the ground there.
    bench = Box((3.5, -0.7, 0.0), (3.95, 0.7, 0.4))
    level = [looking((-0.2, 0.1 * at), 0.0, 1.4, 0.02) for at in range(-6, 7)]
    nearer = [looking((-3.0, 0.2 * at), 0.0, 1.4, 0.35) for at in range(-3, 4)]
    grid = grid_of([*WALLS, bench], nearer + level)
    assert (values(grid, (-1.0, -0.5), (0.0, 0.5)) == FREE).mean() > 0.9
    assert (values(grid, (2.5, -0.5), (2.9, 0.5)) == FREE).mean() > 0.9
    assert not (values(grid, (3.55, -0.6), (3.9, 0.6)) == FREE).any()


def test_a_thin_seat_far_away_is_in_the_way_and_ground_seen_below_it_is_none() -> None:
    seat = Box((2.4, -0.9, 0.37), (2.8, 0.9, 0.42))
    before = [looking((-3.4, 0.11 * at), 0.0, 1.4, 0.25) for at in range(-9, 10)]
    grid = grid_of([*WALLS, seat], before)
    there = values(grid, (2.4, -0.8), (2.75, 0.8))
    assert (there == OCCUPIED).mean() > 0.3
    assert (there == FREE).mean() < 0.15


def patchy(boxes: list[Box], pose: np.ndarray, noise: float, seed: int) -> np.ndarray:
    """Depth of stereo: inverse depths stray alike over some pixels."""
    depth = depth_of(boxes, pose)
    drawn = np.random.default_rng(seed).normal(size=(depth.shape[0] // 4, depth.shape[1] // 4))
    stray = noise * np.kron(drawn, np.ones((4, 4)))
    with np.errstate(divide="ignore"):
        return np.where(depth > 0, 1.0 / np.maximum(1.0 / depth + stray, 0.05), 0.0).astype(np.float32)


def test_depth_as_noisy_as_of_stereo_shows_ground_and_walls() -> None:
    scans = Scans(CAMERA, CONFIG.width)
    for at, pose in enumerate(POSES):
        scans.take(at, RGB, patchy([FLOOR, *WALLS], pose, 0.012, at))
    grid = build_grid(scans, lambda keyframe: POSES[keyframe], CONFIG)
    assert grid is not None
    for low, high in (((-3.2, -2.0), (-1.8, 2.0)), ((1.8, -2.0), (3.2, 2.0))):
        there = values(grid, low, high)
        assert (there != UNKNOWN).mean() > 0.9
        assert (there == FREE).sum() > 0.97 * (there != UNKNOWN).sum()
    assert not (values(grid, (4.4, -2.0), (4.6, 2.0)) == FREE).any()
    assert (values(grid, (3.9, -3.0), (4.2, 3.0)) == OCCUPIED).any(axis=1).mean() > 0.95


def test_noise_of_depth_is_told_from_planes() -> None:
    depths = [patchy([FLOOR, *WALLS], pose, 0.012, at)[::4, ::4] for at, pose in enumerate(POSES[:6])]
    assert depth_noise(depths, CONFIG) == pytest.approx(0.012, rel=0.15)
    assert depth_noise([np.zeros((20, 20), np.float32)], CONFIG) == 0.0


@pytest.mark.parametrize("degrees", [2.5, 5.0])
def test_a_map_that_is_not_level_has_the_same_ground(degrees: float) -> None:
    tilted = np.eye(4)
    turn = np.radians(degrees)
    tilted[[0, 0, 2, 2], [0, 2, 0, 2]] = np.cos(turn), -np.sin(turn), np.sin(turn), np.cos(turn)
    scans = Scans(CAMERA, CONFIG.width)
    for at, pose in enumerate(POSES):
        scans.take(at, RGB, depth_of([FLOOR, *WALLS], pose, 0.001, at))
    grid = build_grid(scans, lambda keyframe: tilted @ POSES[keyframe], CONFIG)
    assert grid is not None
    for low, high in (((-3.8, -3.6), (-1.6, 3.6)), ((1.6, -3.6), (3.8, 3.6))):
        assert (values(grid, low, high) == FREE).mean() > 0.98
    rise = grid.heights[grid.cell(np.array([3.0, 0.0]))] - grid.heights[grid.cell(np.array([-3.0, 0.0]))]
    assert rise == pytest.approx(6.0 * np.tan(turn), abs=0.03)


UPPER = Box((-20.0, -20.0, 2.9), (20.0, 20.0, 3.0))


def two_storeys() -> tuple[Scans, list[np.ndarray]]:
    """Walls at 4 m below, at 3 m above; the upper floor was mapped last."""
    above = [Box((x0 * 0.75, y0 * 0.75, 3.0), (x1 * 0.75, y1 * 0.75, 6.0)) for (x0, y0, _), (x1, y1, _) in (
        (wall.low, wall.high) for wall in WALLS)]  # fmt: skip
    poses, scans = [*POSES], Scans(CAMERA, CONFIG.width)
    for pose in POSES:
        poses.append(pose.copy())
        poses[-1][2, 3] += 3.0
    for at, pose in enumerate(poses):
        scans.take(at, RGB, depth_of([FLOOR, UPPER, *WALLS, *above], pose, 0.001, at))
    return scans, poses


@pytest.mark.parametrize(("height", "wall", "storey"), [(None, 3.0, 1), (4.0, 3.0, 1), (1.3, 4.0, 0)])
def test_of_storeys_above_one_another_one_is_kept(height: float | None, wall: float, storey: int) -> None:
    scans, poses = two_storeys()
    grid = build_grid(scans, lambda keyframe: poses[keyframe], CONFIG, None, height)
    assert grid is not None
    assert grid.storey == storey
    assert grid.storeys == pytest.approx([0.0, 3.0], abs=0.03)
    assert (values(grid, (wall - 0.05, -1.5), (wall + 0.1, 1.5)) == OCCUPIED).any(axis=1).mean() > 0.9
    other = 7.0 - wall
    assert not (values(grid, (other - 0.05, -1.5), (other + 0.1, 1.5)) == OCCUPIED).any()
    assert np.nanmedian(grid.heights) == pytest.approx(3.0 * storey, abs=0.03)
    assert [grid.storeys_to(each) for each in (1.5, 4.5)] == [-storey, 1 - storey]


def test_every_storey_has_the_grid_that_it_has_alone() -> None:
    scans, poses = two_storeys()
    both = build_grids(scans, lambda keyframe: poses[keyframe], CONFIG)
    assert [grid.storey for grid in both] == [0, 1]
    for grid, height in zip(both, (1.3, 4.3), strict=True):
        alone = build_grid(scans, lambda keyframe: poses[keyframe], CONFIG, None, height)
        assert alone is not None
        assert (grid.values == alone.values).all()
        assert (grid.origin, grid.storeys) == (alone.origin, alone.storeys)
    assert build_grids(Scans(CAMERA, CONFIG.width), lambda keyframe: None, CONFIG) == []


def test_a_way_that_climbs_without_passing_below_itself_is_one_storey() -> None:
    steps = [Box((0.2 * step, -2.0, -1.0), (0.2 * step + 0.22, 2.0, 0.02 * step)) for step in range(150)]
    poses = [looking((at, 0.0), 0.0, 1.3 + 0.1 * at) for at in np.arange(0.5, 26.0, 1.0)]
    scans = Scans(CAMERA, CONFIG.width)
    for at, pose in enumerate(poses):
        near = steps[max(0, int(5 * pose[0, 3]) - 3) : int(5 * pose[0, 3]) + 40]
        scans.take(at, RGB, depth_of(near, pose, 0.001, at))
    grid = build_grid(scans, lambda keyframe: poses[keyframe], CONFIG)
    assert grid is not None
    assert grid.storeys == ()
    assert (values(grid, (2.5, -0.8), (26.0, 0.8)) == FREE).mean() > 0.9
