"""Guesses: what a question is likeliest to mean where tables find nothing, or nothing sure.

Every landmark is weighed by the words of the question, by its board's words, by what the tables read, and by how near
its board and its kind come to the question's meaning. How sure a guess is is told beside a fixed crowd, all concepts of
the tables, as boards that might stand there as well: so it is the same for a map of two signs as for one of a thousand.
The weights are in `data/wishes/guesses.json` (`tools/train_guesses.py`).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.meaning import load_senses
from lpslam.language.choosing.support import Support, served_by
from lpslam.language.tables.lexicon import read_table

Floats = NDArray[np.float64]

_UNKIND = 0.7  # of its board's cosine: the cosine of a kind that is not known
_FARTHEST = 1.6  # below the best score: what comes less near is not offered
_MOST = 4.0  # of a lead by which guesses differ
_NUMBER = re.compile(r"\d+")
_UNSPACED = frozenset({"zh", "ja", "ko"})
COLUMNS = (
    *("words", "words of the board", "read, of the best", "read", "board", "kind", "strongest word"),
    "kind not known",
)
"""What each landmark is weighed by."""


@dataclass(frozen=True, slots=True, eq=False)
class Heard:
    """What a question says of the landmarks and of the crowd.

    Attributes:
        ids: of the landmarks.
        groups: (landmarks,) of which kinds each is.
        columns: (landmarks, COLUMNS).
        said: (landmarks,) share of the words that speak for each.
        cosines: (concepts,) of their meaning, less their mean.
        words: (concepts,) how much all words speak for each.
        spread: of the cosines.
        language: of the question.
    """

    ids: NDArray[np.int64]
    groups: NDArray[np.int64]
    columns: Floats
    said: Floats
    cosines: Floats
    words: Floats
    spread: float
    language: str


@dataclass(frozen=True, slots=True)
class Guess:
    """A landmark, what else may be meant (by id, 0 < score <= 1), and how probably it is right."""

    best: int
    scores: Mapping[int, float]
    sure: float


class Guessing:
    """The landmarks of a map by the meaning of their boards and kinds."""

    def __init__(self, index: LandmarkIndex, support: Support) -> None:
        self._support = support
        self._senses = load_senses()
        self._ids = np.array(list(support.group_of), int)
        self._groups = np.array(list(support.group_of.values()), int)
        self._row_of = {id_: row for row, id_ in enumerate(support.group_of)}
        self._size = len(index.landmarks)
        # Numbers say nothing of what a board means.
        said = {mark.id: _NUMBER.sub(" ", " ".join([mark.name, *mark.lines])) for mark in index.landmarks}
        texts = {text: at for at, text in enumerate(dict.fromkeys(said[id_] for id_ in support.group_of))}
        self._boards = self._senses.boards(list(texts))
        self._board_of = np.array([texts[said[id_]] for id_ in support.group_of], int)
        known = self._senses.concepts
        signs = [index.signs[int(ids[0])] for ids in support.ids]
        rows = [(at, known[k], w) for at, sign in enumerate(signs) for k, w in sign.kinds if k in known]
        self._kinds = np.array(rows, float).reshape(len(rows), 3)
        self._is_known = np.array([bool(sign.kinds) for sign in signs], bool)
        self._is_brand = np.array([bool(index.signs[id_].identity) for id_ in support.group_of], bool)
        self._served = [
            [known[each] for each in served_by(sign.kinds, support.knowledge) if each in known] for sign in signs
        ]

    def heard(self, question: str, language: str, read: Mapping[int, float]) -> Heard:
        """Return what a question says of every landmark; `read` is how well each serves what the tables read."""
        terms, evidence, _ = self._support.evidence(question, language)
        own = self._support.borne(terms)
        borne = np.zeros(len(self._ids))
        borne[[self._row_of[id_] for id_ in own]] = list(own.values())
        tables = self._support.by_group(read)
        asked = self._senses.asked(question)
        cosines = (self._senses.middles @ asked).astype(float)
        middle = float(cosines.mean())
        board, kind = self._meaning(self._boards @ asked, cosines)
        by_group = np.stack([evidence.sum(axis=0), evidence.max(axis=0, initial=0.0)])[:, self._groups]
        read_of = tables[self._groups]
        columns = (
            *(by_group[0], borne, read_of / max(tables.max(initial=0.0), 1e-9), read_of),
            *(board - middle, np.where(np.isnan(kind), _UNKIND * board, kind) - middle),
            *(by_group[1], np.isnan(kind).astype(float)),
        )
        said = self._support.speaking(evidence)[self._groups]
        words = np.zeros(len(cosines))
        for concept, weight in self._support.spoken_for(terms, language).items():
            if concept in self._senses.concepts:
                words[self._senses.concepts[concept]] += weight
        return Heard(
            *(self._ids, self._groups, np.stack(columns, axis=1), said),
            *(cosines - middle, words, float(cosines.std()) + 1e-9, language),
        )

    def _meaning(self, boards: NDArray[np.float32], cosines: Floats) -> tuple[Floats, Floats]:
        """(landmarks,) cosines of boards and of kinds, NaN where none is known; places of one kind are alike.

        A brand's name is no word: its board says what its kind does.
        """
        of_kind = np.full(len(self._is_known), -np.inf)
        rows = self._kinds[:, 1].astype(int)
        np.maximum.at(of_kind, self._kinds[:, 0].astype(int), self._kinds[:, 2] * cosines[rows])
        kind = np.where(np.isfinite(of_kind), of_kind, np.nan)[self._groups]
        own = np.where(self._is_brand & ~np.isnan(kind), kind, boards[self._board_of].astype(float))
        best = np.full(len(self._is_known), -np.inf)
        np.maximum.at(best, self._groups, own)
        return np.where(self._is_known[self._groups], best[self._groups], own), kind

    def clues(self, heard: Heard, row: int, weights: Floats, sure: float, other: float, vain: bool) -> dict[str, float]:
        """Return what tells how sure it is that a landmark is meant.

        Args:
            heard: what the question says.
            row: of the landmark.
            weights: of the columns.
            sure: how sure the tables are of it.
            other: how sure they are of another.
            vain: whether what they read is not here.
        """
        score = heard.columns @ weights
        others = heard.groups != heard.groups[row]
        own = dict(zip(COLUMNS, heard.columns[row], strict=True))
        in_meaning = heard.columns[:, 4] * weights[4] + heard.columns[:, 5] * weights[5]
        best = np.full(len(self._is_known), -np.inf)
        np.maximum.at(best, heard.groups, score)
        shares = np.exp(best[np.isfinite(best)] - score[row])
        crowd = np.ones(len(heard.cosines), bool)
        crowd[self._served[int(heard.groups[row])]] = False
        known = (weights[0] * heard.words + (weights[4] + weights[5]) * heard.cosines)[crowd]
        alone = own["words"] * weights[0] + own["words of the board"] * weights[1] + float(in_meaning[row])
        nearest = max(own["board"], own["kind"])
        return {
            "share": 1.0 / float(shares.sum()),
            "lead": _lead(score, row, others) / _MOST,
            "lead of meaning": _lead(in_meaning, row, others) / _MOST,
            "lead of words": _lead(heard.columns[:, 0], row, others) / _MOST,
            "alone": float(not others.any()),
            "board": own["board"] / heard.spread / 4.0,
            "kind": own["kind"] / heard.spread / 4.0,
            "words": min(own["words"], 8.0) / 5.0,
            "words of the board": min(own["words of the board"], 6.0) / 4.0,
            "read, of the best": own["read, of the best"],
            "read": own["read"],
            "lead over the known": float(np.clip(alone - known.max(), -8.0, 4.0)) / 6.0,
            "known that come nearer": float(np.log1p((known > alone).sum())) / 4.0,
            "nearer in meaning": float(np.log1p((heard.cosines[crowd] > nearest).sum())) / 4.0,
            "share of words": float(heard.said[row]),
            "few landmarks": 1.0 / self._size,
            "sure by tables": sure,
            "another by tables": other,
            "in vain": float(vain),
            "no spaces": float(heard.language in _UNSPACED),
        }

    def clues_of_guess(
        self, heard: Heard, row: int, weights: Floats, sure: Mapping[int, float], vain: bool
    ) -> dict[str, float]:
        """`clues` of a guess; `sure` is how sure the tables are of what they found."""
        same = max((sure[id_] for id_ in sure if self._is_of(id_, row)), default=0.0)
        other = max((sure[id_] for id_ in sure if not self._is_of(id_, row)), default=0.0)
        return self.clues(heard, row, weights, same, other, vain and not same)

    def best(self, heard: Heard, sure: Mapping[int, float], vain: bool) -> Guess | None:
        """Return the likeliest landmark; `sure` is how sure the tables are of what they found."""
        model = _model()
        score = heard.columns @ model.rank
        if not len(score) or score.max() <= 0.0:
            return None
        row = int(np.argmax(score))
        clues = self.clues_of_guess(heard, row, model.rank, sure, vain)
        near = np.flatnonzero(score >= score[row] - _FARTHEST)
        scores = {int(self._ids[at]): float(np.exp(score[at] - score[row])) for at in near}
        return Guess(int(self._ids[row]), scores, model.found(clues))

    def stands(self, heard: Heard, id_: int, sure: float) -> float:
        """Return how probably what the tables found is meant, as the meaning of all boards has it."""
        row = self.row_of(id_)
        if row is None:
            return 1.0
        model = _model()
        return model.stands(self.clues(heard, row, model.rank, sure, 0.0, False))

    def row_of(self, id_: int) -> int | None:
        """The row of a landmark, None where it is no place."""
        return self._row_of.get(id_)

    def _is_of(self, id_: int, row: int) -> bool:
        return id_ in self._row_of and bool(self._groups[self._row_of[id_]] == self._groups[row])


def _lead(score: Floats, row: int, others: NDArray[np.bool_]) -> float:
    """By how much a landmark leads those of other kinds, below 0 where it does not."""
    return float(np.clip(score[row] - score[others].max(), -_MOST, _MOST)) if others.any() else 0.5 * _MOST


@dataclass(frozen=True, slots=True, eq=False)
class _Model:
    """Weights of columns, and two logistic models of clues: of a guess, and of what the tables found."""

    rank: Floats
    names: tuple[str, ...]
    of_guess: Floats
    of_found: Floats

    def found(self, clues: Mapping[str, float]) -> float:
        """How probably a guess is right."""
        return self._probability(clues, self.of_guess)

    def stands(self, clues: Mapping[str, float]) -> float:
        """How probably what the tables found is right."""
        return self._probability(clues, self.of_found)

    def _probability(self, clues: Mapping[str, float], weights: Floats) -> float:
        x = np.array([*(clues[name] for name in self.names), 1.0])
        return float(1.0 / (1.0 + np.exp(-(x @ weights))))


@lru_cache(maxsize=1)
def _model() -> _Model:
    tree: Mapping[str, Any] = read_table("wishes/guesses.json")
    return _Model(
        *(np.array(tree["rank"]), tuple(tree["names"])),
        *(np.array(tree[each], float) for each in ("of_guess", "of_found")),
    )
