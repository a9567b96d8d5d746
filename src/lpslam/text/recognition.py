"""Scene text recognition (paper, III-B): four-point rectification, a convolutional network, CTC decoding."""

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import SpottingConfig
from lpslam.text.boxes import DOWNWARDS, Boxes
from lpslam.text.detection import network_input
from lpslam.text.emblems import without_emblems
from lpslam.text.networks import Network

# What the model was built for: lines of this height.
_LINE_HEIGHT = 48


class TextRecogniser:
    """Reads the text inside boxes."""

    def __init__(self, network: Network, config: SpottingConfig) -> None:
        self._network = network
        self._config = config
        # CTC's blank comes first, the space last.
        self._alphabet = np.array(["", *network.alphabet, " "])

    def recognise(self, rgb: NDArray[np.uint8], boxes: Boxes) -> list[tuple[str, float]]:
        """Read (n, 4, 2) boxes of an (h, w, 3) image: for each its text, perhaps empty, and confidence 0 to 1."""
        lines = [rectify(rgb, box, self._config.max_line_width) for box in boxes]
        results = [("", 0.0)] * len(lines)
        for batch in self._batches([_padded(line.shape[1]) for line in lines]):
            probabilities = self._network.infer(_stack([lines[index] for index in batch]))
            for index, line in zip(batch, probabilities, strict=True):
                text, confidence = decode_ctc(line, self._alphabet)
                results[index] = without_emblems(lines[index], text), confidence
        return results

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


def decode_ctc(probabilities: NDArray[np.float32], alphabet: NDArray[np.str_]) -> tuple[str, float]:
    """Decode greedily: the best class of each step, repeats and blanks (class 0) removed.

    Args:
        probabilities: (steps, classes).
        alphabet: (classes,) one character each.

    Returns:
        The text, and the mean probability of its letters; ("", 0.0) when there are none.
    """
    best = probabilities.argmax(axis=1)
    kept = best != 0
    kept[1:] &= best[1:] != best[:-1]
    if not kept.any():
        return "", 0.0
    letters = best[kept]
    return "".join(alphabet[letters].tolist()), float(probabilities[kept, letters].mean())


def _padded(width: int) -> int:
    """Round a width up: the engine prepares itself anew for every new shape."""
    return -(-width // 32) * 32


def _stack(lines: Sequence[NDArray[np.uint8]]) -> NDArray[np.float32]:
    """Stack lines of equal padded width into one batch, padded right with mid-grey."""
    batch = np.zeros((len(lines), 3, _LINE_HEIGHT, _padded(lines[0].shape[1])), np.float32)
    for row, line in zip(batch, lines, strict=True):
        row[:, :, : line.shape[1]] = network_input(line)[0]
    return batch
