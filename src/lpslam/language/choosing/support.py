"""What speaks for each landmark of a map: the words of a question, by the concepts that it serves and by its board.

One score a landmark: the evidence of all words, the words that its board bears, and what the tables read in the
question. No single word decides against several weaker ones.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.language.choosing.evidence import heard_in
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.serving import Kinds, best_of
from lpslam.language.tables.knowledge import Knowledge

Floats = NDArray[np.float64]

_LEAST_SERVED = 0.3  # a kind that serves a concept less than this does not speak for it
_OF_WORDS, _OF_BEST, _OF_READING = 1.3, 1.8, 1.4
"""What evidence weighs, what tables read of a place as a share of the best, and as it is (a fit of choices to sets)."""
_AKIN = 0.6  # of what a word of a board says, what another that begins alike says
_SAYS = 0.5  # evidence of a word that speaks for a place
_FARTHEST = 1.6  # below the best score: what comes less near is not offered

CLUES = (
    *("words for it", "share of words for it", "strongest word for it", "board bears words"),
    *("words for more elsewhere", "lead by words", "read as well", "read at all"),
)


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
        self._columns: dict[str, NDArray[np.int64]] = {}
        self._last: tuple[tuple[str, str], Evidence] | None = None

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
        found = np.zeros(len(self.ids))
        for id_, score in read.items():
            if id_ in self.group_of:
                found[self.group_of[id_]] = max(score, found[self.group_of[id_]])
        return found

    def speaking(self, evidence: Evidence) -> Floats:
        """(groups,) the share of the words that speak for each."""
        by_word = evidence.by_word
        return (by_word > _SAYS).mean(axis=0) if len(by_word) else np.zeros(by_word.shape[1])

    def evidence(self, question: str, language: str) -> Evidence:
        """Return what the words of a question speak for.

        All words of a group are heard of the one thing that they say most of together: who sells much has no advantage.
        """
        # One question is asked of tables and guesses.
        last = self._last
        if last is None or last[0] != (question, language):
            last = self._last = (question, language), self._evidence(question, language)
        return last[1]

    def _evidence(self, question: str, language: str) -> Evidence:
        heard = heard_in(language, self.knowledge)
        terms = heard.terms(question)
        weights = [heard.weights(term) for term in terms]
        concepts = np.concatenate([each for each, _ in weights]) if terms else np.zeros(0, np.int64)
        weight = np.concatenate([each for _, each in weights]) if terms else np.zeros(0)
        said = np.zeros(len(heard.concepts))
        np.add.at(said, concepts, weight)
        columns = self._columns_of(language, heard.concepts)
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

    def _columns_of(self, language: str, concepts: Sequence[str]) -> NDArray[np.int64]:
        """Which of the concepts that are served here those of a language are; -1 for others."""
        if language not in self._columns:
            self._columns[language] = np.array([self._column_of.get(each, -1) for each in concepts], np.int64)
        return self._columns[language]

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
