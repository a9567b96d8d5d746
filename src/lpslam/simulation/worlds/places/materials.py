"""Pictures of many materials, painted from a random generator; not those of the mall only."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.simulation import textures
from lpslam.simulation.textures import Image, clouds, pick_colour, to_image, wall_colour

Canvas = NDArray[np.float32]
Material = Callable[[np.random.Generator, int, int, float], Image]


def spectral(rng: np.random.Generator, height: int, width: int, slope: float) -> Canvas:
    """Noise whose amplitude falls as 1/f^slope, of mean 0 and standard deviation 1; it tiles."""
    y, x = np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)[None, :]
    frequency = np.maximum(np.hypot(y, x), 1.0 / max(height, width))
    spectrum = np.fft.rfft2(rng.standard_normal((height, width))) / frequency**slope
    spectrum[0, 0] = 0
    field = np.fft.irfft2(spectrum, (height, width))
    return np.asarray(field / max(float(field.std()), 1e-9), np.float32)


def _coloured(field: Canvas, colours: list[textures.Colour]) -> Canvas:
    """Map a field, mostly -2 to 2, onto a row of colours."""
    place = np.clip((field + 2) / 4, 0, 1)
    stops = np.linspace(0, 1, len(colours))
    return np.stack([np.interp(place, stops, [c[i] for c in colours]) for i in range(3)], axis=-1).astype(np.float32)


def cloudy(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """1/f noise in the colours of nowhere in particular: concrete, felt, rust, stains."""
    base = np.array(wall_colour(rng, 0.5))
    colours = [tuple(np.clip(base * f + rng.normal(0, 12, 3), 5, 250)) for f in rng.uniform(0.5, 1.2, 3)]
    return to_image(_coloured(spectral(rng, height, width, float(rng.uniform(0.7, 1.5))), colours))


def marble(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Veins along a direction, bent by noise."""
    y, x = np.mgrid[0:height, 0:width].astype(np.float32) / scale
    turn, rate = rng.uniform(0, np.pi), rng.uniform(3, 12)
    bend = spectral(rng, height, width, 1.6)
    wave = np.abs(np.sin(rate * (x * np.cos(turn) + y * np.sin(turn)) + rng.uniform(0.8, 2.5) * bend))
    field = 4 * np.sqrt(wave) - 2 + 0.3 * spectral(rng, height, width, 1.0)
    dark, light = pick_colour(rng, (0.02, 0.3), (0.1, 0.5)), pick_colour(rng, (0.0, 0.15), (0.7, 0.97))
    return to_image(_coloured(field, [dark, light, light]))


def wood_grain(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Planks with the rings of a trunk cut lengthwise, and knots."""
    y, x = np.mgrid[0:height, 0:width].astype(np.float32) / scale
    plank = np.floor(y / rng.uniform(0.09, 0.3))
    shift = rng.uniform(0, 40, int(plank.max()) + 1)[plank.astype(int)]
    bend = cv2.resize(spectral(rng, height, max(8, width // 8), 1.4), (width, height))
    rings = np.sin(2 * np.pi * (y * rng.uniform(30, 80) + shift + 0.8 * bend + 0.6 * np.sin(x * 2 + shift)))
    field = rings + 0.4 * cv2.resize(
        rng.standard_normal((height, max(4, width // 24))).astype(np.float32), (width, height)
    )
    base = np.array([rng.uniform(95, 200), rng.uniform(62, 140), rng.uniform(30, 90)])
    picture = _coloured(field.astype(np.float32), [tuple(base * 0.6), tuple(base), tuple(np.clip(base * 1.2, 0, 250))])
    edge = np.diff(plank, axis=0, prepend=plank[:1]) != 0
    picture[edge] *= 0.5
    for _ in range(int(rng.poisson(height * width / scale**2 * 0.8))):
        spot = (int(rng.integers(width)), int(rng.integers(height)))
        cv2.ellipse(
            picture,
            spot,
            (max(2, int(0.02 * scale)), max(1, int(0.009 * scale))),
            0,
            0,
            360,
            (base * 0.4).tolist(),
            -1,
            cv2.LINE_AA,
        )
    return to_image(picture)


def fabric(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """A weave with stripes or checks."""
    y, x = np.mgrid[0:height, 0:width]
    thread = max(2.0, 0.004 * scale)
    weave = np.sin(2 * np.pi * x / thread / 2) * np.sin(2 * np.pi * y / thread / 2)
    picture = np.full((height, width, 3), wall_colour(rng, 0.7), np.float32)
    colours = [pick_colour(rng, (0.1, 0.8), (0.15, 0.9)) for _ in range(3)]
    period = max(6, int(rng.uniform(0.05, 0.3) * scale))
    for axis in ((x,), (x, y))[int(rng.integers(2))] if rng.random() < 0.8 else ():
        phase = axis % period
        low = 0
        for colour in colours:
            wide = int(rng.uniform(0.05, 0.25) * period)
            picture = np.where(
                ((phase >= low) & (phase < low + wide))[..., None], 0.45 * picture + 0.55 * np.array(colour), picture
            )
            low += wide + int(rng.uniform(0, 0.2) * period)
    folds = 1 + 0.12 * cv2.resize(spectral(rng, 16, max(4, width // 16), 1.5), (width, height))
    return to_image(
        (
            picture * (1 + 0.13 * weave + 0.05 * rng.standard_normal((height, width)))[..., None] * folds[..., None]
        ).astype(np.float32)
    )


def carpet(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """A pile of coloured tufts with a pattern of rings, diamonds and borders."""
    y, x = np.mgrid[0:height, 0:width].astype(np.float32) / scale
    cell = rng.uniform(0.15, 0.5)
    u, v = np.abs((x / cell) % 1 - 0.5), np.abs((y / cell) % 1 - 0.5)
    shape = (u + v, np.maximum(u, v), np.hypot(u, v))[int(rng.integers(3))]
    colours = [pick_colour(rng, (0.2, 0.8), (0.15, 0.85)) for _ in range(4)]
    index = (shape * rng.uniform(4, 9)).astype(int) % 4
    picture = np.array(colours, np.float32)[index]
    noise = 1 + 0.18 * cv2.GaussianBlur(rng.standard_normal((height, width)).astype(np.float32), (0, 0), 0.9) * 2
    picture = picture * noise[..., None] * (1 + 0.12 * spectral(rng, height, width, 1.3))[..., None]
    return to_image(picture.astype(np.float32))


def pebbles(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Cells around random points: pebbles, cobbles, terrazzo, cracked earth."""
    size = max(4.0, rng.uniform(0.02, 0.12) * scale)
    count = max(8, int(height * width / size**2))
    seeds = np.zeros((height, width), np.uint8)
    seeds[rng.integers(0, height, count), rng.integers(0, width, count)] = 1
    distance, labels = cv2.distanceTransformWithLabels(1 - seeds, cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL)
    base = np.array(wall_colour(rng, 0.25))
    colours = np.clip(base * rng.uniform(0.5, 1.25, (count + 2, 1)) + rng.normal(0, 10, (count + 2, 3)), 5, 250)
    picture = colours[labels % (count + 2)] * (1.15 - 0.5 * np.clip(distance / size, 0, 1)[..., None] ** 2)
    return to_image((picture * (1 + 0.08 * spectral(rng, height, width, 0.8))[..., None]).astype(np.float32))


def asphalt(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Grains of grey, patches and cracks."""
    grains = cv2.GaussianBlur(rng.standard_normal((height, width)).astype(np.float32), (0, 0), max(0.6, 0.003 * scale))
    base = np.array(wall_colour(rng, 0.0)) * rng.uniform(0.35, 0.7)
    picture = base * (
        1 + 0.25 * (grains / grains.std())[..., None] * 0.8 + 0.14 * spectral(rng, height, width, 1.5)[..., None]
    )
    picture = picture.astype(np.float32)
    textures.wear(rng, picture, scale, 1.2)
    return to_image(picture)


def foliage(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Leaves over leaves, from dark to light: hedges, meadows, house plants."""
    image = np.full((height, width, 3), (18, 30, 14), np.float32)
    long = max(3, int(rng.uniform(0.02, 0.06) * scale))
    hue = pick_colour(rng, (0.5, 0.8), (0.3, 0.5))
    tone = np.array([hue[0] * 0.5 + 25, 90, 30])
    for layer in range(5):
        for _ in range(min(2500, int(height * width / (long * long * 0.55) / 2))):
            spot = (int(rng.integers(width)), int(rng.integers(height)))
            colour = tone * (0.45 + 0.17 * layer) * rng.uniform(0.7, 1.35) + rng.normal(0, 8, 3)
            axes = (long // 2 + 1, max(1, int(long * rng.uniform(0.15, 0.3))))
            cv2.ellipse(
                image, spot, axes, float(rng.uniform(0, 180)), 0, 360, np.clip(colour, 0, 255).tolist(), -1, cv2.LINE_AA
            )
    return to_image(image)


def bricks(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Bricks."""
    base = (rng.uniform(110, 190), rng.uniform(60, 130), rng.uniform(45, 110))
    return textures.wall(rng, height, width, scale, "brick", base)


def tiles(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Tiles of two colours, each a little different from the others."""
    side = max(4, int(rng.uniform(0.08, 0.4) * scale))
    y, x = np.mgrid[0:height, 0:width] // side
    colours = [np.array(wall_colour(rng, 0.5)) for _ in range(2)]
    chosen = (x + y) % 2 if rng.random() < 0.5 else rng.integers(0, 2, (y.max() + 1, x.max() + 1))[y, x]
    shade = rng.uniform(0.88, 1.1, (y.max() + 1, x.max() + 1))[y, x]
    picture = (np.where(chosen[..., None] == 0, colours[0], colours[1]) * shade[..., None]).astype(np.float32)
    joint = max(1, int(0.005 * scale))
    picture[np.arange(height) % side < joint] *= 0.6
    picture[:, np.arange(width) % side < joint] *= 0.6
    textures.wear(rng, picture, scale, 0.5)
    return to_image(picture)


def plaster(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """A painted wall: nearly nothing to see."""
    picture = np.full((height, width, 3), wall_colour(rng, 0.15), np.float32)
    picture *= (1 + 0.012 * spectral(rng, height, width, 1.2) + 0.008 * spectral(rng, height, width, 0.3))[..., None]
    return to_image(picture)


def wallpaper(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Paper with a motif that comes again and again."""
    return textures.wall(rng, height, width, scale, "paper", wall_colour(rng, 0.4))


FLOORS: tuple[Material, ...] = (wood_grain, carpet, tiles, marble, pebbles, cloudy)
WALLS: tuple[Material, ...] = (wallpaper, bricks, plaster, cloudy, tiles, wood_grain)
THINGS: tuple[Material, ...] = (wood_grain, fabric, marble, cloudy, carpet, foliage, pebbles, tiles)
STREETS: tuple[Material, ...] = (asphalt, pebbles, tiles)


def any_of(rng: np.random.Generator, materials: tuple[Material, ...], height: int, width: int, scale: float) -> Image:
    """One of some materials."""
    return materials[int(rng.integers(len(materials)))](rng, max(8, height), max(8, width), scale)


__all__ = ["FLOORS", "STREETS", "THINGS", "WALLS", "Material", "any_of", "clouds", "spectral"]
