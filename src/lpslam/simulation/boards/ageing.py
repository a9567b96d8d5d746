"""What years, weather, lamps and cameras do to a board: cover, dirt, reflections, uneven light, fading, JPEG."""

from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.simulation import textures
from lpslam.simulation.boards.fields import colour, grain, soft

Picture = NDArray[np.float32]
Ageing = Literal["covered", "dirty", "reflecting", "uneven", "faded", "compressed"]
AGEINGS: tuple[Ageing, ...] = get_args(Ageing)
COVERED_SHARE = 0.16  # at most, of the width of a board: its words stay readable for a person


def age(rng: np.random.Generator, picture: Picture, kind: Ageing, scale: float) -> Picture:
    """A picture (h, w, 3) of a board as it looks after that; scale is pixels a metre."""
    acts = {
        "covered": _cover,
        "dirty": _soil,
        "reflecting": _reflect,
        "uneven": _light_unevenly,
        "faded": _fade,
        "compressed": _compress,
    }
    return acts[kind](rng, np.asarray(picture, np.float32), scale)


def _cover(rng: np.random.Generator, picture: Picture, scale: float) -> Picture:
    """A lamp on an arm from above, or twigs from a corner."""
    height, width = picture.shape[:2]
    if rng.random() < 0.5:
        x = int(rng.uniform(0.15, 0.85) * width)
        reach = int(rng.uniform(0.3, 0.5) * height)
        size = max(5, round(min(0.5 * COVERED_SHARE * width, 0.14 * height)))
        cv2.line(picture, (x, 0), (x, reach), (34, 34, 36), max(2, round(0.012 * scale)), cv2.LINE_AA)
        shade = np.array(
            [[x - size // 3, reach], [x + size // 3, reach], [x + size, reach + size], [x - size, reach + size]]
        )
        cv2.fillPoly(picture, [shade.astype(np.int32)], (48, 46, 44), cv2.LINE_AA)
        cv2.ellipse(picture, (x, reach + size), (size, max(2, size // 4)), 0, 0, 360, (252, 240, 205), -1, cv2.LINE_AA)
        y, columns = np.ogrid[:height, :width]
        pool = np.exp(-(((columns - x) / (2.2 * size)) ** 2) - ((y - reach - 2.5 * size) / (2.5 * size)) ** 2)
        return np.asarray(picture * (1 + 0.35 * pool[..., None]), np.float32)
    side = int(rng.integers(2))
    for _ in range(int(rng.integers(14, 30))):
        x = rng.uniform(0, COVERED_SHARE * width)
        y = height * (1 - rng.uniform(0, 1) ** 1.5 * 0.8)
        spot = (int(width - 1 - x if side else x), int(y))
        size = (max(3, round(rng.uniform(0.03, 0.07) * scale)), max(2, round(rng.uniform(0.01, 0.022) * scale)))
        green = tuple(float(v) for v in np.array((52, 96, 40)) * rng.uniform(0.5, 1.4))
        cv2.ellipse(picture, spot, size, rng.uniform(0, 180), 0, 360, green, -1, cv2.LINE_AA)
    return picture


def _soil(rng: np.random.Generator, picture: Picture, scale: float) -> Picture:
    """Dust, rain streaks from the upper edge, rust at screws."""
    height, width = picture.shape[:2]
    dust = np.clip(textures.clouds(rng, height, width, 0.5 * scale, 4) + 0.15, 0, 1) * rng.uniform(0.25, 0.5)
    picture += dust[..., None] * (colour((118, 104, 84)) - picture)
    lanes = np.clip(grain(rng, 1, width, max(1.0, 0.01 * scale)) - 0.9, 0, 2)
    fall = np.linspace(1.0, rng.uniform(0.1, 0.5), height, dtype=np.float32)[:, None]
    picture *= (1 - 0.28 * np.clip(lanes * fall, 0, 1.4))[..., None]
    for _ in range(int(rng.integers(2, 6))):
        x, y = int(rng.integers(width)), int(rng.integers(height))
        rust = np.zeros((height, width), np.float32)
        cv2.ellipse(
            rust, (x, y), (round(0.012 * scale) + 1, round(rng.uniform(0.02, 0.09) * scale) + 1), 0, 0, 360, 1.0, -1
        )
        picture += 0.5 * soft(rust, 0.01 * scale + 1)[..., None] * (colour((110, 58, 26)) - picture)
    textures.wear(rng, picture, scale, 0.7)
    return picture


def _reflect(rng: np.random.Generator, picture: Picture, scale: float) -> Picture:
    """Glass before the board: slanted bands of light, and windows across the street."""
    height, width = picture.shape[:2]
    y, x = np.mgrid[:height, :width].astype(np.float32)
    slant = x + y * rng.uniform(-0.7, 0.7)
    light = np.zeros((height, width), np.float32)
    for _ in range(int(rng.integers(1, 4))):
        middle, half = rng.uniform(0, width), rng.uniform(0.04, 0.16) * width
        light += rng.uniform(0.15, 0.4) * np.clip(1.3 - np.abs(slant - middle) / half, 0, 1)
    pane = max(10, round(rng.uniform(0.2, 0.4) * scale))
    top = int(rng.integers(0, max(1, height // 2)))
    panes = ((x % pane) > 0.35 * pane) & ((y - top) % pane > 0.3 * pane)
    blurred = soft(panes, 0.02 * scale + 1)
    light += rng.uniform(0.05, 0.13) * blurred * np.clip(textures.clouds(rng, height, width, width / 2, 40) + 0.5, 0, 1)
    return np.asarray(picture + np.clip(light, 0, 0.6)[..., None] * (colour((236, 242, 250)) - picture), np.float32)


def _light_unevenly(rng: np.random.Generator, picture: Picture, scale: float) -> Picture:
    """A spot of light, the shadow of an awning's edge, or both."""
    height, width = picture.shape[:2]
    y, x = np.mgrid[:height, :width].astype(np.float32)
    centre, reach = rng.uniform(0, width), rng.uniform(0.25, 0.5) * width
    pool = np.exp(-(((x - centre) / reach) ** 2) - ((y - rng.uniform(-0.2, 0.6) * height) / (1.2 * height)) ** 2)
    light = 0.5 + 0.75 * pool
    if rng.random() < 0.6:
        edge = rng.uniform(0.2, 0.6) * height + (x - width / 2) * rng.uniform(-0.15, 0.15)
        light *= 1 - 0.45 / (1 + np.exp((y - edge) / (0.012 * scale + 0.5)))
    return np.asarray(picture * light[..., None], np.float32)


def _fade(rng: np.random.Generator, picture: Picture, scale: float) -> Picture:
    """Bleached by the sun, with flakes of paint gone."""
    height, width = picture.shape[:2]
    grey = picture.mean(axis=2, keepdims=True)
    pale = grey + (picture - grey) * rng.uniform(0.35, 0.6)
    pale = 128 + (pale - 128) * rng.uniform(0.5, 0.7) + rng.uniform(10, 30)
    flakes = textures.clouds(rng, height, width, 0.08 * scale, 2) > rng.uniform(0.78, 0.95)
    bare = soft(flakes, 0.7)
    return np.asarray(pale + 0.7 * bare[..., None] * (colour((172, 168, 160)) - pale), np.float32)


def _compress(rng: np.random.Generator, picture: Picture, scale: float) -> Picture:
    """A photograph of little detail, kept small."""
    height, width = picture.shape[:2]
    shrink = rng.uniform(1.3, 2.0)
    small = cv2.resize(
        picture, (max(8, round(width / shrink)), max(8, round(height / shrink))), interpolation=cv2.INTER_AREA
    )
    quality = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(14, 34))]
    data = cv2.imencode(".jpg", np.clip(small, 0, 255).astype(np.uint8), quality)[1]
    back = np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.uint8)
    return np.asarray(cv2.resize(back, (width, height), interpolation=cv2.INTER_CUBIC), np.float32)
