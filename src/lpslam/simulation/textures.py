"""Pictures of materials, painted from a random generator: floors, walls, posters, goods."""

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
Field = NDArray[np.float32]
Colour = tuple[float, float, float]


def clouds(rng: np.random.Generator, height: int, width: int, coarse: float, fine: float) -> Field:
    """Smooth noise in about -1..1 with blobs from `coarse` down to `fine` pixels."""
    total = np.zeros((height, width), np.float32)
    size, weight, power = coarse, 1.0, 0.0
    while size >= fine:
        shape = (max(2, round(width / size) + 2), max(2, round(height / size) + 2))
        grid = rng.standard_normal((shape[1], shape[0])).astype(np.float32)
        total += weight * cv2.resize(grid, (width, height), interpolation=cv2.INTER_CUBIC).astype(np.float32)
        power += weight**2
        size, weight = size / 2, weight * 0.75
    return np.asarray(np.clip(total / np.sqrt(power) / 2, -1.2, 1.2), np.float32)


def to_image(picture: NDArray[np.float32]) -> Image:
    """Clip to 8 bit."""
    return np.clip(picture, 0, 255).astype(np.uint8)


def _canvas(height: int, width: int, colour: Colour) -> NDArray[np.float32]:
    return np.full((height, width, 3), colour, np.float32)


def pick_colour(rng: np.random.Generator, saturation: tuple[float, float], value: tuple[float, float]) -> Colour:
    """A colour of random hue; saturation and value in 0..1."""
    hsv = np.array([[[rng.uniform(0, 180), 255 * rng.uniform(*saturation), 255 * rng.uniform(*value)]]], np.uint8)
    red, green, blue = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0, 0]
    return float(red), float(green), float(blue)


# What walls are painted in: quiet colours, and a few that shops choose to stand out.
_QUIET = (
    (226, 218, 200),
    (205, 203, 198),
    (188, 178, 162),
    (170, 182, 190),
    (178, 190, 170),
    (214, 196, 178),
    (150, 150, 152),
)
_BOLD = ((150, 62, 48), (42, 72, 104), (58, 92, 78), (196, 152, 72), (92, 66, 52), (62, 62, 68), (176, 102, 84))


def wall_colour(rng: np.random.Generator, bold: float) -> Colour:
    """A colour that a decorator would choose; `bold` is the share of strong ones."""
    shades = _BOLD if rng.random() < bold else _QUIET
    base = np.array(shades[int(rng.integers(len(shades)))]) * rng.uniform(0.88, 1.1) + rng.normal(0, 5, 3)
    red, green, blue = np.clip(base, 20, 245)
    return float(red), float(green), float(blue)


def wear(rng: np.random.Generator, picture: NDArray[np.float32], scale: float, amount: float) -> None:
    """Darken and scratch a picture in place so that no stretch looks like another; scale is pixels a metre."""
    height, width = picture.shape[:2]
    _shade(picture, 1 + 0.10 * amount * clouds(rng, height, width, 1.2 * scale, 0.04 * scale))
    area = height * width / scale**2
    layer = np.zeros((height, width), np.float32)
    for _ in range(int(area * 5 * amount)):
        centre = (int(rng.integers(width)), int(rng.integers(height)))
        radius = (int(scale * rng.uniform(0.004, 0.05)) + 1, int(scale * rng.uniform(0.004, 0.03)) + 1)
        cv2.ellipse(layer, centre, radius, rng.uniform(0, 180), 0, 360, float(rng.uniform(-0.5, 0.25)), -1, cv2.LINE_AA)
    for _ in range(int(area * 4 * amount)):
        start = np.array([rng.integers(width), rng.integers(height)], np.float64)
        heading, points = rng.uniform(0, 2 * np.pi), [start]
        for _ in range(int(rng.integers(2, 6))):
            heading += rng.normal(0, 0.35)
            points.append(points[-1] + scale * rng.uniform(0.03, 0.15) * np.array([np.cos(heading), np.sin(heading)]))
        line = [np.round(np.array(points)).astype(np.int32)]
        cv2.polylines(layer, line, False, float(rng.uniform(-0.6, 0.3)), int(rng.integers(1, 3)), cv2.LINE_AA)
    _shade(picture, 1 + 0.55 * layer)


def _shade(picture: NDArray[np.float32], factor: NDArray[np.floating]) -> None:
    """Multiply a picture by a factor for each pixel, in place: colour by colour, which is faster than all three."""
    for channel in range(3):
        picture[..., channel] *= factor


def floor(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """A floor of tiles, planks or stone; scale is pixels a metre."""
    kind = rng.choice(["tiles", "planks", "terrazzo"])
    if kind == "tiles":
        side = round(scale * rng.choice([0.4, 0.6, 0.8]))
        base = wall_colour(rng, 0.12)
        picture = _laid(rng, height, width, side, side, base, 0.10, offset=bool(rng.random() < 0.3))
        marbling = 26 * (np.abs(clouds(rng, height, width, 0.5 * scale, 0.015 * scale)) ** 0.5 - 0.5)
        for channel in range(3):
            picture[..., channel] += marbling
        _joints(picture, side, side, round(0.006 * scale) + 1, 0.62)
    elif kind == "planks":
        across, along = round(scale * rng.uniform(0.12, 0.18)), round(scale * 1.2)
        base = (rng.uniform(120, 180), rng.uniform(85, 120), rng.uniform(50, 80))
        picture = _laid(rng, height, width, across, along, base, 0.22, offset=True)
        grain = clouds(rng, height, max(2, width // 14), 0.06 * scale, 2)
        _shade(picture, 1 + 0.22 * cv2.resize(grain, (width, height)))
        _joints(picture, across, None, 2, 0.5)
    else:
        picture = _canvas(height, width, wall_colour(rng, 0.1))
        for size, amount in ((0.05, 22), (0.02, 30), (0.01, 26)):
            chips = clouds(rng, height, width, size * scale, size * scale)
            picture += (amount * (chips > 0.55) - amount * (chips < -0.6)).astype(np.float32)[..., None]
        _joints(picture, round(scale * 1.5), round(scale * 1.5), round(0.008 * scale) + 1, 0.7)
    wear(rng, picture, scale, 1.0)
    return to_image(picture)


def _laid(
    rng: np.random.Generator,
    height: int,
    width: int,
    across: int,
    along: int,
    base: Colour,
    spread: float,
    *,
    offset: bool,
) -> NDArray[np.float32]:
    """Pieces of `across` × `along` pixels laid in rows, each of a slightly different shade."""
    rows, columns = height // across + 2, width // along + 3
    shades = 1 + spread * (rng.random((rows, columns)) - 0.5)
    tint = 1 + 0.12 * spread * rng.standard_normal((rows, columns, 3))
    shift = rng.integers(0, along, rows) if offset else np.zeros(rows, np.int64)
    pieces = (shades[..., None] * tint * np.array(base)).astype(np.float32)
    # Of each row of pieces one line of pixels is painted: the others are as it.
    column, behind_edge = np.divmod(np.arange(width)[None, :] + shift[:, None], along)
    lines = pieces[np.arange(rows)[:, None], column]
    lines[behind_edge < 2] *= 0.7
    return np.asarray(lines[np.arange(height) // across], np.float32)


def _joints(picture: NDArray[np.float32], across: int, along: int | None, thickness: int, factor: float) -> None:
    height, width = picture.shape[:2]
    picture[np.arange(height) % across < thickness] *= factor
    if along is not None:
        picture[:, np.arange(width) % along < thickness] *= factor


def wall(rng: np.random.Generator, height: int, width: int, scale: float, kind: str, base: Colour) -> Image:
    """A stretch of wall of a kind: plaster, panels, brick, tiles, paper or stone."""
    if kind == "brick":
        across, along = round(0.075 * scale), round(0.24 * scale)
        picture = _laid(rng, height, width, across, along, base, 0.45, offset=True)
        _joints(picture, across, None, max(1, round(0.010 * scale)), 1.35)
    elif kind == "tiles":
        across, along = round(0.30 * scale), round(0.45 * scale)
        picture = _laid(rng, height, width, across, along, base, 0.12, offset=False)
        _joints(picture, across, along, max(1, round(0.006 * scale)), 0.7)
    elif kind == "panels":
        picture = _laid(rng, height, width, height + 1, round(0.6 * scale), base, 0.15, offset=False)
        grain = clouds(rng, max(2, height // 12), width, 0.05 * scale, 2)
        _shade(picture, 1 + 0.16 * cv2.resize(grain, (width, height)))
    elif kind == "paper":
        picture = _canvas(height, width, base)
        motif = np.zeros((round(0.36 * scale), round(0.28 * scale)), np.float32)
        for _ in range(5):
            centre = (int(rng.integers(motif.shape[1])), int(rng.integers(motif.shape[0])))
            size = (int(rng.integers(2, motif.shape[1] // 3)), int(rng.integers(2, motif.shape[0] // 3)))
            cv2.ellipse(motif, centre, size, rng.uniform(0, 180), 0, 360, float(rng.uniform(-1, 1)), 2, cv2.LINE_AA)
        reps = (height // motif.shape[0] + 1, width // motif.shape[1] + 1)
        _shade(picture, 1 + 0.16 * np.tile(motif, reps)[:height, :width])
    elif kind == "stone":
        picture = _canvas(height, width, base)
        veins = np.abs(clouds(rng, height, width, 0.7 * scale, 0.02 * scale))
        _shade(picture, 0.78 + 0.35 * np.sqrt(veins))
        _joints(picture, round(0.9 * scale), round(1.1 * scale), max(1, round(0.005 * scale)), 0.75)
    else:
        picture = _canvas(height, width, base)
        _shade(picture, 1 + 0.05 * clouds(rng, height, width, 0.03 * scale, 0.008 * scale))
    wear(rng, picture, scale, 0.75 if kind != "plaster" else 0.6)
    return to_image(picture)


def ceiling(rng: np.random.Generator, scale: float) -> Image:
    """2.4 m × 2.4 m of ceiling, to be laid side by side: perforated boards, slats or bare plaster."""
    side = round(2.4 * scale)
    kind = rng.choice(["boards", "boards", "slats", "plaster"])
    if kind == "boards":
        piece = round(scale * rng.choice([0.6, 1.2]))
        picture = _laid(rng, side, side, round(0.6 * scale), piece, (214, 212, 206), 0.05, offset=False)
        holes = clouds(rng, side, side, 0.03 * scale, 0.012 * scale)
        _shade(picture, 1 - 0.14 * (holes > 0.5))
        _joints(picture, round(0.6 * scale), piece, max(2, round(0.015 * scale)), 0.8)
    elif kind == "slats":
        base = wall_colour(rng, 0.4)
        picture = _laid(rng, side, side, round(0.15 * scale), round(1.2 * scale), base, 0.2, offset=True)
        _joints(picture, round(0.15 * scale), None, max(3, round(0.03 * scale)), 0.35)
    else:
        picture = _canvas(side, side, (222, 220, 214))
        _shade(picture, 1 + 0.05 * clouds(rng, side, side, 0.5 * scale, 0.01 * scale))
        for _ in range(4):
            spot = (int(rng.integers(side)), int(rng.integers(side)))
            cv2.circle(picture, spot, round(0.09 * scale), (150, 150, 150), -1, cv2.LINE_AA)
            cv2.circle(picture, spot, round(0.06 * scale), (60, 60, 60), max(1, round(0.01 * scale)), cv2.LINE_AA)
    return to_image(picture)


def poster(rng: np.random.Generator, height: int, width: int) -> Image:
    """An advertisement without words: coloured ground, shapes, a picture-like patch, a border."""
    picture = np.linspace(pick_colour(rng, (0.2, 0.8), (0.5, 1)), pick_colour(rng, (0.2, 0.9), (0.3, 0.9)), height)
    image = np.repeat(picture[:, None], width, axis=1).astype(np.float32)
    for _ in range(int(rng.integers(6, 16))):
        colour = pick_colour(rng, (0.1, 1.0), (0.15, 1.0))
        centre = (int(rng.integers(width)), int(rng.integers(height)))
        size = int(rng.uniform(0.03, 0.22) * width) + 2
        shape = rng.integers(4)
        if shape == 0:
            cv2.circle(image, centre, size, colour, -1, cv2.LINE_AA)
        elif shape == 1:
            cv2.ellipse(image, centre, (size, size // 2 + 1), rng.uniform(0, 180), 0, 360, colour, -1, cv2.LINE_AA)
        else:
            turn = rng.uniform(0, 2 * np.pi) + np.arange(3 + shape) * 2 * np.pi / (3 + shape)
            corners = np.column_stack([centre[0] + size * np.cos(turn), centre[1] + size * np.sin(turn)])
            cv2.fillPoly(image, [corners.astype(np.int32)], colour, cv2.LINE_AA)
    _shade(image, 1 + 0.14 * clouds(rng, height, width, width / 3, 4))
    border = max(2, width // 40)
    cv2.rectangle(image, (0, 0), (width - 1, height - 1), pick_colour(rng, (0, 0.2), (0.1, 1)), 2 * border)
    return to_image(image)


def leaf(rng: np.random.Generator) -> Image:
    """A patch of green."""
    picture = _canvas(32, 32, (rng.uniform(30, 70), rng.uniform(90, 140), rng.uniform(30, 60)))
    _shade(picture, 1 + 0.3 * clouds(rng, 32, 32, 12, 3))
    picture[:, 15:17] *= 1.35
    return to_image(picture)


def wood(rng: np.random.Generator, height: int, width: int) -> Image:
    """Planed wood for benches and counters."""
    picture = _canvas(height, width, (rng.uniform(110, 170), rng.uniform(75, 110), rng.uniform(40, 70)))
    grain = cv2.resize(clouds(rng, height, max(2, width // 10), 8, 2), (width, height))
    _shade(picture, 1 + 0.25 * grain)
    return to_image(picture)
