"""A street of shops: boards hung side by side on one wall, over windows and doors, among ornaments."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.config import SimulationConfig
from lpslam.errors import UserError
from lpslam.simulation import displays, furniture, lighting, textures
from lpslam.simulation.boards.labels import LabelledBoard
from lpslam.simulation.boards.ornaments import ORNAMENTS, Ornament, paint_ornament
from lpslam.simulation.boards.painting import paint_shop_board
from lpslam.simulation.layout import Layout, Wall
from lpslam.simulation.lettering import Board, PaintedLine
from lpslam.simulation.mall import Mall, SignPainter, Vocabulary, hang_ceiling, lay_floor
from lpslam.simulation.scene import NO_RETURN, SceneBuilder
from lpslam.simulation.signs import rounded
from lpslam.simulation.source import WalkSource
from lpslam.simulation.walk import FPS, STEP, Walk

Vector = NDArray[np.float64]
UP = np.array([0.0, 0.0, 1.0])
LENGTH = 12.4  # metres of shops: with the walk's pace 380 frames
BREADTH, HEIGHT = 6.0, 3.7  # metres between the walls, and up to the ceiling
END = 1.6  # metres of street before the first shop and after the last
AWAY = (2.3, 3.0)  # metres from the wall at which one walks
PACE = 1.0  # metres a second
EYE = (1.4, 1.55)  # metres above the floor
PITCH = math.radians(11.0)  # boards hang above the eyes
GLANCE = math.radians(16.0)  # by which the eyes swing ahead and back
LINTEL = 2.12  # metres: boards hang above, windows and doors end below
STACK_GAP = (0.03, 0.09)  # metres between the boards of two shops in one house
CLOSE = (0.04, 0.3)  # metres of wall between a board and the end of its shop: neighbours hang close together
WALL_SCALE = 150.0  # pixels a metre of plain walls
DEFAULT_WIDTH = 1.3  # metres of a board whose width nobody states


@dataclass(frozen=True, slots=True, eq=False)
class Distractor:
    """An ornament on the wall: its kind, and (4, 3) corners in metres, upper left first, clockwise."""

    kind: str
    corners: Vector


@dataclass(frozen=True, slots=True, eq=False)
class Street:
    """The world, its ornaments, and from where to where its shops reach along the wall, metres."""

    mall: Mall
    distractors: tuple[Distractor, ...]
    shops: tuple[float, float]


class StreetSource(WalkSource):
    """A `FrameSource` that walks past a street of shops.

    Args:
        seed: of shops, ornaments, walk and noise.
        boards: to be hung in this order, as many as fit; drawn from the seed without.
        options: light, shutter and noise.

    Raises:
        UserError: there are no boards.
    """

    def __init__(
        self, seed: int, boards: Sequence[LabelledBoard] | None = None, *, options: SimulationConfig | None = None
    ) -> None:
        if boards is None:
            boards = drawn_boards(seed)
        if not boards:
            raise UserError("simulation: no boards to hang; the folder's labels list no pictures")
        self.boards = tuple(boards[: len(streets_of(boards)[0])])
        street = build_street(seed, self.boards)
        self.distractors = street.distractors
        super().__init__(
            f"street-{seed}", seed, street.mall, pass_by(seed, street.shops), options or SimulationConfig()
        )


def drawn_boards(seed: int) -> list[LabelledBoard]:
    """So many boards of a seed as a street has room for."""
    boards: list[LabelledBoard] = []
    while len(streets_of(boards)) < 2:
        boards.append(paint_shop_board(seed, len(boards)))
    return boards[:-1]


def streets_of(boards: Sequence[LabelledBoard]) -> list[list[LabelledBoard]]:
    """Share boards out among streets, in order; a street has one at least."""
    streets: list[list[LabelledBoard]] = []
    left = 0.0
    for bay in bays_of(boards):
        need = max(map(width_of, bay)) + CLOSE[0] + CLOSE[1]
        if need > left or not streets:
            streets.append([])
            left = LENGTH
        streets[-1] += bay
        left -= need
    return streets


def bays_of(boards: Sequence[LabelledBoard]) -> list[list[LabelledBoard]]:
    """Put flat boards that follow each other one over the other, two shops of one house, as often as they fit.

    Every third bay is such a house: its boards hang a hand's breadth apart.
    """
    bays: list[list[LabelledBoard]] = []
    row = 0
    while row < len(boards):
        pair = list(boards[row : row + 2])
        fits = sum(map(_height_of, pair)) + STACK_GAP[1] <= HEIGHT - LINTEL - 0.15
        alike = len(pair) == 2 and min(map(width_of, pair)) > 0.5 * max(map(width_of, pair))
        is_house = len(bays) % 3 == 1 and fits and alike and all(_height_of(each) < width_of(each) for each in pair)
        bays.append(pair if is_house else pair[:1])
        row += len(bays[-1])
    return bays


def _height_of(board: LabelledBoard) -> float:
    return width_of(board) * float(board.image.shape[0] / board.image.shape[1])


def width_of(board: LabelledBoard) -> float:
    """Metres of a board along the wall, no taller than the wall has room for."""
    height, width = board.image.shape[:2]
    wanted = DEFAULT_WIDTH if board.width is None else board.width
    room = HEIGHT - LINTEL - 0.1 if width > height else 2.0
    return float(min(wanted, LENGTH / 2, room * width / height))


def write_distractors(folder: Path, distractors: Sequence[Distractor]) -> None:
    """Write `ornaments.json` beside a recording."""
    entries = [{"kind": each.kind, "corners": [rounded(corner, 4) for corner in each.corners]} for each in distractors]
    (folder / "ornaments.json").write_text(json.dumps({"ornaments": entries}, indent=1) + "\n", encoding="utf-8")


def read_distractors(folder: Path) -> list[Distractor]:
    """Read what `write_distractors` wrote; none where there is no such file."""
    path = folder / "ornaments.json"
    if not path.exists():
        return []
    entries: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["ornaments"]
    return [Distractor(str(each["kind"]), np.array(each["corners"], np.float64)) for each in entries]


def build_street(seed: int, boards: Sequence[LabelledBoard]) -> Street:
    """Build the wall with its shops, what is before and opposite it, and the light."""
    rng = np.random.default_rng([seed, 47])
    builder = SceneBuilder()
    painter = SignPainter(rng, builder, Vocabulary(rng, SimulationConfig()))
    wall = _ShopWall(rng, builder, painter)
    place = 0.0
    for bay in bays_of(boards):
        place = wall.shop(bay, place)
    low, high = np.array([-END, -BREADTH]), np.array([place + END, 0.0])
    for start, end in ((-END, 0.0), (place, place + END)):
        wall.plain(start, end, 0.0, HEIGHT)
    corridor = np.array([[[0.0, -BREADTH / 2], [place, -BREADTH / 2]]])
    around = (
        Wall(np.array([high[0], low[1]]), low),
        Wall(low, np.array([low[0], high[1]])),
        Wall(high, np.array([high[0], low[1]])),
    )
    layout = Layout(corridor[0], around, np.zeros((0, 2, 2)), np.array([low, high]), corridor)
    for each in around:
        _face_wall(rng, builder, each)
    lay_floor(rng, builder, layout)
    hang_ceiling(rng, builder, layout, HEIGHT)
    lamps = lighting.hang_lamps(rng, builder, layout, HEIGHT)
    scene = builder.build()
    lighting.bake(scene, lamps, HEIGHT)
    mall = Mall(scene, layout, tuple(painter.signs), polish=float(rng.uniform(0.05, 0.25)))
    return Street(mall, tuple(wall.distractors), (0.0, place))


def _face_wall(rng: np.random.Generator, builder: SceneBuilder, wall: Wall) -> None:
    size = (round(HEIGHT * 100), round(wall.length * 100))
    texture = builder.add_texture(textures.wall(rng, *size, 100.0, "panels", textures.wall_colour(rng, 0.3)))
    corner, along = np.append(wall.start, HEIGHT), np.append(wall.right, 0.0) * wall.length
    builder.add_face(corner, along, -UP * HEIGHT, texture)


@dataclass(slots=True)
class _ShopWall:
    """The wall at y = 0, seen from y < 0; x to the right, z up, metres."""

    rng: np.random.Generator
    builder: SceneBuilder
    painter: SignPainter
    distractors: list[Distractor] = field(default_factory=list)

    def shop(self, boards: Sequence[LabelledBoard], start: float) -> float:
        """Build one house with its board or boards from x = `start` on; returns where it ends."""
        rng, width = self.rng, max(map(width_of, boards))
        heights = [_height_of(board) for board in boards]
        gap = float(rng.uniform(*STACK_GAP))
        height = sum(heights) + gap * (len(boards) - 1)
        side = float(rng.uniform(*CLOSE))
        end = start + width + 2 * side
        is_tall = height > width and len(boards) == 1
        if not is_tall:
            self._front(start, end)
        self.plain(start, end, 0.0 if is_tall else LINTEL, HEIGHT)
        low = LINTEL + 0.05 + float(rng.uniform(0.0, 0.6)) * max(0.0, HEIGHT - LINTEL - height - 0.45)
        if is_tall:
            low = float(rng.uniform(1.0, max(1.01, 3.1 - height)))
        foot = low
        for board, tall in zip(reversed(boards), reversed(heights), strict=True):
            own = width_of(board)
            self._hang(board, start + side + (width - own) * float(rng.uniform(0, 1)), foot, own, tall)
            foot += tall + gap
        self._decorate(start, end, low, low + height, is_tall)
        if rng.random() < 0.25:
            along = Wall(np.array([-END, 0.0]), np.array([end + END, 0.0]))
            furniture.stand_pilaster(rng, self.builder, along, end + END, LINTEL)
        return end

    def plain(self, left: float, right: float, low: float, high: float) -> None:
        """A stretch of plain wall."""
        kind = str(self.rng.choice(["plaster", "panels", "tiles", "stone", "brick"]))
        base = (150.0, 92.0, 74.0) if kind == "brick" else textures.wall_colour(self.rng, 0.4)
        size = (max(4, round((high - low) * WALL_SCALE)), max(4, round((right - left) * WALL_SCALE)))
        self._panel(left, right, low, high, textures.wall(self.rng, *size, WALL_SCALE, kind, base))

    def _panel(
        self, left: float, right: float, low: float, high: float, picture: NDArray[np.uint8], out: float = 0.0
    ) -> None:
        corner = np.array([left, -out, high])
        texture = self.builder.add_texture(picture)
        self.builder.add_face(corner, np.array([right - left, 0.0, 0.0]), -UP * (high - low), texture)

    def _front(self, start: float, end: float) -> None:
        """A window with goods behind it and a shutter, blind or grille before it now and then, over a sill."""
        rng, sill, depth = self.rng, float(self.rng.uniform(0.35, 0.6)), float(self.rng.uniform(0.35, 0.6))
        left, right = start + 0.12, end - 0.12
        for x0, x1, z0, z1 in ((start, left, 0.0, LINTEL), (right, end, 0.0, LINTEL), (left, right, 0.0, sill)):
            self.plain(x0, x1, z0, z1)
        side = self.builder.add_colour((88, 82, 76))
        inward, drop = np.array([0.0, depth, 0.0]), -UP * (LINTEL - sill)
        add = self.builder.add_face
        add(np.array([left, 0.0, LINTEL]), inward, drop, side)
        add(np.array([right, depth, LINTEL]), -inward, drop, side)
        add(np.array([left, 0.0, LINTEL]), np.array([right - left, 0.0, 0.0]), inward, side)
        add(np.array([left, depth, sill]), np.array([right - left, 0.0, 0.0]), -inward, side)
        if rng.random() < 0.3:
            kind: Ornament = ("blinds", "grille", "railing", "shelves")[int(rng.integers(4))]
            self._ornament(kind, left, right, sill, LINTEL, out=-0.05)
            return
        goods = displays.goods(rng, round((LINTEL - sill) * WALL_SCALE), round((right - left) * WALL_SCALE), WALL_SCALE)
        self._panel(left, right, sill, LINTEL, goods, out=-depth)
        place = left + 0.1
        while place < right - 0.4:
            wide, tall = float(rng.uniform(0.12, 0.3)), float(rng.uniform(0.2, 0.8))
            texture = self.builder.add_texture(textures.poster(rng, round(tall * 200), round(wide * 200)))
            corner = np.array([place + wide, depth - 0.03, sill])
            self.builder.add_box(corner, np.array([-wide, 0, 0]), np.array([0, -wide * 0.7, 0]), tall, texture)
            place += wide + float(rng.uniform(0.1, 0.5))

    def _hang(self, board: LabelledBoard, left: float, low: float, width: float, height: float) -> None:
        rows, columns = board.image.shape[:2]
        metres = width / columns
        lines = []
        for line in board.lines:
            x0, y0, x1, y1 = line.box or (0.0, 0.0, float(columns), float(rows))
            letter = line.letter_height or (y1 - y0) / (1 if line.box else len(board.lines) + 1)
            spot = (x0 * metres, y0 * metres, x1 * metres, y1 * metres)
            lines.append(PaintedLine(line.text, *spot, letter * metres, role=line.role))
        painted = Board(board.image, width, height, tuple(lines))
        out = float(self.rng.uniform(0.03, 0.12))
        centre = np.array([left + width / 2, -out, low + height / 2])
        if not lines:
            self._panel(left, left + width, low, low + height, board.image, out=out)
            return
        self.painter.hang(
            painted, "shop", centre, np.array([1.0, 0.0, 0.0]), thickness=out,
            gloss=0.0 if board.has_depth else NO_RETURN,
            emission=float(self.rng.uniform(0.95, 1.15)) if board.glows else 0.0,
            features={**board.features, "depth": "yes" if board.has_depth else "no", "file": board.name},
        )  # fmt: skip

    def _decorate(self, start: float, end: float, low: float, high: float, is_tall: bool) -> None:
        """Hang ornaments over the board, under it, and at the seam to the next shop."""
        rng = self.rng
        if HEIGHT - high > 0.3 and rng.random() < 0.6:
            tall = float(rng.uniform(0.16, 0.28))
            foot = high + float(rng.uniform(0.04, max(0.05, HEIGHT - high - tall - 0.05))) * 0.5
            self._ornament(self._any(), start + 0.02, end - 0.02, foot, foot + tall)
        if not is_tall and low - LINTEL > 0.22 and rng.random() < 0.6:
            self._ornament(self._any(), start + 0.02, end - 0.02, LINTEL + 0.02, low - 0.03)
        if rng.random() < 0.35:
            foot = float(rng.uniform(1.0, 1.7))
            self._ornament(self._any(), end - 0.2, end + 0.2, foot, foot + float(rng.uniform(0.3, 0.7)), out=0.05)

    def _any(self) -> Ornament:
        return ORNAMENTS[int(self.rng.integers(len(ORNAMENTS)))]

    def _ornament(self, kind: Ornament, left: float, right: float, low: float, high: float, out: float = 0.015) -> None:
        self._panel(left, right, low, high, paint_ornament(self.rng, kind, high - low, right - left), out=out)
        spots = ((left, high), (right, high), (right, low), (left, low))
        self.distractors.append(Distractor(kind, np.array([[x, -out, z] for x, z in spots])))


def pass_by(seed: int, shops: tuple[float, float]) -> Walk:
    """Walk along the wall, eyes on the boards, swinging a little ahead and back."""
    rng = np.random.default_rng([seed, 53])
    start, end = shops[0] + 0.3, shops[1] - 0.7
    frames = max(60, math.ceil((end - start) / PACE * FPS))
    times = np.arange(math.ceil((frames / FPS + 1.0) / STEP) + 2) * STEP
    x = start + (end - start) * np.clip((times - 0.05) / (frames / FPS), -0.05, 1.1)
    x = x + 0.12 * np.sin(times * rng.uniform(0.5, 0.9) + rng.uniform(0, 6))
    away = rng.uniform(*AWAY) + 0.2 * np.sin(times * rng.uniform(0.3, 0.5) + rng.uniform(0, 6))
    steps = rng.uniform(1.7, 1.95) * 2 * np.pi
    z = rng.uniform(*EYE) + rng.uniform(0.01, 0.018) * np.sin(steps * times)
    heading = math.pi / 2 + GLANCE * np.sin(times * rng.uniform(0.9, 1.3) + rng.uniform(0, 6))
    heading = heading - math.radians(5.0) + 0.004 * np.sin(steps / 2 * times)
    pitch = PITCH + math.radians(2.0) * np.sin(times * rng.uniform(0.6, 0.9)) + 0.004 * np.sin(steps * times + 0.7)
    roll = 0.01 * np.sin(steps / 2 * times)
    positions = np.column_stack([x, -away, z])
    return Walk(np.asarray(times, np.float64), positions, np.column_stack([heading, pitch, roll]), frames)
