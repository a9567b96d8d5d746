"""Paints a shop's board from a seed: its words set by role, finished in one kind of lettering, then aged."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.simulation.boards.ageing import AGEINGS, Ageing, age
from lpslam.simulation.boards.fields import colour
from lpslam.simulation.boards.finishes import (
    GLOWING,
    LETTERINGS,
    NO_DEPTH,
    NO_DEPTH_SHARE,
    Lettering,
    Look,
    draw_look,
    finish,
    lay_ground,
)
from lpslam.simulation.boards.labels import LabelledBoard, LabelledLine
from lpslam.simulation.boards.strokes import Course, Mask, covers, draw_words
from lpslam.simulation.boards.wording import SCRIPTS, Saying, Script, compose
from lpslam.simulation.lettering import CHINESE_FONTS, LATIN_FONTS, is_chinese
from lpslam.simulation.textures import to_image

SCALE = 340.0  # pixels a metre of pictures: about two image pixels at 3 m, so that a near look is still sharp
NEW_SHARE = 0.25  # of the boards that show no age
TWICE_SHARE = 0.45  # of the aged ones that show two kinds of it
SIZES = {"primary": (0.17, 0.28), "secondary": (0.085, 0.13), "contact": (0.065, 0.1), "list": (0.06, 0.09)}
"""Metres that letters are high, by role."""
RIM = 0.1 * SCALE  # pixels at least between ink and the board's edge: more than its frame takes
MAX_WIDTH, MAX_TALL = 1.9, 1.9  # metres of a board along the wall, and of a column
_FONTS: dict[Lettering, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "brush": (("chinese-brush", "chinese-kai-bold"), ("latin-script-brush", "latin-script-fat")),
    "neon": (("chinese-hei-bold", "chinese-hand"), ("latin-round-bold", "latin-script-bold", "latin-sans-bold")),
    "led": (("chinese-hei-bold",), ("latin-square-bold", "latin-grotesque-bold")),
    "hand": (("chinese-hand", "chinese-kai-bold"), ("latin-comic-bold", "latin-script-light", "latin-script-fat")),
    "gold": (
        ("chinese-brush", "chinese-kai-bold", "chinese-song-bold"),
        ("latin-serif-bold", "latin-serif", "latin-script-bold"),
    ),
}


@dataclass(frozen=True, slots=True, eq=False)
class _Set:
    """One line of type: its strokes and how high its letters are in pixels."""

    saying: Saying
    mask: Mask
    height: float


@dataclass(frozen=True, slots=True, eq=False)
class _Laid:
    """A line in its place: pixels of the upper left corner of its mask."""

    line: _Set
    left: float
    top: float


def paint_shop_board(seed: int, number: int, *, letterings: tuple[Lettering, ...] = LETTERINGS) -> LabelledBoard:
    """Paint one board.

    Args:
        seed: of the street; streets of other seeds have other names.
        number: of the board in the street: each takes the next kind of lettering.
        letterings: kinds to take in turn.
    """
    rng = np.random.default_rng([seed, 41, number])
    order = np.random.default_rng([seed, 43]).permutation(len(letterings))
    lettering = letterings[int(order[number % len(letterings)])]
    script: Script = SCRIPTS[int(rng.integers(len(SCRIPTS)))]
    if lettering == "vertical":
        script = "traditional" if rng.random() < 0.5 else "simplified"
    sayings = compose(rng, script)
    look = draw_look(rng, lettering)
    lines = [_set(rng, saying, look) for saying in sayings]
    laid, width, height = _in_columns(rng, lines) if lettering == "vertical" else _in_rows(rng, lines)
    picture = lay_ground(rng, look, height, width, SCALE)
    labelled = []
    for each in laid:
        mask = _on_board(each, height, width)
        chinese = is_chinese(each.line.saying.text)
        finish(rng, picture, mask, look, each.line.height, chinese=chinese, main=each.line.saying.role == "primary")
        labelled.append(_labelled(each.line, mask))
    _frame(rng, picture, look)
    # What shines by itself does not bleach.
    ages = [kind for kind in AGEINGS if not (kind == "faded" and lettering in GLOWING)]
    ageing = () if rng.random() < NEW_SHARE else _ages(rng, ages)
    for kind in ageing:
        picture = age(rng, np.clip(picture, 0, 255), kind, SCALE)
    return LabelledBoard(
        name=f"{seed:04d}-{number:02d}-{lettering}.png",
        image=to_image(picture),
        lines=tuple(labelled),
        width=width / SCALE,
        has_depth=lettering not in NO_DEPTH or rng.random() >= NO_DEPTH_SHARE,
        glows=lettering in GLOWING,
        features={"lettering": lettering, "ageing": "+".join(ageing) or "new", "script": script},
    )


def _ages(rng: np.random.Generator, kinds: list[Ageing]) -> tuple[Ageing, ...]:
    """One kind of age, or two."""
    picked = rng.permutation(len(kinds))[: 1 if rng.random() < 1 - TWICE_SHARE else 2]
    return tuple(kinds[i] for i in sorted(picked.tolist()))


def _font(rng: np.random.Generator, text: str, lettering: Lettering, main: bool) -> str:
    chinese, latin = (CHINESE_FONTS["shop"], LATIN_FONTS["shop"])
    if main or lettering in ("led", "neon", "hand"):
        chinese, latin = _FONTS.get(lettering, (chinese, latin))
    elif not main:
        chinese, latin = CHINESE_FONTS["plain"], LATIN_FONTS["plain"]
    if is_chinese(text):
        usable = [name for name in chinese if covers(name, text)] or ["chinese-kai-bold"]
        return usable[0] if lettering == "brush" else str(rng.choice(usable))
    # Script letters in capitals only are unreadable, also for people.
    usable = [name for name in latin if "script" not in name or not text.isupper()]
    return str(rng.choice(usable or ["latin-comic-bold"]))


def _set(rng: np.random.Generator, saying: Saying, look: Look) -> _Set:
    main = saying.role == "primary"
    text = saying.text
    height = float(rng.uniform(*SIZES[saying.role])) * SCALE
    if look.lettering == "vertical" and not main:
        height *= 1.3  # beside a column there is room
    if look.lettering == "led" and not main:
        height *= 1.25  # a matrix has no finer lamps
    course: Course = "line"
    if main and look.lettering == "curved":
        course = "arc"
    if look.lettering == "vertical" and is_chinese(text) and saying.role != "contact":
        course = "column"
    font = _font(rng, text, look.lettering, main)
    mask = draw_words(rng, text, font, height, course, look.hand)
    limit = MAX_TALL * SCALE if course == "column" else MAX_WIDTH * SCALE * (0.86 if main else 0.7)
    extent = mask.shape[0] if course == "column" else mask.shape[1]
    if extent > limit:
        height *= limit / extent
        mask = draw_words(rng, text, font, height, course, look.hand)
    return _Set(saying, mask, height)


def _in_rows(rng: np.random.Generator, lines: list[_Set]) -> tuple[list[_Laid], int, int]:
    """The name across the board, a motto over or under it, how to reach the shop at the foot, goods on the right."""
    main, others = lines[0], lines[1:]
    goods = [line for line in others if line.saying.role == "list"]
    mottoes = [line for line in others if line.saying.role == "secondary"]
    above = mottoes[:1] if mottoes and rng.random() < 0.3 else []
    below = [line for line in mottoes if line not in above]
    foot = [line for line in others if line.saying.role == "contact"]
    rows = [*above, main, *below, *foot]
    gap = 0.34 * main.height
    small = 0.16 * main.height + 6
    margin = max(RIM, main.height * float(rng.uniform(0.35, 0.6)))
    wide = max(line.mask.shape[1] for line in rows)
    tall = sum(line.mask.shape[0] for line in rows) + gap + small * max(0, len(rows) - 2)
    side = max((line.mask.shape[1] for line in goods), default=0)
    height = tall + 2 * margin
    stack = sum(line.mask.shape[0] for line in goods) + small * 1.2 * max(0, len(goods) - 1)
    height = max(height, stack + margin)
    width = wide + 2 * margin + (side + margin if goods else 0)
    laid, top = [], (height - tall) / 2 + (0 if len(rows) > 1 else gap / 2)
    for number, line in enumerate(rows):
        laid.append(_Laid(line, margin + (wide - line.mask.shape[1]) / 2, top))
        next_is_main = number + 1 < len(rows) and (rows[number + 1] is main or line is main)
        top += line.mask.shape[0] + (gap if next_is_main else small)
    top = (height - stack) / 2
    for line in goods:
        laid.append(_Laid(line, wide + 2 * margin, top))
        top += line.mask.shape[0] + 1.2 * small
    # The name comes first among the lines, wherever it stands.
    laid.sort(key=lambda each: each.line is not main)
    return laid, math.ceil(width), math.ceil(height)


def _in_columns(rng: np.random.Generator, lines: list[_Set]) -> tuple[list[_Laid], int, int]:
    """The name down the middle, other lines in columns to its left, how to reach the shop across the foot."""
    feet = [line for line in lines if line.saying.role == "contact" and line.mask.shape[1] > line.mask.shape[0]]
    columns = [line for line in lines if line not in feet]
    main = columns[0]
    margin = max(RIM, main.height * float(rng.uniform(0.3, 0.5)))
    gap = 0.35 * main.height
    wide = sum(line.mask.shape[1] for line in columns) + gap * (len(columns) - 1)
    wide = max(wide, max((line.mask.shape[1] for line in feet), default=0))
    tall = max(line.mask.shape[0] for line in columns)
    height = 2 * margin + tall + sum(line.mask.shape[0] + 0.3 * gap + 4 for line in feet)
    width = 2 * margin + wide
    laid, right = [], width - margin
    for line in columns:
        laid.append(_Laid(line, right - line.mask.shape[1], margin + 0.15 * (tall - line.mask.shape[0])))
        right -= line.mask.shape[1] + gap
    top = margin + tall + 0.3 * gap + 4
    for line in feet:
        laid.append(_Laid(line, (width - line.mask.shape[1]) / 2, top))
        top += line.mask.shape[0] + 0.3 * gap + 4
    return laid, math.ceil(width), math.ceil(height)


def _on_board(each: _Laid, height: int, width: int) -> Mask:
    board = np.zeros((height, width), np.float32)
    rows, columns = each.line.mask.shape
    top = int(np.clip(round(each.top), 0, max(0, height - rows)))
    left = int(np.clip(round(each.left), 0, max(0, width - columns)))
    part = each.line.mask[: height - top, : width - left]
    board[top : top + part.shape[0], left : left + part.shape[1]] = part
    return board


def _labelled(line: _Set, mask: NDArray[np.float32]) -> LabelledLine:
    rows, columns = np.flatnonzero(mask.max(axis=1) > 0.1), np.flatnonzero(mask.max(axis=0) > 0.1)
    box = (float(columns[0]), float(rows[0]), float(columns[-1] + 1), float(rows[-1] + 1))
    return LabelledLine(line.saying.text, line.saying.role, box, line.height)


def _frame(rng: np.random.Generator, picture: NDArray[np.float32], look: Look) -> None:
    """A rim of metal, a line of the accent's colour, or the board's bare edge."""
    height, width = picture.shape[:2]
    thick = max(2, round(0.02 * SCALE * rng.uniform(0.6, 1.4)))
    way = rng.random()
    inset = 0 if way < 0.5 else round(1.6 * thick)
    if way > 0.8 or look.lettering == "led":
        return
    rim = colour((74.0, 74.0, 78.0)) if way < 0.5 else 0.9 * colour(look.accent)
    for part in (
        np.s_[inset : inset + thick, inset : width - inset],
        np.s_[height - inset - thick : height - inset, inset : width - inset],
        np.s_[inset : height - inset, inset : inset + thick],
        np.s_[inset : height - inset, width - inset - thick : width - inset],
    ):
        picture[part] = rim * rng.uniform(0.9, 1.1)
