"""Guesses: what a question is likeliest to mean where tables find nothing, or nothing sure.

Every landmark is weighed by the words of the question, by its board's words, by what the tables read, and by how near
its board and its kind come to the question's meaning. How sure a guess is is told beside a fixed crowd, all concepts of
the tables, as boards that might stand there as well: so it is the same for a map of two signs as for one of a thousand.
The weights are in `data/wishes/guesses.json` (`tools/train_guesses.py`).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.language.choosing.evidence import Support, heard_in, served_by
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.meaning import load_senses
from lpslam.language.tables.lexicon import read_table

Floats = NDArray[np.float64]

_UNKIND = 0.7  # of its board's cosine: the cosine of a kind that is not known
_FARTHEST = 1.6  # below the best score: what comes less near is not offered
_MOST = 4.0  # of a lead by which guesses differ
_AS_WELL = 0.97  # of how well tables see a place serve: another that serves as well
_KEPT = 4  # questions of which it is kept what they say: one and its parts
_NUMBER = re.compile(r"\d+")
LEAST_SURE = 0.55
"""Probability of a place to be what was meant, below which the answer is none."""
COLUMNS = (
    *("words", "words of the board", "read, of the best", "read", "board", "kind", "strongest word"),
    "kind not known",
)
"""What each landmark is weighed by."""


@dataclass(frozen=True, slots=True, eq=False)
class Heard:
    """What a question says of the landmarks and of the crowd.

    Attributes:
        ids: of the landmarks, those of one group together.
        groups: (landmarks,) of which kinds each is.
        starts: (groups,) the first landmark of each.
        columns: (landmarks, COLUMNS).
        said: (groups,) share of the words that speak for each.
        cosines: (concepts,) of their meaning, less their mean.
        words: (concepts,) how much all words speak for each.
    """

    ids: NDArray[np.int64]
    groups: NDArray[np.int64]
    starts: NDArray[np.int64]
    columns: Floats
    said: Floats
    cosines: Floats
    words: Floats

    def best_of(self, scores: Floats) -> Floats:
        """(groups,) the best of each group's landmarks, of (landmarks,) scores."""
        return np.maximum.reduceat(scores, self.starts) if len(scores) else np.zeros(0)


@dataclass(frozen=True, slots=True)
class Found:
    """What the tables found.

    Attributes:
        best: the landmark; None where they found none.
        clues: what tells how sure that is, by name.
        reads_more: whether they read something in the question.
    """

    best: int | None
    clues: Mapping[str, float]
    reads_more: bool


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
        # What tables found and a guess beside it are judged one after the other, of the same words.
        self._heard = lru_cache(maxsize=_KEPT)(self._of_words)
        self._heard_with = lru_cache(maxsize=_KEPT)(self._with_read)
        # Numbers say nothing of what a board means.
        said = {mark.id: _NUMBER.sub(" ", " ".join([mark.name, *mark.lines])) for mark in index.landmarks}
        texts = {text: at for at, text in enumerate(dict.fromkeys(said[id_] for id_ in support.group_of))}
        self._boards = self._senses.boards(list(texts))
        self._board_of = np.array([texts[said[id_]] for id_ in support.group_of], int)
        known = self._senses.concepts
        self._concepts = list(known)
        signs = [index.signs[int(ids[0])] for ids in support.ids]
        rows = [(at, known[k], w) for at, sign in enumerate(signs) for k, w in sign.kinds if k in known]
        self._kinds_group = np.array([at for at, _, _ in rows], int)
        self._kinds_concept = np.array([concept for _, concept, _ in rows], int)
        self._kinds_weight = np.array([weight for _, _, weight in rows], float)
        self._is_known = np.array([bool(sign.kinds) for sign in signs], bool)
        self._is_brand = np.array([bool(index.signs[id_].identity) for id_ in support.group_of], bool)
        self._starts = np.searchsorted(self._groups, np.arange(len(support.ids)))
        self._served = [
            [known[each] for each in served_by(sign.kinds, support.knowledge) if each in known] for sign in signs
        ]
        self._senses_in = cache(self._senses_of)

    def heard(self, question: str, language: str, read: Mapping[int, float]) -> Heard:
        """Return what a question says of every landmark; `read` is how well each serves what the tables read."""
        return self._heard_with(question, language, tuple(read.items()))

    def _with_read(self, question: str, language: str, read: tuple[tuple[int, float], ...]) -> Heard:
        """What a question says, with what tables read of each landmark."""
        heard = self._heard(question, language)
        if not read:
            return heard
        columns = heard.columns.copy()
        tables = self._support.by_group(dict(read))
        columns[:, 3] = tables[self._groups]
        columns[:, 2] = columns[:, 3] / max(tables.max(initial=0.0), 1e-9)
        return replace(heard, columns=columns)

    def _of_words(self, question: str, language: str) -> Heard:
        """What the words of a question say, whatever is read in it."""
        evidence = self._support.evidence(question, language)
        borne = np.zeros(len(self._ids))
        borne[[self._row_of[id_] for id_ in evidence.borne]] = list(evidence.borne.values())
        asked = self._senses.asked(question)
        cosines = (self._senses.middles @ asked).astype(float)
        middle = float(cosines.mean())
        board, kind = self._meaning(self._boards @ asked, cosines)
        is_unknown = np.isnan(kind)
        columns = np.zeros((len(self._ids), len(COLUMNS)))
        columns[:, 0] = evidence.total[self._groups]
        columns[:, 1] = borne
        columns[:, 4] = board - middle
        columns[:, 5] = np.where(is_unknown, _UNKIND * board, kind) - middle
        columns[:, 6] = evidence.by_word.max(axis=0, initial=0.0)[self._groups]
        columns[:, 7] = is_unknown
        words = np.zeros(len(cosines) + 1)
        words[self._senses_in(language)] = evidence.said
        return Heard(
            *(self._ids, self._groups, self._starts, columns, self._support.speaking(evidence)),
            *(cosines - middle, words[:-1]),
        )

    def _senses_of(self, language: str) -> NDArray[np.int64]:
        """Which concept of the crowd each of a language's concepts is; the one after the last where it is none."""
        concepts, known = heard_in(language, self._support.knowledge).concepts, self._senses.concepts
        return np.array([known.get(each, len(known)) for each in concepts], np.int64)

    def _meaning(self, boards: NDArray[np.float32], cosines: Floats) -> tuple[Floats, Floats]:
        """(landmarks,) cosines of boards and of kinds, NaN where none is known; places of one kind are alike.

        A brand's name is no word: its board says what its kind does.
        """
        of_kind = np.full(len(self._is_known), -np.inf)
        np.maximum.at(of_kind, self._kinds_group, self._kinds_weight * cosines[self._kinds_concept])
        kind = np.where(np.isfinite(of_kind), of_kind, np.nan)[self._groups]
        own = np.where(self._is_brand & ~np.isnan(kind), kind, boards[self._board_of].astype(float))
        if not len(own):
            return own, kind
        best = np.maximum.reduceat(own, self._starts)
        return np.where(self._is_known[self._groups], best[self._groups], own), kind

    def clues(self, heard: Heard, row: int, weights: Floats, found: Found) -> dict[str, float]:
        """Return what tells how sure it is that a landmark is meant, by the weights of the columns."""
        group = int(heard.groups[row])
        own = dict(zip(COLUMNS, heard.columns[row].tolist(), strict=True))
        score = heard.columns @ weights
        meaning = heard.columns[:, 4] * weights[4] + heard.columns[:, 5] * weights[5]
        # What serves what is read as well is no rival: who is hungry is told of any of two restaurants.
        as_well = (heard.columns[self._starts, 3] >= _AS_WELL * own["read"]) & (own["read"] > 0.0)
        as_well[group] = False
        others = ~as_well
        shares = np.exp(heard.best_of(score)[others] - score[row])
        others[group] = False
        known, cosines = weights[0] * heard.words + (weights[4] + weights[5]) * heard.cosines, heard.cosines.copy()
        known[self._served[group]] = cosines[self._served[group]] = -np.inf
        alone = own["words"] * weights[0] + own["words of the board"] * weights[1] + float(meaning[row])
        nearest = max(own["board"], own["kind"])
        is_found = found.best is not None and self._is_of(found.best, row)

        def lead(scores: Floats) -> float:
            """By how much it leads landmarks of other kinds, below 0 where it does not."""
            rival = float(heard.best_of(scores).max(initial=-np.inf, where=others))
            return min(max(float(scores[row]) - rival, -_MOST), _MOST) / _MOST if rival > -np.inf else 0.5

        return {
            **(found.clues if is_found else {}),
            "share": 1.0 / float(shares.sum()),
            "lead": lead(score),
            "lead of meaning": lead(meaning),
            "lead of words": lead(heard.columns[:, 0]),
            "alone": float(not others.any()),
            "others as well": float(np.log1p(as_well.sum())),
            "words": min(own["words"], 8.0) / 5.0,
            "words of the board": min(own["words of the board"], 6.0) / 4.0,
            "read, of the best": own["read, of the best"],
            "read": own["read"],
            "lead over the known": min(max(alone - float(known.max()), -8.0), 4.0) / 6.0,
            "known that come nearer": float(np.log1p((known > alone).sum())) / 4.0,
            "nearer in meaning": float(np.log1p((cosines > nearest).sum())) / 4.0,
            "share of words": float(heard.said[group]),
            "few landmarks": 1.0 / self._size,
            "by tables": float(is_found),
            "another by tables": float(found.best is not None and not is_found),
            "in vain": float(found.reads_more and not is_found),
        }

    def kind(self, heard: Heard, row: int) -> str:
        """Return the concept that a landmark is first of all; empty where no table reads it."""
        served = self._served[int(heard.groups[row])]
        return self._concepts[served[0]] if served else ""

    def likeliest(self, heard: Heard, found: Found, weights: Floats) -> list[int]:
        """Return the rows of the landmarks that may be meant: what the tables found, and what comes first."""
        score = heard.columns @ weights
        rows = [int(np.argmax(score))] if score.max(initial=0.0) > 0.0 else []
        if found.best is None:
            return rows
        return [self._row_of[found.best], *(row for row in rows if not self._is_of(found.best, row))]

    def sure(self, heard: Heard, found: Found) -> float:
        """Return how probably what the tables found is meant."""
        assert found.best is not None
        model = _model()
        row = self._row_of[found.best]
        return model.probability(self.clues(heard, row, model.rank, found), self.kind(heard, row))

    def best(self, heard: Heard, found: Found) -> Guess | None:
        """Return the landmark that is likeliest to be meant; what the tables are sure of stands."""
        model = _model()
        rows = self.likeliest(heard, found, model.rank)
        if not rows:
            return None
        surest = {
            row: model.probability(self.clues(heard, row, model.rank, found), self.kind(heard, row)) for row in rows
        }
        is_sure = found.best is not None and surest[rows[0]] >= LEAST_SURE
        # What is told in so many words is not taken back for what is a little likelier.
        row = rows[0] if is_sure else max(surest, key=lambda each: surest[each])
        score = heard.columns @ model.rank
        near = np.flatnonzero(score >= score[row] - _FARTHEST)
        shares = np.minimum(1.0, np.exp(score[near] - score[row]))
        scores = dict(zip(self._ids[near].tolist(), shares.tolist(), strict=True))
        return Guess(int(self._ids[row]), scores, surest[row])

    def _is_of(self, id_: int, row: int) -> bool:
        return bool(self._groups[self._row_of[id_]] == self._groups[row])


@dataclass(frozen=True, slots=True, eq=False)
class _Model:
    """Weights of columns, and a logistic model of what may be meant.

    Attributes:
        rank: weights of the columns.
        names: of the clues.
        usual: by concept, by how much oftener than others one that may be meant is: logarithm of odds.
        weights: of the clues, of what is usual, and one that stands alone.
    """

    rank: Floats
    names: tuple[str, ...]
    usual: Mapping[str, float]
    weights: Floats

    def probability(self, clues: Mapping[str, float], kind: str) -> float:
        """How probably a landmark of a kind is meant."""
        x = np.array([*(clues.get(name, 0.0) for name in self.names), self.usual.get(kind, 0.0), 1.0])
        return float(1.0 / (1.0 + np.exp(-(x @ self.weights))))


@lru_cache(maxsize=1)
def _model() -> _Model:
    tree: Mapping[str, Any] = read_table("wishes/guesses.json")
    rank, weights = np.array(tree["rank"], float), np.array(tree["weights"], float)
    return _Model(rank, tuple(tree["names"]), tree["usual"], weights)
