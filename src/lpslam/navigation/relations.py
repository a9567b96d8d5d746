"""How places stand to one another: costs in metres, lower is truer; infinite where a relation does not hold.

A relation that the positions cannot decide does not hold, and its doubt says why.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lpslam.config import NavigationConfig
from lpslam.language.wishes.form import Relation
from lpslam.navigation.floors import Floors
from lpslam.navigation.places import Distances, Here, Place, Point
from lpslam.navigation.sites import Sites

_UP = np.array([0.0, 0.0, 1.0])
_NO = float("inf")
_NEIGHBOURS_OF_A_LINE = 3  # places that tell along which line boards hang
_NEAREST = 5  # places around a board, itself among them, whose line it is held to hang on


@dataclass(frozen=True, slots=True)
class Judged:
    """What a relation costs, and what is not sure of it."""

    cost: float
    doubt: str = ""


class Scene:
    """All places, the asker, how far it is between them, and by what they are judged."""

    def __init__(self, sites: Sites, here: Here, ways: Distances, config: NavigationConfig) -> None:
        self.config = config
        self.sites = sites
        self.places = sites.places
        self.here = here
        self.ways = ways
        self._facings: dict[int, tuple[Point | None, str]] = {}
        self._from_here: dict[int, float] = {}

    @cached_property
    def floors(self) -> Floors:
        """The floors on which the places lie."""
        return Floors(self.places, self.config)

    def from_here(self, place: Place) -> float:
        """Metres from the asker, whose place must be known: measured once, and compared with every anchor."""
        assert self.here.position is not None
        known = self._from_here.get(place.id)
        if known is None:
            known = self._from_here[place.id] = self.ways.distance(self.here.position, place.position)
        return known

    def facing_of(self, place: Place) -> tuple[Point | None, str]:
        """Where a board faces; where that is not known, across the line of its neighbours, which is a guess."""
        if place.facing is not None:
            return _level(place.facing), ""
        if place.id not in self._facings:
            self._facings[place.id] = self._guessed_facing(place)
        return self._facings[place.id]

    def _guessed_facing(self, place: Place) -> tuple[Point | None, str]:
        if len(self.places) < _NEIGHBOURS_OF_A_LINE:
            return None, ""
        near = self.sites.nearest(place.position, _NEAREST)
        spread = np.array([each.position[:2] for each in near]) - place.position[:2]
        _, _, axes = np.linalg.svd(np.vstack([spread, -spread]), full_matrices=False)
        normal = np.array([-axes[0][1], axes[0][0], 0.0])
        return normal, f"which way {place.name} faces is guessed from its neighbours"

    def is_same_floor(self, place: Place, anchor: Place) -> bool:
        """Whether two boards hang on one floor; else they are no neighbours, however near."""
        return abs(float(place.position[2] - anchor.position[2])) <= self.config.floor_height

    def are_opposed(self, place: Place, anchor: Place) -> bool:
        """Whether two boards are known to face one another, or away from one another."""
        facings = place.facing, anchor.facing
        return (
            facings[0] is not None and facings[1] is not None and float(facings[0] @ facings[1]) < -self.config.opposed
        )

    def is_same_side(self, place: Place, anchor: Place) -> bool:
        """Whether two boards face the same way; also where that is not known."""
        facings = place.facing, anchor.facing
        return facings[0] is None or facings[1] is None or float(facings[0] @ facings[1]) > self.config.opposed


def _level(direction: Point) -> Point | None:
    flat = np.array([direction[0], direction[1], 0.0])
    size = float(np.linalg.norm(flat))
    return flat / size if size > 1e-6 else None


def next_to(place: Place, anchor: Place, scene: Scene) -> Judged:
    """Near enough to be a neighbour, on the same wall before across the corridor."""
    apart = scene.ways.distance(place.position, anchor.position)
    if not scene.is_same_floor(place, anchor):
        return Judged(_NO)
    reach = max(scene.config.neighbour_reach, scene.config.neighbour_gaps * scene.sites.usual_gap)
    if apart > reach:
        return Judged(_NO)
    if scene.are_opposed(place, anchor):
        apart *= scene.config.opposed_cost
    return Judged(apart)


def near(place: Place, anchor: Place, scene: Scene) -> Judged:
    """As near as possible."""
    return Judged(scene.ways.distance(place.position, anchor.position))


def opposite(place: Place, anchor: Place, scene: Scene) -> Judged:
    """Across, in the direction in which the anchor's board faces."""
    config = scene.config
    facing, doubt = scene.facing_of(anchor)
    if facing is None:
        return Judged(_NO, f"which way {anchor.name} faces is not known")
    if not scene.is_same_floor(place, anchor):
        return Judged(_NO, doubt)
    offset = place.position - anchor.position
    offset = np.array([offset[0], offset[1], 0.0])
    across = float(offset @ facing)
    across = abs(across) if doubt else across
    apart = float(np.linalg.norm(offset))
    if apart < 1e-6 or across < config.across_share * apart:
        return Judged(_NO, doubt)
    beside = float(np.linalg.norm(offset - (offset @ facing) * facing))
    faces_away = place.facing is not None and float(place.facing @ facing) > config.turned_away
    return Judged(across + config.aside_cost * beside + (config.turned_away_cost if faces_away else 0.0), doubt)


def _sideways(sign: float) -> Callable[[Place, Place, Scene], Judged]:
    def judge(place: Place, anchor: Place, scene: Scene) -> Judged:
        forward: Point | None
        doubt = ""
        if anchor.facing is not None and (level := _level(anchor.facing)) is not None:
            forward = -level
        elif scene.here.position is not None:
            forward = _level(anchor.position - scene.here.position)
            doubt = "left and right are taken as seen from here"
        else:
            forward, doubt = None, ""
        if not scene.is_same_floor(place, anchor):
            return Judged(_NO, doubt)
        if forward is None:
            return Judged(_NO, f"which way {anchor.name} faces is not known, nor where you stand")
        right = np.cross(forward, _UP)
        offset = place.position - anchor.position
        offset = np.array([offset[0], offset[1], 0.0])
        beside, apart = sign * float(offset @ right), float(np.linalg.norm(offset))
        if beside <= scene.config.beside_share * apart:
            return Judged(_NO, doubt)
        if scene.are_opposed(place, anchor):
            # On the other wall it is opposite, and to the left of nothing here.
            return Judged(_NO, doubt)
        return Judged(beside + scene.config.aside_cost * abs(float(offset @ forward)), doubt)

    return judge


def between(place: Place, first: Place, second: Place, scene: Scene) -> Judged:
    """On the way from one anchor to the other, with the smallest detour."""
    whole = scene.ways.distance(first.position, second.position)
    parts = scene.ways.distance(first.position, place.position), scene.ways.distance(place.position, second.position)
    if max(parts) >= whole or sum(parts) > scene.config.detour * whole:
        return Judged(_NO)
    return Judged(sum(parts) - whole)


def on_the_way(place: Place, anchor: Place, start: Point | None, scene: Scene) -> Judged:
    """The detour on the way to the anchor."""
    if start is None:
        return Judged(_NO, "where you stand is not known")
    parts = scene.ways.distance(start, place.position), scene.ways.distance(place.position, anchor.position)
    return Judged(sum(parts) - scene.ways.distance(start, anchor.position))


def before(place: Place, anchor: Place, scene: Scene) -> Judged:
    """In front of the anchor: on the way to it; without a start, where its board faces."""
    if scene.here.position is None:
        facing, doubt = scene.facing_of(anchor)
        offset = place.position - anchor.position
        if facing is None or float(offset @ facing) <= 0.0:
            return Judged(_NO, doubt or f"which way {anchor.name} faces is not known")
        return Judged(float(np.linalg.norm(offset)), doubt)
    here_to_place, here_to_anchor = scene.from_here(place), scene.from_here(anchor)
    if here_to_place >= here_to_anchor:
        return Judged(_NO)
    apart = scene.ways.distance(place.position, anchor.position)
    return Judged(here_to_place + apart - here_to_anchor + apart)


def behind(place: Place, anchor: Place, scene: Scene) -> Judged:
    """Past the anchor, seen from here; without a start, behind its board."""
    if scene.here.position is None:
        facing, doubt = scene.facing_of(anchor)
        if facing is None or float((place.position - anchor.position) @ facing) >= 0.0:
            return Judged(_NO, doubt or f"which way {anchor.name} faces is not known")
        return Judged(scene.ways.distance(place.position, anchor.position), doubt)
    here_to_place, here_to_anchor = scene.from_here(place), scene.from_here(anchor)
    if here_to_place <= here_to_anchor:
        return Judged(_NO)
    apart = scene.ways.distance(place.position, anchor.position)
    return Judged(here_to_anchor + apart - here_to_place + apart)


def this_side(place: Place, anchor: Place, scene: Scene) -> Judged:
    """Nearer to here than the anchor."""
    return before(place, anchor, scene)


PAIRED: dict[Relation, Callable[[Place, Place, Scene], Judged]] = {
    Relation.NEXT_TO: next_to,
    Relation.NEAR: near,
    Relation.OPPOSITE: opposite,
    Relation.LEFT_OF: _sideways(-1.0),
    Relation.RIGHT_OF: _sideways(1.0),
    Relation.BEFORE: before,
    Relation.BEHIND: behind,
    Relation.THIS_SIDE: this_side,
}
"""Relations between a place and one anchor."""
