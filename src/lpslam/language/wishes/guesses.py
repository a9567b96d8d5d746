"""Guesses beside what the tables found: they answer where tables find nothing sure, and may doubt what those found."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import cached_property

from lpslam.language.choosing.guessing import Guess, Guessing, Heard
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.serving import best_of
from lpslam.language.choosing.support import Support
from lpslam.language.questions.phrasing import answer_language, phrases_in
from lpslam.language.questions.wanted import Wish as Meaning
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.wishes.form import Stop, Which
from lpslam.language.wishes.served import LEAST_SURE, Served, Way

_LEAST_GUESSED = 0.8
"""Probability of a guess below which it is none (left out of the training, one in five of the surer ones is wrong)."""
_LEAST_OFFERED = 0.4  # probability of a guess from which it fills a gap in a plan
_STANDS = 0.5  # probability of what tables found below which it is no answer
_CERTAIN = 1.0  # what is asked for in so many words is not doubted
_READ = 0.5  # a wanted concept of this weight is more than “food” or “a shop”


def is_told(stop: Stop) -> bool:
    """Whether a place, an order or an exclusion tells which of a sort is meant."""
    return stop.relation is not None or stop.which is not Which.ANY or bool(stop.without)


def is_doubted(served: Served) -> bool:
    """Whether meaning may speak against what was found: not where it is asked for in so many words."""
    return served.way is Way.KIND and served.sure < _CERTAIN and not served.is_said


class Guesses:
    """The guesses about one set of landmarks."""

    def __init__(self, index: LandmarkIndex, bearing: Callable[[str], Collection[int]], knowledge: Knowledge) -> None:
        self._index, self._bearing, self._knowledge = index, bearing, knowledge

    @cached_property
    def support(self) -> Support:
        """What speaks for the landmarks, made when it is first asked for."""
        return Support(self._index, self._bearing, self._knowledge)

    @cached_property
    def guessing(self) -> Guessing:
        """What they mean, made when it is first asked for."""
        return Guessing(self._index, self.support)

    def heard(self, served: Served, language: str) -> Heard:
        """What a stop says of every landmark."""
        return self.guessing.heard(served.stop.what, language, served.read)

    def judged(
        self,
        served: Served,
        meaning: Meaning,
        language: str,
        trusted: Callable[[Mapping[int, float]], dict[int, float]],
    ) -> Served:
        """Return what is likelier: what the tables found, or a guess; what is neither is not sure."""
        is_sure = bool(served.scores) and served.sure >= LEAST_SURE
        if is_sure and not is_doubted(served):
            return served
        if not self.support.group_of:
            return served
        heard = self.heard(served, language)
        if is_sure:
            stands = self.guessing.stands(heard, best_of(served.scores), served.sure)
            if stands >= _STANDS:
                return served
            served = replace(served, sure=min(served.sure, stands))
        guess = self.guess(heard, served, meaning)
        scores = trusted(guess.scores) if guess is not None else {}
        least = max(_LEAST_OFFERED, served.sure * bool(served.scores))
        if guess is None or guess.best not in scores or guess.sure <= least:
            return served
        return self._guessed(served, guess, scores)

    def agreed(self, served: Served, meaning: Meaning, language: str) -> Served:
        """Return what tables left of a refusal, surer where a guess is the same: a guess hears no refusal itself."""
        if not served.scores or served.sure >= LEAST_SURE or not self.support.group_of:
            return served
        guess = self.guess(self.heard(served, language), served, meaning)
        group_of = self.support.group_of
        if guess is None or guess.sure < _LEAST_GUESSED or group_of[guess.best] != group_of.get(best_of(served.scores)):
            return served
        return replace(served, sure=guess.sure, confidence=guess.sure)

    def guess(self, heard: Heard, served: Served, meaning: Meaning) -> Guess | None:
        """The likeliest landmark beside what the tables found."""
        is_read = any(weight >= _READ for _, weight in meaning.wanted)
        found = {best_of(served.scores): served.sure} if served.scores else {}
        return self.guessing.best(heard, found, is_read)

    def _guessed(self, served: Served, guess: Guess, scores: Mapping[int, float]) -> Served:
        found = replace(served, scores=scores, way=Way.GUESS, exact=frozenset(), strength=0.0, why=None)
        if guess.sure < _LEAST_GUESSED:
            # What tables have to say of it goes before what is likeliest: “Starbucks is not on this map”.
            doubt = served.doubt if served.scores else served.evidence
            return replace(found, sure=min(guess.sure, LEAST_SURE - 0.01), doubt=doubt)
        phrases = phrases_in(answer_language(served.stop.what, served.stop.language))

        def why(id_: int) -> str:
            return phrases.say("words_speak", words=served.stop.what, name=clean_text(self._index.name_of[id_]))

        return replace(found, evidence=why(guess.best), confidence=guess.sure, sure=guess.sure, why=why)
