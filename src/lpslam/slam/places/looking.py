"""Whether a picture shows what a place has in view, whether or not corners are found there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.config import LocatingConfig
from lpslam.slam.features import FeatureExtractor
from lpslam.slam.kernels.looking import NOWHERE
from lpslam.slam.map import SlamMap
from lpslam.slam.places.located import Located, at_least
from lpslam.slam.places.twins import spread_over


class Looking:
    """Asks a picture for map points at their places, against places beside them.

    Of the corners of a place a tenth to a half is found again, by light, noise and side: so little is found of a place
    with the same pattern as well. What a corner looks like is there all the same, and needs not be found as a corner:
    where the place is right, most descriptors are more like what stands at their place than like what stands around it.
    Of what does not, one in five is by chance.
    """

    def __init__(self, slam_map: SlamMap, extractor: FeatureExtractor, config: LocatingConfig) -> None:
        self._map = slam_map
        self._extractor = extractor
        self._config = config
        beside = config.looked_beside
        self._steps = np.array([(0, 0), (beside, 0), (-beside, 0), (0, beside), (0, -beside)], np.int32)

    def at(self, gray: NDArray[np.uint8]) -> "Shown":
        """A picture (h, w) to be asked; the caller holds the lock while it is."""
        return Shown(self, gray)

    def share(self, gray: NDArray[np.uint8], located: Located) -> float:
        """Share of what should be seen that a picture (h, w) shows at its place, at least; the caller holds the lock.

        Less what should be seen in parts of the picture where no corner of it was found: a pattern is all over a wall,
        and what stands before the wall tells the place. Where too little can be asked, the least that is believed.
        """
        config = self._config
        _, is_there = self._asked(gray, located, config.looked_at)
        if len(is_there) < config.min_matches:
            return config.min_there_share
        return at_least(int(is_there.sum()), len(is_there)) - max(located.missing_share, 0.0)

    def contradicts(self, gray: NDArray[np.uint8], located: Located) -> bool:
        """Whether a picture (h, w) shows nothing of points that stand together, and most of all the others.

        At one end of a corridor a sign hangs beside the door, at the other end none: all else is alike. Of what is not
        there, the likest of five places is its own by chance; of what is there, as many as usually in this picture. The
        first must be more likely by far of some of the groups (a ratio of likelihoods). The caller holds the lock.
        """
        from scipy.spatial import cKDTree

        config = self._config
        pixels, is_there = self._asked(gray, located, config.looked_for)
        size = config.looked_together
        if len(is_there) < _GROUPS * size:
            return False
        _, together = cKDTree(pixels).query(pixels, size)
        found = is_there[together].sum(axis=1)
        by_chance = 1 / len(self._steps)
        # Half a point more may always be missing: of a few hundred none is certain.
        usual = min(float(np.median(found)) / size, 1 - 0.5 / size)
        least = int(found.min())
        if usual <= by_chance or least >= size * usual:
            return False
        gain = least * np.log(by_chance / usual) + (size - least) * np.log((1 - by_chance) / (1 - usual))
        return bool(gain >= np.log(config.lacking_odds * len(is_there) / size))

    def _asked(
        self, gray: NDArray[np.uint8], located: Located, most: int
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Of at most so many points that should be seen: pixels (n, 2), and whether the picture shows them there."""
        config, expected = self._config, located.expected
        some = spread_over(np.arange(len(expected.points)), most)
        bits = self._extractor.unlikeness(
            gray,
            expected.pixels[some],
            expected.levels[some],
            self._map.columns.point_descriptor[expected.points[some]],
            self._steps,
            config.looked_around,
        )
        is_asked = (bits[:, 0] < NOWHERE) & ((bits[:, 1:] < NOWHERE).sum(axis=1) >= _LEAST_BESIDE)
        return expected.pixels[some[is_asked]], bits[is_asked, 0] < bits[is_asked, 1:].min(axis=1)


@dataclass(frozen=True, eq=False)
class Shown:
    """`Look` at one picture (h, w)."""

    looking: Looking
    gray: NDArray[np.uint8]

    def share(self, located: Located) -> float:
        """As `Looking.share`."""
        return self.looking.share(self.gray, located)

    def contradicts(self, located: Located) -> bool:
        """As `Looking.contradicts`."""
        return self.looking.contradicts(self.gray, located)


_LEAST_BESIDE = 2
"""Places beside its own with which a point is compared; near a corner of the picture there are no more."""

_GROUPS = 4
"""Of points that stand together that there must be, to say what is usual."""
