"""Printed and made things: pages, spines of books, pictures, screens, packages, keyboards."""

import cv2
import numpy as np

from lpslam.simulation.textures import Image, pick_colour, poster, to_image, wall_colour
from lpslam.simulation.worlds.places.materials import THINGS, any_of, spectral


def page(rng: np.random.Generator, height: int, width: int) -> Image:
    """A printed page: lines of little strokes that no one can read, a heading, sometimes a picture."""
    image = np.full((height, width, 3), rng.uniform(222, 250, 3), np.float32)
    line = max(4, int(height * rng.uniform(0.018, 0.035)))
    y, left, right = int(0.08 * height), int(0.1 * width), int(0.9 * width)
    while y < 0.92 * height:
        if rng.random() < 0.06 and y + 8 * line < 0.9 * height:
            h, w = 7 * line, int((right - left) * rng.uniform(0.4, 1.0))
            image[y : y + h, left : left + w] = picture(rng, h, w)
            y += 9 * line
            continue
        x, end = left, right - int(rng.random() < 0.2) * int(rng.uniform(0.1, 0.6) * (right - left))
        while x < end:
            for _ in range(int(rng.integers(2, 8))):
                low, high = y + line // 4, y + 3 * line // 4
                if rng.random() < 0.25:
                    low -= line // 5
                cv2.line(image, (x, low), (x + int(rng.integers(-1, 2)), high), (40, 40, 45), 1, cv2.LINE_AA)
                x += max(2, line // 4)
            x += max(2, line // 3)
        y += line
    return to_image(image)


def spines(rng: np.random.Generator, height: int, width: int) -> Image:
    """A shelf's row of books seen from their backs."""
    image = np.full((height, width, 3), (40, 30, 25), np.float32)
    x = 0
    while x < width:
        w, tall = max(3, int(height * rng.uniform(0.06, 0.22))), int(height * rng.uniform(0.65, 0.98))
        colour = np.array(pick_colour(rng, (0.1, 0.9), (0.15, 0.95)))
        image[height - tall :, x : x + w] = colour
        for _ in range(int(rng.integers(1, 5))):
            y = height - int(tall * rng.uniform(0.1, 0.95))
            thick = max(1, int(height * rng.uniform(0.01, 0.12)))
            image[y : y + thick, x + 1 : x + w - 1] = np.clip(colour * rng.uniform(0.3, 2.2), 0, 255)
        image[height - tall :, x : x + 1] *= 0.4
        x += w + int(rng.random() < 0.1) * w
    return to_image(image * (1 + 0.05 * spectral(rng, height, width, 0.6))[..., None])


def picture(rng: np.random.Generator, height: int, width: int) -> Image:
    """What hangs in frames: a landscape of noise, a mosaic, stripes, or shapes."""
    kind = int(rng.integers(5))
    if kind == 0:
        field = spectral(rng, height, width, 1.7) + np.linspace(-1.5, 1.5, height)[:, None].astype(np.float32)
        stops = [np.array(pick_colour(rng, (0.1, 0.8), (0.1, 0.95))) for _ in range(5)]
        place = np.clip((field + 2.5) / 5, 0, 1)
        image = np.stack([np.interp(place, np.linspace(0, 1, 5), [s[i] for s in stops]) for i in range(3)], axis=-1)
        return to_image(image.astype(np.float32))
    if kind == 1:
        cells = (max(2, int(rng.integers(3, 14))), max(2, int(rng.integers(3, 14))))
        small = np.array([[pick_colour(rng, (0, 1), (0.05, 1)) for _ in range(cells[1])] for _ in range(cells[0])])
        large = cv2.resize(small.astype(np.float32), (width, height), interpolation=cv2.INTER_NEAREST)
        return to_image(np.asarray(large, np.float32))
    if kind == 2:
        image = np.zeros((height, width, 3), np.float32)
        for _ in range(int(rng.integers(15, 50))):
            corners = rng.uniform(-0.1, 1.1, (3, 2)) * [width, height]
            cv2.fillPoly(image, [corners.astype(np.int32)], pick_colour(rng, (0.1, 1), (0.1, 1)), cv2.LINE_AA)
        return to_image(image)
    if kind == 3:
        image = any_of(rng, THINGS, height, width, max(height, width) / rng.uniform(0.3, 1.5)).astype(np.float32)
        for _ in range(int(rng.integers(2, 9))):
            centre = (int(rng.integers(width)), int(rng.integers(height)))
            size = max(2, int(rng.uniform(0.04, 0.3) * min(width, height)))
            cv2.circle(
                image, centre, size, pick_colour(rng, (0, 1), (0.05, 1)), int(rng.choice([-1, 2, 4])), cv2.LINE_AA
            )
        return to_image(image)
    return poster(rng, height, width)


def screen(rng: np.random.Generator, height: int, width: int) -> Image:
    """A display with windows of lines and pictures."""
    image = picture(rng, height, width).astype(np.float32) * 0.6
    for _ in range(int(rng.integers(2, 5))):
        h, w = int(height * rng.uniform(0.3, 0.7)), int(width * rng.uniform(0.25, 0.6))
        y, x = int(rng.integers(0, height - h)), int(rng.integers(0, width - w))
        image[y : y + h, x : x + w] = page(rng, h, w) if rng.random() < 0.6 else picture(rng, h, w)
        cv2.rectangle(image, (x, y), (x + w, y + max(3, h // 14)), wall_colour(rng, 0.8), -1)
    return to_image(image)


def keyboard(rng: np.random.Generator, height: int, width: int) -> Image:
    """Rows of keys."""
    image = np.full((height, width, 3), rng.uniform(20, 60), np.float32)
    rows, base = 5, rng.uniform(30, 210)
    for row in range(rows):
        x = int(0.02 * width)
        while x < 0.96 * width:
            w = int(width * (0.055 if rng.random() < 0.85 else rng.uniform(0.08, 0.2)))
            y0, y1 = int((row + 0.12) / rows * height), int((row + 0.88) / rows * height)
            shade = base * rng.uniform(0.92, 1.06)
            cv2.rectangle(image, (x, y0), (x + w - 3, y1), (shade, shade, shade), -1)
            cv2.circle(image, (x + w // 3, (y0 + y1) // 2), max(1, height // 45), (255 - base,) * 3, -1, cv2.LINE_AA)
            x += w
    return to_image(image)


def package(rng: np.random.Generator, height: int, width: int) -> Image:
    """The side of a box, tin or carton: a ground, bands, a patch."""
    ground = pick_colour(rng, (0.05, 0.9), (0.2, 0.95))
    image = np.full((height, width, 3), ground, np.float32)
    for _ in range(int(rng.integers(1, 4))):
        y, h = int(rng.uniform(0, 0.9) * height), max(2, int(rng.uniform(0.04, 0.3) * height))
        image[y : y + h] = pick_colour(rng, (0.05, 0.9), (0.1, 0.98))
    h, w = max(4, int(height * rng.uniform(0.25, 0.5))), max(4, int(width * rng.uniform(0.4, 0.8)))
    y, x = int(rng.integers(0, max(1, height - h))), int(rng.integers(0, max(1, width - w)))
    image[y : y + h, x : x + w] = picture(rng, h, w)
    return to_image(image * (1 + 0.04 * spectral(rng, height, width, 0.7))[..., None])
