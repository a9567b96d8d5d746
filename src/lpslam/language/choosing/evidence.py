"""The words of a question as weighed evidence for concepts: what each is said of, and how rarely of others.

Every phrase of a language's tables, and the words that are associated with concepts (`data/lexicon/associations`),
are found by their words. A word speaks for the concepts whose phrases have it, or
another form of it, the more the fewer concepts share it: the logarithm of how much likelier the concept is made by it.
"""

import math
from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from rapidfuzz.distance import Prefix

from lpslam.language.building import building
from lpslam.language.kept import kept
from lpslam.language.tables.concepts import load_associations, load_buildings
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.words import is_mark, is_unspaced

Weights = tuple[NDArray[np.int64], NDArray[np.float64]]
"""Concepts, as `Heard` counts them, and how much a word speaks for each, in units of a natural logarithm."""

Made = tuple[list[tuple[str, tuple[str, ...]]], dict[str, list[int]], list[str]]
"""The phrases of a language with their concepts, which of them have a word, and all words in order."""

_SHORTEST = 3  # letters of a word that says something
_WHOLE = 4  # letters up to which a word has no other forms
_BEGINS_ALIKE = 0.65  # of a word's letters: another form of it begins with them
_ALIKE = 0.6  # of the longer word's letters, in common, that two forms of one word have
_OF_SIZE = 0.7  # power of the number of a concept's phrases by which its words count less
_FEW_PHRASES = 4.0  # added to that number: concepts of one phrase are no surer than others
_DOUBT = 0.3  # added to what all concepts have of a word: one phrase is no proof
_LIKELIER = 40.0  # how much likelier a word makes the only concept that has it
_ASKS = "ask"  # said of all that one may ask about


class Heard:
    """The phrases of one language, searched by words.

    Attributes:
        concepts: all that phrases are said of.
    """

    def __init__(self, language: str, knowledge: Knowledge, made: Made | None = None) -> None:
        self._language = language
        self._folder = knowledge.folder
        self._common = knowledge.common[language]
        self._rows, self._rows_of, self._words = _made(language, knowledge) if made is None else made
        self._said = Counter(concept for _, concepts in self._rows for concept in concepts)
        self._number_of = {concept: number for number, concept in enumerate(self._said)}
        self.concepts = tuple(self._said)
        self._kept: dict[str, Weights] = {}

    def terms(self, question: str) -> list[str]:
        """Return the words of a question that say something; of scripts without spaces every two characters."""
        units = self._folder.units(question)
        starts = self._folder.word_starts(question)
        found: list[str] = []
        for at, unit in enumerate(units):
            if is_mark(unit) or unit.isdigit():
                continue
            if not is_unspaced(unit):
                found += [unit] if len(unit) >= _SHORTEST and unit not in self._common else []
            elif at + 1 < len(units) and is_unspaced(units[at + 1]) and at + 1 not in starts:
                pair = unit + units[at + 1]
                is_filler = all("\u3040" <= each <= "\u309f" for each in pair) or self._common.issuperset(pair)
                found += [] if is_filler else [" ".join(pair)]
        return list(dict.fromkeys(found))

    def weights(self, term: str) -> Weights:
        """Return what a word speaks for."""
        if term not in self._kept:
            if len(self._kept) >= _KEPT:
                self._kept = {}
            self._kept[term] = self._weighed(term)
        return self._kept[term]

    def _weighed(self, term: str) -> Weights:
        said: dict[str, float] = defaultdict(float)
        for row, alike in self._having(term).items():
            phrase, concepts = self._rows[row]
            share = alike / math.sqrt(self._size(phrase))
            for concept in concepts:
                said[concept] += share
        shares = {concept: each / (self._said[concept] + _FEW_PHRASES) ** _OF_SIZE for concept, each in said.items()}
        whole = sum(shares.values()) + _DOUBT
        weights = [math.log1p(_LIKELIER * share / whole * min(1.0, said[concept])) for concept, share in shares.items()]
        return np.array([self._number_of[concept] for concept in shares], np.int64), np.array(weights, np.float64)

    def _size(self, phrase: str) -> int:
        """How many words of a phrase say something."""
        words = phrase.split(" ")
        if is_unspaced(words[0]):
            return max(1, len(words) - 1)
        return max(1, sum(word not in self._common for word in words))

    def _having(self, term: str) -> dict[int, float]:
        """The phrases that have a word or another form of it, and how alike that is."""
        found: dict[int, float] = {}
        if is_unspaced(term):
            return dict.fromkeys(self._rows_of.get(term, ()), 1.0)
        kept = len(term) if len(term) <= _WHOLE else max(_WHOLE, math.ceil(_BEGINS_ALIKE * len(term)))
        for word in self._beginning(term[:kept]):
            alike = Prefix.similarity(word, term) / max(len(word), len(term))
            for row in self._rows_of[word] if alike >= _ALIKE else ():
                found[row] = max(found.get(row, 0.0), alike * alike)
        return dict(sorted(found.items()))

    def _beginning(self, letters: str) -> Iterator[str]:
        """The words of phrases that begin with some letters."""
        for at in range(bisect_left(self._words, letters), len(self._words)):
            if not self._words[at].startswith(letters):
                return
            yield self._words[at]


_KEPT = 4096  # words of a language whose weights are kept


def _made(language: str, knowledge: Knowledge) -> Made:
    rows = [(phrase, tuple(concepts)) for phrase, concepts in _rows(language, knowledge)]
    rows_of = _rows_of([phrase for phrase, _ in rows])
    return rows, rows_of, sorted(rows_of)


def _rows(language: str, knowledge: Knowledge) -> Iterator[tuple[str, Sequence[str]]]:
    """The phrases of a language with the concepts that they are said of."""
    unsaid = knowledge.general | knowledge.modifiers | {_ASKS}
    for phrase, meaning in knowledge.spoken(language).items():
        concepts = [concept for concept, _ in meaning.concepts if concept not in unsaid]
        if meaning.role == "means" and concepts:
            yield phrase, concepts
    for entry in load_buildings().concepts:
        for parts in entry.apart.get(language, ()):
            yield " ".join(map(knowledge.folder.phrase, parts)), (entry.name,)
    for concept, phrases in load_associations(language):
        if concept not in unsaid:
            for phrase in phrases:
                yield knowledge.folder.phrase(phrase), (concept,)


def _rows_of(phrases: Sequence[str]) -> dict[str, list[int]]:
    """Which phrases have a word, or two characters of a script without spaces beside each other."""
    found: dict[str, dict[int, None]] = defaultdict(dict)
    for row, phrase in enumerate(phrases):
        words = phrase.split(" ")
        for word in words:
            found[word][row] = None
        for one, other in pairwise(words):
            if one and other and is_unspaced(one) and is_unspaced(other):
                found[f"{one} {other}"][row] = None
    return {word: list(rows) for word, rows in found.items()}


@lru_cache(maxsize=8)
def heard_in(language: str, knowledge: Knowledge) -> Heard:
    """Return the phrases of a language, made when they are first asked for."""
    with building():
        return Heard(language, knowledge, kept(f"heard-{language}", b"", lambda: _made(language, knowledge)))
