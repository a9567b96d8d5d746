"""Ways over grids: short, with room to the sides, and said plainly where there is none."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from lpslam.config import WayConfig
from lpslam.ground.grid import FREE, OCCUPIED, UNKNOWN, Grid
from lpslam.navigation.walking.blocks import Blocks
from lpslam.navigation.walking.goals import goal_before
from lpslam.navigation.walking.ways import NoWayError, Walkable, WayDistances

CONFIG = WayConfig()


def hall(door: float = 1.2, side: int = 160) -> Grid:
    """Eight metres square, with a wall across the middle whose door is at the far side."""
    values = np.full((side, side), FREE, np.int8)
    values[:1], values[-1:], values[:, :1], values[:, -1:] = (OCCUPIED,) * 4
    values[: side - 1 - round(door / 0.05), side // 2 : side // 2 + 2] = OCCUPIED
    return Grid(values, (0.0, 0.0), 0.05)


def clearances(walkable: Walkable, points: np.ndarray) -> np.ndarray:
    dense = np.concatenate([np.linspace(a, b, 50) for a, b in pairwise(points)])
    return np.array([walkable.clearance[walkable.grid.cell(point)] for point in dense])


def test_a_way_leads_through_the_door_with_room_on_both_sides() -> None:
    walkable = Walkable(hall(), CONFIG)
    start, end = np.array([1.0, 1.0]), np.array([7.0, 1.0])
    way = walkable.way(start, end)
    assert np.linalg.norm(way.points[0] - start) < 0.06
    assert np.linalg.norm(way.points[-1] - end) < 0.06
    assert clearances(walkable, way.points).min() > CONFIG.robot_radius - 0.05
    # Around the end of the wall, a robot's radius off it.
    corner = 8.0 - 1.2 - 0.05 + CONFIG.robot_radius
    shortest = 2.0 * np.hypot(3.0, corner - 1.0)
    assert shortest - 0.1 < way.length < 1.1 * shortest
    assert way.seconds == pytest.approx(way.length / CONFIG.speed)


@pytest.mark.parametrize("seed", range(12))
def test_ways_among_scattered_things_keep_clear_and_are_near_the_shortest(seed: int) -> None:
    random = np.random.default_rng(seed)
    values = np.full((120, 140), FREE, np.int8)
    for row, column in random.integers(10, 110, (14, 2)):
        values[row : row + random.integers(2, 14), column : column + random.integers(2, 14)] = OCCUPIED
    walkable = Walkable(Grid(values, (-3.0, 2.0), 0.05), CONFIG)
    cells = np.argwhere(walkable.regions == np.bincount(walkable.regions.ravel())[1:].argmax() + 1)
    first, last = cells[random.integers(len(cells), size=2)]
    start, end = walkable.grid.middles(np.array([first, last]))
    way = walkable.way(start, end)
    assert way.length >= np.linalg.norm(end - start) - 1e-9
    if len(way.points) > 1:
        assert clearances(walkable, way.points).min() > CONFIG.robot_radius - 0.05
    bold = Walkable(walkable.grid, WayConfig(comfort_cost=0.0)).way(start, end)
    assert bold.length <= way.length + 0.1


def test_a_large_grid_gives_the_same_way_in_two_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    grid, (start, end) = hall(side=600), (np.array([1.0, 1.0]), np.array([28.0, 2.0]))
    fine = Walkable(grid, CONFIG).way(start, end)
    monkeypatch.setattr("lpslam.navigation.walking.ways._MOST_SQUARES", 64)
    coarse = Walkable(grid, CONFIG).way(start, end)
    assert coarse.length == pytest.approx(fine.length, rel=0.03)


@pytest.mark.parametrize("seed", range(6))
def test_walls_thinner_than_a_square_are_gone_round_in_two_rounds(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rooms of 4 m with walls of 10 cm, two doors each; squares of 8 cells."""
    random, side, room = np.random.default_rng(seed), 480, 80
    values = np.full((side, side), FREE, np.int8)
    for wall in range(0, side, room):
        values[wall : wall + 2, :] = values[:, wall : wall + 2] = OCCUPIED
    for wall in range(room, side, room):
        for beside in range(0, side, room):
            door = beside + random.integers(12, 40)
            values[wall : wall + 2, door : door + 24] = FREE
            door = beside + random.integers(12, 40)
            values[door : door + 24, wall : wall + 2] = FREE
    values[-2:] = values[:, -2:] = OCCUPIED
    grid, ends = Grid(values, (0.0, 0.0), 0.05), (np.array([1.5, 1.5]), np.array([22.5, 22.5]))
    whole = Walkable(grid, CONFIG).way(*ends)
    monkeypatch.setattr("lpslam.navigation.walking.ways._MOST_SQUARES", 60)
    walkable = Walkable(grid, CONFIG)
    assert walkable._blocks is not None
    near = walkable._blocks.near(walkable.start(ends[0]), walkable.start(ends[1]))
    assert near is not None
    assert near.mean() < 0.3
    way = walkable.way(*ends)
    assert way.length < 1.05 * whole.length
    assert clearances(walkable, way.points).min() > CONFIG.robot_radius - 0.05


def test_squares_know_what_hangs_together() -> None:
    cost = np.ones((16, 24), np.float32)
    cost[:, 3] = np.inf
    blocks = Blocks.of(cost, 8)
    assert blocks.parts[0, 0] != blocks.parts[0, 5]
    assert blocks.near((0, 0), (0, 5)) is None
    cost[15, 3] = 1.0
    blocks = Blocks.of(cost, 8)
    assert blocks.near((0, 0), (0, 20)) is not None


def test_a_door_that_is_too_narrow_says_for_whom_it_is_not() -> None:
    with pytest.raises(NoWayError, match=r"radius does not get through.*one of 0\.2"):
        Walkable(hall(door=0.4), CONFIG).way(np.array([1.0, 1.0]), np.array([7.0, 1.0]))


def test_islands_and_starts_where_nobody_can_stand_are_said() -> None:
    values = hall().values.copy()
    values[:, 80:82] = UNKNOWN
    values[:, 82:90] = UNKNOWN
    walkable = Walkable(Grid(values, (0.0, 0.0), 0.05), CONFIG)
    with pytest.raises(NoWayError, match="islands"):
        walkable.way(np.array([1.0, 1.0]), np.array([7.0, 1.0]))
    with pytest.raises(NoWayError, match=r"no way begins at \(30\.00, 30\.00\).*nearest place with room is"):
        walkable.way(np.array([30.0, 30.0]), np.array([1.0, 1.0]))
    blocked = hall().values.copy()
    blocked[20:60, 20:60] = OCCUPIED
    with pytest.raises(NoWayError, match="something is in the way there"):
        Walkable(Grid(blocked, (0.0, 0.0), 0.05), CONFIG).way(np.array([2.0, 2.0]), np.array([1.0, 7.0]))
    with pytest.raises(NoWayError, match="no room to stand"):
        Walkable(hall(), CONFIG).way(np.array([1.0, 1.0]), np.array([4.0, 1.0]))
    with pytest.raises(NoWayError, match="robot_radius"):
        Walkable(hall(), WayConfig(robot_radius=9.0)).way(np.array([1.0, 1.0]), np.array([7.0, 1.0]))


def test_distances_follow_the_ground_and_are_straight_where_there_is_none() -> None:
    distances = WayDistances(Walkable(hall(), CONFIG))
    start, wall = np.array([1.0, 1.0, 1.2]), np.array([4.15, 1.0, 2.0])
    assert distances.distance(start, np.array([7.0, 1.0, 0.0])) > 12.0
    assert distances.distance(start, wall) < 20.0
    assert distances.distance(start, np.array([1.0, -40.0, 1.2])) == pytest.approx(41.0)


# Goal poses ----------------------------------------------------------------------------------------------------------


def test_a_goal_stands_before_its_sign_and_faces_it() -> None:
    walkable = Walkable(hall(), CONFIG)
    goal = goal_before(np.array([0.05, 3.0, 2.2]), np.array([1.0, 0.0, 0.0]), walkable)
    assert goal.is_before
    assert goal.position == pytest.approx([1.05, 3.0], abs=0.15)
    assert abs(abs(goal.yaw) - np.pi) < 0.2
    other = goal_before(np.array([4.1, 3.0, 2.2]), np.array([1.0, 0.0, 0.0]), walkable, np.array([1.0, 1.0]))
    assert other.is_before
    assert other.position[0] > 4.1


def test_a_sign_that_cannot_be_walked_up_to_gets_the_nearest_ground() -> None:
    values = hall().values.copy()
    values[:, 60:80] = OCCUPIED
    values[:, 80:] = UNKNOWN
    walkable = Walkable(Grid(values, (0.0, 0.0), 0.05), CONFIG)
    goal = goal_before(np.array([6.0, 3.0, 2.2]), np.array([-1.0, 0.0, 0.0]), walkable)
    assert not goal.is_before
    assert goal.position[0] < 3.0
    assert goal.missing == pytest.approx(6.0 - goal.position[0], abs=0.1)
    assert abs(goal.yaw) < 0.2


def test_a_goal_is_on_the_readers_side_and_nothing_stands_between() -> None:
    values = hall().values.copy()
    values[40:80, 24:28] = OCCUPIED  # a shelf before the sign on the wall at x = 0
    walkable = Walkable(Grid(values, (0.0, 0.0), 0.05), CONFIG)
    goal = goal_before(np.array([0.05, 3.0, 2.2]), np.array([1.0, 0.0, 0.0]), walkable)
    assert goal.is_before
    assert goal.position[0] < 1.2
    hung = goal_before(np.array([2.0, 6.0, 2.2]), np.array([0.0, 0.0, -1.0]), walkable)
    assert hung.is_before


def test_no_ground_is_said() -> None:
    empty = Walkable(Grid(np.full((10, 10), UNKNOWN, np.int8), (0.0, 0.0), 0.05), CONFIG)
    with pytest.raises(NoWayError, match="no ground with room"):
        goal_before(np.zeros(3), np.array([1.0, 0.0, 0.0]), empty)


@pytest.mark.parametrize(
    ("far_half", "radius", "why"),
    [(UNKNOWN, 0.25, "no ground was seen before it"), (FREE, 0.25, "no way was seen to the ground"),
     (OCCUPIED, 0.25, "no ground was seen before it"), (FREE, 1.7, "no room before it for a robot of 1.7 m")],
)  # fmt: skip
def test_why_a_robot_stops_short_of_a_sign_is_said(far_half: int, radius: float, why: str) -> None:
    values = hall(door=7.95).values.copy()
    values[:, 76:80] = OCCUPIED
    values[1:-1, 80:-1] = far_half
    if radius > 1.0:
        values[1:-1:10, 82:-1:10] = OCCUPIED
    walkable = Walkable(Grid(values, (0.0, 0.0), 0.05), WayConfig(robot_radius=radius))
    goal = goal_before(np.array([7.0, 4.0, 2.2]), np.array([-1.0, 0.0, 0.0]), walkable, np.array([1.9, 4.0]))
    assert not goal.is_before
    assert goal.why.startswith(("there is " + why, why))


def test_a_sign_of_unknown_place_is_refused_in_words() -> None:
    with pytest.raises(NoWayError, match="where the sign hangs is not known"):
        goal_before(np.array([np.nan, 0.0, 1.0]), None, Walkable(hall(), CONFIG))


@pytest.mark.parametrize(("height", "said"), [(4.4, "1 storey higher"), (7.5, "2 storeys higher"), (1.4, None)])
def test_there_is_no_way_to_a_sign_on_another_storey(height: float, said: str | None) -> None:
    grid = replace(hall(), storeys=(0.0, 3.0, 6.1), storey=0)
    sign, normal = np.array([0.05, 3.0, height]), np.array([1.0, 0.0, 0.0])
    if said is None:
        assert goal_before(sign, normal, Walkable(grid, CONFIG)).is_before
        return
    with pytest.raises(NoWayError, match=said):
        goal_before(sign, normal, Walkable(grid, CONFIG))
