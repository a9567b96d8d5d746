"""A forecourt under the open sky: most of what is seen lies beyond the depth sensor's range."""

from dataclasses import replace

import cv2
import numpy as np

from lpslam.simulation import furniture, textures
from lpslam.simulation.scene import Scene
from lpslam.simulation.textures import Image, to_image
from lpslam.simulation.worlds.places.materials import STREETS, THINGS, any_of, bricks, cloudy, foliage, marble, spectral
from lpslam.simulation.worlds.places.place import Place, Route, ahead, smooth_path
from lpslam.simulation.worlds.places.workshop import UP, Workshop, facing, vec

SKY = 150.0  # metres away


def forecourt(rng: np.random.Generator) -> Place:
    """A paved square of about 36 by 26 metres before a row of houses, with benches, planters, trees and a kiosk."""
    shop = Workshop(rng)
    long, wide = float(rng.uniform(30.0, 42.0)), float(rng.uniform(22.0, 30.0))
    _ground(shop, long, wide)
    _sky(shop, long, wide)
    tall = float(rng.uniform(7.0, 14.0))
    for heading, centre, width in (
        (-np.pi / 2, vec(0, wide / 2), long), (np.pi / 2, vec(0, -wide / 2 - 25), long + 30),
        (0.0, vec(-long / 2 - 8, 0), wide), (np.pi, vec(long / 2 + 12, 0), wide + 10),
    ):  # fmt: skip
        _houses(shop, heading, centre, width, tall)
    for k in range(4):
        x = (k - 1.5) * long / 5
        shop.sign("shop", "shop", float(rng.uniform(0.35, 0.5)), 4.5, vec(x, wide / 2 - 0.1, 3.4), -np.pi / 2)
    near = wide / 2 - float(rng.uniform(8.0, 13.0))
    points = smooth_path(
        np.column_stack([
            np.array([-5.0, -2.0, 2.0, 5.0, 4.0, 0.0, -4.0]), near + np.array([-1.0, 0.6, 0.4, -0.8, -3.0, -3.6, -3.0]),
            np.full(7, float(rng.uniform(1.35, 1.6))),
        ]),
        True,
    )  # fmt: skip
    _furnish(shop, points, near)
    targets = ahead(points)
    if rng.random() < 0.5:
        targets = np.column_stack([0.5 * points[:, 0], np.full(len(points), wide / 2), np.full(len(points), 2.0)])
    route = Route(points, targets, True, 0.9, float(rng.uniform(0.6, 1.1)))
    scene = _daylit(shop.build_unlit(), rng)
    return Place(scene, shop.signs(), route, shop.solids((-30, -30, 0.05), (30, 30, 5.0)))


def _ground(shop: Workshop, long: float, wide: float) -> None:
    """Slabs of one large pavement, no two alike, and coarser ground around them."""
    rng, cell = shop.rng, 6.0
    picture = any_of(rng, STREETS, 1400, 1400, 60.0).astype(np.float32)
    textures.wear(rng, picture, 60.0, 1.0)
    whole = to_image(picture)
    for x in np.arange(-12.0, 12.0, cell):
        for y in np.arange(-12.0, 12.0, cell):
            row, column = round((12 - y - cell) * 58), round((x + 12) * 58)
            cut = whole[row : row + 348, column : column + 348]
            shop.builder.add_face(
                vec(x, y + cell + wide / 2 - 12), vec(cell, 0), vec(0, -cell), shop.builder.add_texture(cut)
            )
    far = shop.builder.add_texture(any_of(rng, STREETS, 512, 512, 50.0))
    reach = SKY
    for low, high in (
        ((-reach, -reach), (reach, wide / 2 - 24)),
        ((-reach, wide / 2 - 24), (-12, reach)),
        ((12, wide / 2 - 24), (reach, reach)),
        ((-12, wide / 2), (12, reach)),
    ):
        size = np.array(high) - np.array(low)
        shop.builder.add_face(
            vec(low[0], high[1]),
            vec(size[0], 0),
            vec(0, -size[1]),
            far,
            repeat=(max(1.1, size[0] / 10), max(1.1, size[1] / 10)),
        )


def _sky(shop: Workshop, long: float, wide: float) -> None:
    """A box of clouds around everything."""
    rng = shop.rng
    low, high = np.array([150.0, 175.0, 205.0]) * rng.uniform(0.8, 1.1), np.array([235.0, 238.0, 245.0])
    for heading in (0.0, np.pi / 2, np.pi, -np.pi / 2):
        share = np.clip(0.5 + 0.35 * spectral(rng, 256, 512, 1.7), 0, 1)[..., None]
        image = to_image((low * (1 - share) + high * share).astype(np.float32))
        right, out = facing(heading)
        corner = -out * SKY - right * SKY + UP * 100.0
        shop.builder.add_face(corner, right * 2 * SKY, -UP * 102.0, shop.builder.add_texture(image), emission=1.0)
    share = np.clip(0.5 + 0.35 * spectral(rng, 256, 256, 1.7), 0, 1)[..., None]
    top = shop.builder.add_texture(to_image((low * (1 - share) + high * share).astype(np.float32)))
    shop.builder.add_face(vec(-SKY, -SKY, 100.0), vec(2 * SKY, 0), vec(0, 2 * SKY), top, emission=1.0)


def facade(rng: np.random.Generator, width: float, height: float) -> Image:
    """The front of a house: rows of windows in a wall, each a little different."""
    scale = min(60.0, 1400 / max(width, height))
    h, w = round(height * scale), round(width * scale)
    image = any_of(rng, (bricks, cloudy, marble), h, w, scale).astype(np.float32)
    storey, bay = float(rng.uniform(2.8, 3.8)), float(rng.uniform(1.6, 3.0))
    glass = np.array([60.0, 75.0, 90.0]) * rng.uniform(0.5, 1.4)
    for row in range(int(height // storey)):
        for column in range(int(width // bay)):
            x, y = round((column + 0.25) * bay * scale), h - round((row + 0.82) * storey * scale)
            size = (round(0.5 * bay * scale), round(0.52 * storey * scale))
            cv2.rectangle(image, (x - 2, y - 2), (x + size[0] + 2, y + size[1] + 2), (215, 212, 205), -1)
            shade = glass * rng.uniform(0.6, 1.5) if rng.random() < 0.8 else np.array([190.0, 180.0, 150.0])
            cv2.rectangle(image, (x, y), (x + size[0], y + size[1]), np.clip(shade, 0, 255).tolist(), -1)
            cv2.line(image, (x + size[0] // 2, y), (x + size[0] // 2, y + size[1]), (200, 198, 190), 1)
    return to_image(image)


def _houses(shop: Workshop, heading: float, centre: np.ndarray, width: float, tall: float) -> None:
    """A row of houses of several widths and heights."""
    rng = shop.rng
    right, _ = facing(heading)
    place = -width / 2
    while place < width / 2 - 1.0:
        w, h = min(float(rng.uniform(7.0, 13.0)), width / 2 - place), tall * float(rng.uniform(0.7, 1.3))
        shop.hang(centre + right * (place + w / 2) + UP * h / 2, heading, (w, h), facade(rng, w, h))
        place += w


def _furnish(shop: Workshop, points: np.ndarray, near: float) -> None:
    """Benches, planters, bins, trees and a car or two, away from the route."""
    rng, spots = shop.rng, [points[::8, :2]]
    for _ in range(60):
        spot = np.array([rng.uniform(-10, 10), near + rng.uniform(-9, 5.5)])
        if np.linalg.norm(np.vstack(spots) - spot, axis=1).min() < 1.9:
            continue
        spots.append(spot[None])
        foot, turn, kind = vec(*spot), float(rng.uniform(0, np.pi)), int(rng.integers(6))
        if kind == 0:
            shop.turned_box(foot, (1.6, 0.45, 0.45), turn, THINGS)
        elif kind == 1:
            shop.turned_box(foot, (1.0, 1.0, 0.5), turn, THINGS)
            leaves = shop.builder.add_texture(foliage(rng, 200, 200, 250.0))
            shop.turned_box(foot + UP * 0.5, (0.85, 0.85, 0.55), turn + 0.2, leaves)
        elif kind == 2:
            furniture.stand_plant(rng, shop.builder, foot)
            shop.block(foot - vec(0.5, 0.5), vec(1, 0), vec(0, 1), 1.6)
        elif kind == 3:
            wrap = shop.builder.add_texture(any_of(rng, THINGS, 120, 60, 150.0))
            shop.drum(foot, 0.25, float(rng.uniform(0.6, 1.0)), wrap, (60, 60, 62))
        elif kind == 4:
            bark = shop.builder.add_texture(any_of(rng, (cloudy,), 200, 40, 100.0))
            shop.drum(foot, 0.14, 2.6, bark, (70, 60, 45))
            leaves = shop.builder.add_texture(foliage(rng, 300, 300, 130.0))
            for k in range(3):
                shop.turned_box(
                    foot + UP * (2.2 + 0.5 * k),
                    (2.0 - 0.4 * k, 1.9 - 0.4 * k, 0.9),
                    turn + 0.5 * k,
                    leaves,
                    bottom=True,
                )
        else:
            paint = shop.builder.add_texture(any_of(rng, (cloudy, marble), 100, 200, 120.0))
            shop.turned_box(foot, (1.2, 1.0, 1.9), turn, paint)


def _daylit(scene: Scene, rng: np.random.Generator) -> Scene:
    """Light of the sky and a low or high sun; nothing throws shadows."""
    sun = rng.uniform([-1.0, -1.0, 0.5], [1.0, 1.0, 1.5])
    sun /= np.linalg.norm(sun)
    shade = 0.62 + 0.12 * scene.normal[:, 2] + 0.45 * np.maximum(scene.normal @ sun, 0)
    counts = scene.light_maps[:, 1] * scene.light_maps[:, 2]
    return replace(scene, light=np.repeat(shade, counts).astype(np.float32))
