"""What is left of what serves a stop that refuses something: what serves the one part, less what serves the other."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from lpslam.language.choosing.guessing import LEAST_SURE
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.meaning import load_senses
from lpslam.language.choosing.serving import best_of
from lpslam.language.questions.wanted import Wish as Meaning
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.wishes.board_words import BoardWords
from lpslam.language.wishes.form import Stop
from lpslam.language.wishes.guesses import LEAST_IN_SPITE
from lpslam.language.wishes.identities import Identities
from lpslam.language.wishes.rules import ALIKE, ALL_REFUSED, LEAST_REFUSED
from lpslam.language.wishes.served import Served, Way
from lpslam.language.wishes.sorts import attributes_of, others_alike

_LEAST_READ = 0.4  # probability of what tables read beside what they read as refused
_LEAST_CONFIRMED = 0.1  # probability of what serves the rest, where what is refused is some of that
_AS_WANTED = 0.5  # of the best score: what may be wanted where the best is refused
_HAS = 0.7  # of how well a place serves what it has of its own

_FEWEST_TO_TELL_APART = 2
_FIRST_OF_ALL = 0.9  # of a kind that a place is
_NEARER = 0.08  # by which the cosine of what is refused and a board leads, where that board is left out

Parts = tuple[str, Sequence[str]]
"""What a text wants, and each thing that it refuses."""
Serving = Callable[[Stop], Served]


class Refusing:
    """Refusals among one set of landmarks; `serve` says which of them serve a part of a stop."""

    def __init__(
        self, serve: Serving, boards: BoardWords, identities: Identities, index: LandmarkIndex, knowledge: Knowledge
    ) -> None:
        self._serve, self._boards, self._identities = serve, boards, identities
        self._index, self._knowledge = index, knowledge

    def left_of(self, served: Served, meaning: Meaning, language: str) -> Served:
        """What serves the words that refuse nothing, less every place that serves what the others refuse."""
        parts = self._boards.parted(served.stop.what, meaning, language)
        if parts is None:
            return served
        stop = replace(served.stop, what="", kinds=(), refused=(), language=language)
        rest_of = cache(lambda: _as_told(self._serve(replace(stop, what=parts[0]))))
        left = self._less(served, meaning, parts, stop, rest_of)
        elsewhere = self._serving(meaning.refused) | _nearly_best(rest_of())
        return left if elsewhere - left.scores.keys() else self._told_by_refusal(left, parts[1])

    def _told_by_refusal(self, left: Served, refused: Sequence[str]) -> Served:
        """What is left where none is left out yet, without the one of a sort that comes nearest to what is refused.

        A refusal tells places that serve alike apart: of two registries “not the one for crimes” is the other.
        """
        ids = self._of_one_sort(left)
        if len(ids) < _FEWEST_TO_TELL_APART:
            return left
        senses = load_senses()
        boards = senses.boards([self._index.name_of[id_] for id_ in ids])
        alike = np.max([boards @ senses.asked(each) for each in refused], axis=0)
        second, first = np.argsort(alike)[-2:]
        if alike[first] - alike[second] < _NEARER:
            return left
        return replace(left, scores={id_: score for id_, score in left.scores.items() if id_ != ids[first]})

    def _of_one_sort(self, served: Served) -> list[int]:
        """Of the landmarks that come near the best, those whose boards are of a kind that it is."""
        first = {
            id_: {kind for kind, weight in self._index.signs[id_].kinds if weight >= _FIRST_OF_ALL}
            for id_ in _nearly_best(served)
        }
        return sorted(id_ for id_, kinds in first.items() if kinds & first[best_of(served.scores)])

    def _less(
        self, served: Served, meaning: Meaning, parts: Parts, stop: Stop, rest_of: Callable[[], Served]
    ) -> Served:
        """What serves, less what is refused by the words of boards, by what tables read, or by what serves it."""
        language, served = stop.language or "en", _as_told(served)
        named = {id_ for name in meaning.refused_names for id_ in self._index.ids_of.get(name, ())}
        alike: set[int] = set()
        for each in parts[1]:
            borne = set(self._boards.said_on(each))
            borne |= self._identities.bearing(each, lambda: (*served.scores, *rest_of().scores))
            borne |= self._told_by(each, (*served.scores, *rest_of().scores))
            named |= borne
            # What no table reads as refused is left out where it stands on a board, and not by what is like it.
            alike |= self._best_of(each, stop) if meaning.refused and not borne else set()
        out = named | alike or self._serving(meaning.refused) - served.scores.keys()
        most = _AS_WANTED * max(served.scores.values(), default=0.0)
        read = {id_: score for id_, score in served.scores.items() if id_ not in out and score >= most}
        # What is refused by what its board says is that board alone; tables read a kind.
        is_read = bool(meaning.rest and read) and len(parts[1]) == 1 and not named and served.sure >= LEAST_SURE
        if is_read:
            return replace(served, scores=read)
        rest = rest_of()
        least = LEAST_IN_SPITE if rest.way is Way.GUESS else LEAST_SURE
        # What is refused is of what is wanted: so that was understood.
        if self._is_confirmed(rest, out):
            rest = rest.confirmed(least)
        if not rest.scores or rest.sure < least:
            # Tables that read what is refused as well as what is wanted are right more often than their words tell.
            is_surer = bool(read and meaning.refused) and max(served.sure, rest.sure) >= _LEAST_READ
            return replace(served.confirmed(LEAST_SURE if is_surer else 0.0), scores=read, strictness=1.0)
        # What comes far behind what is refused was not wanted.
        near = _AS_WANTED * max(rest.scores.values())
        left = {id_: score for id_, score in rest.scores.items() if id_ not in out and (score >= near or id_ in read)}
        if not left and not self._boards.leaves_out(served.stop.what, language):
            # “The computer won't take my password” only tells of something.
            return replace(rest, stop=served.stop)
        if not left and named and read and served.sure >= _LEAST_READ and rest.way is not Way.NAME:
            # A brand that is refused serves so much better than all else that nothing else was near it.
            return replace(served.confirmed(LEAST_SURE), scores=read)
        left = {id_: score for id_, score in left.items() if id_ in read} or left
        name_of = self._index.name_of
        alike = others_alike((name_of[id_] for id_ in named), {id_: name_of[id_] for id_ in left})
        left = {id_: left[id_] for id_ in alike} or left
        said = rest.evidence if left else ALL_REFUSED
        return replace(rest, stop=served.stop, scores=left, exact=rest.exact & left.keys(), evidence=said)

    def _told_by(self, text: str, ids: Iterable[int]) -> set[int]:
        """Of some landmarks, those whose boards bear the colour, the age or what else a text says of a place."""
        asked = attributes_of(text)
        return {id_ for id_ in ids if asked & attributes_of(self._index.name_of[id_])} if asked else set()

    def _is_confirmed(self, rest: Served, out: set[int]) -> bool:
        """Whether what serves the rest, though unsure, is partly refused, and partly not."""
        near = _AS_WANTED * max(rest.scores.values(), default=0.0)
        best = {id_ for id_, score in rest.scores.items() if score >= near}
        return rest.sure >= _LEAST_CONFIRMED and bool(best & out) and bool(best - out)

    def _best_of(self, text: str, stop: Stop) -> set[int]:
        """The landmarks that serve a text as well as any."""
        served = self._serve(replace(stop, what=text))
        best = max(served.scores.values(), default=0.0)
        is_found = served.sure >= (LEAST_SURE if served.way is Way.GUESS else LEAST_REFUSED)
        return {id_ for id_, score in served.scores.items() if is_found and score >= ALIKE * best}

    def _serving(self, concepts: Sequence[str]) -> set[int]:
        """All landmarks that are something, or have it of their own."""
        groups = self._index.members
        matches = (self._index.matches(concept) for concept in concepts)
        return {id_ for found in matches for at, share in found.items() if share >= _HAS for id_ in groups[at]}


def _nearly_best(served: Served) -> set[int]:
    """The landmarks that come near the best one."""
    least = _AS_WANTED * max(served.scores.values(), default=0.0)
    return {id_ for id_, score in served.scores.items() if score >= least}


def _as_told(served: Served) -> Served:
    return replace(served, strictness=1.0) if served.way is Way.KIND else served
