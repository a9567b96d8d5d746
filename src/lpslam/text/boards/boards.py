"""Texts of one board are one landmark: a name, its slogan, a telephone number and what is on the menu.

Two groups become one while they are more probably one board than two. What links them is said by their best pair of
neighbours; what divides them by all pairs that were compared, so that no row of weak links joins what stands on
different grounds, however many lines it has. A number or an address by itself is some board's.
"""

import heapq
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lpslam.config import InstanceConfig
from lpslam.text.boards.kinship import CONTACT_ALONE, Kinship, kinship
from lpslam.text.boards.roles import Role, role_by_form
from lpslam.text.placing.places import Place


def boards(places: Sequence[Place], config: InstanceConfig) -> list[list[Place]]:
    """Group places into boards, in the order of their first id."""
    kin = _Kin([each.letter for each in places])
    # No pair farther apart is even looked at: it would not be linked, and a city has thousands of texts.
    for first, second in _pairs_in_reach(places, config):
        if _are_near(places[first], places[second], config):
            kin.add(first, second, kinship(places[first], places[second]))
    contacts = np.array([role_by_form(each.name) is Role.CONTACT for each in places], np.bool_)
    # Groups are known by their first place; only those that a pair links can become one.
    groups = {each: [each] for each in range(len(places))}
    kin_of = kin.linked
    scores = {(a, b): _log_odds(kin, contacts, [a], [b]) for a in sorted(kin_of) for b in kin_of[a] if b < a}
    # Of equals, those that come first. What has another score by now, or none, is passed over.
    best = [(-score, *pair) for pair, score in scores.items()]
    heapq.heapify(best)
    while best:
        least, a, b = heapq.heappop(best)
        if scores.get((a, b)) != -least:
            continue
        if least >= 0.0:
            break
        groups[b] += groups.pop(a)
        for other in kin_of[a]:
            del scores[max(a, other), min(a, other)]
        around = (kin_of.pop(a) | kin_of[b]) - {a, b}
        kin_of[b] = around
        for other in around:
            kin_of[other] = (kin_of[other] - {a}) | {b}
            later, earlier = max(b, other), min(b, other)
            scores[later, earlier] = _log_odds(kin, contacts, groups[later], groups[earlier])
            heapq.heappush(best, (-scores[later, earlier], later, earlier))
    found = [[places[row] for row in sorted(group)] for group in groups.values()]
    return sorted(found, key=lambda group: min(each.id for each in group))


class _Kin:
    """What speaks for pairs of places to be one board, and against it; the other pairs are too far apart to tell.

    Attributes:
        linked: rows of places that are linked with one, by its row.
    """

    def __init__(self, letters: Sequence[float]) -> None:
        self._letters = letters
        self._link: dict[tuple[int, int], float] = {}
        self._divide: dict[tuple[int, int], float] = {}
        self._names_apart: dict[tuple[int, int], float] = {}
        self.linked: dict[int, set[int]] = {}

    def add(self, first: int, second: int, kin: Kinship) -> None:
        """Take a pair, the later first."""
        self._link[first, second], self._divide[first, second] = kin.link, kin.divide
        if kin.names_apart:
            self._names_apart[first, second] = kin.names_apart
        if np.isfinite(kin.link):
            self.linked.setdefault(first, set()).add(second)
            self.linked.setdefault(second, set()).add(first)

    def between(self, first: list[int], second: list[int]) -> float:
        """Log odds of two groups to be one: the best link, what divides on average, and by their largest lines."""
        pairs = [(max(a, b), min(a, b)) for a in first for b in second]
        link = max(self._link.get(pair, -np.inf) for pair in pairs)
        divide = float(np.mean([self._divide[pair] for pair in pairs if pair in self._divide]))
        a, b = (max(group, key=self._letters.__getitem__) for group in (first, second))
        return link + divide + self._names_apart.get((max(a, b), min(a, b)), 0.0)


def _pairs_in_reach(places: Sequence[Place], config: InstanceConfig) -> list[tuple[int, int]]:
    """Pairs, the later first, that may be near: none that is farther apart than any two can be."""
    if len(places) < 2:
        return []
    positions = np.array([each.position for each in places])
    reach = max((each.width + each.height) + config.board_reach * each.letter for each in places)
    near = cKDTree(positions).query_pairs(reach * (1.0 + 1e-9) + 1e-9, output_type="ndarray")
    return sorted((max(a, b), min(a, b)) for a, b in near.tolist())


def _log_odds(kin: _Kin, contacts: NDArray[np.bool_], first: list[int], second: list[int]) -> float:
    # Of two groups that are each of one kind, or have a name already, none needs the other.
    is_needed = bool(contacts[first].all() != contacts[second].all())
    return float(kin.between(first, second) + CONTACT_ALONE * is_needed)


def _are_near(first: Place, second: Place, config: InstanceConfig) -> bool:
    reach = config.board_reach * (first.letter + second.letter) / 2.0
    apart = float(np.linalg.norm(first.position - second.position))
    return apart <= (first.width + first.height + second.width + second.height) / 2.0 + reach
