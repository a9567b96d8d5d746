"""The map of words as JSON-able documents and back, equal."""

from dataclasses import asdict, dataclass
from typing import Any

from lpslam.language.model import Judgement
from lpslam.text.remembering.memory import ForgottenClass, LongShortTermMemory, Pool, TextClass
from lpslam.typed import restored

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


@dataclass(frozen=True, slots=True)
class _Memory:
    """What `from_memory` gives."""

    clock: float | None
    next_id: int
    forgotten_count: int
    forgotten: list[ForgottenClass]
    classes: list[TextClass]


def restore_memory(memory: LongShortTermMemory, document: Document) -> None:
    """Fill an empty memory with what `from_memory` gave.

    Raises:
        ValueError: it is something else.
    """
    kept: _Memory = restored(_Memory, document)
    memory.clock, memory.next_id, memory.forgotten_count = kept.clock, kept.next_id, kept.forgotten_count
    memory.forgotten.extend(kept.forgotten)
    for each in kept.classes:
        pool = memory.long_term if each.pool is Pool.LONG_TERM else memory.short_term
        pool[each.id] = each


def from_judgements(judgements: dict[str, dict[str, Judgement]]) -> Document:
    """Judgements by name, then by question."""
    return {name: {key: asdict(each) for key, each in by_question.items()} for name, by_question in judgements.items()}


def to_judgements(document: Document) -> dict[str, dict[str, Judgement]]:
    """Restore what `from_judgements` gave.

    Raises:
        ValueError: it is something else.
    """
    kept: dict[str, dict[str, Judgement]] = restored(dict[str, dict[str, Judgement]], document)
    return kept
