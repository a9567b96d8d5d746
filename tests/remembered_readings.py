"""What the networks read in a picture, kept for whoever has the same picture read again."""

import hashlib
import os
import pickle
import threading
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from lpslam.config import SpottingConfig
from lpslam.text.reading.boxes import Boxes
from lpslam.text.reading.spotting import PaddleSpotter
from lpslam.text.types import Recognition

Read = TypeVar("Read")


class RememberingSpotter(PaddleSpotter):
    """Reads the pixels of a picture once for all tests and processes: most tests show it the same walk.

    Attributes:
        folder: where readings are kept.
    """

    folder: ClassVar[Path]

    def __init__(self, config: SpottingConfig) -> None:
        super().__init__(config)
        self._settings = repr(config)

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[Boxes, NDArray[np.float64]]:
        """See `TextSpotter`."""
        return self._remembered("detect", (rgb,), lambda: PaddleSpotter.detect(self, rgb))

    def recognise(self, rgb: NDArray[np.uint8], boxes: Boxes) -> list[Recognition]:
        """See `TextSpotter`."""
        return self._remembered("recognise", (rgb, boxes), lambda: PaddleSpotter.recognise(self, rgb, boxes))

    def _remembered(self, what: str, arrays: tuple[NDArray[np.generic], ...], read: Callable[[], Read]) -> Read:
        asked = hashlib.sha256(f"{self._settings} {what} {[each.shape for each in arrays]}".encode())
        for each in arrays:
            asked.update(np.ascontiguousarray(each).data)
        path = self.folder / asked.hexdigest()
        if path.exists():
            kept: Read = pickle.loads(path.read_bytes())
            return kept
        found = read()
        unfinished = path.with_suffix(f".{os.getpid()}.{threading.get_ident()}")
        unfinished.write_bytes(pickle.dumps(found))
        unfinished.rename(path)
        return found
