"""Letters that no view shows: where a tube does not burn, or paint has come off, a word has a gap like a space."""

from collections.abc import Iterable, Iterator, Set
from functools import cached_property
from itertools import pairwise
from string import ascii_lowercase

_SHORTEST = 5
"""Letters of a word that has lost one: shorter ones are near to too much else."""


_ALONE = frozenset("aeiouy")
"""Letters that are words by themselves in some language; other ones are pieces."""


class LostLetters:
    """Finds spaces that stand for a letter: with it, what they part is one known word.

    A thousandth of 60,000 known names has such a space: between two words (to let, toilet), or where words follow each
    other in other names as well (hot pot, hotspot). These are left alone.

    Args:
        words: known ones, without case and accents, that may have lost a letter.
        short: others that may stand beside a space.
        names: known ones, in which words follow each other.
    """

    def __init__(self, words: Set[str], short: Set[str], names: Iterable[str]) -> None:
        self._words = words
        self._short = short
        self._names = names

    def spaces(self, text: str) -> list[int]:
        """Where in a text such spaces are."""
        return sorted({at for at, _ in self._found(text)})

    def filled(self, text: str) -> Iterator[str]:
        """The text with one such space taken for each letter that it may be."""
        for at, letter in self._found(text):
            is_upper = text[at + 1 : at + 3].isupper() if len(text) > at + 2 else text[at - 1].isupper()
            yield text[:at] + (letter.upper() if is_upper else letter) + text[at + 1 :]

    def _found(self, text: str) -> Iterator[tuple[int, str]]:
        parts, at = text.split(" "), -1
        for first, second in pairwise(parts):
            at += len(first) + 1
            a, b = first.casefold(), second.casefold()
            is_plain = (a + b).isascii() and a.isalpha() and b.isalpha() and len(a) + len(b) + 1 >= _SHORTEST
            if not is_plain or a + b in self._words or (self._is_word(a) and self._is_word(b)):
                continue
            letters = [letter for letter in ascii_lowercase if a + letter + b in self._words]
            if letters and f" {a} {b} " not in self._sequences:
                yield from ((at, letter) for letter in letters)

    def _is_word(self, part: str) -> bool:
        return part in self._words or part in self._short or part in _ALONE

    @cached_property
    def _sequences(self) -> str:
        """All names, each word between spaces; made when it is first asked for."""
        return " ".join(f" {' '.join(name.casefold().split())} \n" for name in self._names)
