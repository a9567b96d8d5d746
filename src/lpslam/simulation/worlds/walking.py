"""People who walk by: made of boxes, with legs and arms that swing."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.simulation import textures
from lpslam.simulation.scene import Scene
from lpslam.simulation.worlds.places.materials import THINGS, any_of
from lpslam.simulation.worlds.places.place import Walker
from lpslam.simulation.worlds.places.workshop import Workshop, vec

WAITING = -40.0  # metres below the floor at which people are built, so that they throw no light or shadow
STRIDE = 0.75  # metres
LIT = 0.85  # brightness of people, wherever they are
MOST_COVERED = 0.4  # share of a view that people may hide
GIRTH, HEIGHT = 0.3, 1.75  # metres: the box of someone, from its middle to its sides, and upwards
CELLS = (24, 32)  # rows and columns of a view in which hidden parts are counted

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Limb:
    """A box of a body: half widths across and along the walk, from a height to another, how it swings."""

    aside: float
    wide: float
    deep: float
    low: float
    high: float
    swing: int
    colour: int


def add_walker(shop: Workshop, start: Array, end: Array) -> Walker:
    """Build someone who goes to and fro between two places (2,) metres."""
    rng = shop.rng
    tall = float(rng.uniform(1.55, 1.9)) / 1.75
    skin = shop.builder.add_colour(tuple(int(v) for v in np.array([225, 180, 150]) * rng.uniform(0.35, 1.05)))  # type: ignore[arg-type]
    shirt = shop.builder.add_texture(any_of(rng, THINGS, 90, 70, 160.0))
    trousers = shop.builder.add_texture(textures.wall(rng, 120, 40, 150.0, "plaster", textures.wall_colour(rng, 0.6)))
    hair = shop.builder.add_colour(tuple(int(v) for v in rng.integers(15, 120, 3)))  # type: ignore[arg-type]
    limbs = (
        _Limb(0.09, 0.075, 0.08, 0.0, 0.85, 1, trousers), _Limb(-0.09, 0.075, 0.08, 0.0, 0.85, -1, trousers),
        _Limb(0.0, 0.2, 0.12, 0.85, 1.45, 0, shirt), _Limb(0.25, 0.05, 0.06, 0.8, 1.42, -1, shirt),
        _Limb(-0.25, 0.05, 0.06, 0.8, 1.42, 1, shirt), _Limb(0.0, 0.06, 0.07, 1.45, 1.52, 0, skin),
        _Limb(0.0, 0.085, 0.1, 1.52, 1.68, 0, skin), _Limb(0.0, 0.095, 0.11, 1.66, 1.76, 0, hair),
    )  # fmt: skip
    first = shop.builder.count
    for limb in limbs:
        corner = vec(-limb.deep, limb.aside - limb.wide, WAITING + limb.low * tall)
        size = vec(2 * limb.deep, 0), vec(0, 2 * limb.wide)
        shop.box(corner, *size, (limb.high - limb.low) * tall, limb.colour, bottom=True, is_solid=False)
    swings = np.repeat([limb.swing for limb in limbs], 6)
    hips = np.repeat([limb.high * tall for limb in limbs], 6)
    speed, phase = float(rng.uniform(0.6, 1.4)), float(rng.uniform(0, 20))
    return Walker(first, shop.builder.count, start, end, speed, phase, swings, hips)


def lit(scene: Scene, walkers: tuple[Walker, ...]) -> Scene:
    """The scene with people as bright as a usual wall."""
    light = scene.light.copy()
    for walker in walkers:
        for start, width, height in scene.light_maps[walker.first : walker.last]:
            light[start : start + width * height] = LIT
    return replace(scene, light=light)


def walked(scene: Scene, walkers: tuple[Walker, ...], time: float) -> Scene:
    """The scene with everyone where they are at a time."""
    if not walkers:
        return scene
    origin, edge_u, edge_v, normal = (each.copy() for each in (scene.origin, scene.edge_u, scene.edge_v, scene.normal))
    for walker in walkers:
        rows = slice(walker.first, walker.last)
        place, heading, stride = _stand(walker, time)
        angle = walker.swings * 0.45 * np.sin(2 * np.pi * stride / (2 * STRIDE))
        pivot = np.column_stack([np.zeros((len(angle), 2)), walker.hips + WAITING])
        turn = np.array([[np.cos(heading), -np.sin(heading), 0], [np.sin(heading), np.cos(heading), 0], [0, 0, 1]])
        origin[rows] = (_swung(origin[rows] - pivot, angle) + pivot - [0, 0, WAITING]) @ turn.T + [*place, 0.0]
        for each in (edge_u, edge_v, normal):
            each[rows] = _swung(each[rows], angle) @ turn.T
    return replace(scene, origin=origin, edge_u=edge_u, edge_v=edge_v, normal=normal)


def thinned(
    walkers: tuple[Walker, ...], camera: PinholeCamera, world_from_camera: Array, times: Array
) -> tuple[Walker, ...]:
    """The walkers without those by whom more than `MOST_COVERED` of some view (n, 4, 4) at a time (n,) was hidden."""
    hidden = np.array([
        [_hidden(_stand(walker, time)[0], camera, pose) for time, pose in zip(times, world_from_camera, strict=True)]
        for walker in walkers
    ])  # fmt: skip
    kept = list(range(len(walkers)))
    while kept:
        cover = hidden[kept].any(axis=0).mean(axis=(1, 2))
        if cover.max() <= MOST_COVERED:
            break
        kept.remove(max(kept, key=lambda k: float(hidden[k, cover.argmax()].mean())))
    return tuple(walkers[k] for k in kept)


def _hidden(place: Array, camera: PinholeCamera, world_from_camera: Array) -> NDArray[np.bool_]:
    """(rows, columns) the cells of a view that someone who stands at a place (2,) hides."""
    sides = np.array([(x, y, z) for x in (-GIRTH, GIRTH) for y in (-GIRTH, GIRTH) for z in (0.0, HEIGHT)])
    x, y, z = ((sides + np.append(place, 0.0) - world_from_camera[:3, 3]) @ world_from_camera[:3, :3]).T
    result = np.zeros(CELLS, np.bool_)
    if z.max() > 0.05:
        z = np.maximum(z, 0.05)
        u, v = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
        left, right = np.clip(np.rint([u.min() / camera.width * CELLS[1], u.max() / camera.width * CELLS[1]]), 0, None)
        top, low = np.clip(np.rint([v.min() / camera.height * CELLS[0], v.max() / camera.height * CELLS[0]]), 0, None)
        result[int(top) : int(low), int(left) : int(right)] = True
    return result


def _swung(vectors: Array, angle: Array) -> Array:
    """Vectors (n, 3) turned by (n,) radians about the axis across the walk."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y, z = vectors.T
    return np.column_stack([cosine * x + sine * z, y, -sine * x + cosine * z])


def _stand(walker: Walker, time: float) -> tuple[Array, float, float]:
    """Where someone is, which way they look, and how far they have walked."""
    way = walker.end - walker.start
    length = float(np.linalg.norm(way))
    walked_so_far = walker.phase + walker.speed * time
    fold = walked_so_far % (2 * length)
    is_back = fold > length
    share = (2 * length - fold if is_back else fold) / length
    heading = float(np.arctan2(way[1], way[0])) + (np.pi if is_back else 0.0)
    return walker.start + share * way, heading, walked_so_far
