"""Place recognition: which keyframes look like a view (ORB-SLAM, III-E; DBoW2)."""

import threading
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lpslam.config import PlacesConfig
from lpslam.slam.kernels import words as kernels
from lpslam.slam.map import SlamMap
from lpslam.slam.places.vocabulary import Vocabulary


class PlaceIndex:
    """An inverted index: for every word the keyframes that show it.

    May be used from several threads: each call holds a lock of its own for about a millisecond, and takes no other
    meanwhile. Takes about 20 KB for a keyframe of 1000 different words, and 5 MB at least.

    Args:
        vocabulary: the words; those that travel with the package without.
    """

    def __init__(self, vocabulary: Vocabulary | None = None) -> None:
        self.vocabulary = vocabulary or Vocabulary.load()
        self._lock = threading.Lock()
        self._shown: list[tuple[NDArray[np.int32], NDArray[np.float32]] | None] = []
        self._postings = kernels.Postings(
            head=np.full(self.vocabulary.size, -1, np.int32),
            fill=np.zeros(self.vocabulary.size, np.int32),
            keyframe=np.empty((0, kernels.BLOCK), np.int32),
            weight=np.empty((0, kernels.BLOCK), np.float32),
            next_block=np.empty(0, np.int32),
            free=np.empty(0, np.int32),
            free_count=np.zeros(1, np.int32),
        )

    @classmethod
    def of(cls, slam_map: SlamMap, vocabulary: Vocabulary | None = None) -> "PlaceIndex":
        """An index of all living keyframes of a map."""
        index = cls(vocabulary)
        for keyframe in slam_map.living_keyframes().tolist():
            index.add(keyframe, slam_map.features(keyframe).descriptor)
        return index

    def __len__(self) -> int:
        """How many keyframes are indexed."""
        with self._lock:
            return sum(shown is not None for shown in self._shown)

    def __contains__(self, keyframe: int) -> bool:
        """Whether a keyframe is indexed."""
        with self._lock:
            return self._holds(keyframe)

    @property
    def nbytes(self) -> int:
        """Memory taken by postings and by the words of every keyframe, bytes."""
        with self._lock:
            shown = sum(each[0].nbytes + each[1].nbytes for each in self._shown if each is not None)
            return shown + sum(column.nbytes for column in self._postings)

    def add(self, keyframe: int, descriptors: NDArray[np.uint64]) -> None:
        """Index a keyframe by its descriptors (n, 4).

        Raises:
            ValueError: it is indexed already.
        """
        words, weights = self.vocabulary.weighted(descriptors)
        with self._lock:
            if self._holds(keyframe):
                raise ValueError(f"keyframe {keyframe} is indexed already")
            self._shown.extend([None] * (keyframe + 1 - len(self._shown)))
            self._shown[keyframe] = (words, weights)
            self._reserve(len(words))
            kernels.add_postings(self._postings, keyframe, words, weights)

    def remove(self, keyframe: int) -> None:
        """Forget a keyframe; one that is not indexed is ignored."""
        with self._lock:
            if not self._holds(keyframe):
                return
            shown = self._shown[keyframe]
            assert shown is not None
            self._shown[keyframe] = None
            kernels.remove_postings(self._postings, keyframe, shown[0])

    def query(self, descriptors: NDArray[np.uint64], eligible: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
        """How like a view each keyframe looks, by id.

        Args:
            descriptors: (n, 4) of the view.
            eligible: (K,) which keyframes may score; all without. Keyframes beyond its end may not.

        Returns:
            (K,) DBoW2's L1 score, 0 for nothing in common or not indexed, 1 for the same words; one row for each
            keyframe up to the newest that is indexed.
        """
        words, weights = self.vocabulary.weighted(descriptors)
        with self._lock:
            return self._score(words, weights, eligible)

    def query_keyframe(self, keyframe: int, eligible: NDArray[np.bool_] | None = None) -> NDArray[np.float32]:
        """`query` by the words of an indexed keyframe; it scores 1 itself.

        Raises:
            KeyError: it is not indexed.
        """
        with self._lock:
            return self._score(*self._words_of(keyframe), eligible)

    def _holds(self, keyframe: int) -> bool:
        return 0 <= keyframe < len(self._shown) and self._shown[keyframe] is not None

    def _words_of(self, keyframe: int) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        shown = self._shown[keyframe] if self._holds(keyframe) else None
        if shown is None:
            raise KeyError(f"keyframe {keyframe} is not indexed")
        return shown

    def _score(
        self, words: NDArray[np.int32], weights: NDArray[np.float32], eligible: NDArray[np.bool_] | None
    ) -> NDArray[np.float32]:
        scores = np.zeros(len(self._shown), np.float32)
        kernels.add_scores(self._postings, words, weights, scores)
        if eligible is not None:
            scores[: len(eligible)][~eligible[: len(scores)]] = 0
            scores[len(eligible) :] = 0
        return scores

    def _reserve(self, blocks: int) -> None:
        """Make sure that so many blocks are free."""
        old, free = self._postings, int(self._postings.free_count[0])
        if free >= blocks:
            return
        rows = len(old.next_block)
        added = np.arange(rows, max(2 * rows, rows + blocks, 1024), dtype=np.int32)
        self._postings = old._replace(
            keyframe=np.concatenate([old.keyframe, np.empty((len(added), kernels.BLOCK), np.int32)]),
            weight=np.concatenate([old.weight, np.empty((len(added), kernels.BLOCK), np.float32)]),
            next_block=np.concatenate([old.next_block, np.empty(len(added), np.int32)]),
            free=np.concatenate([old.free[:free], added, np.empty(rows - free, np.int32)]),
            free_count=np.array([free + len(added)], np.int32),
        )


def group_candidates(
    scores: NDArray[np.float32],
    covisible: Callable[[int, int], NDArray[np.int32]],
    limit: int,
    *,
    floor: float = 0.0,
    config: PlacesConfig | None = None,
) -> list[int]:
    """The likeliest places, one keyframe each, best first (ORB-SLAM, V-E).

    Keyframes that see a place together speak for it together: each of the best keyframes counts with its best covisible
    ones, and stands for the one among them that is most like the view.

    Args:
        scores: (K,) of `PlaceIndex.query`.
        covisible: gives the keyframes that share at least so many points with a keyframe, most shared first
            (`SlamMap.covisible`).
        limit: most places.
        floor: keyframes must score more; for loops, the least score of the keyframes covisible with the view's.
        config: thresholds; defaults without.
    """
    config = config or PlacesConfig()
    likely = np.flatnonzero(scores > max(floor, 0.0))
    likely = likely[np.argsort(-scores[likely], kind="stable")][: config.considered]
    together: dict[int, float] = {}
    for keyframe in likely.tolist():
        neighbours = covisible(keyframe, 1)[: config.group]
        group = np.concatenate([[keyframe], neighbours[neighbours < len(scores)]]).astype(np.int64)
        group = group[(scores[group] > max(floor, 0.0))]
        best = int(group[scores[group].argmax()])
        together[best] = max(together.get(best, 0.0), float(scores[group].sum()))
    ranked = sorted(together, key=lambda keyframe: (-together[keyframe], keyframe))
    return [k for k in ranked if together[k] >= config.least_share * together[ranked[0]]][:limit]
