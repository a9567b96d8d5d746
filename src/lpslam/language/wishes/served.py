"""What a scorer says of a stop: which landmarks serve it, and why."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from lpslam.language.wishes.form import Stop


@dataclass(frozen=True, slots=True)
class Served:
    """The landmarks that serve a stop.

    Attributes:
        stop: with what its words mean.
        scores: by id, 0 < score <= 1.
        evidence: why, in words.
        confidence: of the best, 0 to 1.
        others: next best where none serves.
        ignored: what of the wish could not be heeded.
        exact: of those, the landmarks whose board says these very words, and no more.
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
