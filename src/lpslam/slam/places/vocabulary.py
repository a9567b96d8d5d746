"""Visual words: a tree of binary descriptors that sorts every descriptor to one of some ten thousand leaves."""

from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.kernels import words as kernels


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """A binary vocabulary tree (Gálvez-López and Tardós 2012), learned by `tools/train_vocabulary.py`.

    Attributes:
        tree: (branches + branches² + …, 4) uint64 descriptors, level by level, the children of a node side by side.
        branches: children of every node.
        rarity: (size,) float32 inverse document frequency of each word, ln(images / images with it).
    """

    tree: NDArray[np.uint64]
    branches: int
    rarity: NDArray[np.float32]

    @staticmethod
    @lru_cache(maxsize=1)
    def load() -> "Vocabulary":
        """The vocabulary that travels with the package."""
        with (files("lpslam.slam") / "assets" / "vocabulary.npz").open("rb") as stream, np.load(stream) as stored:
            rarity = stored["rarity"].astype(np.float32)
            return Vocabulary(stored["tree"], int(stored["branches"]), rarity)

    @property
    def size(self) -> int:
        """How many words there are."""
        return len(self.rarity)

    def words(self, descriptors: NDArray[np.uint64]) -> NDArray[np.int32]:
        """The word (n,) of each descriptor (n, 4)."""
        return np.asarray(kernels.find_words(np.ascontiguousarray(descriptors), self.tree, self.branches))

    def weighted(self, descriptors: NDArray[np.uint64]) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """The different words of a view, rising, and their weights: frequency times rarity, one in sum."""
        counts = np.bincount(self.words(descriptors), minlength=self.size)
        words = np.flatnonzero(counts).astype(np.int32)
        weights = counts[words] * self.rarity[words]
        total = weights.sum()
        return words, (weights / total if total > 0 else weights).astype(np.float32)
