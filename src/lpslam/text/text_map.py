"""The map of words: classes, their observations, and the landmarks that follow from the keyframes' present poses."""

import copy
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from lpslam.config import TextConfig
from lpslam.errors import UserError
from lpslam.language.model import Judgement, Slots
from lpslam.text import documents
from lpslam.text.again.crops import CropStore
from lpslam.text.boards.boards import boards
from lpslam.text.boards.lines import lines_of
from lpslam.text.boards.overlaps import without_overlaps
from lpslam.text.boards.scripts import in_one_script, script_ahead
from lpslam.text.correcting.applying import corrected, judged_by_hand
from lpslam.text.correcting.corrections import Corrections
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.patterned import Patterns, without_patterned
from lpslam.text.placing.places import PLACES_OF_A_CLASS, Place, read_places
from lpslam.text.remembering.memory import LongShortTermMemory, TextClass
from lpslam.text.schema import refuse_other_document
from lpslam.text.sightings import SightingStore
from lpslam.text.types import Landmark


class TextMap:
    """What has been read and remembered.

    Only what was observed is stored, hung on keyframes; landmarks are derived anew whenever they are asked for.

    Attributes:
        memory: the classes of homologous texts in their two pools.
        judgements: by what a board says of itself, then by question.
        question: what `Landmark.is_landmark` answers; None before anything was judged.
        crops: cut-outs around texts whose names are unsure, until they are looked at again.
        sightings: pictures of texts as they were seen best.
        patterns: where boxes were refused as patterns.
        corrections: what a person has said of landmarks; it wins over readings.
    """

    def __init__(self, config: TextConfig) -> None:
        self.config = config
        self.memory = LongShortTermMemory(config.memory)
        self.judgements: dict[str, dict[str, Judgement]] = {}
        self.question: str | None = None
        self.crops = CropStore(config.again)
        self.sightings = SightingStore(config.sightings)
        self.patterns = Patterns()
        self.corrections = Corrections()

    def copy(self) -> "TextMap":
        """The same readings, with judgements and corrections that can be changed apart."""
        other = copy.copy(self)
        other.judgements = {name: dict(by_question) for name, by_question in self.judgements.items()}
        return other

    @property
    def long_term(self) -> list[TextClass]:
        """The classes in long-term memory, by id."""
        return [self.memory.long_term[key] for key in sorted(self.memory.long_term)]

    def is_remembered(self, text_class: int) -> bool:
        """Whether a class is in long-term memory."""
        return text_class in self.memory.long_term

    def is_unsure(self, text_class: int) -> bool:
        """Whether a class has a name that another look may mend."""
        own = self.memory.long_term.get(text_class)
        return own is not None and (own.naming is None or own.naming.confidence < self.config.again.sure)

    def landmarks(self, world_from_keyframe: KeyframePoses) -> list[Landmark]:
        """Derive the landmarks: the boards that long-term texts stand on, wherever they stand.

        Args:
            world_from_keyframe: takes a keyframe's id to its 4×4 pose in the map frame.

        Returns:
            Landmarks by id, whatever their judgement, as a person has corrected them.
        """
        marks = corrected(self.as_read(world_from_keyframe), self.corrections, world_from_keyframe)
        return [self._judged(mark) for mark in marks]

    def state(self) -> tuple[Any, ...]:
        """What landmarks follow from beside poses: as long as it equals an older one, so do they.

        What is only added to is told by how much there is of it; what is replaced, by what it is.
        """
        read = [
            (each, each.naming, each.named_at_count, each.count, len(each.looks), len(each.observations))
            for each in self.long_term
        ]
        judged = {name: dict(by_question) for name, by_question in self.judgements.items()}
        return (
            self.config,
            self.question,
            self.corrections,
            self.patterns,
            sum(each.count for each in self.patterns.seen),
            read,
            judged,
        )

    def as_read(self, world_from_keyframe: KeyframePoses) -> list[Landmark]:
        """The same as nobody has corrected or judged them."""
        instances = self.config.instances
        memory = self.config.memory
        poses = cache(world_from_keyframe)
        places = [place for each in self.long_term for place in read_places(each, poses, instances, memory)]
        places = without_patterned(places, self.patterns.standing(poses), self.config.patterns)
        groups = boards(without_overlaps(places, instances, memory), instances)
        ahead = script_ahead(groups)
        return [
            self._landmark(in_one_script(group, self._slots_of, around))
            for group, around in zip(groups, ahead, strict=True)
        ]

    def _slots_of(self, place: Place) -> Iterator[Slots]:
        return (look.slots for look in self.memory.long_term[place.id // PLACES_OF_A_CLASS].looks)

    def judge(self, judgements: Sequence[tuple[str, Judgement]], question: str) -> None:
        """Keep judgements of what boards say (`Landmark.wording`), and make the question the map's current one."""
        self.question = question
        for name, judgement in judgements:
            self.judgements.setdefault(name, {})[judgement.question] = judgement

    def _landmark(self, board: list[Place]) -> Landmark:
        named, lines = lines_of(board)
        first = max(board, key=lambda place: (place.width * place.height, -place.id))
        # The middle of what all lines cover together.
        reach = [
            [
                float((place.position - first.position) @ axis) + side * size / 2.0
                for place, size in sizes
                for side in (-1, 1)
            ]
            for axis, sizes in (
                (first.baseline, [(place, place.width) for place in board]),
                (first.down, [(place, place.height) for place in board]),
            )
        ]
        (left, right), (top, bottom) = ((min(values), max(values)) for values in reach)
        middle = first.baseline * (left + right) / 2.0 + first.down * (top + bottom) / 2.0
        return Landmark(
            id=min(place.id for place in board),
            name=named.text,
            variants={text: count for place in board for text, count in place.variants.items()},
            position=first.position + middle,
            normal=first.normal,
            spread=float(np.mean([place.spread for place in board])),
            width=right - left,
            height=bottom - top,
            observations=max(place.observations for place in board),
            confidence=named.confidence,
            lines=tuple(lines),
            role=named.role,
        )

    def _judged(self, mark: Landmark) -> Landmark:
        judgements = {**self.judgements.get(mark.wording, {}), **judged_by_hand(mark)}
        current = judgements.get(self.question) if self.question is not None else None
        return replace(mark, judgements=judgements, is_landmark=current.answer if current else None)

    def to_document(self) -> dict[str, Any]:
        """Everything remembered, as JSON can hold it."""
        return {
            "config": self.config.model_dump(mode="json"),
            "memory": documents.from_memory(self.memory),
            "judgements": documents.from_judgements(self.judgements),
            "question": self.question,
        }

    @classmethod
    def from_document(cls, document: dict[str, Any]) -> "TextMap":
        """Restore what `to_document` gave.

        Raises:
            UserError: the document is not one of `to_document`.
        """
        try:
            refuse_other_document(document)
            text_map = cls(TextConfig.model_validate(_without_superseded(document["config"])))
            documents.restore_memory(text_map.memory, document["memory"])
            text_map.judgements = documents.to_judgements(document["judgements"])
            text_map.question = document["question"]
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            reason = " ".join(str(error).split())
            raise UserError(f"the texts of this map cannot be read ({reason}); map the sequence again") from error
        return text_map


def _without_superseded(config: dict[str, Any]) -> dict[str, Any]:
    """The thresholds of a map, without those that older maps have and reading no longer knows."""
    return {
        section: {key: value for key, value in values.items() if (section, key) not in _SUPERSEDED}
        for section, values in config.items()
    }


_SUPERSEDED = frozenset(
    {
        *(("spotting", name) for name in ("border_margin", "other_size", "idle_frames")),
        *(("instances", f"line_{name}") for name in ("gap", "height_ratio", "offset", "angle", "ground_difference")),
    }
)
"""Section and name of thresholds that were given up; older maps may have them."""
