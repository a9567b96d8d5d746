"""Corrections made and taken back, by whoever has seen what there is now."""

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np

from lpslam.errors import UserError
from lpslam.language.model import LanguageModel
from lpslam.language.sanitise import clean_text
from lpslam.text.correcting.corrections import LONGEST_NAME, Anchor, Correction, Corrections, Kind
from lpslam.text.distilling import DEFAULT_QUESTION
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.places import PLACES_OF_A_CLASS
from lpslam.text.text_map import TextMap
from lpslam.text.types import Landmark


class ConflictError(UserError):
    """Somebody else has changed the corrections meanwhile.

    Attributes:
        corrections: as they are now.
    """

    def __init__(self, corrections: Corrections) -> None:
        super().__init__(
            f"somebody else has corrected this map meanwhile (revision {corrections.revision}); look at it again"
        )
        self.corrections = corrections


class NoSuchCorrectionError(UserError):
    """What is to be corrected, or taken back, is not there."""


@dataclass(frozen=True, slots=True)
class Change:
    """What somebody wants to say of a landmark.

    Attributes:
        kind: what is corrected.
        landmark: its id.
        name: for a name.
        into: for a merge, the id of the landmark that it is the same as.
        answer: for a judgement, by the map's current question.
    """

    kind: Kind
    landmark: int
    name: str = ""
    into: int | None = None
    answer: bool | None = None


def correct(
    text_map: TextMap,
    world_from_keyframe: KeyframePoses,
    change: Change,
    language: LanguageModel,
    revision: int | None = None,
) -> None:
    """Say something of a landmark; the text map's corrections are replaced, its readings stay.

    Args:
        text_map: is changed.
        world_from_keyframe: takes a keyframe's id to its 4×4 pose in the map frame.
        change: what is said.
        language: judges a new name by the map's current question.
        revision: of the corrections that whoever says it has seen; any without.

    Raises:
        ConflictError: the corrections are of another revision.
        NoSuchCorrectionError: there is no such landmark.
        UserError: the change says nothing.
    """
    old = text_map.corrections
    if revision is not None and revision != old.revision:
        raise ConflictError(old)
    marks = {mark.id: mark for mark in text_map.landmarks(world_from_keyframe)}
    mark = _of(marks, change.landmark)
    entry = Correction(
        number=old.next_number,
        kind=change.kind,
        landmark=_anchor(text_map, mark, world_from_keyframe),
        made=datetime.now(UTC).isoformat(timespec="seconds"),
        **_said(text_map, change, marks, world_from_keyframe),
    )
    text_map.corrections = old.with_one(entry)
    if change.kind is Kind.JUDGE:
        text_map.question = entry.question
    elif change.kind is Kind.RENAME and text_map.question is not None:
        _judge(text_map, world_from_keyframe, change.landmark, language)


def take_back(text_map: TextMap, number: int, revision: int | None = None) -> None:
    """Take a correction back, by its number.

    Raises:
        ConflictError: the corrections are of another revision.
        NoSuchCorrectionError: there is none of this number.
    """
    old = text_map.corrections
    if revision is not None and revision != old.revision:
        raise ConflictError(old)
    try:
        text_map.corrections = old.without(number)
    except UserError as error:
        raise NoSuchCorrectionError(str(error)) from None


def _said(
    text_map: TextMap, change: Change, marks: dict[int, Landmark], world_from_keyframe: KeyframePoses
) -> dict[str, Any]:
    if change.kind is Kind.RENAME:
        name = clean_text(change.name, LONGEST_NAME)
        if not name:
            raise UserError("the name is empty; give what the sign says")
        return {"name": name}
    if change.kind is Kind.MERGE:
        if change.into is None or change.into == change.landmark:
            raise UserError("with which other landmark is it the same? give that one's id")
        return {"into": _anchor(text_map, _of(marks, change.into), world_from_keyframe)}
    if change.kind is Kind.JUDGE:
        if change.answer is None:
            raise UserError("is it, or is it not? give yes or no")
        return {"answer": change.answer, "question": text_map.question or DEFAULT_QUESTION}
    return {}


def _of(marks: dict[int, Landmark], id_: int) -> Landmark:
    if id_ not in marks:
        raise NoSuchCorrectionError(f"the map has no landmark {id_}; it may be hidden or merged")
    return marks[id_]


def _anchor(text_map: TextMap, mark: Landmark, world_from_keyframe: KeyframePoses) -> Anchor:
    """What keeps to a landmark: what was read of it, and its place on the keyframe that saw it last."""
    read = next(each for each in text_map.as_read(world_from_keyframe) if each.id == mark.id)
    text_class = text_map.memory.long_term.get(mark.id // PLACES_OF_A_CLASS)
    for seen in reversed(text_class.observations if text_class is not None else []):
        pose = world_from_keyframe(seen.keyframe)
        if pose is not None:
            x, y, z = (float(each) for each in np.linalg.inv(pose)[:3] @ [*read.position, 1.0])
            return Anchor(mark.id, clean_text(read.name, LONGEST_NAME), seen.keyframe, (x, y, z))
    return Anchor(mark.id, clean_text(read.name, LONGEST_NAME))


def _judge(text_map: TextMap, world_from_keyframe: KeyframePoses, id_: int, language: LanguageModel) -> None:
    """Judge a landmark of a new name, unless that name is judged already."""
    question = text_map.question
    mark = next((each for each in text_map.landmarks(world_from_keyframe) if each.id == id_), None)
    if question is None or mark is None or question in mark.judgements:
        return
    (judgement,) = language.judge([mark.wording_by_line], question)
    text_map.judge([(mark.wording, judgement)], question)
