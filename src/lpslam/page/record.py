"""A map as the page has it: numbers and strings, whatever signs say cleaned."""

import base64
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.language.sanitise import clean_text
from lpslam.mapfile.export import corrections_record
from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.pictures import picture_of
from lpslam.text.correcting.corrections import Corrections
from lpslam.text.remembering.histories import score_histories
from lpslam.text.remembering.memory import LongShortTermMemory
from lpslam.text.types import Landmark

Array = NDArray[np.float64]

_MOST_POSES, _MOST_VARIANTS = 2000, 8
_MOST_CLASSES, _MOST_SAMPLES = 150, 120  # histories of classes, and samples of each


def map_record(world: LanguageMap) -> dict[str, Any]:
    """What is shown of a map."""
    drawn = picture_of(*world.room_from_above(), world.grid())
    return {
        "title": clean_text(world.source) or "lpslam",
        "picture": "" if drawn is None else "data:image/png;base64," + base64.b64encode(drawn.png).decode("ascii"),
        "picture_extent": None if drawn is None else [round(each, 3) for each in drawn.extent],
        "trajectory": way_record(world.frame_poses().positions),
        "memory": memory_record(world.text.memory),
        **said_record(world),
    }


def memory_record(memory: LongShortTermMemory) -> dict[str, Any]:
    """How the scores of classes rose and faded: those that were strongest, thinned."""
    known = [each for each in score_histories(memory) if each.samples]
    known.sort(key=lambda each: (not each.is_long_term, -max(score for _, score in each.samples)))
    histories = [
        {
            "id": each.id,
            "name": clean_text(each.name),
            "kept": each.is_long_term,
            "samples": [_rounded(np.array(at)) for at in _thinned(each.samples)],
        }
        for each in known[:_MOST_CLASSES]
    ]
    return {"promotion": memory.config.promotion, "histories": histories}


def _thinned(samples: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """A few samples of a history: its ends, and of each stretch between them the highest and the lowest."""
    if len(samples) <= _MOST_SAMPLES:
        return list(samples)
    kept = {0, len(samples) - 1}
    for rows in np.array_split(np.arange(len(samples)), _MOST_SAMPLES // 2):
        scores = [samples[row][1] for row in rows]
        kept |= {int(rows[int(np.argmax(scores))]), int(rows[int(np.argmin(scores))])}
    return [samples[row] for row in sorted(kept)]


def said_record(world: LanguageMap) -> dict[str, Any]:
    """The signs of a map, by which question they are judged, and what a person has said of them."""
    return {
        "signs": sign_records(world.landmarks()),
        "question": world.text.question,
        "edits": corrections_record(world.text.corrections),
    }


def empty_record(title: str) -> dict[str, Any]:
    """The same of a map of which nothing is known yet."""
    return {
        "title": clean_text(title) or "lpslam",
        "picture": "",
        "picture_extent": None,
        "trajectory": [],
        "memory": None,
        "signs": [],
        "question": None,
        "edits": corrections_record(Corrections()),
    }


def way_record(positions: Array) -> list[list[float]]:
    """The camera's way as (x, y) in metres, thinned."""
    known = positions[np.isfinite(positions).all(axis=1)]
    return [_rounded(at[:2]) for at in known[:: max(1, -(-len(known) // _MOST_POSES))]]


def sign_records(marks: Iterable[Landmark]) -> list[dict[str, Any]]:
    """The landmarks that have a place."""
    return [_sign(mark) for mark in marks if np.isfinite(mark.position).all()]


def _sign(mark: Landmark) -> dict[str, Any]:
    counted = sorted(mark.variants.items(), key=lambda each: (-each[1], each[0]))
    return {
        "id": mark.id,
        "name": clean_text(mark.name),
        "lines": [clean_text(line.text) for line in mark.lines],
        "variants": {clean_text(text): int(count) for text, count in counted[:_MOST_VARIANTS]},
        "position": _rounded(mark.position),
        "normal": _rounded(np.nan_to_num(mark.normal)),
        "spread": round(float(np.nan_to_num(mark.spread)), 3),
        "observations": int(mark.observations),
        "confidence": round(float(np.nan_to_num(mark.confidence)), 3),
        "is_landmark": mark.is_landmark,
        "corrections": [each.number for each in mark.corrections],
    }


def _rounded(values: Array) -> list[float]:
    return [round(float(value), 3) for value in values]
