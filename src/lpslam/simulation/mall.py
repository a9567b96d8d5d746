"""Builds the mall: the floor plan's walls become shop fronts, doors and poster walls, with signs on them."""

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from lpslam.config import SimulationConfig
from lpslam.simulation import lexicon, lighting, textures
from lpslam.simulation.fronts import WallBuilder
from lpslam.simulation.layout import Layout, Wall, plan
from lpslam.simulation.lettering import Board, paint_board
from lpslam.simulation.lexicon import Wording
from lpslam.simulation.scene import Scene, SceneBuilder
from lpslam.simulation.signs import Sign, SignLine

FLOOR_CELL = 4.0  # metres; only cells that a corridor touches get a texture
REPEATED_KINDS = ("shop", "restaurant", "facility")  # that a mall has more than one of
DUPLICATE_SLACK = 0.25  # share by which a duplicate may hang nearer or farther than was asked for


@dataclass(frozen=True, slots=True, eq=False)
class Mall:
    """A world: what is drawn, how one may walk through it, what can be read, how its floor mirrors (0 to 0.4)."""

    scene: Scene
    layout: Layout
    signs: tuple[Sign, ...]
    polish: float


@dataclass(frozen=True, slots=True, eq=False)
class _Dealt:
    """What one sign says: the lines to paint, the most prominent first, and chance as it was before it was painted."""

    wording: Wording
    lines: tuple[str, ...]
    place: NDArray[np.float64]
    look: np.random.Generator


@dataclass(slots=True)
class Vocabulary:
    """Deals wordings so that none comes twice before duplicates are asked for."""

    rng: np.random.Generator
    options: SimulationConfig
    _piles: dict[str, list[Wording]] = field(default_factory=dict)
    _dealt: list[Wording] = field(default_factory=list)
    _repeatable: list[_Dealt] = field(default_factory=list)
    _distances: list[float] = field(init=False)

    def __post_init__(self) -> None:
        self._distances = list(self.options.duplicate_distances)

    def deal(self, kind: str, place: NDArray[np.float64]) -> _Dealt:
        """Say what a sign of a kind at a place (3,) metres shows: something new, unless it is due to repeat another."""
        if (twin := self._twin(kind, place)) is not None:
            return _Dealt(twin.wording, twin.lines, place, deepcopy(twin.look))
        wording = self._next(kind)
        lines = self._lines(wording)
        if not self._distances:
            return _Dealt(wording, lines, place, self.rng)
        self._repeatable.append(_Dealt(wording, lines, place, deepcopy(self.rng)))
        return _Dealt(wording, lines, place, self.rng)

    def _twin(self, kind: str, place: NDArray[np.float64]) -> _Dealt | None:
        """A sign of that kind that hangs about as far from here as some duplicate should."""
        if kind not in REPEATED_KINDS:
            return None
        for wanted in self._distances:
            for other in self._repeatable:
                off = abs(float(np.linalg.norm(other.place - place)) - wanted)
                if other.wording.kind == kind and off <= DUPLICATE_SLACK * wanted:
                    self._distances.remove(wanted)
                    self._repeatable.remove(other)
                    return other
        return None

    def _lines(self, wording: Wording) -> tuple[str, ...]:
        lines = wording.lines(self.options.language)
        if len(lines) == 2:
            choice = self.rng.random()
            lines = (
                lines[:1] if choice < 0.3 else lines[1:] if choice < 0.5 else lines[::-1] if choice < 0.75 else lines
            )
        return lines

    def _next(self, kind: str) -> Wording:
        same = [wording for wording in self._dealt if wording.kind == kind]
        repeated = len(self._dealt) - len({id(wording) for wording in self._dealt})
        if same and repeated < self.options.duplicates and self.rng.random() < 0.5:
            wording = same[int(self.rng.integers(len(same)))]
        else:
            if not self._piles:
                self._stack()
            # A large mall has more doors than there are facilities: then take what is left of anything.
            pile = self._piles.get(kind) or max(self._piles.values(), key=len)
            wording = pile.pop()
            self._piles = {sort: rest for sort, rest in self._piles.items() if rest}
        self._dealt.append(wording)
        return wording

    def _stack(self) -> None:
        """Shuffle all wordings into piles by kind."""
        similar = lexicon.SIMILAR if self.options.similar_names else ()
        taken = {text for wording in similar for text in (wording.english, wording.chinese) if text}
        plain = [w for w in lexicon.EVERYTHING if not taken & {w.english, w.chinese}]
        usable = [w for w in (*plain, *similar) if w.lines(self.options.language)]
        # Piles are dealt from the end: what is featured comes before anything else of its kind.
        featured = set(self.options.featured) | taken
        order = self.rng.permutation(len(usable))
        for i in sorted(order, key=lambda i: bool(featured & {usable[i].english, usable[i].chinese})):
            self._piles.setdefault(usable[i].kind, []).append(usable[i])


@dataclass(slots=True)
class SignPainter:
    """Paints boards, hangs them into the scene and keeps their ground truth."""

    rng: np.random.Generator
    builder: SceneBuilder
    vocabulary: Vocabulary
    signs: list[Sign] = field(default_factory=list)

    def paint(
        self,
        kind: str,
        style: str,
        letter_height: float,
        max_width: float,
        resolution: float,
        place: NDArray[np.float64],
    ) -> tuple[Board, str]:
        """Paint the next wording of a kind, to hang near `place` (3,); metres, resolution in pixels a metre."""
        dealt = self.vocabulary.deal(kind, place)
        board = paint_board(dealt.look, dealt.lines, kind, style, letter_height, max_width, resolution)
        return board, dealt.wording.kind

    def hang(
        self,
        board: Board,
        kind: str,
        centre: NDArray[np.float64],
        right: NDArray[np.float64],
        *,
        thickness: float,
        double_sided: bool = False,
        gloss: float = 0.0,
        emission: float = 0.0,
        features: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        """Hang a board upright with its face's middle at `centre`; `right` is the reader's right (unit, horizontal)."""
        up = np.array([0.0, 0.0, 1.0])
        normal = np.cross(right, up)
        corner = centre - right * board.width / 2 + up * board.height / 2
        texture = self.builder.add_texture(board.image)
        face = self.builder.add_face(
            corner, right * board.width, -up * board.height, texture, gloss=gloss, emission=emission
        )
        far = corner + right * board.width - normal * thickness
        back = texture if double_sided else self.builder.add_colour((60, 60, 60))
        self.builder.add_face(far, -right * board.width, -up * board.height, back, gloss=gloss)
        rim = self.builder.add_colour((90, 90, 92))
        self.builder.add_face(corner - normal * thickness, normal * thickness, -up * board.height, rim)
        self.builder.add_face(corner + right * board.width, -normal * thickness, -up * board.height, rim)
        self.builder.add_face(corner - normal * thickness, right * board.width, normal * thickness, rim)
        low = corner - up * board.height
        self.builder.add_face(low, right * board.width, -normal * thickness, rim)
        lines = tuple(
            SignLine(
                line.text,
                _corners(corner, right, line.left, line.top, line.right, line.bottom),
                line.letter_height,
                role=line.role,
            )
            for line in board.lines
        )
        ink = [min(line.left for line in board.lines), min(line.top for line in board.lines)]
        ink += [max(line.right for line in board.lines), max(line.bottom for line in board.lines)]
        texts = [line.text for line in board.lines]
        others = texts[1:] + ([" ".join(texts), " ".join(texts[::-1])] if len(texts) > 1 else [])
        self.signs.append(
            Sign(
                id=len(self.signs),
                aliases=tuple(others),
                kind=kind,
                normal=normal,
                corners=_corners(corner, right, *ink),
                lines=lines,
                thickness=thickness,
                double_sided=double_sided,
                face=face,
                features=dict(features),
            )
        )


def _corners(
    origin: NDArray[np.float64], along: NDArray[np.float64], left: float, top: float, right: float, bottom: float
) -> NDArray[np.float64]:
    """(4, 3) of a box on an upright board with its upper left corner at `origin`: upper left first, clockwise."""
    up = np.array([0.0, 0.0, 1.0])
    spots = ((left, top), (right, top), (right, bottom), (left, bottom))
    return np.array([origin + along * x - up * y for x, y in spots])


def build_mall(seed: int, options: SimulationConfig) -> Mall:
    """Build the world of a seed: plan, floor, ceiling, walls, furniture, signs, light."""
    rng = np.random.default_rng([seed, 7])
    layout = plan(rng, options.layout, options.loop_length)
    builder = SceneBuilder()
    painter = SignPainter(rng, builder, Vocabulary(rng, options))
    height = float(rng.uniform(2.9, 3.2))
    lay_floor(rng, builder, layout)
    hang_ceiling(rng, builder, layout, height)
    lamps = lighting.hang_lamps(rng, builder, layout, height)
    front = WallBuilder(rng, builder, painter, height, options.projecting_share)
    for wall in sorted(layout.walls, key=lambda each: -each.length):
        front.furnish(wall)
    _hang_overhead_signs(rng, painter, layout, height)
    scene = builder.build()
    lighting.bake(scene, lamps, height)
    return Mall(scene, layout, tuple(painter.signs), polish=float(rng.uniform(0.05, 0.4)))


def lay_floor(rng: np.random.Generator, builder: SceneBuilder, layout: Layout) -> None:
    """Cut one large worn floor into cells and lay those that a corridor touches."""
    (x0, y0), (x1, y1) = layout.outline
    scale = min(200.0, float(np.sqrt(24e6 / ((x1 - x0) * (y1 - y0)))))
    picture = textures.floor(rng, round((y1 - y0) * scale), round((x1 - x0) * scale), scale)
    for low_y in np.arange(y0, y1, FLOOR_CELL):
        for low_x in np.arange(x0, x1, FLOOR_CELL):
            high_x, high_y = min(low_x + FLOOR_CELL, x1), min(low_y + FLOOR_CELL, y1)
            if any(
                b[0, 0] < low_x and b[0, 1] < low_y and b[1, 0] > high_x and b[1, 1] > high_y for b in layout.blocks
            ):
                continue
            rows = slice(round((y1 - high_y) * scale), max(round((y1 - low_y) * scale), 1))
            columns = slice(round((low_x - x0) * scale), max(round((high_x - x0) * scale), 1))
            cut = picture[rows, columns]
            if cut.size == 0:
                continue
            texture = builder.add_texture(cut)
            edge_u, edge_v = np.array([high_x - low_x, 0.0, 0.0]), np.array([0.0, low_y - high_y, 0.0])
            builder.add_face(np.array([low_x, high_y, 0.0]), edge_u, edge_v, texture, gloss=0.15)


def hang_ceiling(rng: np.random.Generator, builder: SceneBuilder, layout: Layout, height: float) -> None:
    """One ceiling over all, `height` metres up."""
    (x0, y0), (x1, y1) = layout.outline
    texture = builder.add_texture(textures.ceiling(rng, 150.0))
    repeat = ((x1 - x0) / 2.4, (y1 - y0) / 2.4)
    edge_u, edge_v = np.array([x1 - x0, 0.0, 0.0]), np.array([0.0, y1 - y0, 0.0])
    builder.add_face(np.array([x0, y0, height]), edge_u, edge_v, texture, repeat=repeat)


def _hang_overhead_signs(rng: np.random.Generator, painter: SignPainter, layout: Layout, height: float) -> None:
    """One double-sided facility sign across each longer corridor, under the ceiling."""
    for start, end in layout.corridors:
        span = float(np.linalg.norm(end - start))
        if span < 6.0:
            continue
        along = (end - start) / span
        kind = "facility" if rng.random() < 0.8 else "slogan"
        letters, middle = float(rng.uniform(0.14, 0.2)), np.append((start + end) / 2, 2.25)
        board, kind = painter.paint(kind, "plain", letters, 1.9, 320.0, middle)
        place = start + along * span * rng.uniform(0.4, 0.6)
        centre = np.array([place[0], place[1], min(2.25 + board.height / 2, height - 0.1 - board.height / 2)])
        right = np.array([-along[1], along[0], 0.0])
        painter.hang(board, kind, centre, right, thickness=0.06, double_sided=True)
        rod = painter.builder.add_colour((50, 50, 52))
        for side in (-0.4, 0.4):
            foot = centre + right * board.width * side - np.array([along[0], along[1], 0.0]) * 0.03
            foot[2] = centre[2] + board.height / 2
            ahead = np.array([along[0], along[1], 0.0]) * 0.02
            painter.builder.add_box(foot, ahead, right * 0.02, height - foot[2], rod)


__all__ = ["Mall", "SignPainter", "Wall", "build_mall", "hang_ceiling", "lay_floor"]
