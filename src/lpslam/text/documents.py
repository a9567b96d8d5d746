"""The map of words as JSON-able documents and back, equal."""

from dataclasses import asdict
from typing import Any

from lpslam.language.model import Judgement, Naming
from lpslam.text.remembering.evidence import Look
from lpslam.text.remembering.memory import ForgottenClass, LongShortTermMemory, Pool, TextClass, Variant
from lpslam.text.types import Bearing, Placement, TextObservation

Document = dict[str, Any]


def from_memory(memory: LongShortTermMemory) -> Document:
    """Both pools, the clock and what is kept of forgotten classes."""
    return {
        "clock": memory.clock,
        "next_id": memory.next_id,
        "forgotten_count": memory.forgotten_count,
        "forgotten": [asdict(each) for each in memory.forgotten],
        "classes": [asdict(each) for each in memory.classes],
    }


def restore_memory(memory: LongShortTermMemory, document: Document) -> None:
    """Fill an empty memory with what `from_memory` gave."""
    memory.clock = document["clock"]
    memory.next_id = document["next_id"]
    memory.forgotten_count = document["forgotten_count"]
    memory.forgotten.extend(
        ForgottenClass(each["id"], each["name"], tuple(_samples(each["history"]))) for each in document["forgotten"]
    )
    for each in document["classes"]:
        text_class = _text_class(each)
        pool = memory.long_term if text_class.pool is Pool.LONG_TERM else memory.short_term
        pool[text_class.id] = text_class


def from_judgements(judgements: dict[str, dict[str, Judgement]]) -> Document:
    """Judgements by name, then by question."""
    return {name: {key: asdict(each) for key, each in by_question.items()} for name, by_question in judgements.items()}


def to_judgements(document: Document) -> dict[str, dict[str, Judgement]]:
    """Restore what `from_judgements` gave."""
    return {name: {key: Judgement(**each) for key, each in entry.items()} for name, entry in document.items()}


def _text_class(document: Document) -> TextClass:
    fields = dict(document)
    naming = fields.pop("naming")
    return TextClass(
        variants={text: Variant(**variant) for text, variant in fields.pop("variants").items()},
        pool=Pool(fields.pop("pool")),
        history=_samples(fields.pop("history")),
        observations=[_observation(each) for each in fields.pop("observations")],
        looks=[_look(each) for each in fields.pop("looks", ())],
        naming=Naming(**naming) if naming else None,
        **fields,
    )


def _look(document: Document) -> Look:
    slots = tuple(tuple((letter, sure) for letter, sure in slot) for slot in document["slots"])
    visit, size, angle = document["view"]
    return Look(**{**document, "slots": slots, "view": (visit, size, angle)})


def _observation(document: Document) -> TextObservation:
    fields = dict(document)
    placement = fields.pop("placement")
    # Older maps have no bearings.
    bearing = fields.pop("bearing", None)
    fields |= {key: tuple(fields[key]) for key in ("ground", "ink", "bare", "clear", "whole") if fields.get(key)}
    return TextObservation(
        placement=Placement(**{key: _frozen(value) for key, value in placement.items()}) if placement else None,
        bearing=Bearing(**{key: _frozen(value) for key, value in bearing.items()}) if bearing else None,
        **fields,
    )


def _frozen(value: Any) -> Any:
    """Lists as the tuples that they were."""
    return tuple(_frozen(each) for each in value) if isinstance(value, list | tuple) else value


def _samples(history: list[list[float]]) -> list[tuple[float, float]]:
    return [(timestamp, score) for timestamp, score in history]
