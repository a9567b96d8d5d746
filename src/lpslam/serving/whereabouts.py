"""Where somebody stands: as told, by the signs in sight, or where the camera was last; and what is near."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rapidfuzz import fuzz

from lpslam.serving.atlas import ServedMap, folded
from lpslam.serving.filters import distances

_ALIKE = 85.0  # percent of a name's letters in order that make two texts the same sign
_IN_SIGHT = 20.0  # metres between signs that are seen from one place
_SHORTEST = 2  # letters of a sign that says where one is


@dataclass(frozen=True, slots=True, eq=False)
class Whereabouts:
    """Where somebody probably stands.

    Attributes:
        position: (2,) or (3,) metres, map frame; None where the signs say nothing.
        heading: degrees; None where that is not known.
        is_sure: whether nothing else fits as well.
        matched: rows of the landmarks that the signs are, one for each that was found.
        unknown: signs that the map does not have.
        how: in a few words.
    """

    position: NDArray[np.float64] | None
    heading: float | None
    is_sure: bool
    matched: tuple[int, ...]
    unknown: tuple[str, ...]
    how: str


def last_known(served: ServedMap) -> Whereabouts:
    """Where the camera was last."""
    position, heading = served.view
    return Whereabouts(position, float(np.degrees(heading)), False, (), (), "where the camera was last")


def by_signs(served: ServedMap, signs: Sequence[str]) -> Whereabouts:
    """Among the signs that are seen: where most of them stand together."""
    found = {sign: _rows_of(served, sign) for sign in signs}
    unknown = tuple(sign for sign, rows in found.items() if not rows)
    if not any(found.values()):
        return Whereabouts(None, None, False, (), unknown, "none of these signs is on the map")
    places = np.array([mark.position for mark in served.directory.landmarks])
    groups = [_around(places, anchor, found) for rows in found.values() for anchor in rows]
    best = max(groups, key=len)
    middle = places[list(best)].mean(axis=0)
    rivals = [
        group
        for group in groups
        if len(group) == len(best) and float(np.linalg.norm(places[list(group)].mean(axis=0) - middle)) > _IN_SIGHT
    ]
    how = f"among {len(best)} of {len(found)} signs" + ("; elsewhere as many stand together" if rivals else "")
    return Whereabouts(middle, None, not rivals, best, unknown, how)


def near(served: ServedMap, position: NDArray[np.float64], count: int) -> list[tuple[int, float]]:
    """The nearest landmarks, by row, and their distances in metres on the floor plan."""
    marks = served.directory.landmarks
    apart = distances(marks, range(len(marks)), tuple(position[:2].tolist()))
    return [(int(row), float(apart[row])) for row in np.argsort(apart, kind="stable")[:count]]


def _rows_of(served: ServedMap, sign: str) -> list[int]:
    """Landmarks that bear a sign's text."""
    text = folded(sign)
    if len(text) < _SHORTEST:
        return []
    return [
        row
        for row, words in enumerate(served.words)
        if any(fuzz.ratio(text, line, score_cutoff=_ALIKE) for line in words.split("\n"))
    ]


def _around(places: NDArray[np.float64], anchor: int, found: dict[str, list[int]]) -> tuple[int, ...]:
    """Of every sign the landmark that is nearest to one of them, as far as it is in sight from there."""
    chosen = []
    for rows in found.values():
        if rows:
            apart = np.linalg.norm(places[rows] - places[anchor], axis=1)
            if apart.min() <= _IN_SIGHT:
                chosen.append(rows[int(apart.argmin())])
    return tuple(dict.fromkeys(chosen))
