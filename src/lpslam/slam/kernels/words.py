"""Words of descriptors and the inverted index over them: the inner loops of place recognition."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import popcount

BLOCK = 64
"""Postings that are stored together: enough that reading them on hides the wait for the next block."""


class Postings(NamedTuple):
    """Which keyframes show a word, and by which weight: for each word a chain of blocks, all full but the first.

    Attributes:
        head: (W,) first block of each word, or -1.
        fill: (W,) postings in it.
        keyframe, weight: (B, BLOCK) the postings.
        next_block: (B,) the next block of the same word, or -1.
        free: (B,) blocks not in use, the last of them taken first.
        free_count: (1,) how many they are.
    """

    head: NDArray[np.int32]
    fill: NDArray[np.int32]
    keyframe: NDArray[np.int32]
    weight: NDArray[np.float32]
    next_block: NDArray[np.int32]
    free: NDArray[np.int32]
    free_count: NDArray[np.int32]


@njit(cache=True, nogil=True)
def find_words(descriptors: NDArray[np.uint64], tree: NDArray[np.uint64], branches: int) -> NDArray[np.int32]:
    """Walk each descriptor (n, 4) down a tree of descriptors, always to the nearest child; (n,) the leaves reached.

    Args:
        descriptors: 256 bits each.
        tree: (branches + branches² + …, 4), level by level, the children of a node side by side.
        branches: children of every node.
    """
    words = np.empty(descriptors.shape[0], np.int32)
    for i in range(descriptors.shape[0]):
        a, b, c, d = descriptors[i, 0], descriptors[i, 1], descriptors[i, 2], descriptors[i, 3]
        node, level_start, level_size = 0, 0, branches
        while level_start < tree.shape[0]:
            nearest, least = 0, np.int64(257)
            for child in range(node * branches, node * branches + branches):
                row = level_start + child
                bits = np.int64(
                    popcount(a ^ tree[row, 0])
                    + popcount(b ^ tree[row, 1])
                    + popcount(c ^ tree[row, 2])
                    + popcount(d ^ tree[row, 3])
                )
                if bits < least:
                    nearest, least = child, bits
            node = nearest
            level_start += level_size
            level_size *= branches
        words[i] = node
    return words


@njit(cache=True, nogil=True)
def add_postings(postings: Postings, keyframe: int, words: NDArray[np.int32], weights: NDArray[np.float32]) -> None:
    """Enter a keyframe's words (n,), none twice, and their weights (n,); n blocks must be free."""
    head, fill = postings.head, postings.fill
    for i in range(words.shape[0]):
        word = words[i]
        if head[word] < 0 or fill[word] == BLOCK:
            postings.free_count[0] -= 1
            taken = postings.free[postings.free_count[0]]
            postings.next_block[taken] = head[word]
            head[word] = taken
            fill[word] = 0
        postings.keyframe[head[word], fill[word]] = keyframe
        postings.weight[head[word], fill[word]] = weights[i]
        fill[word] += 1


@njit(cache=True, nogil=True)
def remove_postings(postings: Postings, keyframe: int, words: NDArray[np.int32]) -> None:
    """Take a keyframe's words (n,) out; the newest posting of a word fills the gap."""
    head, fill, following = postings.head, postings.fill, postings.next_block
    for i in range(words.shape[0]):
        word = words[i]
        block, count = head[word], fill[word]
        found = -1
        while found < 0 and block >= 0:
            for k in range(count):
                if postings.keyframe[block, k] == keyframe:
                    found = k
            if found < 0:
                block, count = following[block], np.int32(BLOCK)
        if found < 0:
            continue
        first = head[word]
        fill[word] -= 1
        postings.keyframe[block, found] = postings.keyframe[first, fill[word]]
        postings.weight[block, found] = postings.weight[first, fill[word]]
        if fill[word] == 0:
            head[word] = following[first]
            fill[word] = BLOCK if head[word] >= 0 else 0
            postings.free[postings.free_count[0]] = first
            postings.free_count[0] += 1


@njit(cache=True, nogil=True)
def add_scores(
    postings: Postings, words: NDArray[np.int32], weights: NDArray[np.float32], scores: NDArray[np.float32]
) -> None:
    """Add to each keyframe's score (K,) what it shares with the words (n,) and weights (n,) of a view.

    With weights that sum to one on both sides, 1 − ½·|v − w|₁ is the sum of the lesser weight of every common word
    (Nistér and Stewénius 2006; DBoW2, Gálvez-López and Tardós 2012).
    """
    for i in range(words.shape[0]):
        weight = weights[i]
        block, count = postings.head[words[i]], postings.fill[words[i]]
        while block >= 0:
            keyframes, others = postings.keyframe[block], postings.weight[block]
            for k in range(count):
                # Unsigned, for which no test of a negative index is compiled in.
                scores[np.uint32(keyframes[k])] += min(weight, others[k])
            block, count = postings.next_block[block], np.int32(BLOCK)
