"""What letters are made of: paint, neon, lamps, metal, gold leaf, lit acrylic; each on the ground that goes with it."""

from dataclasses import dataclass
from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.simulation import textures
from lpslam.simulation.boards.fields import grain, slopes, soft
from lpslam.simulation.boards.strokes import STEADY, Hand, Mask, brushed, dots, tubes

Picture = NDArray[np.float32]
Lettering = Literal[
    "painted", "brush", "neon", "led", "embossed", "curved", "hand", "gold", "backlit", "outlined", "vertical"
]
LETTERINGS: tuple[Lettering, ...] = get_args(Lettering)
NO_DEPTH: frozenset[Lettering] = frozenset({"neon", "led", "backlit"})
"""What stands on dark glass or shines: depth sensors get nothing back from it in `NO_DEPTH_SHARE` of the boards."""
NO_DEPTH_SHARE = 0.5
GLOWING: frozenset[Lettering] = frozenset({"neon", "led", "backlit"})
BURNT_SHARE = 0.3  # of lines of neon that have a dark stretch
LED_ROWS = {True: 20, False: 13}  # lamps in the height of a Chinese character and of a capital
_DARK = ((22, 22, 26), (34, 30, 28), (18, 26, 36), (46, 24, 20), (20, 34, 28))
_BOLD = ((164, 30, 28), (24, 62, 118), (18, 92, 62), (206, 152, 26), (70, 40, 96), (30, 30, 34), (192, 84, 24))
_LIGHT = ((244, 240, 230), (250, 226, 120), (232, 236, 240), (255, 250, 245))
_GLOW = ((255, 60, 70), (255, 80, 190), (70, 200, 255), (90, 255, 140), (255, 170, 50), (235, 235, 255))
_LAMPS = ((255, 40, 30), (255, 150, 20), (60, 255, 80))


@dataclass(frozen=True, slots=True)
class Look:
    """How one board's letters are finished.

    Attributes:
        lettering: the kind.
        ground: colour of the board.
        ink: of the main line.
        accent: of the other lines, and of shadows and rims.
        hand: how unevenly letters are set.
    """

    lettering: Lettering
    ground: textures.Colour
    ink: textures.Colour
    accent: textures.Colour
    hand: Hand = STEADY


def draw_look(rng: np.random.Generator, lettering: Lettering) -> Look:
    """Colours that sign makers use with a kind of lettering."""
    dark, bold, light = (_pick(rng, colours) for colours in (_DARK, _BOLD, _LIGHT))
    if lettering == "neon":
        return Look(lettering, dark, _pick(rng, _GLOW), _pick(rng, _GLOW))
    if lettering == "led":
        lamp = _pick(rng, _LAMPS)
        return Look(lettering, (12.0, 12.0, 13.0), lamp, lamp)
    if lettering == "gold":
        ground = _pick(rng, ((150, 22, 24), (118, 16, 20), (40, 24, 18)))
        return Look(lettering, ground, (226, 178, 72), (238, 204, 120))
    if lettering == "backlit":
        return Look(lettering, _pick(rng, _DARK), (255, 252, 240), (240, 236, 220))
    if lettering == "embossed":
        metal = _pick(rng, ((176, 178, 182), (186, 150, 92), (120, 116, 110), (206, 204, 198)))
        own = rng.random() < 0.5
        ink = (0.92 * metal[0], 0.92 * metal[1], 0.92 * metal[2]) if own else _pick(rng, _LIGHT)
        return Look(lettering, metal if own else bold, ink, light if not own else dark)
    if lettering == "hand":
        board = rng.random() < 0.5
        hand = Hand(turn=0.05, shift=0.03, scale=0.06)
        chalk = _pick(rng, ((240, 238, 230), (250, 226, 150), (250, 196, 200)))
        return Look(lettering, (38, 42, 40) if board else (150, 112, 72), chalk if board else (40, 28, 22), chalk, hand)
    if lettering == "outlined":
        return Look(lettering, bold, light, _pick(rng, _DARK))
    if rng.random() < 0.6:
        return Look(lettering, bold, light, light)
    return Look(lettering, light, bold if sum(bold) < 330 else (150.0, 24.0, 26.0), dark)


def _pick(rng: np.random.Generator, colours: tuple[tuple[float, float, float], ...]) -> textures.Colour:
    colour = colours[int(rng.integers(len(colours)))]
    red, green, blue = (float(np.clip(value + rng.normal(0, 6), 0, 255)) for value in colour)
    return red, green, blue


def lay_ground(rng: np.random.Generator, look: Look, height: int, width: int, scale: float) -> Picture:
    """The bare board, (height, width, 3); scale is pixels a metre."""
    if look.lettering == "neon" and rng.random() < 0.5:
        brick = textures.wall(rng, height, width, scale, "brick", (96, 52, 44))
        return np.asarray(0.42 * brick.astype(np.float32), np.float32)
    picture = np.full((height, width, 3), look.ground, np.float32)
    if look.lettering in ("hand", "gold") and sum(look.ground) > 60 and rng.random() < 0.6:
        lines = cv2.resize(textures.clouds(rng, height, max(2, width // 12), 10, 2), (width, height))
        picture *= (1 + 0.16 * lines)[..., None]
        for seam in range(0, height, max(8, round(0.16 * scale))):
            picture[seam : seam + 2] *= 0.7
    if look.lettering == "embossed":
        # Brushed metal, or lacquer over it.
        picture *= (1 + 0.05 * grain(rng, height, width, 14, 0.6))[..., None]
    shine = np.linspace(1 + rng.uniform(0, 0.12), 1 - rng.uniform(0, 0.16), height, dtype=np.float32)
    picture *= shine[:, None, None]
    picture *= (1 + 0.05 * textures.clouds(rng, height, width, width / 2 + 2, 5))[..., None]
    return np.asarray(picture, np.float32)


def finish(
    rng: np.random.Generator, picture: Picture, mask: Mask, look: Look, height: float, *, chinese: bool, main: bool
) -> None:
    """Put one line's strokes onto a board, in place.

    Args:
        rng: decides streaks and lamps that are out.
        picture: (h, w, 3), 0 to 255 or beyond where it shines.
        mask: (h, w) strokes, on the whole board.
        look: colours and kind.
        height: of its letters, pixels.
        chinese: whether they are Chinese: lamps stand closer.
        main: whether it is the name; other lines are finished more simply.
    """
    ink = look.ink if main else look.accent
    kind = look.lettering
    if kind == "neon":
        mask = _burnt_out(rng, mask, height)
        _glow(picture, tubes(mask, height) if main else mask, ink, height, 1.0 if main else 0.45)
    elif kind == "led":
        lit, every = dots(mask, height, LED_ROWS[chinese])
        around = cv2.dilate(mask, np.ones((3, 3), np.uint8), iterations=max(1, round(height * 0.25)))
        paint(picture, every * 0.16 * around, ink)
        paint(picture, lit, ink)
        _add(picture, soft(lit, 0.07 * height), ink, 0.35)
    elif kind in ("brush", "hand") and main:
        paint(picture, brushed(rng, mask, height) if kind == "brush" else _chalk(rng, mask), ink)
    elif kind == "embossed" and main:
        _emboss(picture, mask, ink, height)
    elif kind == "gold":
        _gild(picture, mask, ink, height)
    elif kind == "backlit" and main:
        _add(picture, soft(mask, 0.16 * height), (255, 240, 210), 0.55)
        paint(picture, mask, ink)
    elif kind == "outlined" and main:
        reach = max(1, round(0.045 * height))
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
        rim = np.asarray(cv2.dilate(mask, disc), np.float32)
        paint(picture, np.roll(rim, (reach, reach), (0, 1)) * 0.6, (10, 10, 12))
        paint(picture, rim, look.accent)
        paint(picture, mask, ink)
    else:
        paint(picture, mask, ink)


def paint(picture: Picture, cover: Mask, colour: textures.Colour) -> None:
    """Lay a colour over a picture where `cover` (h, w) is, in place."""
    picture += cover[..., None] * (np.array(colour, np.float32) - picture)


def _add(picture: Picture, light: NDArray[np.float32], colour: textures.Colour, strength: float) -> None:
    picture += strength * light[..., None] * np.array(colour, np.float32)


def _glow(picture: Picture, tube: Mask, colour: textures.Colour, height: float, share: float) -> None:
    for reach, strength in ((0.05, 0.8), (0.16, 1.3), (0.45, 0.9)):
        _add(picture, soft(tube, max(0.8, reach * height)), colour, share * strength)
    core = np.clip(1.5 * soft(tube, 0.8) - 0.35, 0, 1)
    hot = 0.45 * np.array(colour) + 0.55 * 255
    paint(picture, tube, colour)
    paint(picture, np.asarray(core, np.float32), (float(hot[0]), float(hot[1]), float(hot[2])))


def _emboss(picture: Picture, mask: Mask, ink: textures.Colour, height: float) -> None:
    """Letters that stand out of the board: bevels that face the lamp above are light, the others dark."""
    deep = max(1, round(0.05 * height))
    shadow = soft(np.roll(mask, (deep, deep // 2), (0, 1)), 0.7 * deep)
    picture *= (1 - 0.55 * np.clip(shadow - mask, 0, 1))[..., None]
    relief = soft(mask, 0.5 * deep + 0.5)
    right, down = slopes(relief)
    slope = down + 0.6 * right
    paint(picture, mask, ink)
    picture *= (1 + 0.30 * np.clip(slope, -1.6, 1.6) * np.maximum(mask, relief))[..., None]


def _gild(picture: Picture, mask: Mask, ink: textures.Colour, height: float) -> None:
    deep = max(1, round(0.03 * height))
    paint(picture, np.roll(mask, (deep, deep), (0, 1)) * 0.65, (26, 10, 6))
    rows = np.linspace(0, 3 * np.pi, mask.shape[0], dtype=np.float32)
    before = picture.copy()
    paint(picture, mask, ink)
    sheen = 1 + 0.14 * np.sin(rows)[:, None] * mask
    picture[:] = np.where(mask[..., None] > 0, picture * sheen[..., None], before)
    _, slope = slopes(soft(mask, 0.8 * deep + 0.4))
    picture *= (1 + 0.16 * np.clip(slope, -1.5, 1.5) * mask)[..., None]


def _burnt_out(rng: np.random.Generator, mask: Mask, height: float) -> Mask:
    """Strokes of which a stretch shines no more, now and then."""
    if rng.random() > BURNT_SHARE:
        return mask
    columns = np.arange(mask.shape[1])
    inked = np.flatnonzero(mask.max(axis=0) > 0)
    middle = rng.uniform(inked[0], inked[-1])
    dark = np.clip(1.2 - np.abs(columns - middle) / (0.3 * height), 0, 0.85)
    return np.asarray(mask * (1 - dark), np.float32)


def _chalk(rng: np.random.Generator, mask: Mask) -> Mask:
    dust = np.clip(grain(rng, mask.shape[0], mask.shape[1], 1.1) - 0.4, 0, 2)
    return np.asarray(mask * np.clip(1.0 - 0.35 * dust, 0.2, 1), np.float32)
