"""Which of many patterns may be found in a text, told at a glance: each needs one of a few pieces to stand in it.

Of each pattern the strings are gathered of which one stands in whatever it matches; a table of their letters leads from
a text to the patterns that are worth a search. What is left out cannot match; what is left in may.
"""

import re
from collections.abc import Iterable, Sequence
from functools import lru_cache, partial
from re import _constants as said  # type: ignore[attr-defined]
from re import _parser as parser  # type: ignore[attr-defined]
from typing import Any

from lpslam.language.kept import kept

_LONGEST = 3  # letters of a piece that are looked up
_MOST_LETTERS = 12  # of a class of letters that is told letter by letter
# Letters that a pattern without case takes for i, s and k; the last is the sign of kelvins, and no K.
_ODD = frozenset("\u0131\u0130\u017f\u212a")
_KEPT = 16  # texts whose pieces are kept: those of one question

_MANY = 50  # patterns whose pieces are kept on disk

Pieces = frozenset[str]
_Made = tuple[frozenset[int], dict[str, frozenset[int]]]


class Sieve:
    """Patterns by the pieces that they need.

    Args:
        patterns: to be looked for, with or without case; they are parsed, and not compiled.

    Raises:
        re.error: one is no pattern.
    """

    def __init__(self, patterns: Sequence[str]) -> None:
        self._every = tuple(range(len(patterns)))
        made: _Made
        if len(patterns) >= _MANY:
            made = kept("sieve", "\0".join(patterns).encode(), partial(_made, patterns))
        else:
            made = _made(patterns)
        self._always, self._by_letters = made
        self._possible = lru_cache(maxsize=_KEPT)(self._sieved)

    def possible(self, text: str) -> tuple[int, ...]:
        """Which patterns may be found in a text, by their place among all, in order."""
        return self._possible(text)

    def _sieved(self, text: str) -> tuple[int, ...]:
        if not _ODD.isdisjoint(text):
            return self._every
        found = self._by_letters.keys() & _runs(text)
        return tuple(sorted(self._always.union(*(self._by_letters[letters] for letters in found))))


def _made(patterns: Sequence[str]) -> _Made:
    """The patterns of which no piece is known that they need, and those that need a piece of some letters."""
    always: set[int] = set()
    by_letters: dict[str, set[int]] = {}
    for at, pattern in enumerate(patterns):
        needed = _needed(parser.parse(pattern, re.IGNORECASE))
        for piece in needed or ():
            by_letters.setdefault(_letters(piece), set()).add(at)
        if needed is None:
            always.add(at)
    return frozenset(always), {letters: frozenset(found) for letters, found in by_letters.items()}


@lru_cache(maxsize=_KEPT)
def _runs(text: str) -> frozenset[str]:
    """All runs of a few letters of a text, small."""
    small = text.lower()
    return frozenset(small[at : at + size] for size in range(1, _LONGEST + 1) for at in range(len(small) - size + 1))


def _letters(piece: str) -> str:
    """The few letters of a piece by which it is looked up; those around spaces are in every text."""
    runs = [piece[at : at + _LONGEST] for at in range(max(1, len(piece) - _LONGEST + 1))]
    return min(runs, key=lambda run: run.count(" "))


def _needed(parts: Iterable[tuple[Any, Any]]) -> Pieces | None:
    """The pieces of which one stands in whatever a sequence matches, the most telling ones; None where none need."""
    found: list[Pieces] = []
    run = ""
    for kind, what in parts:
        if kind is said.LITERAL:
            run += chr(what).lower()
            continue
        found += [frozenset([run])] if run else []
        run = ""
        inner = _needed_by(kind, what)
        found += [inner] if inner is not None else []
    found += [frozenset([run])] if run else []
    return max(found, key=_telling, default=None)


def _needed_by(kind: Any, what: Any) -> Pieces | None:
    """As `_needed`, of one part of a pattern."""
    if kind is said.SUBPATTERN:
        return _needed(what[-1])
    if kind is said.ATOMIC_GROUP:
        return _needed(what)
    if kind in (said.MAX_REPEAT, said.MIN_REPEAT, said.POSSESSIVE_REPEAT):
        return _needed(what[2]) if what[0] > 0 else None
    if kind is said.BRANCH:
        branches = [_needed(branch) for branch in what[1]]
        whole = [each for each in branches if each is not None]
        return frozenset().union(*whole) if len(whole) == len(branches) else None
    if kind is said.IN and len(what) <= _MOST_LETTERS and all(each is said.LITERAL for each, _ in what):
        return frozenset(chr(letter).lower() for _, letter in what)
    return None


def _telling(pieces: Pieces) -> tuple[int, int]:
    """How much it tells that none of some pieces is in a text: the longer they are, and the fewer."""
    return min(min(len(piece.strip()), _LONGEST) for piece in pieces), -len(pieces)
