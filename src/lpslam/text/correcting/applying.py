"""Landmarks as a person has corrected them: the one place where corrections meet what was read."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lpslam.language.model import Judgement
from lpslam.text.correcting.corrections import Anchor, Correction, Corrections, Kind
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.places import PLACES_OF_A_CLASS
from lpslam.text.types import Landmark

BY_HAND = "a person"
"""The model of a judgement that a person gave."""

_SAME_PLACE = 1.0
"""Metres within which a landmark is the one that was corrected: what was read of it says so too. A landmark counts as
found within as much of its sign."""


def corrected(
    marks: Sequence[Landmark], corrections: Corrections, world_from_keyframe: KeyframePoses
) -> list[Landmark]:
    """The landmarks with what was said of them; hidden and merged ones are left out.

    Args:
        marks: as they were read.
        corrections: what was said. One whose landmark is not in the map now waits until it is.
        world_from_keyframe: takes a keyframe's id to its 4×4 pose in the map frame.
    """
    if not corrections.entries:
        return list(marks)
    by_id = {mark.id: mark for mark in marks}
    said: dict[int, list[Correction]] = {}
    goes_to: dict[int, int] = {}
    for entry in corrections.entries:
        found = find(entry.landmark, marks, world_from_keyframe)
        if found is None:
            continue
        if entry.into is not None:
            other = find(entry.into, marks, world_from_keyframe)
            # What was merged in a ring would be nowhere.
            if other is None or _end(other.id, goes_to) == _end(found.id, goes_to):
                continue
            goes_to[_end(found.id, goes_to)] = _end(other.id, goes_to)
        said.setdefault(found.id, []).append(entry)
    kept: dict[int, list[int]] = {}
    for id_ in by_id:
        kept.setdefault(_end(id_, goes_to), []).append(id_)
    shown = [_one(by_id, end, members, said) for end, members in sorted(kept.items())]
    return [mark for mark in shown if not any(each.kind is Kind.HIDE for each in mark.corrections)]


def judged_by_hand(mark: Landmark) -> dict[str, Judgement]:
    """What was said of a landmark, by question."""
    return {
        each.question: Judgement(each.question, each.answer, 1.0, "said by a person", BY_HAND)
        for each in mark.corrections
        if each.kind is Kind.JUDGE
    }


def find(anchor: Anchor, marks: Sequence[Landmark], world_from_keyframe: KeyframePoses) -> Landmark | None:
    """The landmark that is meant: the nearest of the same class or reading; without a place, that of the same id."""
    pose = world_from_keyframe(anchor.keyframe) if anchor.keyframe >= 0 else None
    if pose is None:
        return next((mark for mark in marks if mark.id == anchor.id), None)
    place = pose[:3, :3] @ np.array(anchor.position) + pose[:3, 3]
    near = [(_distance(mark, place), mark.id != anchor.id, mark.id, mark) for mark in marks if _alike(mark, anchor)]
    best = min(near, default=None)
    return best[3] if best is not None and best[0] < _SAME_PLACE else None


def _distance(mark: Landmark, place: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(mark.position - place))


def _alike(mark: Landmark, anchor: Anchor) -> bool:
    return (
        mark.id // PLACES_OF_A_CLASS == anchor.id // PLACES_OF_A_CLASS
        or anchor.name == mark.name
        or anchor.name in mark.variants
    )


def _end(id_: int, goes_to: dict[int, int]) -> int:
    """Where a chain of merged landmarks ends."""
    while id_ in goes_to:
        id_ = goes_to[id_]
    return id_


def _one(by_id: dict[int, Landmark], end: int, members: list[int], said: dict[int, list[Correction]]) -> Landmark:
    """A landmark with those that are merged into it, and all that was said of it."""
    mark = by_id[end]
    others = [by_id[each] for each in members if each != end]
    own = said.get(end, [])
    # Of what was merged, only that: its own name and judgement are no longer anybody's.
    merged = [each for other in others for each in said.get(other.id, []) if each.kind is Kind.MERGE]
    if others:
        told = {line.text for line in mark.lines}
        more = [line for other in others for line in other.lines if line.text not in told]
        variants = dict(mark.variants)
        for other in others:
            for text, count in other.variants.items():
                variants[text] = variants.get(text, 0) + count
        seen = mark.observations + sum(other.observations for other in others)
        mark = replace(mark, lines=(*mark.lines, *more), variants=variants, observations=seen)
    for each in own:
        if each.kind is Kind.RENAME:
            mark = _renamed(mark, each.name)
    everything = tuple(sorted((*own, *merged), key=lambda each: each.number))
    return replace(mark, corrections=everything) if everything else mark


def _renamed(mark: Landmark, name: str) -> Landmark:
    """A landmark of another name; how it was read is no name of it any more."""
    lines = tuple(replace(line, text=name, confidence=1.0) if line.text == mark.name else line for line in mark.lines)
    told = {line.text for line in lines}
    variants = {name: mark.observations} | {text: count for text, count in mark.variants.items() if text in told}
    return replace(mark, name=name, lines=lines, variants=variants, confidence=1.0)
