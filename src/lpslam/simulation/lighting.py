"""Lamps under the ceiling and the light that they throw, baked into each face's little light map."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.simulation.layout import Layout
from lpslam.simulation.scene import Scene, SceneBuilder

AMBIENT = 0.34  # share of full brightness that comes from everywhere
REACH = 6.0  # metres; farther lamps add to the ambient only


Vectors = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Lamps:
    """Light strips: (m, 3) centres, metres, and (m,) strengths."""

    centres: NDArray[np.float64]
    strengths: NDArray[np.float64]


def hang_lamps(rng: np.random.Generator, builder: SceneBuilder, layout: Layout, height: float) -> Lamps:
    """Hang light strips along the middle of every corridor."""
    glow = builder.add_colour((255, 250, 238))
    case = builder.add_colour((190, 190, 190))
    centres, strengths = [], []
    spacing = float(rng.uniform(2.2, 3.0))
    for start, end in layout.corridors:
        span = float(np.linalg.norm(end - start))
        along = np.append((end - start) / span, 0.0)
        across = np.array([-along[1], along[0], 0.0])
        count = max(1, int(span / spacing))
        for i in range(count):
            spot = np.append(start, height) + along * span * (i + 0.5) / count
            corner = spot - along * 0.6 - across * 0.1 - np.array([0, 0, 0.06])
            builder.add_box(corner, along * 1.2, across * 0.2, 0.059, case)
            builder.add_face(corner, along * 1.2, across * 0.2, glow, emission=1.15)
            centres.append(spot - np.array([0, 0, 0.08]))
            strengths.append(float(rng.uniform(0.8, 1.15)))
    return Lamps(np.array(centres), np.array(strengths))


def bake(scene: Scene, lamps: Lamps, height: float) -> None:
    """Write the light maps of a scene: ambient light, darker in corners, plus every lamp that is in sight."""
    _bake(
        scene.origin, scene.edge_u, scene.edge_v, scene.normal, scene.light, scene.light_maps, lamps.centres,
        lamps.strengths, height,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def blocked(
    origin: Vectors, edge_u: Vectors, edge_v: Vectors, normal: Vectors, start: Vectors, end: Vectors, margin: float
) -> bool:
    """Whether any face crosses the straight line from start to end, `margin` metres off its ends."""
    ray = end - start
    length = math.sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2])
    low, high = margin / length, 1.0 - margin / length
    for i in range(origin.shape[0]):
        slope = normal[i, 0] * ray[0] + normal[i, 1] * ray[1] + normal[i, 2] * ray[2]
        if abs(slope) < 1e-12:
            continue
        gap = 0.0
        for j in range(3):
            gap += normal[i, j] * (origin[i, j] - start[j])
        share = gap / slope
        if share <= low or share >= high:
            continue
        uu = vv = du = dv = 0.0
        for j in range(3):
            offset = start[j] + share * ray[j] - origin[i, j]
            du += offset * edge_u[i, j]
            dv += offset * edge_v[i, j]
            uu += edge_u[i, j] * edge_u[i, j]
            vv += edge_v[i, j] * edge_v[i, j]
        if 0.0 <= du <= uu and 0.0 <= dv <= vv:
            return True
    return False


@njit(cache=True, nogil=True)
def _bake(
    origin: Vectors,
    edge_u: Vectors,
    edge_v: Vectors,
    normal: Vectors,
    light: NDArray[np.float32],
    light_maps: NDArray[np.int64],
    lamps: Vectors,
    strengths: Vectors,
    height: float,
) -> None:
    for i in range(origin.shape[0]):
        first, width, rows = light_maps[i]
        for row in range(rows):
            for column in range(width):
                a, b = column / (width - 1), row / (rows - 1)
                # Texels on the rim are lit a little inside it, where they are not buried in a neighbour.
                a, b = 0.02 + 0.96 * a, 0.02 + 0.96 * b
                spot = origin[i] + a * edge_u[i] + b * edge_v[i] + 0.01 * normal[i]
                total = AMBIENT * (
                    0.72 + 0.28 * min(1.0, spot[2] / 0.5) * min(1.0, max(0.0, height - spot[2]) / 0.4 + 0.3)
                )
                for lamp in range(lamps.shape[0]):
                    way = lamps[lamp] - spot
                    distance = math.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
                    if distance > REACH or distance < 0.02:
                        continue
                    cosine = (normal[i, 0] * way[0] + normal[i, 1] * way[1] + normal[i, 2] * way[2]) / distance
                    down = way[2] / distance
                    if cosine <= 0.0 or down <= 0.0:
                        continue
                    fade = 1.0 - (distance / REACH) ** 2
                    gain = (
                        1.35
                        * strengths[lamp]
                        * (0.25 + 0.75 * cosine)
                        * (0.35 + 0.65 * down)
                        * fade
                        / (1.0 + distance * distance * 0.45)
                    )
                    if gain > 0.01 and not blocked(origin, edge_u, edge_v, normal, spot, lamps[lamp], 0.03):
                        total += gain
                # Pictures hold display values: light acts through the display's gamma.
                light[first + row * width + column] = min(1.25, total) ** 0.6
