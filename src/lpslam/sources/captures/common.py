"""What the readers of captures share: decoding from memory, and files that are listed by number."""

import itertools
import math
import re
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.sources.images import decoded_image
from lpslam.sources.inside import PictureFile

RATE = 30.0
"""Frames a second, where a layout states none."""


def decoded_colour(data: bytes, name: str) -> NDArray[np.uint8]:
    """A JPEG or PNG as (height, width, 3) red, green, blue.

    Raises:
        BadImageError: it is truncated or no image.
    """
    return np.asarray(decoded_image(data, name, cv2.IMREAD_COLOR_RGB), np.uint8)


def number_of(path: PictureFile) -> int | None:
    """The last number in a picture's name, or in that of its folder where each has one."""
    digits = re.findall(r"\d{1,30}", path.stem) or re.findall(r"\d{1,30}", path.parent.name)
    return int(digits[-1]) if digits else None


def numbered(folder: Path, suffixes: tuple[str, ...]) -> dict[int, Path]:
    """The images of a folder by the last number in their names."""
    found: dict[int, Path] = {}
    for path in sorted(folder.iterdir()):
        number = number_of(path)
        if number is not None and path.suffix.lower() in suffixes:
            found[number] = path
    return found


def enlarged(depth: NDArray[np.float32], size: tuple[int, int]) -> NDArray[np.float32]:
    """Depth (h, w) of the same view at the size (width, height) of the colour image; readings are not mixed."""
    return np.asarray(cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST), np.float32)


def rising_times(seconds: Sequence[float], count: int, rate: float = RATE) -> tuple[list[float], tuple[str, ...]]:
    """The first `count` times where they are finite and rise; else `rate` frames a second, with a note."""
    times = list(seconds[:count])
    is_rising = all(later > earlier for earlier, later in itertools.pairwise(times))
    if len(times) == count and is_rising and all(map(math.isfinite, times)):
        return times, ()
    return [number / rate for number in range(count)], (f"its frames carry no times: {rate:g} a second are taken",)
