"""Corridors: one with nearly nothing to see, and a street of shops that all look alike."""

import numpy as np

from lpslam.simulation import displays, textures
from lpslam.simulation.walk import rounded
from lpslam.simulation.worlds.places import prints
from lpslam.simulation.worlds.places.materials import FLOORS, WALLS, any_of, cloudy, marble, plaster, tiles
from lpslam.simulation.worlds.places.place import Place, Route, ahead
from lpslam.simulation.worlds.places.workshop import Workshop, facing, vec


def corridor(rng: np.random.Generator) -> Place:
    """A ring of bare corridors with a few doors, notices and door plates."""
    shop = Workshop(rng)
    long, wide, gap = float(rng.uniform(9.0, 13.0)), float(rng.uniform(7.0, 9.0)), float(rng.uniform(1.7, 2.3))
    height = float(rng.uniform(2.4, 2.8))
    bare = (plaster,)
    shop.room((0, 0), (long, wide), height, bare, (plaster, cloudy, tiles))
    shop.box(vec(gap, gap), vec(long - 2 * gap, 0), vec(0, wide - 2 * gap), height, bare)
    door = textures.wood(rng, 180, 80)
    walls = (
        (vec(0, 0), vec(1, 0), long, np.pi / 2), (vec(0, wide), vec(1, 0), long, -np.pi / 2),
        (vec(0, 0), vec(0, 1), wide, 0.0), (vec(long, 0), vec(0, 1), wide, np.pi),
        (vec(gap, gap), vec(1, 0), long - 2 * gap, -np.pi / 2),
        (vec(long - gap, gap), vec(0, 1), wide - 2 * gap, 0.0),
    )  # fmt: skip
    for start, along, length, heading in walls:
        for at in np.arange(float(rng.uniform(1.0, 2.5)), length - 0.9, float(rng.uniform(2.6, 4.5))):
            spot = start + float(at) * along + 0.01 * facing(heading)[1]
            shop.hang(spot + vec(0, 0, 1.0), heading, (0.9, 2.0), door)
            right, out = facing(heading)
            if rng.random() < 0.45:
                shop.sign("facility", "plain", 0.1, 0.8, spot + 0.85 * right + 0.02 * out + vec(0, 0, 1.6), heading)
            elif rng.random() < 0.25:
                w, h = (float(v) for v in rng.uniform(0.25, 0.6, 2))
                notice = spot - 0.85 * right + vec(0, 0, 1.5)
                shop.hang(notice, heading, (w, h), prints.page(rng, int(h * 400), int(w * 400)))
    corners = np.array(
        [[gap / 2, gap / 2], [long - gap / 2, gap / 2], [long - gap / 2, wide - gap / 2], [gap / 2, wide - gap / 2]]
    )
    path = rounded(corners, 0.7)
    points = np.column_stack([path, np.full(len(path), float(rng.uniform(1.25, 1.5)))])
    route = Route(points, ahead(points), True, 0.8, float(rng.uniform(0.4, 1.1)))
    return Place(shop.build(), shop.signs(), route, shop.solids((0, 0, 0.05), (long, wide, height)))


def shop_fronts(rng: np.random.Generator) -> Place:
    """A street under a roof: two rows of fronts, each row the same picture again and again."""
    shop = Workshop(rng)
    units, unit = int(rng.integers(6, 9)), float(rng.uniform(2.6, 3.4))
    long, wide, height = units * unit, float(rng.uniform(4.2, 5.4)), 3.0
    shop.room((0, 0), (long, wide), height, WALLS, FLOORS)
    names = int(rng.integers(3, 6))
    for heading, y in ((np.pi / 2, 0.0), (-np.pi / 2, wide)):
        front, side = _front(rng, unit), shop.builder.add_colour((70, 66, 60))
        texture = shop.builder.add_texture(front)
        right, out = facing(heading)
        for k in range(units):
            middle = vec((k + 0.5) * unit, y) + 0.02 * out
            corner = middle - right * unit / 2 + vec(0, 0, 2.3)
            shop.builder.add_face(corner, right * unit, vec(0, 0, -2.3), texture)
            # A pillar at every seam, all alike.
            foot = middle - right * (unit / 2 + 0.09)
            shop.box(foot, *_upward(right * 0.18, out * 0.14), height, side)
        for k in rng.choice(units, names, replace=False):
            spot = vec((float(k) + 0.5) * unit, y, 2.6) + 0.05 * out
            shop.sign("shop", "shop", float(rng.uniform(0.16, 0.24)), unit - 0.6, spot, heading)
    end = vec(0.02, wide / 2, 1.6)
    shop.sign("slogan", "friendly", 0.12, 1.6, end, 0.0)
    shop.hang(vec(long - 0.02, wide / 2, 1.5), np.pi, (1.2, 1.6), prints.picture(rng, 500, 380))
    aside = wide / 2 - 1.35
    corners = np.array(
        [
            [1.3, wide / 2 - aside],
            [long - 1.3, wide / 2 - aside],
            [long - 1.3, wide / 2 + aside],
            [1.3, wide / 2 + aside],
        ]
    )
    path = rounded(corners, 0.6)
    points = np.column_stack([path, np.full(len(path), float(rng.uniform(1.3, 1.5)))])
    targets = ahead(points)
    if rng.random() < 0.5:
        targets = np.column_stack(
            [points[:, 0], np.where(points[:, 1] < wide / 2, wide, 0.0), np.full(len(points), 1.4)]
        )
        targets = smooth_targets(targets)
    route = Route(points, targets, True, 0.8, float(rng.uniform(0.4, 1.1)))
    return Place(shop.build(2.0), shop.signs(), route, shop.solids((0, 0, 0.05), (long, wide, height)))


def smooth_targets(targets: np.ndarray) -> np.ndarray:
    """Targets of a closed route that jump nowhere."""
    from scipy.ndimage import gaussian_filter1d

    return np.asarray(gaussian_filter1d(targets, 18, axis=0, mode="wrap"))


def _upward(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two horizontal edges in the order in which their product points up."""
    return (a, b) if np.cross(a, b)[2] > 0 else (b, a)


def _front(rng: np.random.Generator, unit: float) -> np.ndarray:
    """The picture of a front: a door, a window with goods, a wall around them."""
    scale = 170.0
    h, w = round(2.3 * scale), round(unit * scale)
    image = any_of(rng, (marble, tiles, cloudy), h, w, scale)
    top, door, sill = round(0.25 * scale), round(1.0 * scale), h - round(0.45 * scale)
    left = round(0.2 * scale)
    image[top:, left : left + door] = displays.goods(rng, h - top, door, 130.0)
    pane = slice(left + door + round(0.15 * scale), w - round(0.2 * scale))
    image[top:sill, pane] = displays.goods(rng, sill - top, pane.stop - pane.start, 150.0)
    image[top - 5 : top, :] = 40
    return image
