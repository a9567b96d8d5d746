"""The words of a question: without its filler, those that no table knows, and those that say what is wanted."""

from collections.abc import Sequence

from lpslam.language.questions.speaking import languages_of, wish_languages
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.words import is_mark, is_unspaced, longest_phrases
from lpslam.language.wishes.rules import content_of

SHORTEST = 3  # letters of a word that is a name by itself


class AskedWords:
    """Cuts questions into words, by the tables of the languages that they may be in."""

    def __init__(self, knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self._last: tuple[str, tuple[list[str], list[str]]] | None = None

    def asked(self, text: str) -> tuple[list[str], list[str]]:
        """The words of a question without its filler, and those of them that no table knows."""
        last = self._last
        if last is None or last[0] != text:
            last = self._last = (text, self._asked(text))
        words, proper = last[1]
        return list(words), list(proper)

    def _asked(self, text: str) -> tuple[list[str], list[str]]:
        languages = wish_languages(text, self._knowledge)
        words, bare = self.of(content_of(text, languages), self.likely(text))
        if all(map(is_unspaced, bare)):
            return words, bare
        # “Sala de reuniones” is one phrase with its filler only.
        proper = set(self.of(text, self.likely(text))[1])
        return words, [word for word in bare if is_unspaced(word) or word in proper]

    def likely(self, text: str) -> tuple[str, ...]:
        """The languages that a text may be in; a few words may be in any that knows them."""
        return languages_of(text, self._knowledge) or wish_languages(text, self._knowledge)

    def of(self, content: str, languages: Sequence[str]) -> tuple[list[str], list[str]]:
        """The words of a text, runs of scripts without spaces whole; and those of them that no table knows."""
        units = self._knowledge.folder.units(content)
        common = frozenset().union(*(self._knowledge.common.get(each, frozenset()) for each in languages))
        known: set[int] = set()
        for language in languages:
            for span in longest_phrases(units, self._knowledge.tables_of(language)):
                known.update(range(span.start, span.end))
        words = _joined([unit for unit in units if is_unspaced(unit) or not (is_mark(unit) or unit in common)])
        proper = _joined(
            ["" if at in known or unit in common or is_mark(unit) else unit for at, unit in enumerate(units)]
        )
        return words, [word for word in proper if len(word) >= (2 if is_unspaced(word) else SHORTEST)]


def _joined(units: Sequence[str]) -> list[str]:
    """Characters of scripts without spaces that follow one another as one word; "" parts them."""
    words: list[str] = []
    is_open = False
    for unit in units:
        if unit and is_unspaced(unit):
            if is_open:
                words[-1] += unit
            else:
                words.append(unit)
            is_open = True
        else:
            is_open = False
            if unit and not is_mark(unit):
                words.append(unit)
    return words
