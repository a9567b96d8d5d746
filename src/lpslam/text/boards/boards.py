"""Texts of one board are one landmark: a name, its slogan, a telephone number and what is on the menu.

Two groups become one while they are more probably one board than two. What links them is said by their best pair of
neighbours; what divides them by all pairs, so that no row of weak links joins what stands on different grounds. A
number or an address by itself is some board's.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lpslam.config import InstanceConfig
from lpslam.text.boards.kinship import CONTACT_ALONE, kinship
from lpslam.text.boards.roles import Role, role_by_form
from lpslam.text.placing.places import Place

Array = NDArray[np.float64]


def boards(places: Sequence[Place], config: InstanceConfig) -> list[list[Place]]:
    """Group places into boards, in the order of their first id."""
    count = len(places)
    # No pair farther apart is even looked at: it would not be linked, and a city has thousands of texts.
    link, divide = np.full((count, count), -np.inf), np.zeros((count, count))
    for first, second in _pairs_in_reach(places, config):
        if _are_near(places[first], places[second], config):
            kin = kinship(places[first], places[second])
            link[first, second] = link[second, first] = kin.link
            divide[first, second] = divide[second, first] = kin.divide
    contacts = np.array([role_by_form(each.name) is Role.CONTACT for each in places], np.bool_)
    # Groups are known by their first place; only those that a pair links can become one.
    groups = {each: [each] for each in range(count)}
    kin_of: dict[int, set[int]] = {each: set(np.flatnonzero(np.isfinite(link[each])).tolist()) for each in groups}
    scores = {(a, b): _log_odds(link, divide, contacts, [a], [b]) for a in groups for b in kin_of[a] if b < a}
    while scores:
        # Of equals, those that come first.
        (a, b), best = max(scores.items(), key=lambda each: (each[1], -each[0][0], -each[0][1]))
        if best <= 0.0:
            break
        groups[b] += groups.pop(a)
        around = (kin_of.pop(a) | kin_of[b]) - {a, b}
        kin_of[b] = around
        for other in around:
            kin_of[other] = (kin_of[other] - {a}) | {b}
        scores = {pair: score for pair, score in scores.items() if a not in pair and b not in pair}
        for other in around:
            later, earlier = max(b, other), min(b, other)
            scores[later, earlier] = _log_odds(link, divide, contacts, groups[later], groups[earlier])
    found = [[places[row] for row in sorted(group)] for group in groups.values()]
    return sorted(found, key=lambda group: min(each.id for each in group))


def _pairs_in_reach(places: Sequence[Place], config: InstanceConfig) -> list[tuple[int, int]]:
    """Pairs, the later first, that may be near: none that is farther apart than any two can be."""
    if len(places) < 2:
        return []
    positions = np.array([each.position for each in places])
    reach = max((each.width + each.height) + config.board_reach * each.letter for each in places)
    near = cKDTree(positions).query_pairs(reach * (1.0 + 1e-9) + 1e-9, output_type="ndarray")
    return sorted((max(a, b), min(a, b)) for a, b in near.tolist())


def _log_odds(link: Array, divide: Array, contacts: NDArray[np.bool_], first: list[int], second: list[int]) -> float:
    pairs = np.ix_(first, second)
    # Of two groups that are each of one kind, or have a name already, none needs the other.
    is_needed = bool(contacts[first].all() != contacts[second].all())
    return float(link[pairs].max() + divide[pairs].mean() + CONTACT_ALONE * is_needed)


def _are_near(first: Place, second: Place, config: InstanceConfig) -> bool:
    reach = config.board_reach * (first.letter + second.letter) / 2.0
    apart = float(np.linalg.norm(first.position - second.position))
    return apart <= (first.width + first.height + second.width + second.height) / 2.0 + reach
