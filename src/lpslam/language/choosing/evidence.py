"""The words of a question as weighed evidence for concepts: what each is said of, and how rarely of others.

Every phrase of a language's tables, and the words that are associated with concepts (`data/lexicon/associations`),
are found by their words. A word speaks for the concepts whose phrases have it, or
another form of it, the more the fewer concepts share it: the logarithm of how much likelier the concept is made by it.
"""

import math
from bisect import bisect_left
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from rapidfuzz.distance import Prefix

from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.serving import Kinds, best_of
from lpslam.language.kept import building, kept
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
_KEPT = 4096  # words of a language whose weights are kept
_ASKS = "ask"  # said of all that one may ask about
Floats = NDArray[np.float64]
_LEAST_SERVED = 0.3  # a kind that serves a concept less than this does not speak for it
_OF_WORDS, _OF_BEST, _OF_READING = 1.3, 1.8, 1.4
"""What evidence weighs, what tables read of a place as a share of the best, and as it is (a fit of choices to sets)."""
_AKIN = 0.6  # of what a word of a board says, what another that begins alike says
_SAYS = 0.5  # evidence of a word that speaks for a place
_QUESTIONS_KEPT = 4  # questions of which it is kept what they speak for: one and its parts
_FARTHEST = 1.6  # below the best score: what comes less near is not offered
CLUES = (
    *("words for it", "share of words for it", "strongest word for it", "board bears words"),
    *("words for more elsewhere", "lead by words", "read as well", "read at all"),
)


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
        self.weights = lru_cache(maxsize=_KEPT)(self._weighed)

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

    def _weighed(self, term: str) -> Weights:
        """What a word speaks for."""
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


@dataclass(frozen=True, slots=True, eq=False)
class Supported:
    """What speaks for the landmarks of a map.

    Attributes:
        scores: by id, 0 < score <= 1, of those that come near the best.
        clues: how sure that is, by name.
        words: those that speak for the best, as the tables have them.
    """

    scores: Mapping[int, float]
    clues: Mapping[str, float]
    words: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What the words of a question speak for; not to be changed.

    Attributes:
        terms: the words that say something.
        by_word: (words, groups) how much each speaks for each group.
        total: (groups,) how much all do.
        elsewhere: how much all speak for the concept that nothing here serves.
        said: (concepts,) how much all speak for each concept of the language, here or not.
        borne: how much they speak for the landmarks whose boards bear them, by id.
    """

    terms: list[str]
    by_word: Floats
    total: Floats
    elsewhere: float
    said: Floats
    borne: Mapping[int, float]


class Support:
    """The groups of landmarks of a map by the concepts that they serve."""

    def __init__(
        self,
        index: LandmarkIndex,
        bearing: Callable[[str], Collection[int]],
        akin: Callable[[str], Collection[int]],
        knowledge: Knowledge,
    ) -> None:
        """`bearing` returns the landmarks whose boards bear a word, `akin` those that bear one that begins alike."""
        self.knowledge = knowledge
        self._bearing, self._akin = bearing, akin
        self._count = len(index.landmarks)
        groups = [(kinds, ids) for kinds, ids in index.groups.items() if not kinds or index.signs[ids[0]].is_place]
        self.ids = [ids for _, ids in groups]
        self.group_of = {id_: at for at, (_, ids) in enumerate(groups) for id_ in ids}
        serving: dict[str, dict[int, float]] = defaultdict(dict)
        for at, (kinds, _) in enumerate(groups):
            for concept, share in served_by(kinds, knowledge).items():
                serving[concept][at] = share
        # The groups that serve a concept, and how well, one concept after the other.
        self._column_of = {concept: column for column, concept in enumerate(serving)}
        self._sizes = np.array([len(shares) for shares in serving.values()], np.int64)
        self._starts = np.cumsum(self._sizes) - self._sizes
        self._groups = np.array([at for shares in serving.values() for at in shares], np.int64)
        self._shares = np.array([each for shares in serving.values() for each in shares.values()], np.float64)
        self._columns_of = cache(self._columns)
        # One question is asked of tables and guesses.
        self.evidence = lru_cache(maxsize=_QUESTIONS_KEPT)(self._evidence)

    def of(self, question: str, language: str, read: Mapping[int, float]) -> Supported:
        """Return what speaks for the landmarks; `read` is how well each serves what the tables read."""
        evidence = self.evidence(question, language)
        terms, own = evidence.terms, evidence.borne
        strength = max(read.values(), default=0.0)
        by_group = self.by_group(read)
        tables = by_group * (_OF_BEST / max(strength, 1e-9) + _OF_READING)
        total = _OF_WORDS * evidence.total + tables
        found = self._scored(total, own, read)
        if not found:
            return Supported({}, {})
        best = best_of(found)
        said = evidence.by_word[:, self.group_of[best]] if terms else np.zeros(0)
        by_board = own.get(best, 0.0)
        rivals = [each for id_, each in found.items() if self.group_of[id_] != self.group_of[best]]
        clues = (
            float(said.sum()) / 5.0,
            float((said > _SAYS).mean()) if terms else 0.0,
            float(said.max(initial=0.0)) / 4.0,
            by_board / 4.0,
            max(evidence.elsewhere - float(said.sum()) - by_board, 0.0) / 4.0,
            min(found[best] - max(rivals, default=0.0), 6.0) / 6.0,
            read.get(best, 0.0) / strength if strength else 0.0,
            strength,
        )
        top = found[best]
        scores = {id_: math.exp(each - top) for id_, each in found.items() if each >= top - _FARTHEST}
        words = tuple(term.replace(" ", "") for term, each in zip(terms, said, strict=True) if each > _SAYS)
        return Supported(scores, dict(zip(CLUES, clues, strict=True)), words)

    def by_group(self, read: Mapping[int, float]) -> Floats:
        """(groups,) how well each serves what the tables read."""
        found, group_of = [0.0] * len(self.ids), self.group_of
        for id_, score in read.items():
            at = group_of.get(id_)
            if at is not None and score > found[at]:
                found[at] = score
        return np.array(found)

    def speaking(self, evidence: Evidence) -> Floats:
        """(groups,) the share of the words that speak for each."""
        by_word = evidence.by_word
        return (by_word > _SAYS).mean(axis=0) if len(by_word) else np.zeros(by_word.shape[1])

    def _evidence(self, question: str, language: str) -> Evidence:
        """What the words of a question speak for.

        All words of a group are heard of the one thing that they say most of together: who sells much has no advantage.
        """
        heard = heard_in(language, self.knowledge)
        terms = heard.terms(question)
        weights = [heard.weights(term) for term in terms]
        concepts = np.concatenate([each for each, _ in weights]) if terms else np.zeros(0, np.int64)
        weight = np.concatenate([each for _, each in weights]) if terms else np.zeros(0)
        said = np.zeros(len(heard.concepts))
        np.add.at(said, concepts, weight)
        columns = self._columns_of(language)
        row = np.repeat(np.arange(len(terms)), [len(each) for each, _ in weights])
        is_here = columns[concepts] >= 0
        at, share, of = self._serving(columns[concepts[is_here]])
        found = np.zeros((len(terms), len(self.ids)))
        np.maximum.at(found, (row[is_here][of], at), weight[is_here][of] * share)
        asked = np.flatnonzero(said)
        here = asked[columns[asked] >= 0]
        at, share, of = self._serving(columns[here])
        together = np.zeros(len(self.ids))
        np.maximum.at(together, at, said[here][of] * share)
        found *= together / np.maximum(found.sum(axis=0), 1e-9)
        elsewhere = float(said[asked[columns[asked] < 0]].max(initial=0.0))
        return Evidence(terms, found, found.sum(axis=0), elsewhere, said, self._borne(terms))

    def _columns(self, language: str) -> NDArray[np.int64]:
        """Which of the concepts that are served here those of a language are; -1 for others."""
        concepts = heard_in(language, self.knowledge).concepts
        return np.array([self._column_of.get(each, -1) for each in concepts], np.int64)

    def _serving(self, columns: NDArray[np.int64]) -> tuple[NDArray[np.int64], Floats, NDArray[np.int64]]:
        """The groups that serve some concepts, how well, and which of these concepts each is of."""
        sizes = self._sizes[columns]
        of = np.repeat(np.arange(len(columns)), sizes)
        rows = np.arange(len(of)) + np.repeat(self._starts[columns] - (np.cumsum(sizes) - sizes), sizes)
        return self._groups[rows], self._shares[rows], of

    def _borne(self, terms: list[str]) -> dict[int, float]:
        """How much the words of a question speak for the landmarks whose boards bear them, the rarer the more."""
        found: dict[int, float] = defaultdict(float)
        for term in terms:
            word = term.replace(" ", "")
            for ids, share in ((self._bearing(word), 1.0), (self._akin(word), _AKIN)):
                for id_ in ids:
                    if id_ in self.group_of:
                        found[id_] += share * math.log1p(self._count / len(ids))
        return found

    def _scored(self, total: Floats, own: Mapping[int, float], read: Mapping[int, float]) -> dict[int, float]:
        """The landmarks of the best groups, and those whose boards bear words."""
        found = {id_: float(total[self.group_of[id_]]) + _OF_WORDS * each for id_, each in own.items()}
        top = max(float(total.max(initial=0.0)), max(found.values(), default=0.0))
        if top <= 0.0:
            return {}
        for at in np.flatnonzero(total >= max(top - 2.0 * _FARTHEST, 1e-9)):
            # Of places of one kind, those that the reading left.
            for id_ in [each for each in self.ids[at] if each in read] or self.ids[at]:
                found.setdefault(id_, float(total[at]))
        return found


def served_by(kinds: Kinds, knowledge: Knowledge) -> Mapping[str, float]:
    """The concepts that a place of some kinds serves, and how well."""
    found: dict[str, float] = {}
    for kind, sure in kinds:
        for concept, share in knowledge.served_by(kind).items():
            found[concept] = max(found.get(concept, 0.0), sure * share)
    return {concept: share for concept, share in found.items() if share >= _LEAST_SERVED}
