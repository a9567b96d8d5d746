"""Whether a picture shows what a place has in view, whether or not corners are found there."""

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

    def share(self, gray: NDArray[np.uint8], located: Located) -> float:
        """Share of what should be seen that a picture (h, w) shows at its place, at least; the caller holds the lock.

        Less what should be seen in parts of the picture where no corner of it was found: a pattern is all over a wall,
        and what stands before the wall tells the place. Where too little can be asked, the least that is believed.
        """
        config, expected = self._config, located.expected
        some = spread_over(np.arange(len(expected.points)), config.looked_at)
        bits = self._extractor.unlikeness(
            gray,
            expected.pixels[some],
            expected.levels[some],
            self._map.columns.point_descriptor[expected.points[some]],
            self._steps,
            config.looked_around,
        )
        is_asked = (bits[:, 0] < NOWHERE) & ((bits[:, 1:] < NOWHERE).sum(axis=1) >= _LEAST_BESIDE)
        if np.count_nonzero(is_asked) < config.min_matches:
            return config.min_there_share
        is_there = bits[is_asked, 0] < bits[is_asked, 1:].min(axis=1)
        return at_least(int(is_there.sum()), len(is_there)) - max(located.missing_share, 0.0)


_LEAST_BESIDE = 2
"""Places beside its own with which a point is compared; near a corner of the picture there are no more."""
