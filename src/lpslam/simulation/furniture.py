"""Things that stand along the walls: plants, bins, pilasters."""

import numpy as np
from numpy.typing import NDArray

from lpslam.simulation import textures
from lpslam.simulation.layout import Wall
from lpslam.simulation.scene import SceneBuilder

Vector = NDArray[np.float64]
LEAVES = 34


def stand_plant(rng: np.random.Generator, builder: SceneBuilder, foot: Vector) -> None:
    """A pot with leaves at `foot`, (3,) metres on the floor."""
    glaze = builder.add_texture(textures.wall(rng, 48, 48, 150.0, "stone", textures.wall_colour(rng, 0.6)))
    soil = builder.add_colour((58, 44, 34))
    side, tall = float(rng.uniform(0.24, 0.34)), float(rng.uniform(0.28, 0.45))
    turn = float(rng.uniform(0, np.pi / 2))
    along = side * np.array([np.cos(turn), np.sin(turn), 0.0])
    across = np.array([-along[1], along[0], 0.0])
    corner = foot - (along + across) / 2
    builder.add_box(corner, along, across, tall, glaze, top=soil)
    stem = builder.add_texture(textures.wood(rng, 32, 8))
    up = np.array([0.0, 0.0, float(rng.uniform(0.35, 0.6))])
    bud = foot + np.array([0, 0, tall]) - 0.015 * (along + across) / side
    builder.add_box(bud, 0.03 * along / side, 0.03 * across / side, up[2], stem)
    greens = [builder.add_texture(textures.leaf(rng)) for _ in range(3)]
    crown = foot + np.array([0, 0, tall]) + up
    for _ in range(LEAVES):
        heading, rise = rng.uniform(0, 2 * np.pi), rng.uniform(-0.5, 1.3)
        out = np.array([np.cos(heading) * np.cos(rise), np.sin(heading) * np.cos(rise), np.sin(rise)])
        flat = np.cross(out, [0.0, 0.0, 1.0])
        flat /= np.linalg.norm(flat)
        length, breadth = rng.uniform(0.16, 0.34), rng.uniform(0.05, 0.1)
        base = crown - up * rng.uniform(0, 0.7)
        builder.add_face(
            base - flat * breadth / 2, flat * breadth, out * length, int(rng.choice(greens)), two_sided=True
        )


def stand_bin(rng: np.random.Generator, builder: SceneBuilder, wall: Wall, place: float) -> None:
    """A litter bin at the foot of a wall, `place` metres from its start."""
    metal = builder.add_texture(textures.wall(rng, 110, 60, 150.0, "panels", textures.wall_colour(rng, 0.5)))
    lid = builder.add_colour((40, 40, 42))
    spot = wall.start + wall.right * (place + 0.36) + wall.normal * 0.04
    corner = np.array([spot[0], spot[1], 0.0])
    builder.add_box(
        corner, -0.36 * _flat(wall.right), 0.3 * _flat(wall.normal), float(rng.uniform(0.7, 0.85)), metal, top=lid
    )


def stand_pilaster(rng: np.random.Generator, builder: SceneBuilder, wall: Wall, place: float, height: float) -> None:
    """A flat pillar against a wall from floor to ceiling, its middle `place` metres from the wall's start."""
    width, depth = float(rng.uniform(0.28, 0.45)), float(rng.uniform(0.12, 0.22))
    kind = str(rng.choice(["stone", "tiles", "plaster"]))
    picture = textures.wall(rng, round(height * 150), round(width * 150), 150.0, kind, textures.wall_colour(rng, 0.2))
    spot = wall.start + wall.right * (place + width / 2)
    corner = np.array([spot[0], spot[1], 0.0])
    texture = builder.add_texture(picture)
    builder.add_box(corner, -width * _flat(wall.right), depth * _flat(wall.normal), height, texture)


def _flat(direction: NDArray[np.float64]) -> Vector:
    return np.array([direction[0], direction[1], 0.0])
