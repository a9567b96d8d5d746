"""Relative poses of keyframes, as whole pictures tell them, beside the points that keyframes share."""

from collections import deque
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import PictureConfig
from lpslam.slam.kernels.relative import RelativeProblem

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


class RelativePoses:
    """What pictures say of pairs of keyframes, and how far it is believed.

    A picture says how sure it is as if each of its pixels erred by itself. By how much more it errs shows where three
    keyframes are compared with one another and the way round does not close, times what is wrong alike in all three. It
    errs no more than it differs from the map where the camera moves calmly: what keypoints err adds to that.

    Args:
        config: thresholds.
    """

    def __init__(self, config: PictureConfig) -> None:
        self._config = config
        self.forget()

    def forget(self) -> None:
        """Know nothing: what was compared is measured otherwise now."""
        self._pairs = np.empty((0, 2), np.int32)
        self._a_from_b: list[_Matrix] = []
        self._information: list[_Matrix] = []
        supposed = [self._config.supposed_gap] * self._config.supposed_gaps
        self._gaps: deque[float] = deque(supposed, maxlen=self._config.remembered_gaps)
        self._differences: deque[float] = deque(maxlen=self._config.remembered_gaps)

    @property
    def judged(self) -> int:
        """How many ways round have been looked at, as far as they are remembered."""
        return max(len(self._gaps) - self._config.supposed_gaps, 0)

    @property
    def excess(self) -> float:
        """By which factor the variance of relative poses is more than pictures say."""
        most = self._config.unseen_errors * float(np.median(self._gaps))
        if len(self._differences) >= self._config.judged_first:
            most = min(most, float(np.median(self._differences)))
        return max(most / _MEDIAN_CHI2, 1.0)

    def judge(self, gap: float) -> None:
        """Learn from a way round three keyframes: χ² (six degrees of freedom) by which it does not close."""
        self._gaps.append(gap)

    def differ(self, difference: float) -> None:
        """Learn from a calm step: χ² by which what pictures say differs from a map that they did not touch yet."""
        self._differences.append(difference)

    def add(self, a: int, b: int, b_from_a: _Matrix, information: _Matrix) -> None:
        """Keep a relative pose (4×4, camera b from camera a) with its information.

        Args:
            a, b: keyframes.
            b_from_a: (4, 4).
            information: (6, 6) of a twist (translation, rotation vector) in the frame of camera b, as pictures say it.
        """
        self._pairs = np.concatenate([self._pairs, np.array([[a, b]], np.int32)])
        self._a_from_b.append(inverse_transform(b_from_a))
        self._information.append(information)

    def among(self, keyframes: _Rows, free: int) -> RelativeProblem:
        """Those between some keyframes, by their rows, as far as they are believed; the first `free` may move."""
        highest = max(int(self._pairs.max(initial=-1)), int(keyframes.max(initial=-1)))
        row = np.full(highest + 1, -1, np.int32)
        row[keyframes] = np.arange(len(keyframes))
        rows = row[self._pairs]
        known = np.flatnonzero((rows >= 0).all(axis=1) & (rows < free).any(axis=1))
        return RelativeProblem(
            np.ascontiguousarray(rows[known]),
            _stacked((self._a_from_b[k] for k in known), 4),
            _stacked((self._information[k] for k in known), 6) / self.excess,
        )


def _stacked(matrices: Iterable[_Matrix], size: int) -> _Matrix:
    return np.array([*matrices], np.float64).reshape(-1, size, size)


_MEDIAN_CHI2 = 5.348
"""Median of the χ² distribution with six degrees of freedom."""
