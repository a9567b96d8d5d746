"""Many places that serve, by columns: what is looked up, ordered and measured at once."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from lpslam.navigation.places import Place, Point
from lpslam.navigation.relations import Scene
from lpslam.navigation.sites import tree_of

NEAR_ANCHORS = 8
"""Places of an anchor that a place is held against: those nearest to it."""


class Serving:
    """The places that serve at least so well, by columns; `scores` of all that serve."""

    def __init__(self, scene: Scene, scores: Mapping[int, float], least: float = 0.0) -> None:
        ids = np.fromiter(scores.keys(), np.int64, len(scores))
        values = np.fromiter(scores.values(), np.float64, len(scores))
        rows = scene.sites.rows(ids)
        kept = (rows >= 0) & (values >= least * values.max(initial=0.0))
        self._sites = scene.sites
        self.ids, self.scores, self._rows = ids[kept], values[kept], rows[kept]

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def positions(self) -> NDArray[np.float64]:
        """(n, 3) metres."""
        return np.asarray(self._sites.positions[self._rows])

    def place(self, at: int) -> Place:
        """One of them."""
        return self._sites.places[int(self._rows[at])]

    def first(self, most: int, *keys: NDArray[np.float64]) -> list[int]:
        """The first so many, by some keys, the most important first, and then by id."""
        order = np.lexsort((self.ids, *reversed(keys)))
        return [int(at) for at in order[:most]]


def apart_from(serving: Serving, anchors: Sequence[Sequence[Place]]) -> NDArray[np.float64]:
    """(n,) metres as the crow flies from each place to the nearest anchor, never to itself."""
    points = [each for found in anchors for each in found]
    tree = tree_of(np.array([each.position for each in points]))
    both = np.asarray(tree.query(serving.positions, k=min(2, len(points)))[0]).reshape(len(serving), -1)
    ids = np.array([each.id for each in points])
    is_anchor = np.isin(serving.ids, ids)
    return np.asarray(np.where(is_anchor, both[:, -1], both[:, 0]))


def detours(serving: Serving, anchors: Sequence[Place], start: Point) -> NDArray[np.float64]:
    """(n,) metres of detour, as the crow flies, by each place on the way from a point to the anchor near that place."""
    points = np.array([each.position for each in anchors])
    count = min(NEAR_ANCHORS, len(points))
    onwards, which = (
        np.asarray(each).reshape(len(serving), -1) for each in tree_of(points).query(serving.positions, k=count)
    )
    itself = np.array([each.id for each in anchors])[which] == serving.ids[:, None]
    there = np.linalg.norm(serving.positions - start, axis=1)[:, None]
    straight = np.linalg.norm(points - start, axis=1)[which]
    return np.asarray(np.where(itself, np.inf, there + onwards - straight).min(axis=1))


class Near:
    """The few anchors that stand nearest to a place, as the crow flies: the others can hardly be meant."""

    def __init__(self, anchors: Sequence[Place]) -> None:
        self._anchors = anchors
        self._tree = tree_of(np.array([each.position for each in anchors])) if len(anchors) > NEAR_ANCHORS else None

    def to(self, place: Place) -> Sequence[Place]:
        """Anchors near a place, never the place itself."""
        near: Sequence[Place] = self._anchors
        if self._tree is not None:
            found = np.asarray(self._tree.query(place.position, k=NEAR_ANCHORS)[1])
            near = [self._anchors[int(at)] for at in found]
        return [each for each in near if each is not place]
