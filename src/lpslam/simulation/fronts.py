"""Furnishes walls: each is cut into bays, and each bay becomes a shop front, a door, or a wall with posters."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lpslam.simulation import displays, furniture, textures
from lpslam.simulation.layout import Wall
from lpslam.simulation.scene import SceneBuilder

if TYPE_CHECKING:
    from lpslam.simulation.mall import SignPainter

Vector = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
WALL_SCALE = 150.0  # pixels a metre of wall pictures: about one image pixel at 4 m
DOOR_HEIGHT = 2.1  # metres


@dataclass(slots=True)
class WallBuilder:
    """Turns walls of a floor plan into faces and signs; `height` metres, `projecting_share` of the shops."""

    rng: np.random.Generator
    builder: SceneBuilder
    painter: "SignPainter"
    height: float
    projecting_share: float

    def furnish(self, wall: Wall) -> None:
        """Cut a wall into bays and build each."""
        base = textures.wall_colour(self.rng, 0.0)
        place = 0.0
        while place < wall.length - 1e-6:
            left = wall.length - place
            width = float(self.rng.uniform(3.0, 4.4))
            kinds = ["shop", "shop", "shop", "door", "posters"]
            if left < 2.6:
                width, kinds = left, ["posters"] if left < 1.6 else ["door", "posters"]
            elif left < width + 1.2:
                width = left if left < 4.6 else left / 2
            kind = str(self.rng.choice(kinds))
            if kind != "shop":
                width = min(width, float(self.rng.uniform(1.7, 2.6))) if left - 2.6 > 0.8 else width
            bay = _Bay(self, wall, place, width, base)
            {"shop": bay.shop, "door": bay.door, "posters": bay.posters}[kind]()
            place += width
            self._stand_between(wall, place)

    def _stand_between(self, wall: Wall, place: float) -> None:
        """Something at the seam of two bays: a pilaster, a plant, a bin, or nothing."""
        if not 0.6 < place < wall.length - 0.6:
            return
        choice = self.rng.random()
        if choice < 0.4:
            furniture.stand_pilaster(self.rng, self.builder, wall, place, self.height)
        elif choice < 0.65:
            spot = wall.start + wall.right * place + wall.normal * float(self.rng.uniform(0.24, 0.32))
            furniture.stand_plant(self.rng, self.builder, np.array([spot[0], spot[1], 0.0]))
        elif choice < 0.8:
            furniture.stand_bin(self.rng, self.builder, wall, place)


@dataclass(slots=True)
class _Bay:
    """A stretch of wall, addressed by x metres to the right, z metres up and `out` metres into the corridor."""

    parent: WallBuilder
    wall: Wall
    place: float
    width: float
    base: textures.Colour

    def _at(self, x: float, z: float, out: float = 0.0) -> Vector:
        spot = self.wall.start + self.wall.right * (self.place + x) + self.wall.normal * out
        return np.array([spot[0], spot[1], z])

    @property
    def _right(self) -> Vector:
        return np.append(self.wall.right, 0.0)

    @property
    def _normal(self) -> Vector:
        return np.append(self.wall.normal, 0.0)

    def _panel(
        self,
        x0: float,
        x1: float,
        z0: float,
        z1: float,
        texture: int,
        *,
        out: float = 0.0,
        gloss: float = 0.0,
        emission: float = 0.0,
    ) -> None:
        corner = self._at(x0, z1, out)
        edges = self._right * (x1 - x0), -UP * (z1 - z0)
        self.parent.builder.add_face(corner, *edges, texture, gloss=gloss, emission=emission)

    def _skin(self, x0: float, x1: float, z0: float, z1: float, kind: str, base: textures.Colour) -> None:
        """A panel of wall with a picture of its own."""
        size = (max(4, round((z1 - z0) * WALL_SCALE)), max(4, round((x1 - x0) * WALL_SCALE)))
        picture = textures.wall(self.parent.rng, *size, WALL_SCALE, kind, base)
        if z0 == 0.0:
            foot = max(2, round(0.1 * WALL_SCALE))
            picture[-foot:] = (picture[-foot:] * 0.45).astype(np.uint8)
        self._panel(x0, x1, z0, z1, self.parent.builder.add_texture(picture))

    def _recess(
        self, x0: float, x1: float, z0: float, z1: float, depth: float, back: int, side: int, glow: float = 0.0
    ) -> None:
        """An opening in the wall with a back, two sides, a lid and a floor."""
        add = self.parent.builder.add_face
        inward = -self._normal * depth
        self._panel(x0, x1, z0, z1, back, out=-depth, emission=glow)
        add(self._at(x0, z1), inward, -UP * (z1 - z0), side)
        add(self._at(x1, z1) + inward, -inward, -UP * (z1 - z0), side)
        add(self._at(x0, z1), self._right * (x1 - x0), inward, side)
        # A recess at floor level gets a mat a little above the floor, which may or may not reach in here.
        add(self._at(x0, max(z0, 0.004)) + inward, self._right * (x1 - x0), -inward, side)

    def _material(self) -> tuple[str, textures.Colour]:
        kind = str(self.parent.rng.choice(["plaster", "panels", "brick", "tiles", "paper", "stone"]))
        if kind == "brick":
            return kind, (
                self.parent.rng.uniform(130, 180),
                self.parent.rng.uniform(70, 120),
                self.parent.rng.uniform(55, 100),
            )
        own = textures.wall_colour(self.parent.rng, 0.45)
        return kind, self.base if self.parent.rng.random() < 0.4 else own

    def shop(self) -> None:
        """A front with an entrance, a window with goods behind it, and a sign over both."""
        rng, build = self.parent.rng, self.parent.builder
        kind, base = self._material()
        rim = float(rng.uniform(0.15, 0.3))
        entrance = float(rng.uniform(1.0, 1.5))
        door_left = bool(rng.random() < 0.5)
        first = (rim, rim + entrance) if door_left else (self.width - rim - entrance, self.width - rim)
        pane = (first[1] + 0.2, self.width - rim) if door_left else (rim, first[0] - 0.2)
        top, sill = float(rng.uniform(1.95, 2.1)), float(rng.uniform(0.3, 0.6))
        side = build.add_colour(tuple(int(0.6 * value) for value in base))  # type: ignore[arg-type]
        glow = float(rng.choice([0.0, 0.55, 0.75]))
        # Inside the entrance: shelves at the back of a shallow room.
        room = displays.goods(rng, round(top * 130), round(entrance * 130), 130.0)
        self._recess(*first, 0.0, top, float(rng.uniform(0.6, 0.8)), build.add_texture(room), side, glow * 0.9)
        depth = float(rng.uniform(0.35, 0.6))
        scene = displays.goods(rng, round((top - sill) * 150), round((pane[1] - pane[0]) * 150), 150.0)
        self._recess(*pane, sill, top, depth, build.add_texture(scene), side, glow)
        self._display(pane, sill, depth)
        for left, right in ((0.0, min(first[0], pane[0])), _between(first, pane), (max(first[1], pane[1]), self.width)):
            self._skin(left, right, 0.0, top, kind, base)
        self._skin(*pane, 0.0, sill, kind, base)
        self._skin(0.0, self.width, top, self.parent.height, kind, base)
        self._fascia(top)
        if rng.random() < self.parent.projecting_share:
            self._projecting_sign(top, at=pane[1] if door_left else pane[0])

    def _display(self, pane: tuple[float, float], sill: float, depth: float) -> None:
        """Boxes and pedestals in the window, so that it has parallax."""
        rng, build = self.parent.rng, self.parent.builder
        place = pane[0] + 0.1
        while place < pane[1] - 0.4:
            size = float(rng.uniform(0.12, 0.32))
            tall = float(rng.uniform(0.15, 0.7))
            texture = build.add_texture(textures.poster(rng, round(tall * 200), round(size * 200)))
            out = -depth + float(rng.uniform(0.02, max(0.03, depth - size - 0.03)))
            corner = self._at(place + size, sill, out)
            build.add_box(corner, -self._right * size, self._normal * size * 0.8, tall, texture)
            place += size + float(rng.uniform(0.1, 0.5))
        # Stickers on the glass.
        for _ in range(int(rng.integers(0, 3))):
            w = float(rng.uniform(0.12, 0.3))
            x = float(rng.uniform(pane[0] + 0.03, max(pane[0] + 0.04, pane[1] - w - 0.03)))
            z = float(rng.uniform(sill + 0.1, sill + 1.0))
            picture = build.add_texture(textures.poster(rng, round(w * 260), round(w * 260)))
            self._panel(x, x + w, z, z + w, picture, out=-0.01, gloss=0.3)

    def _fascia(self, top: float) -> None:
        rng, painter = self.parent.rng, self.parent.painter
        space = self.parent.height - top - 0.1
        kind = "restaurant" if rng.random() < 0.38 else "shop"
        # Two lines with their margins are up to 3.6 letters high.
        letters = min(float(rng.uniform(0.2, 0.34)), space / 3.6)
        middle = self._at(self.width / 2, top)
        board, kind = painter.paint(kind, "shop", letters, min(2.5, self.width - 0.3), 300.0, middle)
        x = self.width / 2 + float(rng.uniform(-0.2, 0.2)) * (self.width - board.width) / 2
        z = top + 0.05 + board.height / 2 + max(0.0, space - board.height) * float(rng.uniform(0.0, 0.25))
        painter.hang(board, kind, self._at(x, z, 0.08), self._right, thickness=0.08, gloss=float(rng.choice([0, 0.5])))

    def _projecting_sign(self, top: float, at: float) -> None:
        """A small double-sided sign that stands out of the wall."""
        rng, painter = self.parent.rng, self.parent.painter
        kind = "slogan" if rng.random() < 0.5 else "facility"
        board, kind = painter.paint(kind, "friendly", 0.1, 0.75, 420.0, self._at(at, top))
        centre = self._at(at, top - 0.02 - board.height / 2, 0.26 + board.width / 2)
        painter.hang(board, kind, centre, self._normal, thickness=0.04, double_sided=True)
        iron = painter.builder.add_colour((40, 40, 42))
        corner = self._at(at - 0.01, centre[2] + board.height / 2, 0.0)
        painter.builder.add_box(corner, self._normal * (board.width + 0.26), self._right * 0.02, 0.02, iron)

    def door(self) -> None:
        """A door of a public facility with a plate beside or above it."""
        rng, build, painter = self.parent.rng, self.parent.builder, self.parent.painter
        kind, base = self._material()
        leaf = float(rng.uniform(0.85, 1.1))
        x0 = float(rng.uniform(0.2, max(0.21, self.width - leaf - 0.2)))
        x0 = min(x0, self.width - leaf - 0.05)
        colour = textures.pick_colour(rng, (0.05, 0.5), (0.3, 0.7))
        grain = textures.wood(rng, round(leaf * 150), round(DOOR_HEIGHT * 150))
        picture = np.swapaxes(grain, 0, 1).astype(np.float32)
        picture = 0.5 * picture + 0.5 * np.array(colour, np.float32)
        h, w = picture.shape[:2]
        for low, high in ((0.08, 0.45), (0.55, 0.92)):
            picture[int(low * h) : int(high * h), int(0.15 * w) : int(0.85 * w)] *= 0.86
        picture[int(0.48 * h) : int(0.52 * h), int(0.8 * w) : int(0.9 * w)] = 220
        side = build.add_colour((90, 88, 86))
        door_texture = build.add_texture(textures.to_image(picture))
        self._recess(x0, x0 + leaf, 0.0, DOOR_HEIGHT, 0.12, door_texture, side)
        self._skin(0.0, x0, 0.0, DOOR_HEIGHT, kind, base)
        self._skin(x0 + leaf, self.width, 0.0, DOOR_HEIGHT, kind, base)
        self._skin(0.0, self.width, DOOR_HEIGHT, self.parent.height, kind, base)
        letters, middle = float(rng.uniform(0.1, 0.16)), self._at(x0 + leaf / 2, DOOR_HEIGHT)
        board, sign_kind = painter.paint("facility", "plain", letters, self.width - 0.5, 420.0, middle)
        x = min(max(x0 + leaf / 2, board.width / 2 + 0.24), self.width - board.width / 2 - 0.24)
        painter.hang(
            board, sign_kind, self._at(x, DOOR_HEIGHT + 0.08 + board.height / 2, 0.03), self._right, thickness=0.03
        )
        room_right, room_left = self.width - (x0 + leaf), x0
        if max(room_right, room_left) > 0.75 and rng.random() < 0.75:
            span = max(room_right, room_left) - 0.12
            x = x0 + leaf + room_right / 2 if room_right > room_left else room_left / 2
            letters = float(rng.uniform(0.085, 0.12))
            board, sign_kind = painter.paint("warning", "plain", letters, span, 520.0, self._at(x, 1.5))
            centre = self._at(x, float(rng.uniform(1.45, 1.6)), 0.015)
            painter.hang(board, sign_kind, centre, self._right, thickness=0.015)

    def posters(self) -> None:
        """Plain wall with framed posters, a slogan, or a bench before it."""
        rng, build, painter = self.parent.rng, self.parent.builder, self.parent.painter
        kind, base = self._material()
        self._skin(0.0, self.width, 0.0, self.parent.height, kind, base)
        low = 1.0
        if self.width > 1.5 and rng.random() < 0.45:
            self._bench()
        if self.width > 1.2 and rng.random() < 0.7:
            sort = "slogan" if rng.random() < 0.7 else "warning"
            letters, middle = float(rng.uniform(0.12, 0.2)), self._at(self.width / 2, 1.95)
            board, sort = painter.paint(sort, "friendly", letters, self.width - 0.55, 380.0, middle)
            painter.hang(
                board, sort, self._at(self.width / 2, 1.95 + board.height / 2, 0.02), self._right, thickness=0.02
            )
        place = 0.12
        while place < self.width - 0.5:
            w, h = float(rng.uniform(0.4, 0.7)), float(rng.uniform(0.55, 0.85))
            if place + w > self.width - 0.08:
                break
            picture = build.add_texture(textures.poster(rng, round(h * 260), round(w * 260)))
            self._panel(place, place + w, low, low + h, picture, out=0.012, gloss=0.3)
            place += w + float(rng.uniform(0.1, 0.6))

    def _bench(self) -> None:
        rng, build = self.parent.rng, self.parent.builder
        wood = build.add_texture(textures.wood(rng, 60, 240))
        metal = build.add_colour((75, 78, 82))
        long = min(1.4, self.width - 0.3)
        x = (self.width - long) / 2
        build.add_box(self._at(x + long, 0.40, 0.06), -self._right * long, self._normal * 0.4, 0.05, wood, bottom=True)
        for leg in (x + 0.15, x + long - 0.1):
            build.add_box(self._at(leg + 0.05, 0.0, 0.1), -self._right * 0.05, self._normal * 0.32, 0.40, metal)


def _between(first: tuple[float, float], second: tuple[float, float]) -> tuple[float, float]:
    return min(first[1], second[1]), max(first[0], second[0])
