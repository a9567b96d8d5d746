"""Similarity classification: the normalised Levenshtein distance of Eq. 1-3 (paper, III-C)."""

from collections.abc import Mapping, Sequence

from rapidfuzz import fuzz
from rapidfuzz.distance import Levenshtein


def similarity(a: str, b: str) -> float:
    """Eq. 1-3: one minus the edit distance over the longer length; 1 for equal texts, 0 for nothing in common."""
    return Levenshtein.normalized_similarity(a, b)


def comparison_key(text: str) -> str:
    """What of a text is compared: case and spaces are ignored, since readers disagree on both between frames.

    Punctuation stays: it is painted, and a slip in it costs one edit like any other.
    """
    return "".join(text.casefold().split())


def best_class(text: str, classes: Mapping[int, Sequence[str]], threshold: float) -> int | None:
    """Find the class whose spellings are most similar to a text.

    Args:
        text: as read.
        classes: for each class id the spellings it is known by; of equally similar classes the first wins.
        threshold: Eq. 3 similarity that the best must reach.

    Returns:
        The id of the class, or None when no class is similar enough.
    """
    key = comparison_key(text)
    best, best_similarity = None, 0.0
    for identifier, spellings in classes.items():
        for spelling in spellings:
            likeness = similarity(key, comparison_key(spelling))
            if likeness >= threshold and (best is None or likeness > best_similarity):
                best, best_similarity = identifier, likeness
    return best


def is_fragment(part: str, whole: str) -> bool:
    """Whether `part` reads like a piece of the longer `whole`, a slip or two apart."""
    part_key, whole_key = comparison_key(part), comparison_key(whole)
    return len(part_key) < len(whole_key) and fuzz.partial_ratio(part_key, whole_key) >= 75.0


def is_short(text: str) -> bool:
    """Whether a text has up to three letters or two ideographs: ornaments, and pieces of texts, are read as few."""
    return sum(_OF_AN_IDEOGRAPH if letter >= IDEOGRAPHS else 1.0 for letter in comparison_key(text)) <= _FEW_LETTERS


IDEOGRAPHS = "\u2e80"
"""The first character of the East Asian scripts."""

_FEW_LETTERS, _OF_AN_IDEOGRAPH = 3.0, 1.5
"""Letters of a short text, and for how many of them one ideograph counts."""
