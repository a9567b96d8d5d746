"""What a model is asked for, and how its answers are read: tasks, schemas, labels and parts.

Whatever a model makes of a schema, a value that is not of the form that was asked for is refused.
"""

import math
import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib.resources import files
from typing import Any

from lpslam.language.model import Candidate
from lpslam.language.sanitise import clean_text

NONE = "none"
"""What a model answers where no landmark serves."""
TEXT = {"type": "string"}
"""The schema of a text."""
SURE = {"confidence": {"type": "number"}, "evidence": TEXT}
"""The schema of how sure an answer is, and why."""
EVIDENCE_LENGTH = 300
"""Letters of a reason that are kept."""
_LABEL = re.compile(r"\bL\d{4}\b")


class Labels:
    """Names for landmarks that no sign can know, in the order of the map.

    The labels and the order are the same for every question about a map: a server need neither learn a new schema nor
    read the names again.
    """

    def __init__(self, shown: Sequence[Candidate]) -> None:
        self.all = [f"L{1000 + number * 7919 % 9000}" for number in range(len(shown))]
        self.shown = list(zip(self.all, shown, strict=True))
        self._by_label = dict(self.shown)

    def landmark(self, label: Any) -> int | None:
        """Take a label back to a landmark's id.

        Raises:
            ValueError: no landmark has it.
        """
        if label is None or label == NONE:
            return None
        if not isinstance(label, str) or label not in self._by_label:
            raise ValueError(f"id {clean_text(str(label), 20)} was not given")
        return self._by_label[label].id

    def told(self, evidence: str) -> str:
        """Put names for the labels that an explanation mentions."""
        return _LABEL.sub(
            lambda found: self._by_label[found[0]].name if found[0] in self._by_label else found[0], evidence
        )


@lru_cache(maxsize=8)
def task(use: str) -> str:
    """The task and its examples; the version line is for people, what counts for the cache is the wording."""
    text = (files("lpslam.language") / "prompts" / f"{use}.md").read_text(encoding="utf-8")
    return text.partition("\n\n")[2]


def object_of(properties: Mapping[str, Any]) -> dict[str, Any]:
    """A JSON schema of an object with exactly these properties."""
    return {
        "type": "object",
        "properties": dict(properties),
        "required": list(properties),
        "additionalProperties": False,
    }


def a_bool(value: Any) -> bool:
    """Take a value as true or false.

    Raises:
        ValueError: it is neither.
    """
    if not isinstance(value, bool):
        raise ValueError("an answer is neither true nor false")
    return value


def parts_of(numbers: Sequence[int], most: int) -> list[Sequence[int]]:
    """The numbers in as few parts of like size as hold at most so many."""
    count = -(-len(numbers) // most)
    return [numbers[len(numbers) * at // count : len(numbers) * (at + 1) // count] for at in range(count)]


def numbered(tree: Mapping[str, Any], part: Sequence[int]) -> int:
    """Which of the signs of a request an answer is about.

    Raises:
        ValueError: none of them.
    """
    number = tree["sign"]
    if not isinstance(number, int) or not 1 <= number <= len(part):
        raise ValueError(f"sign {clean_text(str(number), 20)} was not given")
    return part[number - 1]


def sureness(tree: Mapping[str, Any]) -> tuple[float, str]:
    """Confidence in 0..1 and evidence in one short line, whatever the model made of them."""
    confidence = float(tree.get("confidence", 0.5))
    if math.isnan(confidence):
        confidence = 0.5
    return min(max(confidence, 0.0), 1.0), clean_text(str(tree.get("evidence", "")), EVIDENCE_LENGTH)
