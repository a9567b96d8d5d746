"""Textures that reading takes for letters: friezes, grilles, zigzags, tiles, railings, brick, shelves, blinds."""

from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.simulation import textures
from lpslam.simulation.boards.fields import colour, soft
from lpslam.simulation.displays import goods

Image = NDArray[np.uint8]
Ornament = Literal[
    "frieze", "grille", "zigzag", "tiles", "railing", "brick", "shelves", "meander", "chevrons", "blinds", "rings"
]
ORNAMENTS: tuple[Ornament, ...] = get_args(Ornament)
SCALE = 340.0  # pixels a metre


def paint_ornament(rng: np.random.Generator, kind: Ornament, height: float, width: float) -> Image:
    """Paint one strip or panel of a kind; metres."""
    rows, columns = max(16, round(height * SCALE)), max(16, round(width * SCALE))
    if kind == "shelves":
        return goods(rng, rows, columns, SCALE * 0.6)
    if kind == "brick":
        return textures.wall(rng, rows, columns, SCALE, "brick", (150.0, 84.0, 66.0))
    light, dark = _pair(rng)
    cover = _DRAWN[kind](rng, rows, columns)
    picture = colour(light) + cover[..., None] * (colour(dark) - colour(light))
    picture *= (1 + 0.06 * textures.clouds(rng, rows, columns, 0.4 * SCALE, 3))[..., None]
    textures.wear(rng, picture, SCALE, 0.5)
    return textures.to_image(picture)


def _pair(rng: np.random.Generator) -> tuple[textures.Colour, textures.Colour]:
    """A ground and a pattern that stand out from each other, either way."""
    bright, dim = textures.wall_colour(rng, 0.1), textures.pick_colour(rng, (0.1, 0.7), (0.08, 0.35))
    return (bright, dim) if rng.random() < 0.6 else (dim, bright)


def _coordinates(rows: int, columns: int, period: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Places in periods: x from 0 to 1 within each, y from 0 to 1 over the whole height."""
    y, x = np.mgrid[:rows, :columns].astype(np.float32)
    return (x / period) % 1, (y + 0.5) / rows


def _smooth(field: NDArray[np.bool_]) -> NDArray[np.float32]:
    return soft(field, 0.8)


def _frieze(rng: np.random.Generator, rows: int, columns: int) -> NDArray[np.float32]:
    """Rings and crosses in turn between two bands."""
    cover = np.zeros((rows, columns), np.float32)
    reach, thick = 0.3 * rows, max(2, round(rng.uniform(0.06, 0.11) * rows))
    for number, x in enumerate(np.arange(0.5 * rows, columns, rng.uniform(0.75, 1.05) * rows)):
        centre, r = (round(float(x)), rows // 2), round(reach)
        if number % 2 == 0:
            cv2.ellipse(cover, centre, (round(0.8 * r), r), 0, 0, 360, 1.0, thick, cv2.LINE_AA)
        else:
            for a, b in ((-1, -1), (-1, 1)):
                start, end = (centre[0] + a * r, centre[1] + b * r), (centre[0] - a * r, centre[1] - b * r)
                cv2.line(cover, start, end, 1.0, thick, cv2.LINE_AA)
    return _banded(cover, rows)


def _rings(rng: np.random.Generator, rows: int, columns: int) -> NDArray[np.float32]:
    cover = np.zeros((rows, columns), np.float32)
    thick, r = max(2, round(rng.uniform(0.06, 0.12) * rows)), round(rng.uniform(0.26, 0.36) * rows)
    squeeze = rng.uniform(0.65, 1.0)
    for x in np.arange(0.4 * rows, columns, 2.35 * r * squeeze):
        centre = (round(float(x)), rows // 2)
        cv2.ellipse(cover, centre, (round(squeeze * r), r), 0, 0, 360, 1.0, thick, cv2.LINE_AA)
    return cover


def _banded(cover: NDArray[np.float32], rows: int) -> NDArray[np.float32]:
    band = max(2, rows // 18)
    cover[band : 2 * band] = 1.0
    cover[-2 * band : -band] = 1.0
    return cover


def _grille(rng: np.random.Generator, rows: int, columns: int) -> NDArray[np.float32]:
    """Crossed bars, upright or slanted."""
    period = rng.uniform(0.07, 0.14) * SCALE
    y, x = np.mgrid[:rows, :columns].astype(np.float32)
    u, v = (x + y, x - y) if rng.random() < 0.5 else (x * 1.2, y)
    bar = rng.uniform(0.14, 0.26)
    return _smooth(((u / period) % 1 < bar) | ((v / period) % 1 < bar))


def _zigzag(rng: np.random.Generator, rows: int, columns: int) -> NDArray[np.float32]:
    x, y = _coordinates(rows, columns, rng.uniform(0.5, 0.9) * rows)
    thick = rng.uniform(0.09, 0.16)
    return _smooth(np.abs(y - 0.2 - 0.6 * np.abs(2 * x - 1)) < thick)


def _tiles(rng: np.random.Generator, rows: int, columns: int) -> NDArray[np.float32]:
    """Squares with a smaller square, or a quarter circle in each corner."""
    period = rng.uniform(0.1, 0.2) * SCALE
    y, x = np.mgrid[:rows, :columns].astype(np.float32)
    u, v = np.abs((x / period) % 1 - 0.5), np.abs((y / period) % 1 - 0.5)
    if rng.random() < 0.5:
        inner = (np.maximum(u, v) < 0.3) & (np.maximum(u, v) > 0.2)
    else:
        inner = np.abs(np.hypot(0.5 - u, 0.5 - v) - 0.33) < 0.05
    return _smooth(inner | (np.maximum(u, v) > 0.47))


def _railing(rng: np.random.Generator, rows: int, columns: int) -> NDArray[np.float32]:
    """Balusters between two rails, each with a knob."""
    x, y = _coordinates(rows, columns, rng.uniform(0.25, 0.5) * rows)
    off = np.abs(x - 0.5)
    post = (off < 0.09) | (np.hypot(off * 1.2, (y - 0.5) * 2.2) < 0.3)
    return _smooth((post & (y > 0.1)) | (y < 0.14) | (y > 0.88))


def _meander(rng: np.random.Generator, rows: int, columns: int) -> NDArray[np.float32]:
    """The Greek key: a line that turns back into itself."""
    key = np.array(
        [[1, 1, 1, 1, 1, 1, 1, 0], [1, 0, 0, 0, 0, 0, 1, 0], [1, 0, 1, 1, 1, 0, 1, 0], [1, 0, 1, 0, 1, 0, 1, 0],
         [1, 0, 0, 0, 1, 0, 1, 0], [1, 1, 1, 1, 1, 0, 1, 1]], np.float32,
    )  # fmt: skip
    side = max(3, round(rows * 0.75))
    cell = cv2.resize(key, (round(side * 8 / 6), side), interpolation=cv2.INTER_NEAREST)
    if rng.random() < 0.5:
        cell = cell[:, ::-1]
    strip = np.tile(cell, (1, columns // cell.shape[1] + 1))[:, :columns]
    cover = np.zeros((rows, columns), np.float32)
    top = (rows - side) // 2
    cover[top : top + side] = strip
    return soft(cover, 0.7)


def _chevrons(rng: np.random.Generator, rows: int, columns: int) -> NDArray[np.float32]:
    y, x = np.mgrid[:rows, :columns].astype(np.float32)
    period = rng.uniform(0.45, 0.8) * rows
    shifted = (x + np.abs(y - rows / 2) * rng.uniform(0.7, 1.1)) / period
    return _smooth((shifted % 1 < 0.4) & (np.abs(y / rows - 0.5) < 0.38))


def _blinds(rng: np.random.Generator, rows: int, columns: int) -> NDArray[np.float32]:
    """Slats, level or upright, with their cords."""
    y, x = np.mgrid[:rows, :columns].astype(np.float32)
    period = rng.uniform(0.035, 0.07) * SCALE
    along, across = (y, x) if rng.random() < 0.6 else (x, y)
    slat = 0.25 + 0.75 * np.clip(1.6 * ((along / period) % 1) - 0.3, 0, 1)
    cord = (across / (0.35 * SCALE)) % 1 < 0.03
    return np.asarray(np.where(cord, 0.1, slat), np.float32)


_DRAWN = {
    "frieze": _frieze,
    "grille": _grille,
    "zigzag": _zigzag,
    "tiles": _tiles,
    "railing": _railing,
    "meander": _meander,
    "chevrons": _chevrons,
    "blinds": _blinds,
    "rings": _rings,
}
