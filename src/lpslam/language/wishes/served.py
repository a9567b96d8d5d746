"""What a scorer says of a stop: which landmarks serve it, and why."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Protocol

from lpslam.language.wishes.form import Stop

_LEAST_ANCHOR = 0.55  # probability of a guess from which it is an anchor, as it is a stop of a plan
NOT_SURE = "it is not sure what is meant"
AS_WELL = 0.97
"""Of the best score: what serves as well."""


class Way(StrEnum):
    """How what serves was found."""

    PLACE = "any place"
    IDENTITY = "identity"
    NAME = "name"
    SORT = "any of a sort"
    KIND = "kind"
    WORDS = "words of the board"
    HEARD = "name as heard"
    GUESS = "guess"


UNQUESTIONED = (Way.PLACE, Way.IDENTITY, Way.SORT, Way.HEARD)
"""What is told by the map, must stand on the board, or sounds like one name alone: no words to be mistaken."""


@dataclass(frozen=True, slots=True)
class Served:
    """The landmarks that serve a stop.

    Attributes:
        stop: with what its words mean.
        scores: by id, 0 < score <= 1.
        evidence: why, in words; where it names a landmark, the best one.
        why: the same of any that serves, by id, where `evidence` names one.
        confidence: of the best, 0 to 1.
        others: next best where none serves.
        ignored: what of the wish could not be heeded.
        way: how they were found.
        sure: probability, 0 to 1, that the best is what was meant.
        strength: of the best, before scores were divided by it.
        heard: what tells how sure the words of a question make us, by name.
        exact: of those, the landmarks whose board says these very words, and no more.
        read: how well landmarks serve what the tables read, by id, before anything else speaks.
        doubt: why none is the answer where that is not sure.
        is_said: whether all that is asked, in a word or two, asks for what was found.
        settled: whether it is known that what is asked for is not here.
        on_any_floor: of those, the landmarks that join floors, where a floor is named.
        strictness: times the probability that else is enough, which the best must have to be the answer.
        sees_all: whether every landmark that serves has its score; a model names a few only.
    """

    stop: Stop
    scores: Mapping[int, float]
    evidence: str
    confidence: float = 0.0
    others: tuple[int, ...] = ()
    ignored: tuple[str, ...] = ()
    sees_all: bool = True
    model: str = "offline"
    exact: frozenset[int] = field(default=frozenset())
    way: Way = Way.PLACE
    strength: float = 1.0
    heard: Mapping[str, float] = field(default_factory=dict)
    sure: float = 1.0
    read: Mapping[int, float] = field(default_factory=dict)
    doubt: str = NOT_SURE
    is_said: bool = False
    settled: bool = False
    on_any_floor: frozenset[int] = field(default=frozenset())
    strictness: float = 1.0
    why: Callable[[int], str] | None = None

    def reason(self, id_: int) -> str:
        """Why one of those that serve does: the one that is chosen need not be the best."""
        return self.evidence if self.why is None else self.why(id_)

    @property
    def certainty(self) -> float:
        """How surely the best is what was meant, where it is told: of a guess, by what speaks for it."""
        return self.sure if self.way is Way.GUESS else self.confidence

    def confirmed(self, least: float) -> "Served":
        """Return it as at least so sure: what else is said confirms that it was understood."""
        return replace(self, sure=max(self.sure, least), confidence=max(self.confidence, least))

    def as_anchor(self) -> "Served":
        """Return what serves an anchor: it is not asked how sure that is, but of a guess."""
        is_guessed = self.way is Way.GUESS and self.sure < _LEAST_ANCHOR
        return replace(self, scores={}) if is_guessed else self


class Scorer(Protocol):
    """Whatever says which landmarks serve a stop's words."""

    @property
    def model(self) -> str:
        """Which model answers."""
        ...

    def serve(self, stop: Stop) -> Served:
        """Return the landmarks that serve."""
        ...

    def is_understood(self, stop: Stop) -> bool:
        """Whether a stop's words are words for a place at all."""
        ...
