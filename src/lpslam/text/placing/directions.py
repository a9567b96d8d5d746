"""In which directions texts without a sure place were read from the present keyframe.

Where depth does not place a text, its directions from several keyframes do; those of one keyframe say the same again.
So a text of which the name is sure is read twice from each keyframe, and more only where it is seen better.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lpslam.config import ReadingConfig
from lpslam.text.placing.views import Array, sides_of
from lpslam.text.types import Bearing

_ENOUGH = 2
"""Readings from one keyframe after which another one tells nothing: one may be a slip."""

_ALONG_SHARE, _ACROSS_SHARE = 0.5, 0.6
"""Shares of the longer text, and of the higher one, within which the middles of one text are seen."""

_CAPACITY = 256
"""Readings of one keyframe that are remembered."""


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """A text in a direction: (3,) unit to its middle and along it, radians of width and height, pixels of letters."""

    middle: Array
    along: Array
    width: float
    height: float
    letters: float
    identifier: int = -1

    @classmethod
    def of(cls, bearing: Bearing, letters: float, identifier: int = -1) -> "_Seen":
        corners = np.array(bearing.corners)
        middle = corners.mean(axis=0)
        along, across = sides_of(corners)
        width, height = float(np.linalg.norm(along)), float(np.linalg.norm(across))
        return cls(middle / np.linalg.norm(middle), along / max(width, 1e-9), width, height, letters, identifier)

    def is_as(self, other: "_Seen") -> bool:
        """Whether both are one text, as far as directions tell."""
        offset = other.middle - self.middle
        along = float(offset @ self.along)
        across = float(np.linalg.norm(offset - along * self.along))
        is_beside = abs(along) < _ALONG_SHARE * max(self.width, other.width)
        return is_beside and across < _ACROSS_SHARE * max(self.height, other.height)


class Directions:
    """Readings of the present keyframe."""

    def __init__(self) -> None:
        self._keyframe: int | None = None
        self._seen: list[_Seen] = []

    def add(self, keyframe: int, identifier: int, bearing: Bearing, letters: float) -> None:
        """Note that a class was read in a direction, its letters so many pixels high."""
        if keyframe != self._keyframe:
            self._keyframe, self._seen = keyframe, []
        self._seen.append(_Seen.of(bearing, letters, identifier))
        del self._seen[:-_CAPACITY]

    def settled_at(
        self, keyframe: int, bearing: Bearing, letters: float, is_sure: Callable[[int], bool], config: ReadingConfig
    ) -> int | None:
        """The class that was read in a direction often enough, and nearly as well as it is seen now; or None.

        Args:
            keyframe, bearing: from which keyframe, in which direction.
            letters: pixels, their height now.
            is_sure: whether the name of a class is sure.
            config: by how much a text must be larger or longer to be seen better.
        """
        if keyframe != self._keyframe:
            return None
        now = _Seen.of(bearing, letters)
        here = [each for each in self._seen if each.is_as(now)]
        classes = {each.identifier for each in here}
        if len(here) < _ENOUGH or len(classes) > 1 or not all(map(is_sure, classes)):
            return None
        is_larger = letters >= config.better_size * max(each.letters for each in here)
        is_longer = now.width > config.longer * max(each.width for each in here)
        return None if is_larger or is_longer else here[0].identifier
