"""What must hold between the parts of a map file, and of the documents of its camera and its run."""

from collections.abc import Iterable
from typing import Annotated, Any

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import NDArray
from pydantic import FiniteFloat, Strict, TypeAdapter
from typing_extensions import TypedDict

from lpslam.text.schema import Number, Seconds, Text, Whole, refuse_unlike
from lpslam.text.text_map import TextMap

_MOST_PIXELS = 1 << 15
"""Of a picture's side: more than any camera has."""
_Side = Annotated[int, Strict(), Ge(1), Le(_MOST_PIXELS)]
_Pixels = Annotated[FiniteFloat, Strict(), Ge(-1e6), Le(1e6)]
_FOREIGN = "{} names keyframe {}, which the map does not have"


class _Camera(TypedDict):
    width: _Side
    height: _Side
    fx: Annotated[_Pixels, Ge(1e-3)]
    fy: Annotated[_Pixels, Ge(1e-3)]
    cx: _Pixels
    cy: _Pixels
    distortion: tuple[Number, Number, Number, Number, Number]
    depth_scale: Number
    fps: Number


class _Event(TypedDict):
    kind: Text
    frame: Whole
    timestamp: Seconds
    reason: Text


class _Run(TypedDict):
    source: Text
    statistics: dict[Text, dict[Text, Number | Text]]
    events: list[_Event]


_CAMERA, _RUN = TypeAdapter(_Camera), TypeAdapter(_Run)
_WORDS = frozenset({"first_reader_error"})
"""The only things that are told of a run in words; all else is counted."""


def refuse_other_camera_or_run(camera: Any, run: Any) -> None:
    """Refuse documents that say something else than a camera and how a run went.

    Raises:
        ValueError: one line; where the first fault is, and what.
    """
    refuse_unlike(_CAMERA, camera)
    refuse_unlike(_RUN, run)
    for part in run["statistics"].values():
        for name, value in part.items():
            if isinstance(value, str) != (name in _WORDS):
                raise ValueError(f"statistics: {name[:40]} is {'a text' if isinstance(value, str) else 'a number'}")


def refuse_strangers(text: TextMap, keyframes: int, others: dict[str, NDArray[Any]]) -> None:
    """Refuse words, and what else hangs on keyframes, that hang on keyframes which a map does not have.

    Args:
        text: with its crops, pictures and patterns.
        keyframes: how many there are, removed ones included.
        others: columns of keyframes' ids, by name; -1 is none.

    Raises:
        ValueError: says which.
    """
    seen = (each.keyframe for one in text.memory.classes for each in one.observations)
    crops = (each.keyframe for own in text.crops.by_class.values() for each in own)
    pictures = (each.keyframe for own in text.sightings.by_class.values() for each in own)
    patterns = (each.keyframe for each in text.patterns.seen)
    named: dict[str, Iterable[int]] = {
        "a sighting": seen,
        "a crop": crops,
        "a picture": pictures,
        "a pattern": patterns,
    }
    for name, column in others.items():
        named[name] = np.unique(column).tolist()
    for what, ids in named.items():
        lowest = -1 if what in others else 0
        for keyframe in ids:
            if not lowest <= keyframe < keyframes:
                raise ValueError(_FOREIGN.format(what, keyframe))
