"""A way in words, turn by turn, with the signs that one passes."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lpslam.language.languages import LANGUAGES
from lpslam.navigation.walking.ways import Way

Array = NDArray[np.float64]

_SLIGHT, _FULL, _SHARP, _BACK = (np.radians(each) for each in (25.0, 60.0, 120.0, 160.0))
_GAP = re.compile(r"\{(\w+)\}")
_AT = 3.0  # metres from a turn at which a sign marks it
_FAR = 3.0  # metres: nearer, one stands before the sign where the way ends; farther, it is told how far it is
_SHORT = 1.0  # metres: a shorter leg is no walk but a part of a turn


@dataclass(frozen=True, slots=True, eq=False)
class Sign:
    """What may be named on a way: a text as it is told, and its place (2 or 3,) in metres."""

    name: str
    position: Array


def told(way: Way, signs: Sequence[Sign], goal: Sign, language: str = "en", heading: float | None = None) -> list[str]:
    """The steps of a way in words.

    Args:
        way: over the ground.
        signs: that may be named at turns.
        goal: the sign to which it leads.
        language: one of `LANGUAGES`, or a tag that begins with it; English for all others.
        heading: radians counter-clockwise from the map's x axis, which way one looks at first; if known, the first
            step says how to turn.
    """
    words = _words(language)
    # Where one goes is no mark of a turn before it: one is not there yet.
    signs = [each for each in signs if each.name != goal.name or not np.array_equal(each.position, goal.position)]
    steps, faced, at = [], heading, 0
    for climb in way.climbs:
        walked, faced = _walked(way.points[at : climb.first + 1], signs, words, faced)
        up = words["up" if climb.storeys > 0 else "down"]
        steps += [*walked, *[up] * abs(climb.storeys)]
        arriving = way.points[climb.last] - way.points[max(climb.last - 1, climb.first)]
        faced, at = float(np.arctan2(arriving[1], arriving[0])), climb.last
    walked, faced = _walked(way.points[at:], signs, words, faced)
    steps += walked
    offset = np.asarray(goal.position[:2], np.float64) - way.points[-1]
    side = "ahead" if faced is None else _side(_difference(float(np.arctan2(offset[1], offset[0])), faced))
    away = float(np.linalg.norm(offset))
    arrival = words["arrive_far" if away > _FAR else "arrive"]
    return [*steps, _filled(arrival, name=goal.name, side=words[side], metres=f"{away:.0f}")]


def _walked(
    way: Array, signs: Sequence[Sign], words: dict[str, str], faced: float | None
) -> tuple[list[str], float | None]:
    """The steps of a way (n, 2) on one storey, and which way one looks at its end; `faced` at its begin."""
    steps: list[str] = []
    points = _legs(way)
    for start, end in pairwise(points):
        step = end - start
        if np.linalg.norm(step) < 0.5:
            continue  # a shuffle, not a walk
        towards = float(np.arctan2(step[1], step[0]))
        turn = "" if faced is None else _turn(_difference(towards, faced))
        if turn:
            mark = None if start is points[0] else _beside(start, signs)
            steps.append(words[turn] if mark is None else _filled(words["at"], name=mark.name, turn=words[turn]))
        steps.append(_filled(words["go"], metres=f"{np.linalg.norm(step):.0f}"))
        faced = towards
    return steps, faced


def length_told(way: Way, language: str = "en") -> str:
    """How long a way is, and how long it takes."""
    return _filled(_words(language)["whole"], metres=f"{way.length:.0f}", seconds=f"{max(way.seconds, 1.0):.0f}")


def _filled(pattern: str, **values: str) -> str:
    """A phrase with its gaps filled; what a sign says is never a pattern itself."""
    return "".join(values.get(part, part) if at % 2 else part for at, part in enumerate(_GAP.split(pattern)))


def _legs(points: Array) -> list[Array]:
    """Corners of a way, but for those that are hardly turns."""
    kept = [points[0]]
    for before, here, after in zip(points[:-2], points[1:-1], points[2:], strict=True):
        into, out = here - before, after - here
        turned = _difference(float(np.arctan2(out[1], out[0])), float(np.arctan2(into[1], into[0])))
        if abs(turned) >= _SLIGHT and np.linalg.norm(here - kept[-1]) >= _SHORT:
            kept.append(here)
    if len(kept) > 1 and np.linalg.norm(points[-1] - kept[-1]) < _SHORT:
        kept.pop()
    return [*kept, points[-1]]


def _turn(angle: float) -> str:
    """The word for a turn of so many radians to the left; none where one goes straight on."""
    size, side = abs(angle), "left" if angle > 0 else "right"
    if size < _SLIGHT:
        return ""
    if size >= _BACK:
        return "back"
    return f"sharp_{side}" if size >= _SHARP else side if size >= _FULL else f"half_{side}"


def _side(angle: float) -> str:
    if abs(angle) < np.radians(45.0):
        return "ahead"
    return "behind" if abs(angle) > np.radians(135.0) else "on_left" if angle > 0 else "on_right"


def _beside(point: Array, signs: Sequence[Sign]) -> Sign | None:
    near = [(float(np.linalg.norm(np.asarray(each.position[:2]) - point)), each) for each in signs]
    away, nearest = min(near, key=lambda each: each[0], default=(np.inf, None))
    return nearest if away <= _AT else None


def _difference(first: float, second: float) -> float:
    return float((first - second + np.pi) % (2.0 * np.pi) - np.pi)


@cache
def _words(language: str) -> dict[str, str]:
    spoken = language.partition("-")[0]  # "zh-Hant" is Chinese
    language = spoken if spoken in LANGUAGES else "en"
    text = files("lpslam.navigation.walking").joinpath("data", f"{language}.json").read_text(encoding="utf-8")
    return {str(key): str(value) for key, value in json.loads(text).items()}
