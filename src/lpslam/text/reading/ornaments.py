"""Ornaments that a reader takes for text: friezes, meanders, arcades, railings.

A pattern explains itself: moved by one period it falls on itself, again and again. A line of text does so by as many
equal letters as it has in a row, and no word has five; nor does one say the same syllable four times. A pattern is
seldom found as a whole: where a box holds but a piece of it, it goes on beyond the box, and text does not.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.text.reading.boxes import Boxes, along_the_lines
from lpslam.text.reading.patterns import ALIKE, SUSPECT_ALIKE, Likeness, likely_lags, likeness
from lpslam.text.reading.recognition import rectify
from lpslam.text.reading.spelt_patterns import CLEAR, SUSPECT, pattern_odds

Array = NDArray[np.float64]

_PERIODS = 4.5
"""Periods from which a strip is a pattern: four equal letters are written (0000), and a box is cut off unevenly."""

_PERIODS_OF_SEVERAL = 3.3
"""The same where a period holds several pieces: BANANA and WWW have three."""

_PIECES = 1.6
"""Pieces, parted by gaps, that a period must hold to be of several, in the mean: letters are cracked, or touch."""

_EXPLAINED = 0.8
"""Correlation of a strip with itself, one period on, from which the period explains two thirds of what varies in it:
letters that are spaced out evenly and blurred mostly correlate less."""

_DIP = 0.3
"""Correlation below which a strip must first fall: until then it only shows how thick its strokes are."""

_SAME = 0.9
"""Share of the highest peak from which an earlier one is the period: two periods fall on each other as well."""

_HEIGHT = 16
"""Height, pixels, at which strips are compared: strokes of a tenth of it are still seen."""

_TOLERANCE = 0.7
"""Pixels of such a strip by which strokes are widened before they are compared."""

_GAP = 0.08
"""Largest share of ink in a column between two letters."""

_LONGEST = 1024
"""Width, pixels, beyond which a strip is squeezed."""

_BEYOND = 3.0
"""Box heights beyond each end of a box in which its pattern is sought."""

_FLAT = 0.3
"""Share of the strongest contrast below which a column at an end is ground."""


def pattern_likenesses(rgb: NDArray[np.uint8], boxes: Boxes) -> list[Likeness]:
    """How like a pattern each of (n, 4, 2) boxes of an (h, w, 3) image is."""
    return [Likeness.IS if is_pattern(_strip(rgb, box)) else _along_its_line(rgb, box) for box in boxes]


def says_a_pattern(rgb: NDArray[np.uint8], box: NDArray[np.float64], text: str) -> bool:
    """Whether what was read in a (4, 2) box is spelt as patterns are, beyond doubt or with the picture for it."""
    odds = pattern_odds(text)
    if odds < SUSPECT:
        return False
    return odds >= CLEAR or _along_its_line(rgb, box, SUSPECT_ALIKE) is Likeness.IS


def says_a_text(text: str) -> bool:
    """Whether what was read is spelt as texts are and patterns are not: evenly set characters look alike, blurred."""
    return pattern_odds(text) <= -SUSPECT


def is_pattern(strip: Array) -> bool:
    """Whether a strip (height, width), as levels of grey, repeats itself more often than letters do."""
    # Strokes fall on each other a period on, though seen aslant they are half a pixel beside.
    strip = _blurred(strip)
    periods, correlation = repetition(strip)
    if correlation < _EXPLAINED or periods < _PERIODS_OF_SEVERAL:
        return False
    return periods >= _PERIODS or _pieces(strip) >= _PIECES * periods


def repetition(strip: Array) -> tuple[float, float]:
    """How many periods a strip (height, width) has, and its correlation with itself one period on; (1, 0) without."""
    strip = _without_blank_ends(strip)
    width = strip.shape[1]
    correlations = _autocorrelation(strip)[: max(2 * width // 3, 1)]
    fallen = np.flatnonzero(correlations < _DIP)
    if not len(fallen):
        return 1.0, 0.0
    lags = np.arange(fallen[0] + 1, len(correlations) - 1)
    before, here, after = correlations[lags - 1], correlations[lags], correlations[lags + 1]
    lags = lags[(here >= before) & (here >= after)]
    if not len(lags) or correlations[lags].max() <= 0.0:
        return 1.0, 0.0
    period = int(lags[correlations[lags] >= _SAME * correlations[lags].max()][0])
    before, here, after = correlations[period - 1 : period + 2]
    # Small periods are no whole number of pixels: the peak of the parabola through three.
    shift = 0.5 * (before - after) / min(before - 2.0 * here + after, -1e-9)
    return width / (period + shift), float(here)


def _along_its_line(rgb: NDArray[np.uint8], box: Boxes, alike: float = ALIKE) -> Likeness:
    """Whether a box holds a piece of a pattern that goes on along its line."""
    line = along_the_lines(box[None])[0]
    height = max(float(np.linalg.norm(line[3] - line[0] + line[2] - line[1])) / 2.0, 1.0)
    before, after = (_room(rgb, ends, height) for ends in (line[[1, 0, 2, 3]], line[[0, 1, 3, 2]]))
    along = np.stack([line[1] - line[0], line[1] - line[0], line[2] - line[3], line[2] - line[3]])
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    wide = line + along * np.array([-before, after, after, -before])[:, None]
    strip = _blurred(_strip(rgb, wide))
    share = strip.shape[1] / max(float(np.linalg.norm(wide[1] - wide[0] + wide[2] - wide[3])) / 2.0, 1.0)
    own = slice(round(before * share), strip.shape[1] - round(after * share))
    if own.stop <= own.start:
        return Likeness.NONE
    # Of a wall seen aslant each part has a period of its own.
    third = max(strip.shape[1] // 3, 1)
    parts = [strip[:, own], strip, *(strip[:, start : start + third] for start in range(0, 3 * third, third))]
    lags = {lag for part in parts for lag in likely_lags(_autocorrelation(part), _HEIGHT)}
    return likeness(strip, own, sorted(lags), _pieces, alike)


def _room(rgb: NDArray[np.uint8], sides: Boxes, height: float) -> float:
    """Pixels, up to `_BEYOND` heights, by which a box's two long sides (from, to; from, to) may go on in the image."""
    room = _BEYOND * height
    last = np.array(rgb.shape[1::-1]) - 1.0
    for start, end in ((sides[0], sides[1]), (sides[3], sides[2])):
        step = (end - start) / max(float(np.linalg.norm(end - start)), 1e-9)
        for axis in (0, 1):
            if abs(step[axis]) > 1e-6:
                limit = last[axis] if step[axis] > 0 else 0.0
                room = min(room, float((limit - end[axis]) / step[axis]))
    return max(room, 0.0)


def _blurred(strip: Array) -> Array:
    return np.asarray(cv2.GaussianBlur(strip, (0, 0), _TOLERANCE), np.float64)


def _strip(rgb: NDArray[np.uint8], box: Boxes) -> Array:
    line = cv2.cvtColor(rectify(rgb, box, _LONGEST * 3), cv2.COLOR_RGB2GRAY)
    size = max(round(line.shape[1] * _HEIGHT / line.shape[0]), 2), _HEIGHT
    return np.asarray(cv2.resize(line, size, interpolation=cv2.INTER_AREA), np.float64)


def _pieces(strip: Array) -> int:
    """How many pieces of ink, parted by gaps, stand in a strip."""
    strip = _without_blank_ends(strip)
    levels = np.clip(strip, 0.0, 255.0).astype(np.uint8)
    threshold, _ = cv2.threshold(levels, 0, 255, cv2.THRESH_OTSU)
    bright = levels > threshold
    ink = ~bright if bright[[0, -1]].mean() > 0.5 else bright
    inked = ink.mean(axis=0) > _GAP
    return int((np.diff(inked.astype(np.int8), prepend=0) == 1).sum())


def _without_blank_ends(strip: Array) -> Array:
    contrast = np.abs(strip - np.median(strip)).max(axis=0)
    drawn = np.flatnonzero(contrast > _FLAT * contrast.max())
    return strip[:, drawn[0] : drawn[-1] + 1] if len(drawn) else strip


def _autocorrelation(strip: Array) -> Array:
    """Correlation (width,) of a strip with itself so many columns on, without what is the same all along a row."""
    strip = strip - strip.mean(axis=1, keepdims=True)
    width = strip.shape[1]
    spectrum = np.fft.rfft(strip, 2 * width, axis=1)
    products = np.fft.irfft((np.abs(spectrum) ** 2).sum(axis=0), 2 * width)[:width]
    energy = np.concatenate([[0.0], np.cumsum((strip**2).sum(axis=0))])
    first, second = energy[width:0:-1], energy[width] - energy[:width]
    return np.asarray(products / np.sqrt(np.maximum(first * second, 1e-9)), np.float64)
