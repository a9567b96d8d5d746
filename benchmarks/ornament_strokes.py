"""Ornaments of single strokes: runes, tallies, cracks and drawings that look like a character and are none."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Ink = tuple[int, int, int]
Draw = Callable[[Picture, np.random.Generator, int, Ink], None]


def _rows(image: Picture, random: np.random.Generator, size: int) -> range:
    """Upper rows of bands of a height, some way apart."""
    return range(int(random.integers(0, 80)), image.shape[0], int(size * random.uniform(1.8, 3.5)))


def _strokes(image: Picture, lines: NDArray[np.float64], left: int, top: int, size: int, thick: int, ink: Ink) -> None:
    """Straight strokes (n, 2, 2) of a square one wide, drawn `size` high."""
    for ends in np.round(lines * size + (left, top)).astype(int).tolist():
        cv2.line(image, ends[0], ends[1], ink, thick, cv2.LINE_AA)


def _runes(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """An upright or two and slanted strokes from it, each rune another one."""
    thick, pitch = max(2, size // 9), int(size * random.uniform(0.8, 1.4))
    for top in _rows(image, random, size):
        for left in range(int(random.integers(0, size)), image.shape[1], pitch):
            uprights = [0.2, 0.7][: int(random.integers(1, 3))]
            lines = [[[x, 0.0], [x, 1.0]] for x in uprights]
            for _ in range(int(random.integers(1, 4))):
                x, y = float(random.choice(uprights)), float(random.choice([0.0, 0.25, 0.5, 0.75]))
                across = float(random.choice([0.45, -0.2 if len(uprights) > 1 else 0.45]))
                lines.append([[x, y], [x + across, y + float(random.choice([-0.25, 0.25]))]])
            _strokes(image, np.array(lines), left, top, size, thick, ink)


def _tallies(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Bundles of four strokes and a fifth across."""
    thick = max(2, size // 10)
    for top in _rows(image, random, size):
        left = int(random.integers(0, 60))
        while left < image.shape[1]:
            count = int(random.integers(2, 6))
            step = size // 4
            for at in range(min(count, 4)):
                lean = int(random.normal(0.0, 0.06 * size))
                cv2.line(image, (left + at * step, top), (left + at * step + lean, top + size), ink, thick, cv2.LINE_AA)
            if count == 5:
                cv2.line(image, (left - step, top + size), (left + 4 * step, top), ink, thick, cv2.LINE_AA)
            left += int(size * random.uniform(1.4, 2.0))


def _lattices(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Windows of a garden wall: a frame, and bars between it that no other window has."""
    thick, pitch = max(2, size // 12), int(size * random.uniform(1.3, 2.2))
    for top in _rows(image, random, size):
        for left in range(4, image.shape[1], pitch):
            cv2.rectangle(image, (left, top), (left + size, top + size), ink, thick)
            cuts = np.sort(random.choice(np.arange(1, 6) / 6.0, int(random.integers(2, 4)), replace=False))
            lines = [[[cut, 0.0], [cut, 1.0]] for cut in cuts]
            lines += [[[0.0, cut], [1.0, cut]] for cut in random.choice(np.arange(1, 6) / 6.0, 2, replace=False)]
            if random.random() < 0.5:
                lines += [[[0.0, 0.0], [1.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]]]
            _strokes(image, np.array(lines), left, top, size, thick, ink)


def _rubble(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """A wall of stones of any size, their joints drawn."""
    thick = max(1, size // 10)
    for top in range(0, image.shape[0], size):
        left = -int(random.integers(0, size))
        while left < image.shape[1]:
            wide = int(size * random.uniform(0.5, 2.2))
            cv2.rectangle(image, (left, top), (left + wide, top + size), ink, thick)
            if random.random() < 0.35:
                middle = top + int(size * random.uniform(0.35, 0.65))
                cv2.line(image, (left, middle), (left + wide, middle), ink, thick)
            left += wide


def _square_codes(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Codes of black and white cells, with a ring in three corners."""
    cells, high = int(random.integers(11, 21)), int(size * random.uniform(1.0, 3.0))
    for top in range(20, image.shape[0] - high, int(high * 1.6)):
        for left in range(int(random.integers(10, 60)), image.shape[1] - high, int(high * 1.8)):
            code = (random.random((cells, cells)) < 0.5).astype(np.uint8)
            ring = np.ones((5, 5), np.uint8)
            ring[1:4, 1:4] = 0
            ring[2, 2] = 1
            code[:5, :5], code[:5, -5:], code[-5:, :5] = ring, ring, ring
            mask = cv2.resize(code, (high, high), interpolation=cv2.INTER_NEAREST) > 0
            image[top : top + high, left : left + high][mask] = ink


def _road_arrows(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Straight, turning and forked arrows of lanes."""
    thick, pitch = max(3, size // 7), int(size * random.uniform(1.1, 2.0))
    for top in _rows(image, random, size):
        for left in range(int(random.integers(0, size)), image.shape[1], pitch):
            middle, foot = left + size // 2, top + size
            for way in random.choice([-1, 0, 1], int(random.integers(1, 3)), replace=False).tolist():
                tip = (middle + way * size // 3, top + (size // 4 if way else 0))
                knee = (middle, top + size // 2)
                cv2.line(image, (middle, foot), knee, ink, thick, cv2.LINE_AA)
                cv2.arrowedLine(image, knee, tip, ink, thick, cv2.LINE_AA, tipLength=0.6)


def _pictograms(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """People who stand, run or sit, stairs, cups and doors, as signs show them."""
    thick, pitch = max(3, size // 7), int(size * random.uniform(1.2, 2.2))
    people = [
        [[[0.5, 0.3], [0.5, 0.65]], [[0.5, 0.65], [0.3, 1.0]], [[0.5, 0.65], [0.7, 1.0]], [[0.25, 0.4], [0.75, 0.4]]],
        [[[0.5, 0.3], [0.4, 0.6]], [[0.4, 0.6], [0.65, 0.8]], [[0.4, 0.6], [0.15, 0.9]], [[0.48, 0.4], [0.8, 0.5]]],
        [[[0.4, 0.3], [0.4, 0.7]], [[0.4, 0.7], [0.75, 0.7]], [[0.75, 0.7], [0.75, 1.0]], [[0.4, 0.45], [0.65, 0.5]]],
    ]
    things = [
        [[[0.0, 1.0], [0.3, 1.0]], [[0.3, 1.0], [0.3, 0.7]], [[0.3, 0.7], [0.6, 0.7]], [[0.6, 0.7], [0.6, 0.4]]],
        [[[0.1, 0.2], [0.2, 0.9]], [[0.2, 0.9], [0.6, 0.9]], [[0.6, 0.9], [0.7, 0.2]], [[0.1, 0.2], [0.7, 0.2]]],
        [[[0.2, 0.1], [0.2, 1.0]], [[0.2, 0.1], [0.7, 0.2]], [[0.7, 0.2], [0.7, 0.95]], [[0.2, 1.0], [0.7, 0.95]]],
    ]
    for top in _rows(image, random, size):
        for left in range(int(random.integers(0, size)), image.shape[1], pitch):
            kind = int(random.integers(0, 6))
            lines = np.array([*people, *things][kind])
            _strokes(image, lines, left, top, size, thick, ink)
            if kind < 3:
                cv2.circle(image, (left + int(0.5 * size), top + size // 8), size // 8, ink, -1, cv2.LINE_AA)


def _checked_cloth(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Stripes of several widths both ways, threads showing."""
    ground = image[0, 0].astype(float)
    sett = np.concatenate([np.full(int(random.integers(1, size // 2)), random.random()) for _ in range(6)])
    along = np.resize(sett, image.shape[1])
    across = np.resize(sett, image.shape[0])
    weave = (np.indices(image.shape[:2]).sum(axis=0) // 2) % 2 == 0
    share = np.where(weave, along[None, :], across[:, None])[..., None]
    image[:] = np.clip(ground + share * (np.array(ink) - ground), 0, 255).astype(np.uint8)


def _cracks(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Cracks in plaster that fork as they run."""
    for _ in range(int(random.integers(4, 14))):
        tips = [(*(random.random(2) * (image.shape[1], image.shape[0])).tolist(), random.uniform(0, 2 * np.pi))]
        for _ in range(int(random.integers(4, 14))):
            grown = []
            for x, y, angle in tips[:6]:
                for _ in range(1 + int(random.random() < 0.3)):
                    turned = angle + float(random.normal(0.0, 0.7))
                    step = size * float(random.uniform(0.2, 0.6))
                    end = (x + step * np.cos(turned), y + step * np.sin(turned))
                    cv2.line(image, (int(x), int(y)), (int(end[0]), int(end[1])), ink, max(1, size // 20), cv2.LINE_AA)
                    grown.append((*end, turned))
            tips = grown


def _sprayed_loops(image: Picture, random: np.random.Generator, size: int, ink: Ink) -> None:
    """Loops in one stroke, as they are sprayed on shutters."""
    for top in _rows(image, random, 2 * size):
        left, turns = float(random.integers(10, 120)), int(random.integers(3, 9))
        at = np.linspace(0.0, 2.0 * np.pi * turns, 40 * turns)
        reach = size * (0.5 + 0.4 * np.sin(at * random.uniform(0.1, 0.4) + random.uniform(0, 6)))
        x = left + at * size * random.uniform(0.08, 0.2) + reach * np.cos(at)
        y = top + size + reach * np.sin(at + random.uniform(0.0, 1.0))
        line = np.int32(np.column_stack([x, y]))
        cv2.polylines(image, [line], False, ink, max(2, size // int(random.integers(6, 12))), cv2.LINE_AA)


STROKES: dict[str, Draw] = {
    "runes": _runes,
    "tallies": _tallies,
    "lattices": _lattices,
    "rubble": _rubble,
    "square codes": _square_codes,
    "road arrows": _road_arrows,
    "pictograms": _pictograms,
    "checked cloth": _checked_cloth,
    "cracks": _cracks,
    "sprayed loops": _sprayed_loops,
}
