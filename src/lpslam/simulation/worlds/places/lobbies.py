"""Large rooms: one with glass walls and mirrors, a hall where people walk, an office whose lamps fail."""

import numpy as np

from lpslam.simulation import furniture
from lpslam.simulation.worlds.places import prints
from lpslam.simulation.worlds.places.homes import LIVELY, hang_pictures, shelf, strew
from lpslam.simulation.worlds.places.materials import FLOORS, THINGS, WALLS, wood_grain
from lpslam.simulation.worlds.places.place import Pane, Place, Route, Walker, ahead, smooth_path
from lpslam.simulation.worlds.places.workshop import UP, Workshop, facing, vec
from lpslam.simulation.worlds.walking import add_walker, lit


def _ring(centre: np.ndarray, reach: np.ndarray, height: float, rng: np.random.Generator) -> np.ndarray:
    """A closed path like an oval, a little uneven."""
    turn = np.linspace(0, 2 * np.pi, 10, endpoint=False)
    swell = rng.uniform(0.94, 1.06, 10)
    rise = height + rng.uniform(-0.08, 0.08, 10)
    corners = np.column_stack(
        [centre[0] + swell * reach[0] * np.cos(turn), centre[1] + swell * reach[1] * np.sin(turn), rise]
    )
    return smooth_path(corners if rng.random() < 0.5 else corners[::-1], True)


def glass(rng: np.random.Generator) -> Place:
    """A lobby with sheets of glass on both sides of the way and mirrors on two walls."""
    shop = Workshop(rng)
    long, wide, height = float(rng.uniform(8.0, 10.0)), float(rng.uniform(7.0, 8.5)), float(rng.uniform(2.7, 3.1))
    shop.room((0, 0), (long, wide), height, WALLS, FLOORS)
    hang_pictures(shop, (long, wide), height, 8)
    centre = vec(long / 2, wide / 2)
    panes = [
        _mirror(shop, vec(0.3 * long, 0.02, 1.25), np.pi / 2, (1.8, 1.9)),
        _mirror(shop, vec(long - 0.02, 0.6 * wide, 1.3), np.pi, (1.4, 2.0)),
    ]
    # A glass box in the middle with things in it, and a screen of glass before one wall.
    half = np.array([0.16 * long, 0.14 * wide])
    for heading, reach, width in (
        (0.0, half[0], half[1]),
        (np.pi, half[0], half[1]),
        (np.pi / 2, half[1], half[0]),
        (-np.pi / 2, half[1], half[0]),
    ):
        _, out = facing(heading)
        panes.append(_sheet(shop, centre + out * reach + vec(0, 0, 1.1), heading, (2 * width, 2.2)))
    panes.append(_sheet(shop, vec(0.62 * long, wide - 0.9, 1.1), -np.pi / 2, (0.3 * long, 2.2)))
    shop.block(centre - vec(*half), vec(2 * half[0], 0), vec(0, 2 * half[1]), 2.2)
    shop.block(vec(0.47 * long, wide - 0.95), vec(0.3 * long, 0), vec(0, 0.95), 2.2)
    _stand(shop, centre, 0.8)
    shop.turned_box(vec(0.62 * long, wide - 0.45), (1.0, 0.4, 0.8), 0.0, THINGS)
    furniture.stand_plant(rng, shop.builder, vec(0.5, 0.5))
    shop.block(vec(0.1, 0.1), vec(0.8, 0), vec(0, 0.8), 1.5)
    _signs(shop, long, wide)
    points = _ring(centre, np.array([0.335 * long, 0.305 * wide]), float(rng.uniform(1.3, 1.5)), rng)
    route = Route(points, ahead(points), True, 0.6, 0.9)
    return Place(shop.build(), shop.signs(), route, shop.solids((0, 0, 0.05), (long, wide, height)), tuple(panes))


def _signs(shop: Workshop, long: float, wide: float) -> None:
    shop.sign("facility", "plain", 0.2, 2.2, vec(0.7 * long, 0.03, 1.9), np.pi / 2)
    shop.sign("shop", "shop", 0.28, 3.0, vec(0.02, 0.5 * wide, 2.0), 0.0)
    shop.sign("slogan", "friendly", 0.2, 2.6, vec(0.25 * long, wide - 0.03, 1.9), -np.pi / 2)
    shop.sign("restaurant", "shop", 0.24, 2.6, vec(long - 0.03, 0.25 * wide, 1.9), np.pi)


def _pane(centre: np.ndarray, heading: float, size: tuple[float, float], is_mirror: bool) -> Pane:
    right, _ = facing(heading)
    corner = centre - right * size[0] / 2 + UP * size[1] / 2
    return Pane(corner, right * size[0], -UP * size[1], is_mirror)


def _mirror(shop: Workshop, centre: np.ndarray, heading: float, size: tuple[float, float]) -> Pane:
    """A mirror with a frame of wood around it."""
    right, out = facing(heading)
    wood = shop.builder.add_texture(wood_grain(shop.rng, 40, 200, 200.0))
    for aside in (-1, 1):
        spot = centre + right * aside * (size[0] / 2 + 0.03) - UP * size[1] / 2
        shop.turned_box(spot + out * 0.01, (0.06, 0.03, size[1]), heading + np.pi / 2, wood, is_solid=False)
    return _pane(centre + out * 0.012, heading, size, True)


def _sheet(shop: Workshop, centre: np.ndarray, heading: float, size: tuple[float, float]) -> Pane:
    """A sheet of glass between two thin posts."""
    right, _ = facing(heading)
    metal = shop.builder.add_colour((120, 124, 128))
    for aside in (-1, 1):
        spot = centre + right * aside * size[0] / 2 - UP * size[1] / 2
        shop.turned_box(spot, (0.04, 0.04, size[1]), heading, metal, is_solid=False)
    return _pane(centre, heading, size, False)


def _stand(shop: Workshop, centre: np.ndarray, side: float) -> None:
    """A table with things on it."""
    tall = float(shop.rng.uniform(0.6, 0.9))
    shop.turned_box(centre, (side, side, tall), 0.0, THINGS)
    strew(shop, centre + vec(0, 0, tall), (side, side), 9)


def people(rng: np.random.Generator) -> Place:
    """A hall with stalls, posters and signs, in which people go to and fro within reach of the camera."""
    shop = Workshop(rng)
    long, wide, height = float(rng.uniform(9.5, 12.0)), float(rng.uniform(8.5, 10.0)), float(rng.uniform(2.9, 3.4))
    shop.room((0, 0), (long, wide), height, LIVELY, FLOORS)
    hang_pictures(shop, (long, wide), height, 14)
    centre = vec(long / 2, wide / 2)
    shelf(shop, vec(0.32, 0.3 * wide, 0), 0.0, 2.0, 1.8, 0.3)
    shelf(shop, vec(long - 0.32, 0.75 * wide, 0), np.pi, 2.0, 1.8, 0.3)
    _signs(shop, long, wide)
    for corner in ((0.7, 0.7), (long - 0.7, 0.7), (0.7, wide - 0.7), (long - 0.7, wide - 0.7)):
        _stand(shop, vec(*corner), 0.7)
    reach = np.array([0.5 * long - 2.1, 0.5 * wide - 2.1])
    points = _ring(centre, reach, float(rng.uniform(1.3, 1.5)), rng)
    walkers = _walkers(shop, centre, reach, int(rng.integers(5, 9)))
    targets = np.column_stack([2 * centre[0] - points[:, 0], 2 * centre[1] - points[:, 1], np.full(len(points), 1.3)])
    route = Route(points, targets if rng.random() < 0.6 else ahead(points), True, 0.6, 1.0)
    scene = lit(shop.build(), walkers)
    return Place(scene, shop.signs(), route, shop.solids((0, 0, 0.05), (long, wide, height)), walkers=walkers)


def _walkers(shop: Workshop, centre: np.ndarray, reach: np.ndarray, count: int) -> tuple[Walker, ...]:
    """People inside the camera's ring, 0.7 m and more from it, and some outside."""
    walkers = []
    for k in range(count):
        turns = shop.rng.uniform(0, 2 * np.pi) + np.array([0.0, shop.rng.uniform(1.2, 3.1)])
        radius = reach * 0.9 - 0.75 if k % 4 else reach * 1.06 + 0.75
        if k % 4 == 0:
            turns[1] = turns[0] + 0.25
        ends = [centre[:2] + radius * [np.cos(turn), np.sin(turn)] for turn in turns]
        walkers.append(add_walker(shop, *ends))
    return tuple(walkers)


def office(rng: np.random.Generator) -> Place:
    """An office with desks and shelves; its lamps fail for a while."""
    shop = Workshop(rng)
    long, wide, height = float(rng.uniform(6.5, 8.0)), float(rng.uniform(5.5, 6.5)), float(rng.uniform(2.5, 2.9))
    shop.room((0, 0), (long, wide), height, WALLS, FLOORS)
    hang_pictures(shop, (long, wide), height, 9)
    for x in (0.25, 0.6):
        spot = vec(x * long + 0.4, 0.42)
        shop.turned_box(spot, (1.5, 0.75, 0.74), 0.0, (wood_grain,))
        strew(shop, spot + vec(0, 0, 0.74), (1.5, 0.75), 14)
        shop.hang(spot + vec(0, -0.38, 1.35), np.pi / 2, (0.9, 0.6), prints.screen(rng, 300, 450), gloss=0.4)
    shelf(shop, vec(0.32, 0.35 * wide, 0), 0.0, 1.8, 2.0, 0.3)
    shelf(shop, vec(0.3 * long + 1.6, wide - 0.3, 0), -np.pi / 2, 1.6, 1.2, 0.3)
    shop.turned_box(vec(long / 2, wide / 2), (1.4, 0.9, 0.72), float(rng.uniform(0, 0.3)), (wood_grain,))
    strew(shop, vec(long / 2, wide / 2, 0.72), (1.1, 0.7), 10)
    shop.sign("facility", "plain", 0.16, 1.8, vec(long - 0.03, 0.5 * wide, 1.8), np.pi)
    shop.sign("warning", "plain", 0.14, 1.7, vec(0.75 * long, wide - 0.03, 1.7), -np.pi / 2)
    points = _ring(vec(long / 2, wide / 2), np.array([0.5 * long - 1.6, 0.5 * wide - 1.45]), 1.4, rng)
    targets = ahead(points)
    if rng.random() < 0.5:
        targets = np.column_stack([long - points[:, 0], wide - points[:, 1], np.full(len(points), 1.1)])
    route = Route(points, targets, True, 0.55, 1.0)
    return Place(shop.build(), shop.signs(), route, shop.solids((0, 0, 0.05), (long, wide, height)), goes_dark=True)
