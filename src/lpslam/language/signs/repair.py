"""Words of a sign that a reader got wrong by a letter: CANTEFN, B0ulangerie, 动物医阮."""

from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache

from lpslam.language.tables.knowledge import Knowledge, load_words
from lpslam.language.tables.spelling import NearestNames, is_alike
from lpslam.language.tables.words import is_unspaced, longest_phrases

_SHORTEST = 6  # letters of a word that may be a misread other one
_SURE = 8  # letters of a word in which any slip is believed
_SHORTEST_MIXED = 5  # of one that has digits among its letters
_SHORTEST_TAIL, _LONGEST_TAIL = 4, 6  # characters of a trade at the end of a sign in no other script
_WORDS = 1 << 16  # whose meaning is kept
_DIGITS = str.maketrans("01358", "olesb")  # as letters, where the word is not known either way


class Repair:
    """Finds the words that misread ones stand for: those of the tables, one letter away."""

    def __init__(self, knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        # Signs share their words.
        self._word = lru_cache(maxsize=_WORDS)(self._meant)

    @cached_property
    def _vocabulary(self) -> frozenset[str]:
        """The words that signs of places are painted with."""
        words = (word for phrase in self._knowledge.painted for word in phrase.split())
        return frozenset(word for word in words if len(word) >= _SHORTEST_MIXED and word.isascii() and word.isalpha())

    @cached_property
    def _nearest(self) -> NearestNames:
        return NearestNames(self._vocabulary)

    @cached_property
    def _skeletons(self) -> Mapping[str, str]:
        return {self._knowledge.folder.skeleton(word): word for word in sorted(self._vocabulary, reverse=True)}

    @cached_property
    def _tails(self) -> NearestNames:
        """Trades of scripts without spaces, which stand at the ends of names."""
        keys = (phrase.replace(" ", "") for phrase in self._knowledge.painted if is_unspaced(phrase))
        return NearestNames(key for key in keys if _SHORTEST_TAIL <= len(key) <= _LONGEST_TAIL)

    def repaired(self, units: Sequence[str], says_something: bool) -> list[str]:
        """Return the units of a sign with the words that they stand for; the same where nothing is misread.

        Beside words that say something, a short unknown one is a name: “Taquería El Charro” sells no churros.
        """
        words = self.words(units, says_something)
        return self._with_tail(words) if words and all(map(is_unspaced, words)) else words

    def words(self, units: Sequence[str], says_something: bool = False) -> list[str]:
        """Return the units with the words of spaced scripts that they stand for."""
        return [self._word(unit, says_something) for unit in self._closed(units)]

    def _closed(self, units: Sequence[str]) -> list[str]:
        """Units with the words that fell in two where a letter was lost: “Se urity”."""
        found: list[str] = []
        for unit in units:
            whole = self._torn(found[-1], unit) if found else None
            if whole is None:
                found.append(unit)
            else:
                found[-1] = whole
        return found

    def _torn(self, head: str, tail: str) -> str | None:
        """The word of which two units are the ends, of which one is none itself."""
        both = head + tail
        if len(both) + 1 < _SHORTEST or not (both.isascii() and both.isalpha()):
            return None
        if all(len(each) > 1 and (each in self._vocabulary or each in load_words()) for each in (head, tail)):
            return None
        ends = len(head), len(both) + 1
        near = (word for _, word in self._nearest.near(both, 1) if len(word) == ends[1])
        return next((word for word in near if word[: ends[0]] == head and word[ends[0] + 1 :] == tail), None)

    def _meant(self, unit: str, says_something: bool) -> str:
        """The word that a word stands for; itself where it is not misread."""
        letters = unit.translate(_DIGITS)
        if letters != unit and unit[0].isalpha() and letters.isalpha() and letters in load_words():
            # “R0om” is a word with its digit read as a letter.
            return letters
        is_mixed = not unit.isalpha() and sum(ch.isalpha() for ch in unit) >= _SHORTEST_MIXED - 1
        if len(unit) < (_SHORTEST_MIXED if is_mixed else _SHORTEST) or not unit.isascii() or not unit.isalnum():
            return unit
        if unit in self._vocabulary or unit in load_words() or not (is_mixed or unit.isalpha()):
            return unit
        alike = self._skeletons.get(self._knowledge.folder.skeleton(unit))
        if alike is not None:
            return alike
        for _, other in self._nearest.near(unit, 1):
            if len(unit) >= _SURE or (self._looks_alike(unit, other) and not says_something):
                return other
        return unit.translate(_DIGITS) if is_mixed and unit[0].isalpha() and unit[-1].isalpha() else unit

    def _looks_alike(self, word: str, other: str) -> bool:
        """Whether two words differ in letters that are taken for one another, small or capital."""
        looks = self._knowledge.folder.skeleton
        return len(word) == len(other) and all(
            one == two or is_alike(one, two, looks) or is_alike(one.upper(), two.upper(), looks)
            for one, two in zip(word, other, strict=True)
        )

    def _with_tail(self, units: list[str]) -> list[str]:
        """A trade at the end of a name, one character off, where no known word has that character."""
        spans = longest_phrases(units, (self._knowledge.painted,))
        covered = {at for span in spans if span.end - span.start > 1 for at in range(span.start, span.end)}
        for size in range(min(len(units), _LONGEST_TAIL), _SHORTEST_TAIL - 1, -1):
            start = len(units) - size
            for _, other in self._tails.near("".join(units[start:]), 1):
                slips = [start + at for at in range(size) if len(other) == size and units[start + at] != other[at]]
                if slips and covered.isdisjoint(slips) and size - len(covered & set(range(start, len(units)))) > 1:
                    return [*units[:start], *other]
        return units
