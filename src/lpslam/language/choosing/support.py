"""What speaks for each landmark of a map: the words of a question, by the concepts that it serves and by its board.

One score a landmark: the evidence of all words, the words that its board bears, how near its board and its kind come to
what the question means, and what the tables read in the question. No single word decides against several weaker ones.

How sure that is is told by a fixed crowd, all concepts of the tables, as boards that might stand there as well: so it
is the same for a map of two signs as for one of a thousand.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.language.choosing.evidence import heard_in
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.meaning import load_senses
from lpslam.language.choosing.serving import Kinds, best_of
from lpslam.language.tables.knowledge import Knowledge

_LEAST_SERVED = 0.3  # a kind that serves a concept less than this does not speak for it
_OF_WORDS, _OF_BEST, _OF_READING = 0.7, 1.5, 1.1
"""What evidence weighs, what tables read of a place as a share of the best, and as it is (a fit of choices to sets)."""
_OF_BOARD, _OF_KIND = 11.8, 3.8  # what the cosine of a board's meaning weighs, and that of its kind
_UNKIND = 0.7  # of its board's cosine: the cosine of a kind that is not known
_AS_WELL = 0.97  # of what the best serves of what is read: another answer
_SAYS = 0.5  # evidence of a word that speaks for a place
_FARTHEST = 1.6  # below the best score: what comes less near is not offered
_FEWEST = 20  # landmarks of a map by which the rarity of a word on boards is told: fewer tell nothing

CLUES = (
    *("words for it", "share of words for it", "strongest word for it", "board bears words"),
    *("words for more elsewhere", "lead by words", "read as well", "read at all"),
    *("meaning of board", "meaning of kind", "lead over the known", "known that are nearer"),
    *("lead by meaning alone", "lead by words alone"),
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
class _Heard:
    """What a question says of the landmarks and of the crowd.

    Attributes:
        terms: words that say something.
        evidence: (words, groups) how much each speaks for each group.
        elsewhere: how much all words speak for the concept that nothing here serves.
        board: (landmarks,) cosines of their boards' meaning.
        kind: (groups,) cosines of their kinds' meaning, NaN where none is known.
        crowd: (concepts,) what speaks for each concept of the tables, by words and meaning.
        cosines: (concepts,) of their meaning.
    """

    terms: list[str]
    evidence: NDArray[np.float64]
    elsewhere: float
    board: NDArray[np.float64]
    kind: NDArray[np.float64]
    crowd: NDArray[np.float64]
    cosines: NDArray[np.float64]


class Support:
    """The landmarks of a map by the concepts that they serve, and by the meaning of their boards."""

    def __init__(self, index: LandmarkIndex, bearing: Callable[[str], Collection[int]], knowledge: Knowledge) -> None:
        """`bearing` returns the landmarks whose boards bear a word."""
        self._knowledge = knowledge
        self._bearing = bearing
        self._count = max(len(index.landmarks), _FEWEST)
        self._senses = load_senses()
        groups = [(kinds, ids) for kinds, ids in index.groups.items() if not kinds or index.signs[ids[0]].is_place]
        self._group_of = {id_: at for at, (_, ids) in enumerate(groups) for id_ in ids}
        self._ids = np.array(list(self._group_of), int)
        self._groups = np.array(list(self._group_of.values()), int)
        self._row_of = {id_: row for row, id_ in enumerate(self._group_of)}
        self._is_known = np.array([bool(kinds) for kinds, _ in groups], bool)
        self._is_brand = np.array([bool(index.signs[id_].identity) for id_ in self._group_of], bool)
        said = {mark.id: " ".join([mark.name, *mark.lines]) for mark in index.landmarks}
        texts = list(dict.fromkeys(said[id_] for id_ in self._group_of))
        row = {text: at for at, text in enumerate(texts)}
        self._boards = self._senses.boards(texts)
        self._board_of = np.array([row[said[id_]] for id_ in self._group_of], int)
        serving: dict[str, dict[int, float]] = defaultdict(dict)
        kinds_of: list[tuple[int, int, float]] = []
        for at, (kinds, _) in enumerate(groups):
            for concept, share in _served_by(kinds, knowledge).items():
                serving[concept][at] = share
            known = self._senses.concepts
            kinds_of += [(at, known[kind], weight) for kind, weight in kinds if kind in known]
        self._columns = {
            concept: (np.array(list(shares)), np.array(list(shares.values()))) for concept, shares in serving.items()
        }
        self._kinds = np.array(kinds_of, float).reshape(len(kinds_of), 3)
        self._served = [
            {self._senses.concepts[each] for each in _served_by(kinds, knowledge) if each in self._senses.concepts}
            for kinds, _ in groups
        ]

    def of(self, question: str, language: str, read: Mapping[int, float]) -> Supported:
        """Return what speaks for the landmarks; `read` is how well each serves what the tables read."""
        heard = self._heard(question, language)
        own = self._borne(heard.terms)
        strength = max(read.values(), default=0.0)
        by_group = self._by_group(read)
        total = self._total(heard, own, by_group)
        found = self._scored(total, own, read)
        if not found:
            return Supported({}, {})
        best = best_of(found)
        top = found[best]
        scores = {id_: math.exp(each - top) for id_, each in found.items() if each >= top - _FARTHEST}
        said = heard.evidence[:, self._group_of[best]] if heard.terms else np.zeros(0)
        words = tuple(term.replace(" ", "") for term, each in zip(heard.terms, said, strict=True) if each > _SAYS)
        # What serves what is read as well is another answer, no rival.
        served = by_group[self._group_of[best]]
        is_rival = (by_group < _AS_WELL * served) | (served <= 0.0)
        is_rival[self._group_of[best]] = False
        rivals = [each for id_, each in found.items() if is_rival[self._group_of[id_]]]
        clues = {
            "words for it": float(said.sum()) / 5.0,
            "share of words for it": float((said > _SAYS).mean()) if heard.terms else 0.0,
            "strongest word for it": float(said.max(initial=0.0)) / 4.0,
            "board bears words": own.get(best, 0.0) / 4.0,
            "words for more elsewhere": max(heard.elsewhere - float(said.sum()) - own.get(best, 0.0), 0.0) / 4.0,
            "lead by words": min(top - max(rivals, default=0.0), 6.0) / 6.0,
            "read as well": read.get(best, 0.0) / strength if strength else 0.0,
            "read at all": strength,
            **self._beside_the_crowd(best, float(said.sum()) + own.get(best, 0.0), heard),
            **self._alone(best, own, heard, is_rival[self._groups]),
        }
        return Supported(scores, clues, words)

    def _heard(self, question: str, language: str) -> _Heard:
        """What a question says of each group, each landmark and each concept of the tables."""
        senses, words = self._senses, heard_in(language, self._knowledge)
        terms = words.terms(question)
        found = np.zeros((len(terms), len(self._is_known)))
        crowd = np.zeros(len(senses.concepts))
        elsewhere: dict[str, float] = defaultdict(float)
        for row, term in zip(found, terms, strict=True):
            for concept, weight in words.weights(term).items():
                if concept in senses.concepts:
                    crowd[senses.concepts[concept]] += weight
                if concept in self._columns:
                    at, share = self._columns[concept]
                    row[at] = np.maximum(row[at], weight * share)
                else:
                    elsewhere[concept] += weight
        asked = senses.asked(question)
        board, cosines = self._boards @ asked, senses.middles @ asked
        kind = np.full(len(self._is_known), -np.inf)
        np.maximum.at(kind, self._kinds[:, 0].astype(int), self._kinds[:, 2] * cosines[self._kinds[:, 1].astype(int)])
        return _Heard(
            *(terms, found, max(elsewhere.values(), default=0.0), board[self._board_of].astype(float)),
            np.where(np.isfinite(kind), kind, np.nan),
            _OF_WORDS * crowd + (_OF_BOARD + _OF_KIND) * cosines,
            cosines.astype(float),
        )

    def _by_group(self, read: Mapping[int, float]) -> NDArray[np.float64]:
        """(groups,) how well each serves what the tables read."""
        found = np.zeros(len(self._is_known))
        for id_, score in read.items():
            if id_ in self._group_of:
                found[self._group_of[id_]] = max(score, found[self._group_of[id_]])
        return found

    def _total(self, heard: _Heard, own: Mapping[int, float], by_group: NDArray[np.float64]) -> NDArray[np.float64]:
        """(landmarks,) all that speaks for each, their meaning beside the middle of the crowd."""
        tables = by_group * (_OF_BEST / max(by_group.max(initial=0.0), 1e-9) + _OF_READING)
        board, kind = self._meaning(heard)
        middle = float(heard.cosines.mean())
        total = (_OF_WORDS * heard.evidence.sum(axis=0) + tables)[self._groups]
        total += _OF_BOARD * (board - middle) + _OF_KIND * (kind - middle)
        for id_, each in own.items():
            total[self._row_of[id_]] += _OF_WORDS * each
        return np.asarray(total)

    def _meaning(self, heard: _Heard) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(landmarks,) cosines of boards and kinds; places of one kind are alike, as the best of them.

        A brand's name is no word: its board says what its kind does. Apple sells no fruit.
        """
        kind = heard.kind[self._groups]
        own = np.where(self._is_brand & ~np.isnan(kind), kind, heard.board)
        best = np.full(len(self._is_known), -np.inf)
        np.maximum.at(best, self._groups, own)
        board = np.where(self._is_known[self._groups], best[self._groups], own)
        return board, np.where(np.isnan(kind), _UNKIND * board, kind)

    def _beside_the_crowd(self, best: int, words: float, heard: _Heard) -> dict[str, float]:
        """How the best stands among all concepts of the tables that it does not serve."""
        board, kind = (float(each[self._row_of[best]]) for each in self._meaning(heard))
        others = np.ones(len(heard.crowd), bool)
        others[list(self._served[self._group_of[best]])] = False
        own = _OF_WORDS * words + _OF_BOARD * board + _OF_KIND * kind
        middle, spread = float(heard.cosines.mean()), float(heard.cosines.std()) + 1e-9
        return {
            "meaning of board": (board - middle) / spread / 4.0,
            "meaning of kind": (kind - middle) / spread / 4.0,
            "lead over the known": (own - float(heard.crowd[others].max(initial=0.0))) / 6.0,
            "known that are nearer": math.log1p(float((heard.crowd[others] > own).sum())) / 4.0,
        }

    def _alone(self, best: int, own: Mapping[int, float], heard: _Heard, others: NDArray[np.bool_]) -> dict[str, float]:
        """By how much the best leads others by meaning alone, and by words alone; below 0 where it does not."""
        board, kind = self._meaning(heard)
        meaning = _OF_BOARD * board + _OF_KIND * kind
        words = heard.evidence.sum(axis=0)[self._groups]
        for id_, each in own.items():
            words[self._row_of[id_]] += each
        at = self._row_of[best]
        found = (
            float(np.clip((each[at] - each[others].max(initial=lowest)) / 4.0, -1.0, 1.0))
            for each, lowest in ((meaning, float(meaning.min())), (words, 0.0))
        )
        return dict(zip(("lead by meaning alone", "lead by words alone"), found, strict=True))

    def _borne(self, terms: list[str]) -> dict[int, float]:
        """How much the words of a question speak for the landmarks whose boards bear them, the rarer the more."""
        found: dict[int, float] = defaultdict(float)
        for term in terms:
            ids = self._bearing(term.replace(" ", ""))
            for id_ in ids:
                if id_ in self._group_of:
                    found[id_] += math.log1p(self._count / len(ids))
        return found

    def _scored(
        self, total: NDArray[np.float64], own: Mapping[int, float], read: Mapping[int, float]
    ) -> dict[int, float]:
        """The landmarks that come near the best; of places of one kind, those that the reading left."""
        is_read = np.zeros(len(self._is_known), bool)
        left = np.array([id_ in read or id_ in own for id_ in self._ids.tolist()], bool)
        is_read[self._groups[left]] = True
        total = np.where(is_read[self._groups] & ~left & self._is_known[self._groups], -np.inf, total)
        top = float(total.max(initial=0.0))
        if top <= 0.0:
            return {}
        near = np.flatnonzero(total >= max(top - 2.0 * _FARTHEST, 1e-9))
        return {int(self._ids[row]): float(total[row]) for row in near}


def _served_by(kinds: Kinds, knowledge: Knowledge) -> Mapping[str, float]:
    """The concepts that a place of some kinds serves, and how well."""
    found: dict[str, float] = {}
    for kind, sure in kinds:
        for concept, share in knowledge.served_by(kind).items():
            found[concept] = max(found.get(concept, 0.0), sure * share)
    return {concept: share for concept, share in found.items() if share >= _LEAST_SERVED}
