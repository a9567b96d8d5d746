"""Which depth a sensor's readings stand for, by how far they are."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.features import Features
from lpslam.slam.kernels import ranges as kernels
from lpslam.slam.sensor import SensorModel

_Metres = NDArray[np.float32]


_STEP = 0.125
"""Metres between entries: much less than depth errors need to change."""


@dataclass(frozen=True, eq=False)
class DepthCurve:
    """What a reading of 0, step, 2 · step, … metres stands for; rising.

    Attributes:
        table: (n,) metres.
        step: metres.
    """

    table: NDArray[np.float64]
    step: float

    @classmethod
    def straight(cls, farthest: float = _STEP) -> "DepthCurve":
        """Readings that are right, with entries up to so many metres."""
        return cls(_STEP * np.arange(int(np.ceil(farthest / _STEP)) + 1, dtype=np.float64), _STEP)

    def reaching(self, farthest: float) -> "DepthCurve":
        """The same curve with entries up to so many metres at least."""
        more = self.step * np.arange(len(self.table), int(np.ceil(farthest / self.step)) + 1)
        return DepthCurve(np.concatenate([self.table, more * self.table[-1] / self._readings[-1]]), self.step)

    @classmethod
    def of(cls, table: NDArray[np.float64]) -> "DepthCurve":
        """A curve by its table, as it was saved.

        Raises:
            ValueError: the table is no rising curve that begins at 0.
        """
        is_table = table.ndim == 1 and table.dtype == np.float64 and 2 <= len(table) <= _MOST_ENTRIES
        if not is_table or not np.isfinite(table).all() or table[0] != 0.0 or not (np.diff(table) > 0.0).all():
            raise ValueError("the curve of depths does not rise from 0")
        return cls(table, _STEP)

    @cached_property
    def is_straight(self) -> bool:
        """Whether readings are taken as they are."""
        return bool((self.table == self._readings).all())

    @property
    def _readings(self) -> NDArray[np.float64]:
        return self.step * np.arange(len(self.table), dtype=np.float64)

    def true(self, readings: _Metres) -> _Metres:
        """What readings of any shape, metres, stand for; what is no depth stays."""
        if self.is_straight:
            return readings
        return kernels.corrected(readings.ravel(), self.table, self.step).reshape(readings.shape)

    def readings(self, true: _Metres) -> _Metres:
        """The readings (n,) that stand for depths."""
        factor = self._readings[-1] / self.table[-1]
        within = np.interp(true, self.table, self._readings)
        return np.where(true < self.table[-1], within, true * factor).astype(np.float32)

    def then(self, at: NDArray[np.float64], excess: NDArray[np.float64]) -> "DepthCurve":
        """The curve that remains when results of this one at some depths (m,) exceed the truth by logarithms (m,)."""
        table = self.table * np.exp(-np.interp(self.table, at, excess))
        # A reading that is farther than another stands for more.
        rise = _LEAST_RISE * self.step * np.arange(len(table))
        return DepthCurve(np.maximum.accumulate(table - rise) + rise, self.step)

    @property
    def largest_change(self) -> tuple[float, float]:
        """The reading in metres that is corrected most, and what it stands for."""
        ratio = np.abs(np.log(self.table[1:] / self._readings[1:]))
        most = 1 + int(ratio.argmax())
        return float(self._readings[most]), float(self.table[most])


@dataclass(frozen=True, slots=True, eq=False)
class DepthChange:
    """Depths by one curve become those by another."""

    before: DepthCurve
    after: DepthCurve

    def __call__(self, depth: _Metres) -> _Metres:
        """(n,) metres; 0, where there is none, stays."""
        return self.after.true(self.before.readings(depth))

    def of(self, features: Features, sensor: SensorModel) -> Features:
        """Keypoints with other depths."""
        depth = self(features.depth)
        return features._replace(depth=depth, u_right=features.pixels[:, 0] - sensor.disparity(depth))


_MOST_ENTRIES = 10_000
"""Of a saved table: more than a kilometre."""

_LEAST_RISE = 0.2
"""Metres by which depth rises with a metre of reading at least, so that the curve can be inverted."""
