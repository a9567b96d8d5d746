"""What the words of boards have in common with the words of a stop: names, words just so, and names as heard."""

import re
from collections.abc import Iterable

from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.questions.question import asks_for_another
from lpslam.language.questions.speaking import wish_languages
from lpslam.language.questions.wanted import Wish as Meaning
from lpslam.language.tables.knowledge import Knowledge, load_words
from lpslam.language.tables.words import is_mark, is_unspaced, longest_phrases
from lpslam.language.wishes.asked_words import SHORTEST, AskedWords
from lpslam.language.wishes.names import Names
from lpslam.language.wishes.refusals import parted
from lpslam.language.wishes.rules import content_of, rules_of
from lpslam.language.wishes.said import SaidNames

_SURE, _NAMED = 1.0, 0.9  # of a whole name, of a part of one
_WHOLE = 0.95  # of a name's letters: the name itself
_MOST_OF_IT = 0.7  # of the letters that are asked for: a name, with a particle
_MOST_OF_A_NAME = 0.5  # of a name's letters that are asked for, where each word by itself means something else
_NAME = re.compile(r"(?<=[a-zà-ÿ] )[A-Z][\w'’-]* (?:[A-Z&][\w'’-]* ?)+")  # “is there a Burger King”
_LEAST_LITERAL = 0.3  # of a board's letters that are asked for word by word


class BoardWords:
    """The words of one set of boards, asked for by the words of a stop."""

    def __init__(self, names: Names, asked: AskedWords, index: LandmarkIndex, knowledge: Knowledge) -> None:
        self._names, self._asked, self._index, self._knowledge = names, asked, index, knowledge
        self._said = SaidNames(names, asked, knowledge)
        self._last: tuple[str, bool] | None = None

    def refuses(self, text: str, meaning: Meaning) -> bool:
        """Whether a text says no to something: then a name in it may be what is refused."""
        return bool(meaning.refused_names or meaning.refused) or self._says_no(text)

    def _says_no(self, text: str) -> bool:
        # It is asked again and again of the text of one stop.
        last = self._last
        if last is None or last[0] != text:
            units = self._knowledge.folder.units(text)
            said_no = asks_for_another(text) or any(
                span.value.role.startswith("refuse")
                for language in self._asked.likely(text)[:1]
                for span in longest_phrases(units, (self._knowledge.spoken(language),))
            )
            last = self._last = text, said_no
        return last[1]

    def parted(self, text: str, meaning: Meaning, language: str) -> tuple[str, list[str]] | None:
        """Return what a text wants, and each thing that it refuses, as its turns of phrase or its words part them."""
        if not content_of(meaning.rest, wish_languages(text, self._knowledge)):
            return parted(text, language)
        what, more = parted(meaning.rest, language) or (meaning.rest, [])
        return what, [meaning.left_out, *more]

    def leaves_out(self, text: str, language: str) -> bool:
        """Whether a text says no to a part of what it asks for (“but”, “except”), not only of something."""
        units = self._knowledge.folder.units(text)
        said = f" {' '.join(units)} "
        turns = any(f" {word} " in said or (is_unspaced(word) and word in text) for word in self._knowledge.turning)
        return turns or asks_for_another(text) or parted(text, language) is not None

    def said_on(self, text: str) -> dict[int, float]:
        """The landmarks whose boards bear all words of a text."""
        return self._names.covered(self._asked.asked(text)[0])

    def by_name(self, text: str, meaning: Meaning) -> dict[int, float]:
        """Landmarks whose board bears every word that is asked for and means nothing else."""
        if self.refuses(text, meaning):
            return {}
        return self._by_words(text) or dict.fromkeys(self._said.own(text), _NAMED) or self._by_some(text, meaning)

    def _by_some(self, text: str, meaning: Meaning) -> dict[int, float]:
        """Boards that bear the names among the words that no table knows: “zu Ebert, weil ich etwas abgeben muss”.

        Beside a kind that is read one word of a further line says nothing: “somewhere to eat Swiss food”.
        """
        names = self._said.spelt_as_names(text, self._asked.asked(text)[1])
        return {
            id_: _NAMED + (1.0 - _NAMED) * share
            for id_, share in self._names.covered(names).items()
            if not meaning.wanted or self._names.is_name_of(id_, names)
        }

    def _by_words(self, text: str) -> dict[int, float]:
        """Boards that bear all words, or all of those that no table knows."""
        languages = wish_languages(text, self._knowledge)
        words, proper = self._asked.asked(text)
        if not words:
            return {}
        whole = self._names.covered(words)
        exact = {id_: _SURE for id_, share in whole.items() if share >= _WHOLE}
        if exact and (proper or len(words) > 1):
            return exact
        if not proper:
            return self._most_of_a_name(self._all_words(text, languages))
        if whole and proper:
            return {id_: _NAMED + (1.0 - _NAMED) * share for id_, share in whole.items()}
        names_a_kind = len(words) > len(proper)
        # “Sala Everest” is Meeting Room Everest.
        proper = [word for word in proper if not any(rules_of(each)["any"].fullmatch(word) for each in languages)]
        if names_a_kind:
            # Beside a word for a kind of place, an everyday word is no name: “the psychiatry department”.
            proper = [word for word in proper if is_unspaced(word) or word not in load_words()]
        named = self._names.covered(proper)
        if named and (len(named) == 1 or sum(map(len, proper)) >= SHORTEST):
            return {id_: _NAMED + (1.0 - _NAMED) * share for id_, share in named.items()}
        return {}

    def _most_of_a_name(self, words: list[str]) -> dict[int, float]:
        """The one board that bears several common words, of which they are the most: “frozen penguin”."""
        bearing = self._names.covered(words) if len(words) > 1 else {}
        is_one = len(bearing) == 1 and max(bearing.values()) >= _MOST_OF_A_NAME
        return dict.fromkeys(bearing, _NAMED) if is_one else {}

    def _all_words(self, text: str, languages: tuple[str, ...]) -> list[str]:
        """The words of a text without its filler, common ones as well: “spin studio”."""
        units = self._knowledge.folder.units(content_of(text, languages))
        return [unit for unit in units if not is_mark(unit)]

    def by_ear(self, text: str, meaning: Meaning) -> dict[int, float]:
        """The one landmark whose name sounds like all that is asked for, else like words that no table knows."""
        words, proper = ([], []) if self.refuses(text, meaning) else self._asked.asked(text)
        is_name = sum(map(len, proper)) >= _MOST_OF_IT * sum(map(len, words))
        return (
            (self._names.sounding(words, is_all=True) if proper else {})
            or (self._names.sounding(proper, is_all=True) if is_name else {})
            or self._names.sounding(proper)
        )

    def are_others(self, text: str, meaning: Meaning, ids: Iterable[int]) -> bool:
        """Whether a text names one of a kind, and some landmarks all bear other names."""
        return not self.refuses(text, meaning) and self._said.are_others(text, ids)

    def is_bare_name(self, text: str, meaning: Meaning) -> bool:
        """Whether all that is asked for is a name: words of no table and of no language, or spelt as names are."""
        if _NAME.search(text):
            return True
        words, proper = self._asked.asked(text)
        if (
            meaning.wanted
            or words != proper
            or not words
            or any(is_unspaced(word) or word in load_words() for word in words)
        ):
            return False
        # “Mein Arm soll geröntgt werden” is a sentence.
        return self._all_words(text, wish_languages(text, self._knowledge)) == words

    def literal(self, text: str, meaning: Meaning) -> dict[int, float]:
        """Boards that bear every word, where nothing else is known to serve."""
        if self.refuses(text, meaning):
            return {}
        words, _ = self._asked.asked(text)
        words = words or self._all_words(text, wish_languages(text, self._knowledge))
        if not words:
            return {}
        return {id_: share for id_, share in self._names.covered(words).items() if share >= _LEAST_LITERAL}
