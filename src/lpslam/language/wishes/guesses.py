"""Guesses beside what the tables found: they answer where tables find nothing sure, and may doubt what those found."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property

from lpslam.language.choosing.guessing import LEAST_SURE, Found, Guess, Guessing, Heard
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.serving import best_of
from lpslam.language.choosing.support import Support
from lpslam.language.questions.phrasing import answer_language, phrases_in
from lpslam.language.questions.wanted import Wish as Meaning
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.wishes.form import Stop, Which
from lpslam.language.wishes.names import Names
from lpslam.language.wishes.served import AS_WELL, Served, Way

_LEAST_OFFERED = 0.25  # probability of a guess from which it fills a gap in a plan
LEAST_IN_SPITE = 0.75  # probability from which what hears no negation, or no name, answers in spite of one
IN_SPITE = LEAST_IN_SPITE / LEAST_SURE  # strictness of what answers in spite of what was read
KIND_SURE = 0.6 / LEAST_SURE  # strictness of a kind: of those below, fewer than two of three were right
_READ = 0.5  # a wanted concept of this weight is more than “food” or “a shop”

Trusted = Callable[[Mapping[int, float]], dict[int, float]]
"""Leaves of landmarks with scores those that are believed."""
Clues = Mapping[str, float]
"""What tells how sure what the tables found is (`certainty.py`)."""


def is_told(stop: Stop) -> bool:
    """Whether a place, an order or an exclusion tells which of a sort is meant."""
    return stop.relation is not None or stop.which is not Which.ANY or bool(stop.without)


class Guesses:
    """The guesses about one set of landmarks."""

    def __init__(self, index: LandmarkIndex, names: Names, knowledge: Knowledge) -> None:
        self._index, self._names, self._knowledge = index, names, knowledge

    @cached_property
    def support(self) -> Support:
        """What speaks for the landmarks, made when it is first asked for."""
        return Support(self._index, self._names.bearing, self._names.akin, self._knowledge)

    @cached_property
    def guessing(self) -> Guessing:
        """What they mean, made when it is first asked for."""
        return Guessing(self._index, self.support)

    def judged(self, served: Served, clues: Clues, meaning: Meaning, language: str, trusted: Trusted) -> Served:
        """Return what is likelier: what the tables found, or a guess; and how probably it is meant."""
        guess = self._guess(served, clues, meaning, language)
        if guess is None:
            return served
        if served.scores and self._serves_as_well(guess.best, served.scores):
            return replace(served, sure=guess.sure, confidence=min(served.confidence, guess.sure))
        scores = trusted(guess.scores)
        if guess.best not in scores or guess.sure < _LEAST_OFFERED:
            return replace(served, sure=min(served.sure, guess.sure))
        guessed = self._guessed(served, guess, scores)
        if served.scores or not any(weight >= _READ for _, weight in meaning.wanted):
            return guessed
        # What was read, and is nowhere here, is not answered by what is only near it: pizza by fried chicken.
        strict = replace(guessed, strictness=IN_SPITE, doubt=served.evidence)
        return strict if guess.sure >= LEAST_IN_SPITE else replace(strict, confidence=served.confidence)

    def sure(self, served: Served, clues: Clues, meaning: Meaning, language: str) -> float:
        """Return how probably what the tables found is meant, no guess beside it."""
        asked = self.asked(served, clues, meaning, language)
        return 1.0 if asked is None or not served.scores else self.guessing.sure(*asked)

    def told(self, served: Served, meaning: Meaning, language: str, trusted: Trusted) -> Served:
        """Return a sure guess where a negation only tells of something: “my jacket can't go in the washing machine”."""
        guess = self._guess(served, {}, meaning, language)
        if guess is None or guess.sure < LEAST_IN_SPITE:
            return served
        scores = trusted(guess.scores)
        return self._guessed(served, guess, scores) if guess.best in scores else served

    def asked(self, served: Served, clues: Clues, meaning: Meaning, language: str) -> tuple[Heard, Found] | None:
        """What a stop says of every landmark, and what the tables found; None where that is no place."""
        best = best_of(served.scores) if served.scores else None
        if not self.support.group_of or (best is not None and best not in self.support.group_of):
            return None
        reads_more = any(weight >= _READ for _, weight in meaning.wanted)
        return self.guessing.heard(served.stop.what, language, served.read), Found(best, clues, reads_more)

    def _guess(self, served: Served, clues: Clues, meaning: Meaning, language: str) -> Guess | None:
        asked = self.asked(served, clues, meaning, language)
        return None if asked is None else self.guessing.best(*asked)

    def _serves_as_well(self, id_: int, scores: Mapping[int, float]) -> bool:
        """Whether a landmark is a place of the best one's kind, or serves as well as it."""
        best = best_of(scores)
        return (
            scores.get(id_, 0.0) >= AS_WELL * scores[best] or self.support.group_of[id_] == self.support.group_of[best]
        )

    def _guessed(self, served: Served, guess: Guess, scores: Mapping[int, float]) -> Served:
        found = replace(served, scores=scores, way=Way.GUESS, exact=frozenset(), strength=0.0, why=None)
        if guess.sure < LEAST_SURE:
            # What tables have to say of it goes before what is likeliest: “Starbucks is not on this map”.
            doubt = served.doubt if served.scores else served.evidence
            return replace(found, sure=guess.sure, doubt=doubt)
        phrases = phrases_in(answer_language(served.stop.what, served.stop.language))

        def why(id_: int) -> str:
            return phrases.say("words_speak", words=served.stop.what, name=clean_text(self._index.name_of[id_]))

        return replace(found, evidence=why(guess.best), confidence=guess.sure, sure=guess.sure, why=why)
