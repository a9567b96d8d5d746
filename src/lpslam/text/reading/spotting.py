"""Scene text recognition (paper, III-B): detection and recognition, called apart, behind one small protocol."""

import unicodedata
from itertools import groupby
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from lpslam.config import SpottingConfig
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.spelling import is_ideograph
from lpslam.text.reading.boxes import Boxes, letter_heights
from lpslam.text.reading.detection import TextDetector
from lpslam.text.reading.emblems import RINGS
from lpslam.text.reading.networks import load_network
from lpslam.text.reading.recognition import TextRecogniser
from lpslam.text.types import Recognition, SpottedText


@runtime_checkable
class TextSpotter(Protocol):
    """Anything that finds and reads text in an image."""

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[Boxes, NDArray[np.float64]]:
        """Find text in an (h, w, 3) image: boxes (n, 4, 2) px, ordered tl, tr, br, bl, and scores (n,)."""
        ...

    def recognise(self, rgb: NDArray[np.uint8], boxes: Boxes) -> list[Recognition]:
        """Read the boxes."""
        ...


@runtime_checkable
class ReadsElsewhere(Protocol):
    """A `TextSpotter` whose work is not done by the thread that asks.

    Attributes:
        seconds_elsewhere: of processor time that it has taken so far.
    """

    seconds_elsewhere: float


class PaddleSpotter:
    """DBNet detection and CTC recognition with PaddleOCR's networks.

    Raises:
        UserError: on creation, where the models or the engine are not installed.
    """

    def __init__(self, config: SpottingConfig) -> None:
        self._detector = TextDetector(load_network("det", config.engine, config.threads), config)
        self._recogniser = TextRecogniser(load_network("rec", config.engine, config.threads), config)

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[Boxes, NDArray[np.float64]]:
        """See `TextSpotter`."""
        return self._detector.detect(rgb)

    def recognise(self, rgb: NDArray[np.uint8], boxes: Boxes) -> list[Recognition]:
        """See `TextSpotter`."""
        return self._recogniser.recognise(rgb, boxes)


def _without_logos(text: str) -> str:
    """Drop symbols around a text: a logo beside the name is read as ★ or ●, a ring before a capitalised word as O."""
    rim = {ch for ch in text if unicodedata.category(ch) == "So" or ch in _LOGO_LIKE}
    text = text.strip("".join(rim) + " ")
    return text[1:] if text[:1] in _RINGS and text[1:2].isupper() and text[2:3].islower() else text


def _letters(text: str) -> int:
    """Letters and digits of a text; an ideograph counts for two unless a line, a box or a beam looks like it."""
    return sum(1 + (is_ideograph(ch) and ch not in _SHAPES) for ch in text if ch.isalnum())


_SHAPES = frozenset("一二三十口日目曰田由甲中回工土王山川人入八个卜丁了口凸凹亚皿四")
"""Ideographs that frames, tiles and beams are read as."""

_LOGO_LIKE = frozenset("*·•°~^_|<>=←↑→↓")
"""What icons, arrows and edges beside a text are read as."""

_RINGS = RINGS | {"Q", "@"}


SURE = 0.8
"""Confidence of a reading from which a box is not looked at in any other way."""

_RUN = 5
"""Equal letters in a row, more than half of a text, that no text has: a frieze is read so."""


def _is_run(text: str) -> bool:
    letters = [ch for ch in text.casefold().replace("0", "o") if ch.isalnum()]
    longest = max((len(list(same)) for _, same in groupby(letters)), default=0)
    return longest >= _RUN and 2 * longest > len(letters)


def _is_of_marks(text: str) -> bool:
    """Whether no more of a text is letters and digits than marks: goods on a shelf are read so, no known name is.

    Full stops after letters shorten words.
    """
    marks = sum(unicodedata.category(ch)[0] in "PS" and ch != "." for ch in text)
    return marks >= sum(map(str.isalnum, text))


def accepted_texts(boxes: Boxes, readings: list[Recognition], config: SpottingConfig) -> list[SpottedText | None]:
    """Clean what was read in (n, 4, 2) boxes; None in place of what is too unsure or too short to be a text."""
    texts: list[SpottedText | None] = []
    for box, height, read in zip(boxes, letter_heights(boxes), readings, strict=True):
        text = _without_logos(clean_text(read.text, config.max_length))
        is_spelt = _letters(text) >= config.min_letters and not _is_run(text) and not _is_of_marks(text)
        is_text = read.confidence >= config.min_confidence and is_spelt
        texts.append(SpottedText(text, read.confidence, box, float(height), *read[2:]) if is_text else None)
    return texts
