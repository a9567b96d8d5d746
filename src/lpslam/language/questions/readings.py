"""A question that is read once for all who know different names: most names say nothing of it."""

from collections.abc import Callable, Collection, Sequence

from lpslam.language.questions.wanted import Wish
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import Phrases

_KEPT = 4  # ways in which the names of maps change the reading of one question


class Readings:
    """What a question says, by what names say of its phrases.

    Args:
        read: reads it with names.
    """

    def __init__(self, read: Callable[[Phrases[Meaning]], Wish]) -> None:
        self._read = read
        self._found: tuple[tuple[_Noted, Wish], ...] = ()

    def with_names(self, names: Phrases[Meaning]) -> Wish:
        """What is asked by who knows these names: as it was read before, where they say the same of all looked up."""
        for noted, wish in self._found:
            if noted.is_all_of(names):
                return wish
        noted = _Noted(names)
        wish = self._read(noted)
        self._found = ((noted, wish), *self._found[: _KEPT - 1])
        return wish


class _Noted:
    """Names that note what is asked of them, and what they say."""

    def __init__(self, names: Phrases[Meaning]) -> None:
        self._names = names
        self._said: dict[str, Meaning | None] = {}
        self._texts: dict[tuple[str, ...], set[int]] = {}
        self._last: tuple[Sequence[str], set[int]] = ((), set())

    def get(self, key: str, /) -> Meaning | None:
        """As of any names, noted."""
        found = self._said[key] = self._names.get(key)
        return found

    def sizes(self, units: Sequence[str], at: int, /) -> Collection[int]:
        """As of any names, noted."""
        if units is not self._last[0]:
            self._last = units, self._texts.setdefault(tuple(units), set())
        self._last[1].add(at)
        return self._names.sizes(units, at)

    def is_all_of(self, names: Phrases[Meaning]) -> bool:
        """Whether other names say the same of all that these were asked."""
        return all(names.get(key) == said for key, said in self._said.items()) and not any(
            names.get(key) is not None
            for units, places in self._texts.items()
            for at in places
            for size in names.sizes(units, at)
            if (key := " ".join(units[at : at + size])) not in self._said
        )
