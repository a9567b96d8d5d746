"""TIFF files of many pages, one picture each, as microscopes and ImageJ write them."""

import struct
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from lpslam.sources.captures.holders.stacks import Entry

SUFFIXES = frozenset((".tif", ".tiff"))
_MOST_PAGES = 100_000
_MALFORMED = (
    OSError,
    ValueError,
    EOFError,
    SyntaxError,
    KeyError,
    TypeError,
    struct.error,
    Image.DecompressionBombError,
)


def has_pages(path: Path) -> bool:
    """Whether a file is a TIFF of two pages and more."""
    return path.suffix.lower() in SUFFIXES and _page(path, 1) is not None


def entries_of(path: Path) -> Iterator[Entry]:
    """The pages as one array, which is called as the file.

    Raises:
        ValueError: it cannot be read.
    """
    first = _page(path, 0)
    if first is None:
        raise ValueError("no page can be read")

    def read(index: Any) -> Any:
        page = _page(path, int(index))
        if page is None or page.shape != first.shape:
            raise ValueError(f"page {index} cannot be read, or has another size")
        return page

    yield Entry(path.stem, (_count(path), *first.shape), first.dtype.kind, 8 * first.dtype.itemsize, read)


def _page(path: Path, number: int) -> NDArray[Any] | None:
    try:
        # Of damaged tags and of large pictures it warns, and goes on.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as image:
                image.seek(number)
                return np.asarray(image)
    except _MALFORMED:
        return None


def _count(path: Path) -> int:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with Image.open(path) as image:
                return min(int(getattr(image, "n_frames", 1)), _MOST_PAGES)
        except _MALFORMED as error:
            raise ValueError(f"its pages cannot be counted ({type(error).__name__})") from error
