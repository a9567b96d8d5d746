"""What the words of boards have in common with the words of a stop: names, words just so, and names as heard."""

import re
from collections.abc import Iterable, Iterator, Sequence
from functools import cache, lru_cache

from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.languages import CAPITALS_ARE_NAMES, UNSPACED
from lpslam.language.questions.question import asks_for_another
from lpslam.language.questions.speaking import languages_of, wish_languages
from lpslam.language.questions.wanted import Wish as Meaning
from lpslam.language.tables.knowledge import Knowledge, load_words
from lpslam.language.tables.patterns import standing
from lpslam.language.tables.words import UNSPACED_RUN, is_mark, is_unspaced, longest_phrases
from lpslam.language.wishes.heard import sound_the_same
from lpslam.language.wishes.names import Names, pairs_of
from lpslam.language.wishes.polarity import parted_by_clauses
from lpslam.language.wishes.rules import content_of, parted, rules_of

SHORTEST = 3  # letters of a word that is a name by itself
_KEPT = 8  # texts whose words are kept: a stop and its parts
_FEW = 8  # boards that bear a word which may tell one of them
_FEWEST_OWN = 2  # characters of the part of such a name that is its own
_PARTICLE = standing(r"$|[^가-힣]|[은는이가을를에로의도와과]|까지|으로|하고|쪽|이요")
_BY_ITSELF = standing(r"[가-힣]{2,}?(?=(?:이?라는|[은는이가을를에]|으로|로|까지|하고)?(?:[^가-힣]|$))|[ァ-ヴー]{3,}")
_NAMED = 0.9  # of a part of a name
_FEW_WORDS = 3  # of a question in which a name of few sounds is heard beside other words
_MOST_OF_IT = 0.7  # of the letters that are asked for: a name, with a particle
_MOST_OF_A_NAME = 0.5  # of a name's letters that are asked for, where each word by itself means something else
_NAME = standing(r"(?<=[a-zà-ÿ] )[A-Z][\w'’-]* (?:[A-Z&][\w'’-]* ?)+")  # “is there a Burger King”
_LEAST_LITERAL = 0.3  # of a board's letters that are asked for word by word


class AskedWords:
    """Cuts questions into words, by the tables of the languages that they may be in."""

    def __init__(self, knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        # One text is asked about again and again.
        self.asked = lru_cache(maxsize=_KEPT)(self._asked)

    def _asked(self, text: str) -> tuple[list[str], list[str]]:
        """The words of a question without its filler, and those of them that no table knows."""
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


class SaidNames:
    """The names of one set of boards, looked for in questions."""

    def __init__(self, names: Names, asked: AskedWords, knowledge: Knowledge) -> None:
        self._names, self._asked, self._knowledge = names, asked, knowledge
        self._name = cache(self._words_of_name)

    def own(self, text: str) -> list[int]:
        """The landmarks of whose name the part that is its own stands in a text: 云岚 of 云岚书店."""
        said = self._words_of(text)
        found: dict[int, int] = {}
        for id_ in self._near(text, said):
            own = self._own(self._name(id_))
            if own and not self.is_known(own) and self._stands_in(text, own):
                found[id_] = len(own)
        longest = max(found.values(), default=0)
        return [id_ for id_, letters in found.items() if letters == longest]

    def are_others(self, text: str, ids: Iterable[int]) -> bool:
        """Whether a text names one of a kind, and some landmarks all bear other names: “Hunter Pharmacy”."""
        named = self._named_beside_a_kind(text)
        return bool(named) and all(self._is_another(id_, named, text) for id_ in ids)

    def _is_another(self, id_: int, named: Sequence[str], text: str) -> bool:
        """Whether a board has, beside its kind, words of Latin letters that are not those named, nor sound like them.

        A name of another script may be the same.
        """
        words = self._words_of(self._names.name_of(id_))
        others = [
            word for word in words if word.isalpha() and not is_unspaced(word) and word not in self._words_of(text)
        ]
        is_near = any(sound_the_same(word, other) for word in named for other in others)
        return len(words) > 1 and bool(others) and not is_near and not self._names.covered(named).get(id_)

    def _named_beside_a_kind(self, text: str) -> list[str]:
        """Words that no table knows, with a capital, right beside a word for a kind of place that has one as well."""
        tokens = re.findall(r"[^\W_][\w'’-]*|\S", text)
        kinds = [token[0].isupper() and self._is_kind(token, text) for token in tokens]
        proper = self._asked.asked(text)[1]
        # A capital within a sentence is a name's; every noun of German has one, but none follows another.
        is_telling = CAPITALS_ARE_NAMES.issuperset(self._asked.likely(text)[:1])
        found: list[str] = []
        for at, token in enumerate(tokens):
            unit = next(iter(self._knowledge.folder.units(token)), "")
            before, after = kinds[max(0, at - 1) : at], kinds[at + 1 : at + 2]
            if token[0].isupper() and unit in proper and any((*before, *after) if is_telling else before):
                found.append(unit)
        return found

    def _is_kind(self, word: str, text: str) -> bool:
        units = self._knowledge.folder.units(word)
        return any(
            span.value.role == "means"
            for language in self._asked.likely(text)
            for span in longest_phrases(units, self._knowledge.tables_of(language))
        )

    def spelt_as_names(self, text: str, words: Sequence[str]) -> list[str]:
        """Those of some words that boards bear, and that are spelt as names are, or are words of no language.

        Among characters of scripts without spaces any word of Latin letters is a name.
        """
        language = next(iter(self._asked.likely(text)), "")
        capital: set[str] = set()
        if language in CAPITALS_ARE_NAMES:
            for word in re.findall(r"(?<=[\s¿¡(«“\"'’])[A-ZÀ-Þ][\w'’-]*", text):
                capital.update(self._knowledge.folder.units(word))
        common = frozenset().union(*self._knowledge.common.values())
        return [
            word
            for word in words
            if not (is_unspaced(word) or word in common)
            and (word not in load_words() or word in capital or language in UNSPACED)
            and self._names.covered([word])
        ]

    def _words_of(self, text: str) -> list[str]:
        return [unit for unit in self._knowledge.folder.units(text.replace("-", " ")) if not is_mark(unit)]

    def _near(self, text: str, said: Sequence[str]) -> Iterator[int]:
        """The landmarks that bear a word or two characters of a text which few boards bear."""
        runs = UNSPACED_RUN.findall(self._knowledge.folder.fold(text))
        bearing = (self._names.bearing(piece) for piece in {*said, *pairs_of(runs)} if len(piece) > 1)
        yield from sorted({id_ for ids in bearing if len(ids) <= _FEW for id_ in ids})

    def _words_of_name(self, id_: int) -> list[str]:
        return self._words_of(self._names.name_of(id_))

    def _stands_in(self, text: str, run: str) -> bool:
        """Whether a run stands in a text; of Hangul, which parts words by spaces, as a word with its particle."""
        folded = self._knowledge.folder.fold(text)
        if not "가" <= run[0] <= "힣":
            return run in folded.replace(" ", "")
        spaced = r" ?".join(map(re.escape, run))
        return any(_PARTICLE.match(folded[hit.end() :]) for hit in re.finditer(rf"(?<![가-힣]){spaced}", folded))

    def _own(self, name: Sequence[str]) -> str:
        """The first part of a name of a script without spaces, before the last phrase that tables know."""
        if not name or not is_unspaced(name[0]):
            return ""
        languages = self._asked.likely("".join(name))
        ends = [
            span.start
            for language in languages
            for span in longest_phrases(name, self._knowledge.tables_of(language))
            if span.end == len(name)
        ]
        own = "".join(name[: min(ends, default=0)])
        return own if len(own) >= _FEWEST_OWN else ""

    def is_known(self, run: str) -> bool:
        """Whether tables know a run of a script without spaces as one phrase."""
        units = list(run)
        return any(
            span.end - span.start == len(units)
            for language in self._asked.likely(run)
            for span in longest_phrases(units, self._knowledge.tables_of(language))
        )


class BoardWords:
    """The words of one set of boards, asked for by the words of a stop."""

    def __init__(self, names: Names, asked: AskedWords, index: LandmarkIndex, knowledge: Knowledge) -> None:
        self._names, self._asked, self._index, self._knowledge = names, asked, index, knowledge
        self._said = SaidNames(names, asked, knowledge)
        self._says_no = lru_cache(maxsize=_KEPT)(self._negates)

    def refuses(self, text: str, meaning: Meaning) -> bool:
        """Whether a text says no to something: then a name in it may be what is refused."""
        return bool(meaning.refused_names or meaning.refused) or self._says_no(text)

    def _negates(self, text: str) -> bool:
        units = self._knowledge.folder.units(text)
        return asks_for_another(text) or any(
            span.value.role.startswith("refuse")
            for language in self._asked.likely(text)[:1]
            for span in longest_phrases(units, (self._knowledge.spoken(language),))
        )

    def parted(self, text: str, meaning: Meaning, language: str) -> tuple[str, list[str]] | None:
        """Return what a text wants, and each thing that it refuses, as its turns of phrase or its words part them."""
        by_clauses = parted_by_clauses(text, language)
        if by_clauses is not None:
            return by_clauses
        if not content_of(meaning.rest, wish_languages(text, self._knowledge)):
            return parted(text, language)
        what, more = parted(meaning.rest, language) or (meaning.rest, [])
        return what, [meaning.left_out, *more]

    def leaves_out(self, text: str, language: str) -> bool:
        """Whether a text says no to a part of what it asks for (“but”, “except”), not only of something."""
        units = self._knowledge.folder.units(text)
        said = f" {' '.join(units)} "
        turns = any(f" {word} " in said or (is_unspaced(word) and word in text) for word in self._knowledge.turning)
        parts = parted_by_clauses(text, language) or parted(text, language)
        return turns or asks_for_another(text) or parts is not None

    def said_on(self, text: str) -> dict[int, float]:
        """The landmarks whose boards bear all words of a text."""
        return self._names.covered(self._asked.asked(text)[0])

    def by_name(self, text: str, meaning: Meaning) -> dict[int, float]:
        """Landmarks whose board bears every word that is asked for and means nothing else."""
        if self.refuses(text, meaning):
            return {}
        return (
            self._by_words(text)
            or dict.fromkeys(self._said.own(text), _NAMED)
            or self._by_letters(text)
            or self._by_some(text, meaning)
            or self._names.aloud(text)
        )

    def _by_letters(self, text: str) -> dict[int, float]:
        """The one board whose name a text is but for spaces and slips, where a word of it is of no language."""
        content = content_of(text, wish_languages(text, self._knowledge))
        words = self._knowledge.folder.units(content.replace("-", " "))
        is_misspelt = any(word.isalpha() and not is_unspaced(word) and word not in load_words() for word in words)
        return self._names.spelt(content) if is_misspelt else {}

    def _by_some(self, text: str, meaning: Meaning) -> dict[int, float]:
        """Boards that bear the names among the words that no table knows: “zu Ebert, weil ich etwas abgeben muss”.

        Beside a kind that is read one word of a further line says nothing: “somewhere to eat Swiss food”.
        """
        named = self._names.covered(self._said.spelt_as_names(text, self._asked.asked(text)[1]), bool(meaning.wanted))
        return {id_: _NAMED + (1.0 - _NAMED) * share for id_, share in named.items()}

    def _by_words(self, text: str) -> dict[int, float]:
        """Boards that bear all words, or all of those that no table knows."""
        languages = wish_languages(text, self._knowledge)
        words, proper = self._asked.asked(text)
        whole = self._names.covered(words)
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
            or self._by_sound_alone(text, meaning)
        )

    def _by_sound_alone(self, text: str, meaning: Meaning) -> dict[int, float]:
        """The one landmark whose name sounds like a word of Hangul or katakana that stands by itself: 헤론 바."""
        if self.refuses(text, meaning):
            return {}
        found: dict[int, float] = {}
        is_brief = len(text.split()) <= _FEW_WORDS
        for word in _BY_ITSELF.findall(text):
            if not self._said.is_known(word):
                found |= self._names.sounding([word]) or self._names.sounding([word], is_all=is_brief)
        return found if len(found) == 1 else {}

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

    def literal(self, text: str) -> dict[int, float]:
        """Boards that bear every word, where nothing else is known to serve."""
        words, _ = self._asked.asked(text)
        words = words or self._all_words(text, wish_languages(text, self._knowledge))
        return {id_: share for id_, share in self._names.covered(words).items() if share >= _LEAST_LITERAL}
