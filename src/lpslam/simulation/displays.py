"""What stands behind a shop window: shelves, clothes on a rail, pictures on the wall, a lit room."""

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.simulation.textures import Image, clouds, pick_colour, poster, to_image, wall_colour


def goods(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """The back of a shop window, `height` × `width` pixels at `scale` pixels a metre."""
    kinds = (_shelves, _shelves, _clothes, _pictures, _room)
    return kinds[int(rng.integers(len(kinds)))](rng, height, width, scale)


def _shelves(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Shelves full of things."""
    base = pick_colour(rng, (0.05, 0.4), (0.25, 0.6))
    image = np.full((height, width, 3), base, np.float32)
    image *= (1 + 0.15 * clouds(rng, height, width, 0.5 * scale, 0.03 * scale))[..., None]
    gap = max(12, round(rng.uniform(0.28, 0.45) * scale))
    palette = [pick_colour(rng, (0.1, 0.7), (0.25, 0.95)) for _ in range(4)]
    palette += [wall_colour(rng, 0.6) for _ in range(4)]
    for shelf in range(gap, height + gap, gap):
        cv2.rectangle(image, (0, shelf - 4), (width, shelf), (70, 58, 48), -1)
        x = int(rng.integers(0, gap // 3 + 1))
        while x < width:
            w, h = int(gap * rng.uniform(0.12, 0.5)) + 2, int(gap * rng.uniform(0.35, 0.85))
            colour = palette[int(rng.integers(len(palette)))]
            foot, top = shelf - 5, shelf - 5 - h
            if rng.random() < 0.25:
                cv2.ellipse(
                    image, (x + w // 2, (foot + top) // 2), (w // 2, h // 2), 0, 0, 360, colour, -1, cv2.LINE_AA
                )
            else:
                cv2.rectangle(image, (x, top), (x + w, foot), colour, -1)
                band = top + int(h * rng.uniform(0.2, 0.6))
                cv2.rectangle(image, (x, band), (x + w, band + h // 5), palette[int(rng.integers(len(palette)))], -1)
            # Round things are darker at their sides, and everything throws a little shadow on its neighbour.
            image[max(top, 0) : foot, x : x + max(1, w // 5)] *= 0.72
            image[max(top, 0) : foot, x + w : x + w + 3] *= 0.6
            x += w + int(rng.integers(1, max(2, gap // 6)))
    image *= (1 + 0.08 * clouds(rng, height, width, 30, 3))[..., None]
    return to_image(image)


def _ground(rng: np.random.Generator, height: int, width: int, scale: float) -> NDArray[np.float32]:
    picture = np.full((height, width, 3), wall_colour(rng, 0.35), np.float32)
    picture *= (1 + 0.12 * clouds(rng, height, width, 0.6 * scale, 0.02 * scale))[..., None]
    # Lamps in the ceiling of the window: brighter above.
    picture *= np.linspace(1.15, 0.8, height, dtype=np.float32)[:, None, None]
    return np.asarray(picture, np.float32)


def _clothes(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Garments on one or two rails, with folds."""
    image = _ground(rng, height, width, scale)
    rails = (0.12,) if height < 1.6 * scale else (0.08, 0.53)
    for rail in rails:
        top, long = round(rail * height), round(height * 0.82 / len(rails))
        cv2.line(image, (0, top), (width, top), (190, 190, 192), max(2, round(0.015 * scale)), cv2.LINE_AA)
        x = round(0.04 * scale)
        while x < width - round(0.2 * scale):
            w, h = round(scale * rng.uniform(0.16, 0.42)), round(long * rng.uniform(0.55, 0.9))
            colour = wall_colour(rng, 0.6) if rng.random() < 0.6 else pick_colour(rng, (0.1, 0.7), (0.3, 0.95))
            drop = round(0.06 * scale)
            outline = np.array(
                [[0.5, -0.1], [0.75, 0.05], [1.0, 0.2], [0.88, 0.4], [0.8, 0.32], [0.86, 1.0], [0.14, 1.0], [0.2, 0.32],
                 [0.12, 0.4], [0.0, 0.2], [0.25, 0.05]]
            )  # fmt: skip
            corners = np.round(outline * [w, h] + [x, top + drop]).astype(np.int32)
            cv2.fillPoly(image, [corners], colour, cv2.LINE_AA)
            folds = np.zeros((height, width), np.uint8)
            cv2.fillPoly(folds, [corners], 255)
            waves = clouds(rng, 1, width, 0.1 * scale, 0.02 * scale)
            image *= np.where(folds[..., None] > 0, 1 + 0.25 * waves[..., None], 1.0).astype(np.float32)
            if rng.random() < 0.4:
                stripe = wall_colour(rng, 0.5)
                for y in range(top + drop + h // 3, top + drop + h, max(4, h // 9)):
                    cv2.line(image, (x + w // 5, y), (x + 4 * w // 5, y), stripe, max(1, h // 40), cv2.LINE_AA)
            x += w + round(scale * rng.uniform(-0.04, 0.12))
    return to_image(image)


def _pictures(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """Framed pictures of several sizes on a wall."""
    image = to_image(_ground(rng, height, width, scale))
    for _ in range(max(3, round(height * width / scale**2 * 4))):
        w, h = (round(scale * rng.uniform(0.18, 0.5)) for _ in range(2))
        if w >= width - 4 or h >= height - 4:
            continue
        x, y = int(rng.integers(1, width - w - 1)), int(rng.integers(1, height - h - 1))
        image[y : y + h, x : x + w] = poster(rng, h, w)
        cv2.rectangle(image, (x, y), (x + w, y + h), (40, 34, 30), max(2, round(0.012 * scale)))
    return image


def _room(rng: np.random.Generator, height: int, width: int, scale: float) -> Image:
    """A view into a restaurant or salon: lamps, tables, chairs, people's height of panelling."""
    image = _ground(rng, height, width, scale)
    dado = round(height * rng.uniform(0.5, 0.65))
    image[dado:] = np.array(wall_colour(rng, 0.8)) * 0.6
    step = max(6, round(0.12 * scale))
    image[dado:, ::step] *= 0.7
    for x in range(round(0.25 * scale), width, round(scale * rng.uniform(0.4, 0.7))):
        drop = round(height * rng.uniform(0.1, 0.25))
        cv2.line(image, (x, 0), (x, drop), (30, 30, 30), 1, cv2.LINE_AA)
        shade = np.array([[x, drop - 6], [x + step, drop + step], [x - step, drop + step]], np.int32)
        cv2.fillPoly(image, [shade], wall_colour(rng, 0.9), cv2.LINE_AA)
        cv2.circle(image, (x, drop + step), max(2, step // 3), (255, 244, 205), -1, cv2.LINE_AA)
    for _ in range(max(2, round(2.2 * width / scale))):
        x, y = int(rng.integers(width)), round(height * rng.uniform(0.7, 0.85))
        w, colour = round(scale * rng.uniform(0.2, 0.4)), wall_colour(rng, 0.7)
        cv2.ellipse(image, (x, y), (w, max(2, w // 5)), 0, 0, 360, colour, -1, cv2.LINE_AA)
        cv2.rectangle(image, (x - 2, y), (x + 2, height), (45, 40, 38), -1)
        for side in (-1, 1):
            seat = x + side * round(1.3 * w)
            cv2.rectangle(image, (seat - w // 3, y - w // 2), (seat + w // 3, y + w // 3), wall_colour(rng, 0.8), -1)
    image *= (1 + 0.08 * clouds(rng, height, width, 0.3 * scale, 3))[..., None]
    return to_image(image)
