"""Scene text recognition (paper, III-B): four-point rectification, a convolutional network, CTC decoding."""

import re
from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import SpottingConfig
from lpslam.language.model import Slot, Slots
from lpslam.language.tables.spelling import is_ideograph
from lpslam.text.reading.boxes import DOWNWARDS, Boxes
from lpslam.text.reading.detection import network_input
from lpslam.text.reading.emblems import without_emblems
from lpslam.text.reading.networks import Network
from lpslam.text.types import Recognition

# What the model was built for: lines of this height.
_LINE_HEIGHT = 48
# Letters kept of one place, and the least probability of a runner-up: what is less likely never decides.
_KEPT_LETTERS, _LEAST_LETTER = 4, 0.003
# Probability from which a letter between two others counts as nearly read.
_NEARLY_READ = 0.1
# Ideographs from which their places tell whether they stand evenly; times the usual step from one to the next, and
# steps of the network (six to a letter's height), from which another one has room between two. Of 1,269 readings of
# drawn and rendered signs 17 have such a hole, one of them right.
_IDEOGRAPHS_IN_STEP, _HOLE, _HOLE_STEPS = 3, 1.7, 3.0
# Grey values; below it a line has noise for edges.
_LEAST_CONTRAST = 8.0


class TextRecogniser:
    """Reads the text inside boxes."""

    def __init__(self, network: Network, config: SpottingConfig) -> None:
        self._network = network
        self._config = config
        # CTC's blank comes first, the space last.
        self._alphabet = np.array(["", *network.alphabet, " "])

    def recognise(self, rgb: NDArray[np.uint8], boxes: Boxes) -> list[Recognition]:
        """Read (n, 4, 2) boxes of an (h, w, 3) image."""
        lines = [rectify(rgb, box, self._config.max_line_width) for box in boxes]
        results = self._read(lines)
        narrow = [row for row, read in enumerate(results) if self._is_narrow(lines[row], read.text)]
        widened = self._read([self._widened(lines[row], results[row].text) for row in narrow])
        for row, read in zip(narrow, widened, strict=True):
            if read.confidence >= results[row].confidence:
                results[row] = read._replace(sharpness=results[row].sharpness)
        return results

    def _read(self, lines: Sequence[NDArray[np.uint8]]) -> list[Recognition]:
        """Read upright lines (48, w, 3)."""
        results = [Recognition("", 0.0)] * len(lines)
        for batch in self._batches([_padded(line.shape[1]) for line in lines]):
            probabilities = self._network.infer(_stack([lines[index] for index in batch]))
            for index, line in zip(batch, probabilities, strict=True):
                read = decode_ctc(line, self._alphabet)
                text = without_emblems(lines[index], read.text)
                results[index] = read._replace(text=text, sharpness=edge_sharpness(lines[index]))
        return results

    def _is_narrow(self, line: NDArray[np.uint8], text: str) -> bool:
        """Whether the letters that were read in a line are so narrow that the network has too few steps for each."""
        return bool(line.shape[1] < self._config.narrow_letters * _LINE_HEIGHT * len(text))

    def _widened(self, line: NDArray[np.uint8], text: str) -> NDArray[np.uint8]:
        """A line of narrow letters, as wide as letters are that are seen from straight ahead; twice as wide at most."""
        wanted = round(self._config.widened_letters * _LINE_HEIGHT * len(text))
        width = min(wanted, 2 * line.shape[1], self._config.max_line_width)
        return np.asarray(cv2.resize(line, (width, _LINE_HEIGHT), interpolation=cv2.INTER_CUBIC), dtype=np.uint8)

    def _batches(self, widths: Sequence[int]) -> Iterator[list[int]]:
        """Group lines of equal padded width: then none is computed wider than it is, or reads otherwise in company."""
        for width in sorted(set(widths)):
            equal = [index for index, each in enumerate(widths) if each == width]
            for start in range(0, len(equal), self._config.recognition_batch):
                yield equal[start : start + self._config.recognition_batch]


def rectify(rgb: NDArray[np.uint8], box: NDArray[np.float64], max_width: int) -> NDArray[np.uint8]:
    """Warp the quadrilateral `box` (4, 2) to an upright line, 48 pixels high, in one perspective resampling.

    A box at least half again as high as wide is taken for a line that runs downwards and is turned.
    """
    top, right, bottom, left = np.linalg.norm(np.roll(box, -1, axis=0) - box, axis=1)
    width, height = max(top, bottom, 1.0), max(left, right, 1.0)
    if height >= DOWNWARDS * width:
        box, width, height = np.roll(box, -1, axis=0), height, width
    columns = int(np.clip(round(width / height * _LINE_HEIGHT), 8, max_width))
    target = np.array([[0, 0], [columns, 0], [columns, _LINE_HEIGHT], [0, _LINE_HEIGHT]], np.float32)
    homography = cv2.getPerspectiveTransform(box.astype(np.float32), target)
    # Text larger than the line is first averaged down by the warp's own scale, else strokes alias.
    shrink = height / _LINE_HEIGHT
    interpolation = cv2.INTER_CUBIC if shrink <= 1.5 else cv2.INTER_AREA
    if shrink > 1.5:
        oversize = int(np.ceil(shrink))
        big = cv2.warpPerspective(
            rgb,
            np.diag([oversize, oversize, 1.0]) @ homography,
            (columns * oversize, _LINE_HEIGHT * oversize),
            flags=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return np.asarray(cv2.resize(big, (columns, _LINE_HEIGHT), interpolation=interpolation), dtype=np.uint8)
    line = cv2.warpPerspective(
        rgb, homography, (columns, _LINE_HEIGHT), flags=interpolation, borderMode=cv2.BORDER_REPLICATE
    )
    return np.asarray(line, dtype=np.uint8)


def decode_ctc(probabilities: NDArray[np.float32], alphabet: NDArray[np.str_]) -> Recognition:
    """Decode greedily: the best class of each step, repeats and blanks (class 0) removed; runners-up are kept.

    Args:
        probabilities: (steps, classes).
        alphabet: (classes,) one character each.

    Returns:
        The text, the mean probability of its letters, and the slots; an empty text when there are none.
    """
    best = probabilities.argmax(axis=1)
    starts = np.flatnonzero(np.concatenate([[True], best[1:] != best[:-1]]))
    kept = starts[best[starts] != 0]
    if not len(kept):
        return Recognition("", 0.0)
    text = "".join(alphabet[best[kept]].tolist())
    mended = _THOUSANDS.sub(",", _LONG_VOWEL.sub("ー", text))
    slots = _slots(probabilities, best, starts, alphabet)
    return Recognition(
        mended,
        float(probabilities[kept, best[kept]].mean()),
        slots if mended == text else _respelt(slots, mended),
        has_hole=_has_hole(text, probabilities, best, starts),
    )


def _respelt(slots: Slots, text: str) -> Slots:
    """The slots with the letters of a text of as many taken instead."""
    letters = iter(text)
    taken = [(slot, next(letters) if slot[0][0] else "") for slot in slots]
    return tuple(((letter, slot[0][1]), *(each for each in slot[1:] if each[0] != letter)) for slot, letter in taken)


_LONG_VOWEL = re.compile("(?<=[ぁ-ゖァ-ヺ])一(?![一-鿿])")
"""A stroke right behind kana and before no ideograph: the long vowel's mark, which looks like the ideograph for one."""

_THOUSANDS = re.compile(r"(?<=\d)\.(?=\d{3}\s?[円元圆圓])")
"""A point before three digits and yen or yuan, of which no price has thousandths: a comma whose tail is not seen."""


def _has_hole(text: str, probabilities: NDArray[np.float32], best: NDArray[np.intp], starts: NDArray[np.intp]) -> bool:
    """Whether two ideographs stand so much farther apart than the others that one more has room between them."""
    if sum(map(is_ideograph, text)) < _IDEOGRAPHS_IN_STEP:
        return False
    ends = [*starts[1:].tolist(), len(best)]
    runs = [slice(start, end) for start, end in zip(starts.tolist(), ends, strict=True) if best[start] != 0]
    middles = [
        float(np.average(np.arange(run.start, run.stop), weights=probabilities[run, best[run.start]])) for run in runs
    ]
    gaps = np.array(
        [
            middles[at + 1] - middles[at]
            for at in range(len(text) - 1)
            if is_ideograph(text[at]) and is_ideograph(text[at + 1])
        ]
    )
    if len(gaps) < 2:
        return False
    widest = int(gaps.argmax())
    usual = float(np.median(np.delete(gaps, widest)))
    return bool(gaps[widest] >= max(_HOLE * usual, usual + _HOLE_STEPS))


def _slots(
    probabilities: NDArray[np.float32], best: NDArray[np.intp], starts: NDArray[np.intp], alphabet: NDArray[np.str_]
) -> Slots:
    """What may stand at each letter, where it is surest; and between letters, where one was nearly read."""
    slots: list[Slot] = []
    ends = [*starts[1:].tolist(), len(best)]
    for start, end in zip(starts.tolist(), ends, strict=True):
        run = probabilities[start:end]
        if best[start] != 0:
            slots.append(_likeliest(run[run[:, best[start]].argmax()], alphabet))
            continue
        # At the rim of a letter its own probability fades: what is read there already is no letter between.
        beside = [int(best[at]) for at in (start - 1, end) if 0 <= at < len(best)]
        letters = run[:, 1:].copy()
        letters[:, [each - 1 for each in beside if each]] = 0.0
        step = int(letters.max(axis=1).argmax())
        if letters[step].max() >= _NEARLY_READ:
            slots.append(_likeliest(run[step], alphabet))
    return tuple(slots)


def _likeliest(step: NDArray[np.float32], alphabet: NDArray[np.str_]) -> Slot:
    rows = np.argpartition(step, -_KEPT_LETTERS)[-_KEPT_LETTERS:]
    rows = rows[np.argsort(-step[rows], kind="stable")]
    kept = [row for place, row in enumerate(rows.tolist()) if place == 0 or step[row] >= _LEAST_LETTER]
    return tuple((str(alphabet[row]), round(float(step[row]), 4)) for row in kept)


def edge_sharpness(line: NDArray[np.uint8]) -> float:
    """Steepest edge along an upright (h, w, 3) line, as a share of the line's contrast a pixel, 0 to 1."""
    grey = line[..., 1].astype(np.float32)
    dark, bright = np.percentile(grey[::2, ::2], (5.0, 95.0))
    steepest = np.percentile(np.abs(np.diff(grey[::2], axis=1)), 99.0)
    return float(min(steepest / max(bright - dark, _LEAST_CONTRAST), 1.0))


def _padded(width: int) -> int:
    """Round a width up: the engine prepares itself anew for every new shape."""
    return -(-width // 32) * 32


def _stack(lines: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
    """Stack lines of equal padded width into one batch, padded right with mid-grey."""
    batch = np.zeros((len(lines), 3, _LINE_HEIGHT, _padded(lines[0].shape[1])), np.float32)
    for row, line in zip(batch, lines, strict=True):
        row[:, :, : line.shape[1]] = network_input(line)[0]
    return batch
