"""The floors of a building, by the heights of its signs and by what these say."""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from lpslam.config import NavigationConfig
from lpslam.language.wishes.codes import board_codes
from lpslam.language.wishes.form import Counting, Floor
from lpslam.navigation.places import Place, Point

_ROOM = 100  # room 304 is on floor 3
_ASKED = 400  # boards that are asked for it


class Floors:
    """Places by floor; the ground floor is the one nearest to where the map's heights begin."""

    def __init__(self, places: Sequence[Place], config: NavigationConfig) -> None:
        self._places, self._witnesses = places, config.floor_witnesses
        heights = np.array([float(place.position[2]) for place in places])
        order = np.argsort(heights, kind="stable")
        steps = np.flatnonzero(np.diff(heights[order]) > config.floor_height) + 1
        groups = [each for each in np.split(order, steps) if len(each)]
        self._heights = np.array([float(np.median(heights[each])) for each in groups])
        self._groups = groups
        self._index = self._indices()

    def __len__(self) -> int:
        return len(self._groups)

    def _indices(self) -> list[int]:
        """Which floor each is, the ground floor being 0; between floors that hold no sign there are more."""
        if len(self._groups) < 2:
            return [0] * len(self._groups)
        height = float(np.diff(self._heights).min())
        ground = float(self._heights[int(np.abs(self._heights).argmin())])
        return [round(float(each - ground) / height) for each in self._heights]

    def named(self, floor: Floor, here: Point | None) -> tuple[set[int], str]:
        """The ids of the places of a floor, and what is not sure of it; none where the map has no such floor."""
        if floor.counting is Counting.TOP:
            return self._ids(len(self) - 1), ""
        if floor.counting is Counting.FROM_HERE:
            if here is None and floor.number:
                # “Upstairs” is above the ground floor for whoever comes in, and says so of anybody.
                rows = [at for at, index in enumerate(self._index) if index * floor.number > 0]
                ids = {id_ for at in rows for id_ in self._ids(at)}
                return ids, f"where you stand is not known: “{floor}” is taken from the ground floor"
            if here is None:
                return set(), f"where you stand is not known, so “{floor}” cannot be decided"
            at = int(np.abs(self._heights - float(here[2])).argmin()) + floor.number
            return (self._ids(at), "") if 0 <= at < len(self) else (set(), f"this map has no {floor}")
        offset = self._numbered_from()
        is_told = offset is not None and floor.number > 0
        first = offset if is_told and offset is not None else 1 if floor.counting is Counting.FROM_ONE else 0
        wanted = floor.number - first if floor.number > 0 else floor.number
        if wanted not in self._index:
            return set(), f"this map has no {floor}"
        note = "" if is_told or not floor.number else "which floor is the ground floor is taken from heights"
        return self._ids(self._index.index(wanted)), note

    def _ids(self, at: int) -> set[int]:
        return {self._places[int(row)].id for row in self._groups[at]}

    def _numbered_from(self) -> int | None:
        """What boards call the ground floor, 0 or 1, by the numbers of their rooms; None where they do not say."""
        votes: Counter[int] = Counter()
        for index, group in zip(self._index, self._groups, strict=True):
            for row in group[:_ASKED]:
                votes.update(number - index for number in _numbers(self._places[int(row)].name))
        said = [(count, offset) for offset, count in votes.items() if offset in (0, 1) and count >= self._witnesses]
        return max(said)[1] if said else None


def _numbers(name: str) -> Iterator[int]:
    """The floors that a board's room numbers stand for: 304, 1.12."""
    for code in board_codes(name):
        if code.until is not None or code.number is None:
            continue
        if code.rest.startswith(".") and not code.letters:
            yield code.number
        elif _ROOM <= code.number < 100 * _ROOM and not code.rest and not code.letters:
            yield code.number // _ROOM
