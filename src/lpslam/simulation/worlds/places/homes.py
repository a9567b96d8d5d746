"""Rooms that people live and work in: a living room, and a desk with shelves and many small things."""

import numpy as np

from lpslam.simulation import furniture
from lpslam.simulation.worlds.places import prints
from lpslam.simulation.worlds.places.materials import (
    FLOORS,
    THINGS,
    WALLS,
    bricks,
    cloudy,
    fabric,
    tiles,
    wallpaper,
    wood_grain,
)
from lpslam.simulation.worlds.places.place import Place, Route, ahead, smooth_path
from lpslam.simulation.worlds.places.workshop import Workshop, vec

LIVELY = (wallpaper, bricks, cloudy, tiles)


def living_room(rng: np.random.Generator) -> Place:
    """A room of about 5 by 6 metres with seats, a table, shelves, pictures, plants."""
    shop = Workshop(rng)
    long, wide, height = float(rng.uniform(5.4, 6.8)), float(rng.uniform(4.8, 5.8)), float(rng.uniform(2.4, 2.8))
    shop.room((0, 0), (long, wide), height, WALLS if rng.random() < 0.6 else LIVELY, FLOORS)
    _seats(shop, wide)
    table = vec(0.52 * long, 0.5 * wide)
    _table(shop, table, (float(rng.uniform(0.9, 1.2)), 0.7, float(rng.uniform(0.4, 0.72))), 9)
    shelf(shop, vec(long - 0.32, 0.5, 0), np.pi, min(2.2, wide - 2.0), height - 0.4, 0.3)
    shelf(shop, vec(0.6 * long, wide - 0.3, 0), -np.pi / 2, 1.4, 1.2, 0.28)
    hang_pictures(shop, (long, wide), height, int(rng.integers(5, 10)))
    furniture.stand_plant(rng, shop.builder, vec(0.35, wide - 0.4))
    shop.block(vec(0, wide - 0.8), vec(0.75, 0), vec(0, 0.8), 1.5)
    shop.sign("slogan", "friendly", float(rng.uniform(0.12, 0.18)), 1.8, vec(0.3 * long, 0.02, 1.65), np.pi / 2)
    shop.sign("restaurant", "shop", float(rng.uniform(0.13, 0.2)), 1.8, vec(0.015, 0.25 * wide, 1.7), 0.0)
    shop.sign("facility", "plain", 0.14, 1.5, vec(0.8 * long, wide - 0.02, 1.75), -np.pi / 2)
    # Around the table, between it and what stands along the walls.
    reach = np.array([0.5 * long - 1.25, 0.5 * wide - 1.25])
    turn = np.linspace(0, 2 * np.pi, 8, endpoint=False)
    ring = np.column_stack([table[0] + reach[0] * np.cos(turn), table[1] + reach[1] * np.sin(turn), np.full(8, 1.35)])
    ring[:, 2] += rng.uniform(-0.12, 0.12, 8)
    points = smooth_path(ring, True)
    outward = rng.random() < 0.5
    targets = (
        ahead(points)
        if outward
        else np.column_stack([2 * table[0] - points[:, 0], 2 * table[1] - points[:, 1], np.full(len(points), 1.0)])
    )
    route = Route(points, targets, True, 0.55, 0.85)
    return Place(shop.build(), shop.signs(), route, shop.solids((0, 0, 0.05), (long, wide, height)))


def _seats(shop: Workshop, wide: float) -> None:
    """A sofa along the left wall."""
    rng, long = shop.rng, float(shop.rng.uniform(1.6, 2.1))
    y, cover = 0.5 * wide - long / 2, (fabric,)
    shop.box(vec(0.05, y), vec(0.85, 0), vec(0, long), 0.42, cover)
    shop.box(vec(0.05, y), vec(0.22, 0), vec(0, long), 0.85, cover)
    for side in (y - 0.02, y + long - 0.18):
        shop.box(vec(0.05, side), vec(0.9, 0), vec(0, 0.2), 0.6, cover)
    for _ in range(3):
        spot = vec(0.42, float(rng.uniform(y + 0.3, y + long - 0.3)), 0.42)
        shop.turned_box(spot, (0.16, 0.4, 0.38), float(rng.uniform(-0.4, 0.4)), THINGS, is_solid=False)


def _table(shop: Workshop, centre: np.ndarray, size: tuple[float, float, float], things: int) -> None:
    width, depth, height = size
    top = 0.04
    shop.box(
        centre + vec(-width / 2, -depth / 2, height - top),
        vec(width, 0),
        vec(0, depth),
        top,
        (wood_grain,),
        bottom=True,
    )
    for x in (-1, 1):
        for y in (-1, 1):
            shop.turned_box(
                centre + vec(x * (width / 2 - 0.06), y * (depth / 2 - 0.06)),
                (0.05, 0.05, height - top),
                0.0,
                (wood_grain,),
            )
    strew(shop, centre + vec(0, 0, height), (width, depth), things)


def strew(shop: Workshop, centre: np.ndarray, area: tuple[float, float], count: int) -> None:
    """Small things on a surface: books, papers, cups, packages, side by side."""
    rng = shop.rng
    taken: list[tuple[np.ndarray, float]] = []
    for _ in range(8 * count):
        if len(taken) == count:
            break
        radius = float(rng.uniform(0.035, 0.13))
        spot = rng.uniform(-0.5, 0.5, 2) * np.maximum(np.array(area) - 2 * radius, 0.02)
        if any(np.linalg.norm(spot - other) < radius + reach for other, reach in taken):
            continue
        taken.append((spot, radius))
        foot, turn = centre + vec(*spot), float(rng.uniform(0, np.pi))
        side = float(rng.uniform(0.9, 1.4)) * radius
        texels = max(24, int(side * 900))
        kind = rng.random()
        if kind < 0.25:
            size = (1.3 * side, 0.95 * side, float(rng.uniform(0.003, 0.012)))
            paper = shop.builder.add_texture(prints.page(rng, texels, int(texels * 1.35)))
            shop.turned_box(foot, size, turn, paper, is_solid=False)
        elif kind < 0.5:
            cover = shop.builder.add_texture(prints.picture(rng, texels, texels))
            shop.turned_box(
                foot, (1.2 * side, 0.85 * side, float(rng.uniform(0.015, 0.07))), turn, cover, is_solid=False
            )
        elif kind < 0.75:
            tall = float(rng.uniform(0.06, 0.26))
            side_picture = shop.builder.add_texture(prints.package(rng, max(16, int(tall * 700)), texels))
            shop.turned_box(foot, (side, 0.6 * side, tall), turn, side_picture)
        else:
            wrap = shop.builder.add_texture(prints.package(rng, 64, 32))
            lid = tuple(int(v) for v in rng.integers(20, 240, 3))
            shop.drum(foot, min(0.55 * radius, 0.05), float(rng.uniform(0.06, 0.22)), wrap, (lid[0], lid[1], lid[2]))


def shelf(shop: Workshop, foot: np.ndarray, heading: float, width: float, height: float, depth: float) -> None:
    """Shelves along a wall, full of books and things, `foot` at the reader's left end of the front."""
    rng = shop.rng
    right, out = vec(-np.sin(heading), np.cos(heading)), vec(np.cos(heading), np.sin(heading))
    wood = shop.builder.add_texture(wood_grain(rng, 120, 120, 220.0))
    back = shop.builder.add_texture(cloudy(rng, 100, 100, 200.0))
    corner = foot - out * depth
    shop.builder.add_face(corner + out * 0.01 + vec(0, 0, height), right * width, vec(0, 0, -height), back)
    for x in (0.0, width - 0.025):
        shop.box(corner + right * x, out * depth, right * 0.025, height, wood, is_solid=False)
    rows = max(2, round(height / 0.36))
    gap = height / rows
    for row in range(rows + 1):
        shop.box(
            corner + vec(0, 0, row * gap - 0.01), out * depth, right * width, 0.02, wood, bottom=True, is_solid=False
        )
        if row < rows:
            _fill(shop, corner + vec(0, 0, row * gap + 0.01), right, out, width, depth, gap - 0.04)
    shop.block(corner, out * depth, right * width, height)


def _fill(
    shop: Workshop, corner: np.ndarray, right: np.ndarray, out: np.ndarray, width: float, depth: float, gap: float
) -> None:
    rng, x = shop.rng, 0.04
    while x < width - 0.15:
        w, tall, deep = (
            float(rng.uniform(0.1, 0.5)),
            gap * float(rng.uniform(0.55, 0.95)),
            depth * float(rng.uniform(0.5, 0.9)),
        )
        w = min(w, width - 0.04 - x)
        size = (max(16, int(tall * 420)), max(16, int(w * 420)))
        maker = prints.spines if rng.random() < 0.6 else prints.package
        texture = shop.builder.add_texture(maker(rng, *size))
        top = shop.builder.add_colour((190, 182, 165))
        shop.box(corner + right * x + out * 0.02, out * deep, right * w, tall, texture, top=top, is_solid=False)
        x += w + float(rng.choice([0.0, 0.02, 0.12]))


def hang_pictures(shop: Workshop, room: tuple[float, float], height: float, count: int) -> None:
    """Framed pictures on the four walls of a room that begins at the origin."""
    rng, (long, wide) = shop.rng, room
    for _ in range(count):
        w, h = (float(v) for v in rng.uniform(0.25, 0.8, 2))
        z = float(rng.uniform(1.1 + h / 2, max(1.2 + h / 2, min(2.1, height - h / 2 - 0.1))))
        wall, share = int(rng.integers(4)), float(rng.uniform(0.12, 0.88))
        spots = ((vec(share * long, 0.012, z), np.pi / 2), (vec(share * long, wide - 0.012, z), -np.pi / 2),
                 (vec(0.012, share * wide, z), 0.0), (vec(long - 0.012, share * wide, z), np.pi))  # fmt: skip
        image = prints.picture(rng, int(h * 320), int(w * 320))
        image[:6] = image[-6:] = image[:, :6] = image[:, -6:] = int(rng.integers(10, 220))
        shop.hang(*spots[wall], (w, h), image, gloss=float(rng.choice([0.0, 0.4])))


def desk(rng: np.random.Generator) -> Place:
    """A desk with many small things, seen from 0.4 to 1.5 m, with shelves and a wall behind it."""
    shop = Workshop(rng)
    long, wide, height = float(rng.uniform(3.6, 4.4)), float(rng.uniform(3.4, 4.2)), float(rng.uniform(2.4, 2.8))
    shop.room((0, 0), (long, wide), height, WALLS, FLOORS)
    width, depth, tall = float(rng.uniform(1.5, 1.9)), float(rng.uniform(0.7, 0.85)), float(rng.uniform(0.7, 0.78))
    centre = vec(0.5 * long, depth / 2 + 0.03)
    _table(shop, centre, (width, depth, tall), int(rng.integers(22, 34)))
    _screens(shop, centre + vec(0, 0, tall), width)
    _wall_board(shop, vec(0.5 * long, 0.015, tall + 0.75), width)
    shelf(shop, vec(0.32, wide - 1.8, 0), 0.0, 1.4, height - 0.5, 0.3)
    hang_pictures(shop, (long, wide), height, 4)
    shop.sign("warning", "plain", 0.035, 0.5, vec(0.5 * long - 0.36 * width, 0.03, tall + 0.36), np.pi / 2)
    shop.sign("shop", "shop", 0.06, 0.7, vec(0.5 * long + 0.36 * width, 0.03, tall + 0.34), np.pi / 2)
    route = _around_desk(rng, centre + vec(0, 0, tall), width, depth)
    return Place(shop.build(5.0), shop.signs(), route, shop.solids((0, 0, 0.05), (long, wide, height)))


def _around_desk(rng: np.random.Generator, top: np.ndarray, width: float, depth: float) -> Route:
    """To and fro along the desk, near and far, high and low, looking at what lies on it."""
    across = np.linspace(-0.55, 0.55, 7) * width
    away = depth / 2 + rng.uniform(0.05, 0.75, 7)
    rise = rng.uniform(0.18, 0.65, 7)
    corners = np.column_stack([top[0] + across, top[1] + away, top[2] + rise])
    corners = np.vstack(
        [
            corners,
            corners[-2:0:-1]
            + np.column_stack([np.zeros((5, 1)), rng.uniform(0.1, 0.3, (5, 1)), rng.uniform(0, 0.2, (5, 1))]),
        ]
    )
    points = smooth_path(corners, True, 0.02)
    targets = np.column_stack(
        [
            top[0] + 0.75 * (points[:, 0] - top[0]),
            np.full(len(points), top[1] - 0.1),
            np.full(len(points), top[2] + 0.1),
        ]
    )
    return Route(points, targets, True, 0.22, float(top[2] + 0.45))


def _screens(shop: Workshop, top: np.ndarray, width: float) -> None:
    rng = shop.rng
    w, h = float(rng.uniform(0.45, 0.6)), 0.34
    spot = top + vec(float(rng.uniform(-0.1, 0.1)) * width, -0.22)
    dark = shop.builder.add_colour((22, 22, 24))
    shop.turned_box(spot, (0.2, 0.14, 0.012), 0.0, dark)
    shop.turned_box(spot, (0.05, 0.04, 0.16), 0.0, dark)
    shop.turned_box(spot + vec(0, 0, 0.12), (w, 0.03, h), 0.0, dark)
    shop.hang(
        spot + vec(0, 0.017, 0.12 + h / 2),
        np.pi / 2,
        (w - 0.02, h - 0.02),
        prints.screen(rng, 260, 420),
        gloss=0.6,
        glow=0.8,
    )
    keys = shop.builder.add_texture(prints.keyboard(rng, 120, 360))
    shop.turned_box(
        top + vec(spot[0] - top[0], 0.12), (0.42, 0.14, 0.02), float(rng.uniform(-0.1, 0.1)), keys, is_solid=False
    )


def _wall_board(shop: Workshop, centre: np.ndarray, width: float) -> None:
    """Notes, cards and pictures pinned to the wall."""
    rng = shop.rng
    for _ in range(14):
        w, h = (float(v) for v in rng.uniform(0.07, 0.26, 2))
        spot = centre + vec(
            float(rng.uniform(-0.5, 0.5)) * width, float(rng.uniform(0, 0.006)), float(rng.uniform(-0.3, 0.4))
        )
        maker = prints.page if rng.random() < 0.5 else prints.picture
        shop.hang(spot, np.pi / 2, (w, h), maker(rng, int(h * 600), int(w * 600)))
