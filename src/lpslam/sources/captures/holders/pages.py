"""TIFF files of many pages, one picture each, as microscopes and ImageJ write them."""

import struct
import threading
import warnings
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from lpslam.sources.captures.holders.stacks import Entry
from lpslam.sources.images import MOST_PIXELS

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
    return path.suffix.lower() in SUFFIXES and _Pages(path).page(1) is not None


def entries_of(path: Path) -> Iterator[Entry]:
    """The pages as one array, which is called as the file.

    Raises:
        ValueError: it cannot be read.
    """
    pages = _Pages(path)
    first = pages.page(0)
    if first is None:
        raise ValueError("no page can be read")

    def read(index: Any) -> Any:
        page = pages.page(int(index))
        if page is None or page.shape != first.shape:
            raise ValueError(f"page {index} cannot be read, or has another size")
        return page

    yield Entry(path.stem, (len(pages), *first.shape), first.dtype.kind, 8 * first.dtype.itemsize, read)


class _Pages:
    """The pages of a file, which is opened once: each page says where the next one lies, and is not asked again."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._image: Image.Image | None = None
        # Asked again, a decoder may give what it had of such a page.
        self._damaged: set[int] = set()
        self._lock = threading.Lock()

    def page(self, number: int) -> NDArray[Any] | None:
        """A page's pixels; None where it cannot be read."""
        with self._lock, _quietly():
            try:
                image = self._opened()
                image.seek(number)
                if number not in self._damaged and image.width * image.height <= MOST_PIXELS:
                    return np.asarray(image)
            except _MALFORMED:
                self._damaged.add(number)
        return None

    def __len__(self) -> int:
        with self._lock, _quietly():
            try:
                return min(int(getattr(self._opened(), "n_frames", 1)), _MOST_PAGES)
            except _MALFORMED as error:
                raise ValueError(f"its pages cannot be counted ({type(error).__name__})") from error

    def _opened(self) -> Image.Image:
        if self._image is None:
            self._image = Image.open(self._path)
            weakref.finalize(self, self._image.close)
        return self._image


@contextmanager
def _quietly() -> Iterator[None]:
    """Of damaged tags and of large pictures the decoder warns, and goes on."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
