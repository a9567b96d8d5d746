"""Where all places of a map stand, by columns: made once, for however many questions."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lpslam.navigation.places import Place, Point

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

_GAPS = 5_000  # places whose nearest neighbours tell the usual gap


def tree_of(points: NDArray[np.float64]) -> "cKDTree":
    """A tree over (n, 3) points. Most wishes need none, and its library takes longer to load than they to answer."""
    from scipy.spatial import cKDTree

    return cKDTree(points)


class Sites:
    """All places of a map; each column is made when it is first asked for."""

    def __init__(self, places: Sequence[Place]) -> None:
        self.places = places

    @cached_property
    def by_id(self) -> Mapping[int, Place]:
        """The places, looked up."""
        return {place.id: place for place in self.places}

    @cached_property
    def positions(self) -> NDArray[np.float64]:
        """(n, 3) metres, of all places."""
        return np.array([place.position for place in self.places], dtype=np.float64).reshape(-1, 3)

    @cached_property
    def _rows_by_id(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The ids of all places in order, and which place each is."""
        ids = np.array([place.id for place in self.places], dtype=np.int64)
        order = np.argsort(ids, kind="stable")
        return ids[order], order

    def rows(self, ids: NDArray[np.int64]) -> NDArray[np.int64]:
        """Which places have these ids; -1 where none has."""
        known, order = self._rows_by_id
        if not len(known):
            return np.full(len(ids), -1, dtype=np.int64)
        at = np.minimum(np.searchsorted(known, ids), len(known) - 1)
        return np.where(known[at] == ids, order[at], -1)

    @cached_property
    def _tree(self) -> "cKDTree":
        return tree_of(self.positions)

    def nearest(self, point: Point, count: int) -> list[Place]:
        """The places nearest to a point, the nearest first."""
        near = np.atleast_1d(np.asarray(self._tree.query(point, k=min(len(self.places), count))[1]))
        return [self.places[int(at)] for at in near]

    @cached_property
    def usual_gap(self) -> float:
        """Metres, the median distance from a place to its nearest neighbour; 0 where there is none.

        Of very many places a few thousand are asked: their median is as good.
        """
        if len(self.places) < 2:
            return 0.0
        some = self.positions[:: max(1, len(self.places) // _GAPS)]
        apart = np.asarray(self._tree.query(some, k=2)[0])
        return float(np.median(apart[:, 1]))
