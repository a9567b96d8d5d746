"""A wish answered, stop by stop: places, why these, and what is not sure."""

from dataclasses import dataclass

from lpslam.language.wishes.form import Stop, Wish
from lpslam.navigation.places import Place


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """One stop answered.

    Attributes:
        stop: with what its words mean.
        place: None where none serves; then `notes` say what is missing.
        others: further places that serve, best first; or the next best.
        confidence: 0 to 1.
        evidence: why these places serve.
        notes: what is not sure, what is missing, what was not heeded.
        model: which model said what serves.
    """

    stop: Stop
    place: Place | None
    others: tuple[Place, ...]
    confidence: float
    evidence: str
    notes: tuple[str, ...] = ()
    model: str = "offline"


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """A wish answered, stop by stop."""

    wish: Wish
    stops: tuple[Solved, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        """All that is not sure, missing or not heeded, each once."""
        return tuple(dict.fromkeys((*self.wish.notes, *(note for stop in self.stops for note in stop.notes))))
