"""Builds places: boxes that block the way, rooms, round things, pictures, signs, lamps."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.config import SimulationConfig
from lpslam.simulation import lighting
from lpslam.simulation.mall import SignPainter, Vocabulary
from lpslam.simulation.scene import Scene, SceneBuilder
from lpslam.simulation.signs import Sign
from lpslam.simulation.textures import Image
from lpslam.simulation.worlds.places.materials import Material, any_of
from lpslam.simulation.worlds.places.place import Solids

Vector = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
SCALE = 220.0  # texels a metre of surfaces that are seen from a metre or two
LARGEST = 900  # texels along a side; larger surfaces repeat their picture


def vec(x: float, y: float, z: float = 0.0) -> Vector:
    """A vector (3,)."""
    return np.array([x, y, z], dtype=np.float64)


def facing(heading: float) -> tuple[Vector, Vector]:
    """The reader's right and the way out of a wall (unit, horizontal) for a wall that looks along a heading."""
    out = vec(np.cos(heading), np.sin(heading))
    return vec(-out[1], out[0]), out


@dataclass(slots=True)
class Workshop:
    """Collects faces, solids, signs and lamps of a place; `rng` paints, `builder` keeps the faces."""

    rng: np.random.Generator
    builder: SceneBuilder = field(default_factory=SceneBuilder)
    painter: SignPainter = field(init=False)
    _solids: list[tuple[Vector, Vector, Vector, float]] = field(default_factory=list)
    _lamps: list[tuple[Vector, float]] = field(default_factory=list)
    _height: float = 3.0

    def __post_init__(self) -> None:
        language = str(self.rng.choice(["mixed", "english", "chinese"]))
        options = SimulationConfig.model_validate({"language": language})
        self.painter = SignPainter(self.rng, self.builder, Vocabulary(self.rng, options))

    def paint(
        self, materials: Sequence[Material], metres: tuple[float, float], scale: float = SCALE
    ) -> tuple[int, tuple[float, float]]:
        """A picture of a material for a surface of (width, height) metres, and how often it is laid there."""
        width, height = metres
        shrink = max(1.0, max(width, height) * scale / LARGEST)
        repeat = (float(max(1, round(width * scale / LARGEST))), float(max(1, round(height * scale / LARGEST))))
        size = [max(8, round(side * scale / times)) for side, times in zip(metres, repeat, strict=True)]
        image = any_of(self.rng, tuple(materials), min(size[1], LARGEST), min(size[0], LARGEST), scale)
        return self.builder.add_texture(image), (1.0, 1.0) if shrink == 1.0 else repeat

    def box(
        self,
        corner: Vector,
        along: Vector,
        across: Vector,
        height: float,
        texture: int | Sequence[Material],
        *,
        top: int | None = None,
        gloss: float = 0.0,
        bottom: bool = False,
        is_solid: bool = True,
    ) -> None:
        """An upright box that blocks the way; `corner` at the bottom, `along` × `across` points up."""
        if not isinstance(texture, int):
            texture, _ = self.paint(texture, (float(np.linalg.norm(along)), height))
        self.builder.add_box(corner, along, across, height, texture, top=top, gloss=gloss, bottom=bottom)
        if is_solid:
            self.block(corner, along, across, height)

    def block(self, corner: Vector, along: Vector, across: Vector, height: float) -> None:
        """Keep cameras out of an upright box."""
        self._solids.append((corner, along, across, height))

    def turned_box(
        self,
        centre: Vector,
        size: tuple[float, float, float],
        turn: float,
        texture: int | Sequence[Material],
        **more: bool | int | float,
    ) -> None:
        """A box of (width, depth, height) metres on `centre`'s ground, turned about the vertical."""
        right, out = vec(np.cos(turn), np.sin(turn)), vec(-np.sin(turn), np.cos(turn))
        corner = centre - right * size[0] / 2 - out * size[1] / 2
        self.box(corner, right * size[0], out * size[1], size[2], texture, **more)  # type: ignore[arg-type]

    def drum(
        self, foot: Vector, radius: float, height: float, texture: int, lid: tuple[int, int, int], sides: int = 8
    ) -> None:
        """A round thing: a cup, a tin, a lamp, a column."""
        turn = 2 * np.pi * np.arange(sides + 1) / sides
        ring = foot + radius * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(sides + 1)])
        for left, right in pairwise(ring):
            self.builder.add_face(left + UP * height, right - left, -UP * height, texture)
        colour = self.builder.add_colour(lid)
        # Rectangles between opposite sides cover the whole lid.
        for k in range(sides // 2):
            left, right, far = ring[k] + UP * height, ring[k + 1] + UP * height, ring[k + sides // 2 + 1] + UP * height
            self.builder.add_face(far, left - far, right - left, colour, two_sided=True)
        side = vec(2 * radius, 0.0)
        self.block(foot - vec(radius, radius), side, vec(0.0, 2 * radius), height)

    def hang(
        self,
        centre: Vector,
        heading: float,
        size: tuple[float, float],
        image: Image,
        *,
        gloss: float = 0.0,
        glow: float = 0.0,
    ) -> None:
        """A flat picture of (width, height) metres that looks along a heading, its middle at `centre`."""
        right, _ = facing(heading)
        corner = centre - right * size[0] / 2 + UP * size[1] / 2
        self.builder.add_face(
            corner, right * size[0], -UP * size[1], self.builder.add_texture(image), gloss=gloss, emission=glow
        )

    def sign(
        self,
        kind: str,
        style: str,
        letters: float,
        widest: float,
        centre: Vector,
        heading: float,
        *,
        double_sided: bool = False,
    ) -> None:
        """A sign that can be read, its middle at `centre`, looking along a heading; letters and width in metres."""
        right, _ = facing(heading)
        board, kind = self.painter.paint(kind, style, letters, widest, min(900.0, 60.0 / letters), centre)
        self.painter.hang(board, kind, centre, right, thickness=0.02, double_sided=double_sided)

    def room(
        self,
        low: tuple[float, float],
        high: tuple[float, float],
        height: float,
        walls: Sequence[Material],
        floor: Sequence[Material],
    ) -> None:
        """Floor, ceiling and four walls, seen from inside, with lamps under the ceiling."""
        (x0, y0), (x1, y1) = low, high
        self._height = height
        add = self.builder.add_face
        texture, repeat = self.paint(floor, (x1 - x0, y1 - y0), 160.0)
        add(
            vec(x0, y1), vec(x1 - x0, 0), vec(0, y0 - y1), texture, repeat=repeat, gloss=float(self.rng.uniform(0, 0.3))
        )
        shade = int(self.rng.uniform(195, 240))
        add(vec(x0, y0, height), vec(x1 - x0, 0), vec(0, y1 - y0), self.builder.add_colour((shade, shade, shade - 6)))
        ring = [vec(x0, y0), vec(x0, y1), vec(x1, y1), vec(x1, y0)]
        shared = self.paint(walls, (x1 - x0, height), 150.0) if self.rng.random() < 0.5 else None
        skirting = self.builder.add_colour((70, 60, 52) if self.rng.random() < 0.5 else (205, 203, 198))
        for start, end in zip(ring, [*ring[1:], ring[0]], strict=True):
            run = end - start
            texture, repeat = shared or self.paint(walls, (float(np.linalg.norm(run)), height), 150.0)
            add(start + UP * height, run, -UP * height, texture, repeat=repeat)
            inward = np.cross(run, UP) / np.linalg.norm(run) * 0.012
            add(start + inward + UP * 0.08, run, -UP * 0.08, skirting)
        self.lamps(np.array([low, high]), height)

    def lamps(self, area: Vector, height: float) -> None:
        """Lamps under a ceiling over (2, 2) corners of an area, about one every two and a half metres."""
        glow = self.builder.add_colour((255, 250, 238))
        counts = np.maximum(1, np.round((area[1] - area[0]) / 2.8)).astype(int)
        for i in range(counts[0]):
            for j in range(counts[1]):
                x, y = area[0] + (area[1] - area[0]) * (np.array([i, j]) + 0.5) / counts
                corner = vec(x - 0.3, y - 0.15, height - 0.02)
                self.builder.add_face(corner, vec(0.6, 0), vec(0, 0.3), glow, emission=1.1)
                self.lamp(vec(x, y, height - 0.08), float(self.rng.uniform(0.8, 1.3)))

    def lamp(self, place: Vector, strength: float) -> None:
        """A source of light."""
        self._lamps.append((place, strength))

    def signs(self) -> tuple[Sign, ...]:
        """All signs that were hung."""
        return tuple(self.painter.signs)

    def solids(self, low: Sequence[float], high: Sequence[float]) -> Solids:
        """What blocks the way within bounds."""
        rows = self._solids or [(vec(0, 0, -99), vec(0.1, 0), vec(0, 0.1), 0.1)]
        corners, along, across, heights = (np.array(each) for each in zip(*rows, strict=True))
        return Solids(np.array([low, high], dtype=np.float64), corners, along, across, heights)

    def build_unlit(self, density: float = 1.0) -> Scene:
        """Lay out all faces without any light of lamps."""
        return self.builder.build(density)

    def build(self, density: float = 3.0) -> Scene:
        """Lay out all faces and bake the lamps' light, `density` texels of light a metre."""
        scene = self.build_unlit(density)
        lamps = lighting.Lamps(np.array([place for place, _ in self._lamps]), np.array([s for _, s in self._lamps]))
        lighting.bake(scene, lamps, self._height)
        return scene


def spotlit(scene: Scene, rng: np.random.Generator, bounds: Vector) -> Scene:
    """The scene in twilight with a few hot spots, placed within (2, 3) bounds."""
    count = int(rng.integers(3, 7))
    centres = rng.uniform(bounds[0], bounds[1], (count, 3))
    radii, peaks = rng.uniform(0.5, 1.4, count), rng.uniform(1.2, 2.6, count)
    light = _spots(scene.origin, scene.edge_u, scene.edge_v, scene.light, scene.light_maps, centres, radii, peaks)
    return replace(scene, light=light)


@njit(cache=True, nogil=True)
def _spots(
    origin: Vector,
    edge_u: Vector,
    edge_v: Vector,
    light: NDArray[np.float32],
    maps: NDArray[np.int64],
    centres: Vector,
    radii: Vector,
    peaks: Vector,
) -> NDArray[np.float32]:
    out = light.copy()
    for i in range(len(maps)):
        first, width, rows = maps[i]
        for row in range(rows):
            for column in range(width):
                a, b = column / (width - 1), row / (rows - 1)
                factor = 0.45
                for spot in range(len(centres)):
                    away = 0.0
                    for j in range(3):
                        away += (origin[i, j] + a * edge_u[i, j] + b * edge_v[i, j] - centres[spot, j]) ** 2
                    factor += peaks[spot] * np.exp(-away / radii[spot] ** 2)
                out[first + row * width + column] = light[first + row * width + column] * factor
    return out
