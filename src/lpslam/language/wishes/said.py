"""Names of boards that stand in a question by what is their own, whatever else is said there."""

import re
from collections.abc import Iterable, Iterator, Sequence

from lpslam.language.languages import CAPITALS_ARE_NAMES, UNSPACED
from lpslam.language.tables.knowledge import Knowledge, load_words
from lpslam.language.tables.words import UNSPACED_RUN, is_mark, is_unspaced, longest_phrases
from lpslam.language.wishes.asked_words import AskedWords
from lpslam.language.wishes.heard import sound_the_same
from lpslam.language.wishes.names import Names, pairs_of

_FEW = 8  # boards that bear a word which may tell one of them
_FEWEST_OWN = 2  # characters of the part of such a name that is its own
_PARTICLE = re.compile(r"$|[^가-힣]|[은는이가을를에로의도와과]|까지|으로|하고|쪽|이요")


class SaidNames:
    """The names of one set of boards, looked for in questions."""

    def __init__(self, names: Names, asked: AskedWords, knowledge: Knowledge) -> None:
        self._names, self._asked, self._knowledge = names, asked, knowledge
        self._units: dict[int, tuple[str, ...]] = {}

    def own(self, text: str) -> list[int]:
        """The landmarks of whose name the part that is its own stands in a text: 云岚 of 云岚书店."""
        said = self._words_of(text)
        found: dict[int, int] = {}
        for id_ in self._near(text, said):
            own = self._own(self._name(id_))
            if own and not self._is_known(own) and self._stands_in(text, own):
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

    def _name(self, id_: int) -> tuple[str, ...]:
        if id_ not in self._units:
            self._units[id_] = tuple(self._words_of(self._names.name_of(id_)))
        return self._units[id_]

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

    def _is_known(self, run: str) -> bool:
        units = list(run)
        return any(
            span.end - span.start == len(units)
            for language in self._asked.likely(run)
            for span in longest_phrases(units, self._knowledge.tables_of(language))
        )
