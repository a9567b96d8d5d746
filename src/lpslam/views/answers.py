"""Answers to questions, as text and as JSON."""

from dataclasses import asdict
from typing import Any

from lpslam.mapfile.export import landmark_record
from lpslam.pipeline import Answer
from lpslam.views.drawable import printable


def answer_text(answer: Answer) -> str:
    """A few lines: where to go, how far it is, why, and what else there is."""
    others = ", ".join(printable(mark.name) for mark in answer.alternatives)
    if answer.landmark is None:
        lines = [f"Nothing in this map serves that: {printable(answer.choice.evidence, longest=300)}"]
    else:
        x, y, z = answer.landmark.position
        lines = [
            f"{printable(answer.landmark.name)} at ({x:.2f}, {y:.2f}, {z:.2f}), {answer.distance:.1f} m away",
            f"  because: {printable(answer.choice.evidence, longest=300)} "
            f"(confidence {answer.choice.confidence:.2f}, {printable(answer.choice.model, longest=100)})",
        ]
    return "\n".join([*lines, f"  or: {others}"] if others else lines)


def answer_record(answer: Answer) -> dict[str, Any]:
    """The answer as JSON can hold it."""
    return {
        "question": answer.question,
        "landmark": landmark_record(answer.landmark) if answer.landmark is not None else None,
        "distance": answer.distance,
        "choice": asdict(answer.choice),
        "alternatives": [mark.name for mark in answer.alternatives],
    }
