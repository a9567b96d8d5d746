"""Guesses beside what the tables found: they answer where tables find nothing sure, and may doubt what those found."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property

from lpslam.language.choosing.evidence import CLUES, Support
from lpslam.language.choosing.guessing import LEAST_SURE, Found, Guess, Guessing, Heard
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.serving import FITS, best_of, likeness, match
from lpslam.language.questions.phrasing import answer_language, phrases_in
from lpslam.language.questions.question import read_part
from lpslam.language.questions.wanted import Wish as Meaning
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.states import together_in
from lpslam.language.tables.words import is_mark, longest_phrases
from lpslam.language.wishes.board_words import AskedWords
from lpslam.language.wishes.form import Stop, Which
from lpslam.language.wishes.names import Names
from lpslam.language.wishes.served import AS_WELL, Served, Way

_RIVALS = 0.97  # of the best score: what serves as well
_MOST_UNITS = 20  # units of a question that count as many
_LEAST_OFFERED = 0.25  # probability of a guess from which it fills a gap in a plan
LEAST_IN_SPITE = 0.75  # probability from which what hears no negation, or no name, answers in spite of one
IN_SPITE = LEAST_IN_SPITE / LEAST_SURE  # strictness of what answers in spite of what was read
KIND_SURE = 0.6 / LEAST_SURE  # strictness of a kind: of those below, fewer than two of three were right
_READ = 0.5  # a wanted concept of this weight is more than “food” or “a shop”
Trusted = Callable[[Mapping[int, float]], dict[int, float]]
"""Leaves of landmarks with scores those that are believed."""
Clues = Mapping[str, float]
"""What tells how sure what the tables found is (`clues_of`)."""


def clues_of(served: Served, index: LandmarkIndex, asked: AskedWords, knowledge: Knowledge) -> dict[str, float]:
    """Return what tells how sure it is that the best of what serves is what was meant, each about 0 to 1."""
    text = served.stop.what
    wish = read_part(text, served.stop.language, knowledge)
    best = best_of(served.scores)
    top = served.scores[best]
    kinds = index.signs[best].kinds
    stop = served.stop
    # What a place, an order or an exclusion tells apart are no rivals.
    is_told = stop.relation is not None or stop.which is not Which.ANY or bool(stop.without)
    rivals = {} if is_told else served.scores
    group_of = index.group_of
    group = group_of[best]
    others = [score for id_, score in rivals.items() if group_of[id_] != group]
    ties = {group, *(group_of[id_] for id_, score in rivals.items() if score >= _RIVALS * top)}
    meant = {concept: weight for concept, weight in wish.wanted if match(concept, kinds, knowledge) >= FITS}
    language = wish.language or next(iter(asked.likely(text)), "en")
    units = knowledge.folder.units(text)
    common = knowledge.common.get(language, frozenset())
    own = [at for at, unit in enumerate(units) if not is_mark(unit) and unit not in common]
    known: set[int] = set()
    telling: set[int] = set()
    longest, several = 0, False
    for span in longest_phrases(units, knowledge.tables_of(language)):
        known.update(range(span.start, span.end))
        if any(concept in meant for concept, _ in span.value.concepts):
            telling.update(range(span.start, span.end))
            longest = max(longest, min(len(span.key), 20))
            several = several or span.end - span.start > 1
    for together in together_in(units, knowledge.states(language)):
        known.update(together.units)
        if together.concept in meant:
            telling.update(together.units)
            several = True
    words = max(len(own), 1)
    weight = dict(wish.wanted)
    direct = max((weight[each] * likeness(each, kinds, knowledge) for each in meant), default=0.0)
    offered = max((weight[each] * match(each, kinds, knowledge) for each in meant), default=0.0)
    is_kind = served.way is Way.KIND
    clues = {
        "is one": direct if is_kind else 0.0,
        "offers it": offered if is_kind and not direct else 0.0,
        "longest phrase": longest / 10.0 if is_kind else 0.0,
        "phrase of several words": float(is_kind and several),
        "unread signs": index.unread,
        "strength": served.strength if is_kind else 0.0,
        "strength of words": served.strength if served.way in (Way.WORDS, Way.NAME) else 0.0,
        "lead by tables": (top - max(others, default=0.0)) / top,
        "rivals": math.log(len(ties)),
        "says so": sum(at in telling for at in own) / words if is_kind else 0.0,
        "not known": sum(at not in known for at in own) / words,
        "length": math.log1p(min(len(own), _MOST_UNITS)),
        "wants much": math.log1p(len(wish.wanted)),
        "only general": float(bool(meant) and all(each in knowledge.general for each in meant)),
        "sign of many kinds": math.log1p(len(kinds)),
        "brand": float(bool(index.signs[best].identity)),
        "language not told": float(wish.language is None),
    }
    clues |= {name: served.heard.get(name, 0.0) for name in CLUES}
    return clues | {"name": float(served.way is Way.NAME), "guess": float(served.way is Way.GUESS)}


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
