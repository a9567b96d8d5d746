"""Letters that are taken for one another, words a single slip away, and known names near a misread one."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from importlib.resources import files

from rapidfuzz.distance import Levenshtein

from lpslam.language.tables.patterns import standing
from lpslam.language.tables.words import is_unspaced

# Letters of the shortest word that is replaced by a known one: shorter ones have too many neighbours.
LEAST_RESPELLED = 4
_MARKS = standing(r"([\W_]+)")


def is_ideograph(letter: str) -> bool:
    """Whether a letter is a Chinese character: a word, or a part of one, by itself."""
    return "\u4e00" <= letter <= "\u9fff"


def words_of(text: str, words: frozenset[str]) -> Iterator[str]:
    """The words of a text: spaces part them, and marks do (salt&pepper), but for the apostrophe of one word (don't).

    Args:
        text: without case and accents.
        words: the known ones.
    """
    for joined in text.split():
        if (letters := joined.replace("'", "")) in words:
            yield letters
        else:
            yield from (part for part in _MARKS.split(joined)[::2] if part)


def respelled(text: str, words: frozenset[str]) -> list[str]:
    """Texts in which one unknown word is replaced by a known one that is a single slip away.

    Args:
        text: without case and accents, words separated by spaces or marks.
        words: the known ones.
    """
    unknown = {each for each in words_of(text, words) if each not in words}
    parts = _MARKS.split(text)
    return [
        "".join([*parts[:at], known, *parts[at + 1 :]])
        for at, word in enumerate(parts)
        if len(word) >= LEAST_RESPELLED and word.isascii() and word.isalpha() and word in unknown
        for known in sorted(_one_slip_from(word) & words)
    ]


def _one_slip_from(word: str) -> set[str]:
    splits = [(word[:at], word[at:]) for at in range(len(word) + 1)]
    letters = "abcdefghijklmnopqrstuvwxyz"
    return (
        {head + tail[1:] for head, tail in splits if tail}
        | {head + letter + tail[1:] for head, tail in splits if tail for letter in letters}
        | {head + letter + tail for head, tail in splits for letter in letters}
    )


def is_alike(letter: str, other: str, looks: Callable[[str], str]) -> bool:
    """Whether readers take one letter for the other; `looks` takes a letter to what it looks like."""
    return letter + other in _near() or looks(letter) == looks(other)


@lru_cache(maxsize=1)
def _near() -> frozenset[str]:
    """Pairs of letters, beside those that look the same, that blur and distance turn into each other; both ways.

    They are found by drawing every letter small (`tools/build_lookalikes.py`).
    """
    table = (files("lpslam.language") / "data" / "lookalikes.txt").read_text(encoding="utf-8")
    return frozenset(pair for both in table.split() for pair in (both, both[::-1]))


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
