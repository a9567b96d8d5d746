"""Pieces of a pattern: whether what is in a box goes on beside it, motif by motif.

Motifs of a wall seen aslant shrink and shift along it, so each is held against the next one by itself, with a little
room for where that stands; a pattern is a run of such pairs that leads through the box and beyond it.
"""

from collections.abc import Callable, Iterable
from enum import IntEnum

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ALIKE = 0.9
"""Correlation from which two neighbouring motifs are the same: letters of one word correlate less, blurred too."""

_NEARLY_ALIKE = 0.86
"""The same, of which blurred words fall short in most views only: a single view says nothing then."""

_MOTIFS, _MOTIFS_OF_SEVERAL = 4.6, 3.6
"""Motifs in a row from which they are a pattern: four equal letters are written (0000); and where a motif holds several
pieces: the same syllable is said three times at most."""

_PIECES = 1.6
"""Pieces, parted by gaps, that a motif must hold in the mean to be of several."""

_COVERED = 0.75
"""Share of the box that the runs must fill: a name may stand beside a frieze."""

_LEAST_PERIOD, _LARGEST_PERIOD = 0.3, 2.2
"""Heights of a box that a motif may be wide: stems of letters stand closer, a word that is repeated is wider."""

_SLACK_ALONG, _SLACK_ACROSS = 0.2, 1
"""Share of a period by which the next motif may stand elsewhere, and pixels above or below."""

_LAGS, _LEAST_PEAK = 2, 0.25
"""Periods that are tried in each part of a strip: the highest peaks, no lower, of its correlation with itself."""

_FAINT = 0.12
"""Share of the box's contrast below which a motif is ground."""


class Likeness(IntEnum):
    """How like a pattern what is in a box is."""

    NONE = 0
    LIKE = 1
    IS = 2


SUSPECT_ALIKE = 0.74
"""The same where the letters that were read speak for a pattern: drawn words, of equal letters too, correlate less."""


def likeness(
    strip: Array, box: slice, lags: Iterable[int], pieces: Callable[[Array], int], alike: float = ALIKE
) -> Likeness:
    """Whether runs of equal motifs lead through the columns of a box in a strip (height, width), perhaps beyond it.

    Args:
        strip: levels of grey.
        box: the columns that were taken for text.
        lags: periods to try, columns.
        pieces: counts the pieces of ink in a strip.
        alike: correlation from which two neighbouring motifs are the same.
    """
    spread = float(strip[:, box].std())
    if spread < 1.0:
        return Likeness.NONE
    by_lag = [(lag, neighbours_alike(strip, lag, _FAINT * spread)) for lag in lags]
    for least, found in ((alike, Likeness.IS), (min(_NEARLY_ALIKE, alike), Likeness.LIKE)):
        explained = np.zeros(strip.shape[1], np.bool_)
        for lag, correlations in by_lag:
            for first, last in runs(correlations >= least):
                if _are_motifs(strip, first, last, lag, pieces):
                    explained[first : last + lag] = True
        if float(explained[box].mean()) >= _COVERED:
            return found
    return Likeness.NONE


def _are_motifs(strip: Array, first: int, last: int, lag: int, pieces: Callable[[Array], int]) -> bool:
    """Whether a run of pairs (from the first column to before the last) is of enough motifs."""
    # The last motif of a run is that which its last pair leads to.
    motifs = (last - first) / lag + 1.0
    if motifs < _MOTIFS_OF_SEVERAL:
        return False
    return motifs >= _MOTIFS or pieces(strip[:, first : last + lag]) >= _PIECES * motifs


def neighbours_alike(strip: Array, lag: int, faint: float) -> Array:
    """For each column (width - lag,) how like the motif around it is the one a period on; 0 where there is none."""
    slack = max(1, round(_SLACK_ALONG * lag))
    width = strip.shape[1] - lag
    here = strip[:, :width]
    mean, deviation = _moments(here.mean(axis=0), (here * here).mean(axis=0), lag)
    wide = np.pad(strip, ((_SLACK_ACROSS, _SLACK_ACROSS), (slack, slack)), mode="edge")
    best = np.zeros(width)
    for down in range(2 * _SLACK_ACROSS + 1):
        # One row each way that the next motif may stand along the strip: (ways, width).
        there = wide[down : down + strip.shape[0], lag:]
        means, squares = (_moved(each.mean(axis=0), width) for each in (there, there * there))
        other, spread = _moments(means, squares, lag)
        products = np.einsum("hc,hwc->wc", here, _moved(there, width)) / len(strip)
        covariance = _over_motif(products, lag) - mean * other
        clear = (deviation > faint) & (spread > faint)
        alike = np.where(clear, covariance / np.maximum(deviation * spread, 1e-6), 0.0)
        best = np.maximum(best, alike.max(axis=0))
    return best


def _moved(columns: Array, width: int) -> Array:
    """Columns (..., m) from each start that leaves so many of them: (..., ways, width)."""
    return np.lib.stride_tricks.sliding_window_view(columns, width, axis=-1)


def _moments(means: Array, squares: Array, lag: int) -> tuple[Array, Array]:
    """Mean and deviation over one period about each column of what has such means and squares in columns."""
    mean = _over_motif(means, lag)
    return mean, np.sqrt(np.maximum(_over_motif(squares, lag) - mean * mean, 0.0))


def _over_motif(columns: Array, lag: int) -> Array:
    """Means over one period about each of the last axis."""
    means = cv2.blur(np.ascontiguousarray(np.atleast_2d(columns)), (lag | 1, 1), borderType=cv2.BORDER_REPLICATE)
    return np.asarray(means, np.float64).reshape(columns.shape)


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and one past the last index of each run of a mask (n,)."""
    steps = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    return list(zip(np.flatnonzero(steps == 1).tolist(), np.flatnonzero(steps == -1).tolist(), strict=True))


def likely_lags(correlations: Array, height: int) -> list[int]:
    """Columns at which the correlation of a strip, so many rows high, with itself (width,) has its highest peaks."""
    lags = np.arange(1, max(2 * len(correlations) // 3, 2) - 1)
    before, here, after = correlations[lags - 1], correlations[lags], correlations[lags + 1]
    likely = (here > before) & (here >= after) & (here > _LEAST_PEAK)
    peaks = lags[likely & (lags >= _LEAST_PERIOD * height) & (lags <= _LARGEST_PERIOD * height)]
    order = np.argsort(-correlations[peaks], kind="stable")
    return [int(each) for each in peaks[order][:_LAGS]]
