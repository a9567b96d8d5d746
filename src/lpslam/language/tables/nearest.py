"""Known names near a misread one, found without going through all of them."""

from collections import defaultdict
from collections.abc import Iterable

from rapidfuzz.distance import Levenshtein

from lpslam.language.tables.words import is_unspaced


class NearestNames:
    """Index of keys by their first and last letters.

    A few wrong letters rarely spoil both ends of a name, so names that share neither end are not compared.
    """

    def __init__(self, keys: Iterable[str]) -> None:
        self._heads: dict[str, list[str]] = defaultdict(list)
        self._tails: dict[str, list[str]] = defaultdict(list)
        for key in keys:
            end = _end_length(key)
            self._heads[key[:end]].append(key)
            self._tails[key[-end:]].append(key)

    def near(self, key: str, farthest: int) -> list[tuple[int, str]]:
        """Return (edit distance, known key) of the known keys within `farthest` edits, nearest first."""
        end = _end_length(key)
        candidates = dict.fromkeys(self._heads.get(key[:end], []) + self._tails.get(key[-end:], []))
        scored = [
            (Levenshtein.distance(key, other, score_cutoff=farthest), other)
            for other in candidates
            if abs(len(other) - len(key)) <= farthest
        ]
        return sorted(pair for pair in scored if pair[0] <= farthest)


def allowed_edits(key: str) -> int:
    """How many letters of a name may be misread before it could as well be another name."""
    if is_unspaced(key):
        return 0 if len(key) < 3 else 1 if len(key) < 7 else 2
    return 0 if len(key) < 5 else 1 if len(key) < 8 else 2 if len(key) < 14 else 3


def _end_length(key: str) -> int:
    return 1 if is_unspaced(key) else 3
