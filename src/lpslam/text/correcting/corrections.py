"""What a person has said of a map's landmarks, kept beside what was read, and as JSON for the map file.

A correction never changes a reading. It is applied when landmarks are derived, so it holds for names and judgements
that come later too, and is gone without a trace when it is taken back.
"""

import math
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

from lpslam.errors import UserError
from lpslam.language.sanitise import clean_text

Vector3 = tuple[float, float, float]

LONGEST_NAME = 120
"""Letters of a name that a person gives: the longest shop name on record has fewer."""

_MOST = 100_000  # corrections of a map; a file with more was made to deceive
_LONGEST_QUESTION, _LONGEST_DATE = 400, 40  # letters
_FARTHEST = 1e6  # metres that mean anything
_LARGEST = 2**53 - 1  # whole numbers that every JSON reader keeps


class Kind(StrEnum):
    """What is corrected."""

    RENAME = "rename"
    MERGE = "merge"
    HIDE = "hide"
    JUDGE = "judge"


@dataclass(frozen=True, slots=True)
class Anchor:
    """Which landmark is meant, in such a way that it is found again when the map has moved or grown.

    Attributes:
        id: of the landmark when it was corrected.
        name: as it was read then.
        keyframe: on which its place hangs; -1 where none does.
        position: metres, in that keyframe's camera frame.
    """

    id: int
    name: str
    keyframe: int = -1
    position: Vector3 = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Correction:
    """One thing that a person has said of a landmark.

    Attributes:
        number: counted from 1, never used again.
        kind: what is corrected.
        landmark: of which.
        name: its name, where that is corrected.
        into: the landmark that it is the same as, where two are merged.
        answer, question: whether it is what the question asks for, where that is judged.
        made: when, ISO 8601.
    """

    number: int
    kind: Kind
    landmark: Anchor
    name: str = ""
    into: Anchor | None = None
    answer: bool = False
    question: str = ""
    made: str = ""

    def to_document(self) -> dict[str, Any]:
        """As JSON can hold it."""
        return asdict(self) | {"kind": self.kind.value}


@dataclass(frozen=True, slots=True)
class Corrections:
    """All of a map, the oldest first; a change makes others.

    Attributes:
        revision: counts changes, taking back included: who changes says which revision it saw.
        entries: what holds.
        next_number: of the correction that comes next.
    """

    revision: int = 0
    entries: tuple[Correction, ...] = field(default=())
    next_number: int = 1

    def with_one(self, correction: Correction) -> "Corrections":
        """These and one more, which takes the next number.

        Raises:
            UserError: there are as many as a map may have.
        """
        if len(self.entries) >= _MOST:
            raise UserError(f"the map has {_MOST:,} corrections; take some of them back first")
        return Corrections(self.revision + 1, (*self.entries, correction), self.next_number + 1)

    def without(self, number: int) -> "Corrections":
        """These but one.

        Raises:
            UserError: there is none of this number.
        """
        kept = tuple(each for each in self.entries if each.number != number)
        if len(kept) == len(self.entries):
            raise UserError(f"the map has no correction {number}; it may have been taken back already")
        return Corrections(self.revision + 1, kept, self.next_number)

    def to_document(self) -> dict[str, Any]:
        """As JSON can hold it."""
        entries = [each.to_document() for each in self.entries]
        return {"revision": self.revision, "next_number": self.next_number, "entries": entries}

    @classmethod
    def from_document(cls, document: Any) -> "Corrections":
        """Restore what `to_document` gave.

        Raises:
            KeyError, TypeError, ValueError: it is something else.
        """
        entries = document["entries"]
        if not isinstance(entries, list) or len(entries) > _MOST:
            raise ValueError("corrections are no list, or too many")
        read = tuple(map(_correction, entries))
        next_number = _whole(document["next_number"])
        numbers = [each.number for each in read]
        if numbers != sorted(set(numbers)) or (numbers and not 0 < numbers[0] <= numbers[-1] < next_number):
            raise ValueError("corrections are not numbered in their order")
        return cls(_whole(document["revision"]), read, next_number)


def _correction(document: dict[str, Any]) -> Correction:
    kind = Kind(document["kind"])
    into = document["into"]
    answer = document["answer"]
    if type(answer) is not bool or (into is None) == (kind is Kind.MERGE):
        raise ValueError("a correction says nothing, or of too many")
    made = Correction(
        number=_whole(document["number"]),
        kind=kind,
        landmark=_anchor(document["landmark"]),
        name=_text(document["name"], LONGEST_NAME),
        into=None if into is None else _anchor(into),
        answer=answer,
        question=_text(document["question"], _LONGEST_QUESTION),
        made=_text(document["made"], _LONGEST_DATE),
    )
    if (kind is Kind.RENAME and not made.name) or (kind is Kind.JUDGE and not made.question):
        raise ValueError("a correction without its words")
    return made


def _anchor(document: dict[str, Any]) -> Anchor:
    x, y, z = (float(each) for each in document["position"] if type(each) in (int, float) and abs(each) < _FARTHEST)
    if not all(map(math.isfinite, (x, y, z))):
        raise ValueError("a corrected landmark has no place")
    keyframe = document["keyframe"]
    if type(keyframe) is not int or not -1 <= keyframe <= _LARGEST:
        raise ValueError("a corrected landmark hangs on nothing")
    return Anchor(_whole(document["id"]), _text(document["name"], LONGEST_NAME), keyframe, (x, y, z))


def _whole(value: Any) -> int:
    if type(value) is not int or not 0 <= value <= _LARGEST:
        raise ValueError(f"{str(value)[:40]!r} is no whole number of a correction")
    return value


def _text(value: Any, longest: int) -> str:
    """A text as it was cleaned when it was given."""
    if not isinstance(value, str):
        raise TypeError("a correction's text is none")
    return clean_text(value, longest)
