"""The three uses of a language model (paper, III-E, III-G, III-I) behind one protocol.

The language layer sees ids and strings, never images or coordinates: it chooses, it never invents.
Text read from the world is untrusted data wherever it appears here.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

Slot = tuple[tuple[str, float], ...]
"""What may stand at one place of a line: (letter, probability), the letter taken first; "" is no letter."""

Slots = tuple[Slot, ...]
"""A line as a recogniser saw it, place by place in the order of reading."""


LINES_APART = " | "
"""Between the lines of one board, where they are told as one string."""


@dataclass(frozen=True, slots=True)
class Reading:
    """One spelling of a class of homologous texts with how often and how surely it was read.

    Attributes:
        text: as read.
        count: how often.
        confidence: mean probability of its letters, 0 to 1.
        right: probability, 0 to 1, that such a reading is exactly what is painted, from how it was seen; None where
            that is not known.
        looks: views that are worth one of their own in which it was read; None is not known either.
        slots: the letters' runners-up in the best of these readings.
        whole: probabilities, 0 to 1, that nothing more is painted before it, and behind it, by the view that shows
            most: what the view cut says little against a longer text.
    """

    text: str
    count: int
    confidence: float
    right: float | None = None
    looks: float | None = None
    slots: Slots = ()
    whole: tuple[float, float] = (1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Naming:
    """The name chosen for a class of misread strings (text clustering, III-E)."""

    name: str
    confidence: float
    evidence: str
    model: str


@dataclass(frozen=True, slots=True)
class Judgement:
    """Whether a name is what the question asks for (landmark judgement, III-G)."""

    question: str
    answer: bool
    confidence: float
    evidence: str
    model: str


@dataclass(frozen=True, slots=True)
class Candidate:
    """A landmark as the language layer sees it: an id, its name, other readings of it, and what else its board says."""

    id: int
    name: str
    aliases: tuple[str, ...] = ()
    lines: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Choice:
    """The landmark that answers a question (navigation, III-I); None when nothing here does.

    `alternatives` are further ids, next best first.
    """

    landmark: int | None
    confidence: float
    evidence: str
    model: str
    alternatives: tuple[int, ...] = ()


class Chooser(Protocol):
    """Whatever chooses among landmarks."""

    def choose(self, question: str, landmarks: Sequence[Candidate]) -> Choice:
        """Choose the landmark that serves what the question wants, or none."""
        ...


class LanguageModel(Chooser, Protocol):
    """Any model, hosted, local or embedded, that can do the three uses."""

    @property
    def model(self) -> str:
        """Which model answers, as it is reported ("offline", "openai:gpt-4.1-mini")."""
        ...

    def name(self, readings: Sequence[Reading]) -> Naming:
        """Choose the most representative name for one class of homologous texts."""
        ...

    def judge(self, names: Sequence[str], question: str) -> list[Judgement]:
        """Answer the question for each name apart, in the order of the names; `LINES_APART` parts a board's lines."""
        ...


@runtime_checkable
class NamesTogether(Protocol):
    """A model that names many classes in few requests."""

    def name_all(self, groups: Sequence[Sequence[Reading]]) -> list[Naming]:
        """Choose a name for each class, as `LanguageModel.name` does for one."""
        ...


@runtime_checkable
class Converses(Protocol):
    """A model that takes what was asked and answered before, and so needs no question written anew."""

    def choose_after(self, history: Sequence[tuple[str, str]], question: str, landmarks: Sequence[Candidate]) -> Choice:
        """Choose as `LanguageModel.choose`; `history` holds (question, answer), the oldest first."""
        ...
