"""What of the map a view should show and shows, in every part of the image."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """Map points by parts of the image.

    Attributes:
        expected: (parts,) how many should be seen from a place.
        seen: (parts,) how many of them are.
    """

    expected: NDArray[np.intp]
    seen: NDArray[np.intp]

    @classmethod
    def of(cls, pixels: NDArray[np.float32], is_seen: NDArray[np.bool_], image_size: tuple[int, int]) -> Self:
        """Of points that should be seen at pixels (n, 2), and are or not (n,), in an image of a width and height."""
        if not len(is_seen):
            return cls(np.zeros(_COUNT, np.intp), np.zeros(_COUNT, np.intp))
        at = np.clip(pixels / image_size * _PARTS, 0, np.array(_PARTS) - 1).astype(int)
        rows = at[:, 0] * _PARTS[1] + at[:, 1]
        seen = np.bincount(rows[is_seen], minlength=_COUNT)
        return cls(np.bincount(rows, minlength=_COUNT), seen)

    @property
    def missing_share(self) -> float:
        """Share of what should be seen in parts where none of it is, beyond what chance explains."""
        known = self.expected >= _LEAST_IN_PART
        expected = self.expected[known]
        share = self.seen.sum() / max(self.expected.sum(), 1)
        by_chance = expected * (1.0 - share) ** expected
        empty = expected[self.seen[known] == 0].sum()
        return float((empty - by_chance.sum()) / max(expected.sum(), 1))

    def speak_for(self, other: Self) -> float:
        """By how much a view speaks for this place rather than for another one that looks alike; below 0 against it.

        Where two places are alike, as much of either is seen; where they differ, much of the right one is and little
        of the other. So the shares that are seen are compared part by part, and what is beyond chance is added up.
        What all of a view has in common, blur or a poor map, is the same for both.

        Returns:
            A sum of standard deviations; between two places that are equally right or wrong it is within about 1.5.
        """
        both = (self.expected >= _LEAST_IN_PART) & (other.expected >= _LEAST_IN_PART)
        own, others = self.expected[both], other.expected[both]
        together = (self.seen[both] + other.seen[both]) / np.maximum(own + others, 1)
        spread = np.sqrt(np.maximum(together * (1.0 - together), _LEAST_VARIANCE) * (1.0 / own + 1.0 / others))
        sigmas = (self.seen[both] / own - other.seen[both] / others) / spread
        return float((np.sign(sigmas) * np.maximum(np.abs(sigmas) - _BY_CHANCE, 0.0)).sum())


_PARTS = (8, 6)
"""Columns and rows of parts of the image."""

_COUNT = _PARTS[0] * _PARTS[1]

_LEAST_IN_PART = 5
"""Points that should be seen in a part; of fewer, none may be found by chance."""

_LEAST_VARIANCE = 0.02
"""Of one point being seen: of a few that all are, or none, chance is not known."""

_BY_CHANCE = 1.5
"""Standard deviations by which the shares of one part differ between places that are alike."""
