"""A question that is read once for all who know different names: most names say nothing of it."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from lpslam.language.questions.wanted import Wish
from lpslam.language.tables.lexicon import Meaning

_KEPT = 4  # ways in which the names of maps change the reading of one question


class Readings:
    """What a question says, by what names say of its phrases.

    Args:
        read: reads it with names.
    """

    def __init__(self, read: Callable[[Mapping[str, Meaning]], Wish]) -> None:
        self._read = read
        self._found: tuple[tuple[Mapping[str, Meaning | None], Wish], ...] = ()

    def with_names(self, names: Mapping[str, Meaning]) -> Wish:
        """What is asked by who knows these names: as it was read before, where they say the same of all looked up."""
        for said, wish in self._found:
            if all(names.get(phrase) == meaning for phrase, meaning in said.items()):
                return wish
        noted = _Noted(names)
        wish = self._read(noted)
        self._found = ((noted.said, wish), *self._found[: _KEPT - 1])
        return wish


class _Noted(Mapping[str, Meaning]):
    """Names that note which phrases are looked up in them, and what they say of each."""

    def __init__(self, names: Mapping[str, Meaning]) -> None:
        self._names = names
        self.said: dict[str, Meaning | None] = {}

    def get(self, key: str, default: Any = None) -> Any:
        """As of any mapping, noted."""
        found = self.said[key] = self._names.get(key)
        return default if found is None else found

    def __getitem__(self, key: str) -> Meaning:
        found = self.get(key)
        if found is None:
            raise KeyError(key)
        return found  # type: ignore[no-any-return]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)
