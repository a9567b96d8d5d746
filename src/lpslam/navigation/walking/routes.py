"""From an answer to where to stand and how to go: a pose before each stop, and the way there."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.config import Config
from lpslam.language.sanitise import clean_text
from lpslam.mapfile.language_map import LanguageMap
from lpslam.navigation.asking import Answer
from lpslam.navigation.walking.goals import Goal, goal_before
from lpslam.navigation.walking.storeys import Building
from lpslam.navigation.walking.telling import Sign, told
from lpslam.navigation.walking.ways import NoWayError, Walkable, Way
from lpslam.text.types import Landmark

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """The way to one stop.

    Attributes:
        landmark: to which it leads.
        goal: where the robot stands at its end.
        way: over the ground.
    """

    landmark: Landmark
    goal: Goal
    way: Way


def building_of(world: LanguageMap, config: Config | None = None) -> Building:
    """The ground of all storeys of a map on which a robot has room, and the ways between them.

    Raises:
        NoWayError: the map has none.
    """
    config = config or Config()
    if world.scans is None or not len(world.scans):
        raise NoWayError(
            "the map keeps nothing of the ground: it was made by an older version; map the recording again"
        )
    grids = world.grids(config.ground)
    if not grids:
        raise NoWayError(
            "the map has no floor: none was seen; point the camera so that the floor is in view, and map again"
        )
    return Building(grids, world.frame_poses().positions, config)


def route(answer: Answer, ground: Walkable | Building) -> list[Leg]:
    """The legs of the way to the answer's stops, one after the other, from where the question was asked.

    Raises:
        NoWayError: there is no answer, or no way.
    """
    stops = [stop for stop in (answer.stops or (answer.landmark,)) if stop is not None]
    if not stops:
        others = ", ".join(clean_text(mark.name) for mark in answer.alternatives[:_TOLD])
        next_best = f"; next best: {others}" if others else ""
        raise NoWayError(f"nothing on the map serves, so there is no way to it: {answer.choice.evidence}{next_best}")
    return route_through(answer.here, stops, ground)


def route_through(here: Array, stops: Sequence[Landmark], ground: Walkable | Building) -> list[Leg]:
    """The legs of the way through landmarks in their order.

    Args:
        here: (2 or 3,) metres, map frame; in a building with its height.
        stops: to go to.
        ground: of one storey, or of a building, in which ways lead over stairs and ramps that were walked.

    Raises:
        NoWayError: there is none to one of them.
    """
    legs, at = [], np.asarray(here, np.float64)
    for stop in stops:
        if isinstance(ground, Building):
            goal, way = ground.to_sign(at, stop.position, stop.normal)
        else:
            goal = goal_before(stop.position, stop.normal, ground, at)
            way = ground.way(at, goal.position)
        legs.append(Leg(stop, goal, way))
        # From before a sign one goes on at the sign's storey.
        at = np.array([*goal.position, stop.position[2]])
    return legs


def told_legs(
    legs: Sequence[Leg], landmarks: Sequence[Landmark], language: str, heading: float | None
) -> list[list[str]]:
    """The steps of each leg in words.

    Args:
        legs: one after the other.
        landmarks: that may be named at turns.
        language: in which they are told.
        heading: radians counter-clockwise from the map's x axis, which way one looks at first; None where unknown.
    """
    signs, steps = [Sign(mark.name, mark.position) for mark in landmarks], []
    for leg in legs:
        goal = Sign(leg.landmark.name, leg.landmark.position)
        steps.append(told(leg.way, signs, goal, language, heading))
        heading = leg.goal.yaw
    return steps


def best_order(here: Array, stops: Sequence[Landmark], walkable: Walkable) -> list[Leg]:
    """The legs in the order that is shortest: of all orders up to seven stops, else always the nearest next.

    Raises:
        NoWayError: there is none to one of them.
    """
    goals = [goal_before(stop.position, stop.normal, walkable, here).position for stop in stops]
    places = [np.asarray(here[:2], np.float64), *goals]
    count = len(places)
    lengths = np.zeros((count, count))
    for i in range(count):
        for j in range(i + 1, count):
            lengths[i, j] = lengths[j, i] = walkable.way(places[i], places[j]).length
    order = _all_orders(lengths) if len(stops) <= _MOST_ORDERED else _nearest_next(lengths)
    return route_through(here, [stops[each - 1] for each in order], walkable)


def _all_orders(lengths: Array) -> list[int]:
    """The shortest order by dynamic programming over sets (Held and Karp 1962)."""
    count = len(lengths)
    best = {(1 << end, end): (lengths[0, end], [end]) for end in range(1, count)}
    for _ in range(count - 2):
        longer: dict[tuple[int, int], tuple[float, list[int]]] = {}
        for (seen, end), (length, order) in best.items():
            for other in range(1, count):
                if not seen >> other & 1:
                    key, total = (seen | 1 << other, other), length + lengths[end, other]
                    if key not in longer or total < longer[key][0]:
                        longer[key] = (total, [*order, other])
        best = longer
    return min(best.values(), key=lambda each: each[0])[1] if best else []


def _nearest_next(lengths: Array) -> list[int]:
    order, left, at = [], set(range(1, len(lengths))), 0
    while left:
        at = min(left, key=lambda each: (lengths[at, each], each))
        left.remove(at)
        order.append(at)
    return order


_TOLD = 3  # places that are told as next best

_MOST_ORDERED = 7
"""Stops of which all orders are compared."""
