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
        self._columns = {
            concept: (np.array(list(shares)), np.array(list(shares.values()))) for concept, shares in serving.items()
        }
        self._last: tuple[tuple[str, str], tuple[list[str], NDArray[np.float64], float]] | None = None

    def of(self, question: str, language: str, read: Mapping[int, float]) -> Supported:
        """Return what speaks for the landmarks; `read` is how well each serves what the tables read."""
        terms, evidence, elsewhere = self.evidence(question, language)
        own = self.borne(terms)
        strength = max(read.values(), default=0.0)
        by_group = self.by_group(read)
        tables = by_group * (_OF_BEST / max(strength, 1e-9) + _OF_READING)
        total = _OF_WORDS * evidence.sum(axis=0) + tables
        found = self._scored(total, own, read)
        if not found:
            return Supported({}, {})
        best = best_of(found)
        said = evidence[:, self.group_of[best]] if terms else np.zeros(0)
        by_board = own.get(best, 0.0)
        rivals = [each for id_, each in found.items() if self.group_of[id_] != self.group_of[best]]
        clues = (
            float(said.sum()) / 5.0,
            float((said > _SAYS).mean()) if terms else 0.0,
            float(said.max(initial=0.0)) / 4.0,
            by_board / 4.0,
            max(elsewhere - float(said.sum()) - by_board, 0.0) / 4.0,
            min(found[best] - max(rivals, default=0.0), 6.0) / 6.0,
            read.get(best, 0.0) / strength if strength else 0.0,
            strength,
        )
        top = found[best]
        scores = {id_: math.exp(each - top) for id_, each in found.items() if each >= top - _FARTHEST}
        words = tuple(term.replace(" ", "") for term, each in zip(terms, said, strict=True) if each > _SAYS)
        return Supported(scores, dict(zip(CLUES, clues, strict=True)), words)

    def by_group(self, read: Mapping[int, float]) -> NDArray[np.float64]:
        """(groups,) how well each serves what the tables read."""
        found = np.zeros(len(self.ids))
        for id_, score in read.items():
            if id_ in self.group_of:
                found[self.group_of[id_]] = max(score, found[self.group_of[id_]])
        return found

    def speaking(self, evidence: NDArray[np.float64]) -> NDArray[np.float64]:
        """(groups,) the share of the words that speak for each, of (words, groups) evidence."""
        return (evidence > _SAYS).mean(axis=0) if len(evidence) else np.zeros(evidence.shape[1])

    def spoken_for(self, terms: Sequence[str], language: str) -> Mapping[str, float]:
        """How much words speak for each concept, here or not."""
        found: dict[str, float] = defaultdict(float)
        heard = heard_in(language, self.knowledge)
        for term in terms:
            for concept, weight in heard.weights(term).items():
                found[concept] += weight
        return found

    def evidence(self, question: str, language: str) -> tuple[list[str], NDArray[np.float64], float]:
        """The words of a question that say something, (words, groups) how much each speaks for each group, and how
        much all speak for the concept that nothing here serves; not to be changed.

        All words of a group are heard of the one thing that they say most of together: who sells much has no advantage.
        """
        # One question is asked of tables and guesses.
        last = self._last
        if last is None or last[0] != (question, language):
            last = self._last = (question, language), self._evidence(question, language)
        return last[1]

    def _evidence(self, question: str, language: str) -> tuple[list[str], NDArray[np.float64], float]:
        heard = heard_in(language, self.knowledge)
        terms = heard.terms(question)
        found = np.zeros((len(terms), len(self.ids)))
        said: dict[str, float] = defaultdict(float)
        for row, term in zip(found, terms, strict=True):
            for concept, weight in heard.weights(term).items():
                said[concept] += weight
                if concept in self._columns:
                    at, share = self._columns[concept]
                    row[at] = np.maximum(row[at], weight * share)
        together = np.zeros(len(self.ids))
        for concept in said.keys() & self._columns.keys():
            at, share = self._columns[concept]
            together[at] = np.maximum(together[at], said[concept] * share)
        found *= together / np.maximum(found.sum(axis=0), 1e-9)
        elsewhere = max((weight for concept, weight in said.items() if concept not in self._columns), default=0.0)
        return terms, found, elsewhere

    def borne(self, terms: list[str]) -> dict[int, float]:
        """How much the words of a question speak for the landmarks whose boards bear them, the rarer the more."""
        found: dict[int, float] = defaultdict(float)
        for term in terms:
            word = term.replace(" ", "")
            for ids, share in ((self._bearing(word), 1.0), (self._akin(word), _AKIN)):
                for id_ in ids:
                    if id_ in self.group_of:
                        found[id_] += share * math.log1p(self._count / len(ids))
        return found

    def _scored(
        self, total: NDArray[np.float64], own: Mapping[int, float], read: Mapping[int, float]
    ) -> dict[int, float]:
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
