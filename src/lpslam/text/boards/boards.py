"""Texts of one board are one landmark: a name, its slogan, a telephone number and what is on the menu.

Two groups become one while they are more probably one board than two. What links them is said by their best pair of
neighbours; what divides them by all pairs, so that no row of weak links joins what stands on different grounds.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lpslam.config import InstanceConfig
from lpslam.text.boards.kinship import kinship
from lpslam.text.placing.places import Place

Array = NDArray[np.float64]


def boards(places: Sequence[Place], config: InstanceConfig) -> list[list[Place]]:
    """Group places into boards, in the order of their first id."""
    count = len(places)
    # No pair farther apart is even looked at: it would not be linked, and a city has thousands of texts.
    link, divide = np.full((count, count), -np.inf), np.zeros((count, count))
    for first in range(count):
        for second in range(first):
            if _are_near(places[first], places[second], config):
                kin = kinship(places[first], places[second])
                link[first, second] = link[second, first] = kin.link
                divide[first, second] = divide[second, first] = kin.divide
    groups = [[each] for each in range(count)]
    while len(groups) > 1:
        scores = {(a, b): _log_odds(link, divide, groups[a], groups[b]) for a in range(len(groups)) for b in range(a)}
        (a, b), best = max(scores.items(), key=lambda each: each[1])
        if best <= 0.0:
            break
        groups[b] += groups.pop(a)
    found = [[places[row] for row in sorted(group)] for group in groups]
    return sorted(found, key=lambda group: min(each.id for each in group))


def _log_odds(link: Array, divide: Array, first: list[int], second: list[int]) -> float:
    pairs = np.ix_(first, second)
    return float(link[pairs].max() + divide[pairs].mean())


def _are_near(first: Place, second: Place, config: InstanceConfig) -> bool:
    reach = config.board_reach * (first.letter + second.letter) / 2.0
    apart = float(np.linalg.norm(first.position - second.position))
    return apart <= (first.width + first.height + second.width + second.height) / 2.0 + reach
