"""How the scores of classes rose and faded (paper, Fig. 13)."""

from collections.abc import Sequence
from dataclasses import dataclass

from lpslam.text.remembering.memory import LongShortTermMemory


@dataclass(frozen=True, slots=True)
class ScoreHistory:
    """The score of one class over time.

    Attributes:
        name: its likeliest spelling; untrusted.
        samples: (seconds, score), in order of time.
        is_long_term: whether it was promoted.
        id: of the class.
    """

    name: str
    samples: Sequence[tuple[float, float]]
    is_long_term: bool
    id: int = -1


def score_histories(memory: LongShortTermMemory) -> list[ScoreHistory]:
    """The histories of all classes; those that are remembered have faded since they were last seen, until now."""
    now = memory.clock
    remembered = [
        ScoreHistory(each.name, [*each.history, *([(now, each.score)] if now is not None else [])], kept, each.id)
        for pool, kept in ((memory.long_term, True), (memory.short_term, False))
        for each in pool.values()
    ]
    return remembered + [ScoreHistory(each.name, each.history, False, each.id) for each in memory.forgotten]
