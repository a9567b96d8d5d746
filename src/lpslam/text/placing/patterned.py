"""Where boxes were refused as patterns, and what that says of texts that were read there.

A frieze is a pattern in most views; in a few, in which a piece of it is in view, it is read as a text. So boxes that
are refused speak against what is read at their place, as readings speak for it: how often a text is taken for a
pattern, and how often a pattern is, differ so much that a few views tell. How the text is spelt counts as well, and so
do equal texts close by: motifs come again along a wall, words hardly ever.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import lgamma, log
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from lpslam.camera import transform_points
from lpslam.config import PatternConfig
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.places import Place
from lpslam.text.reading.spelt_patterns import SUSPECT, pattern_odds, shapes_of
from lpslam.text.remembering.similarity import comparison_key
from lpslam.text.types import Placement

Array = NDArray[np.float64]

_CAPACITY, _RECENT = 4096, 64
"""Patterns kept, the newest, and of these how many may be the same as one that is added."""

_NUMBERS = 13


@dataclass(slots=True)
class Pattern:
    """A box that was refused as a pattern, in the frame of its keyframe's camera, and how often it was there."""

    keyframe: int
    placement: Placement
    count: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """n patterns in the world: (n, 3) metres, (n, 3) unit twice, (n, 2) metres, and (n,) how often each was seen."""

    positions: Array
    normals: Array
    baselines: Array
    sizes: Array
    counts: Array

    def at(self, place: Place, config: PatternConfig) -> int:
        """How many boxes were refused where a text stands."""
        if not len(self.counts):
            return 0
        offsets = self.positions - place.position
        shared = np.ones(len(offsets))
        for axis, size, others in (
            (place.baseline, place.width, self.sizes[:, 0]),
            (place.down, place.height, self.sizes[:, 1]),
        ):
            both = (size + others) / 2.0 - np.abs(offsets @ axis)
            shared *= np.clip(both / np.maximum(np.minimum(size, others), 1e-6), 0.0, 1.0)
        along = np.abs(self.baselines @ place.baseline) > np.sqrt(0.5)
        there = along & (np.abs(offsets @ place.normal) <= config.depth) & (self.normals @ place.normal > 0.5)
        return int(self.counts[there & (shared >= config.covered)].sum())


@dataclass(slots=True)
class Patterns:
    """The boxes of a map that were refused as patterns, hung on keyframes."""

    seen: list[Pattern] = field(default_factory=list)

    def add(self, keyframe: int, placement: Placement) -> None:
        """Note a refused box; boxes of one keyframe at one place are one."""
        for each in reversed(self.seen[-_RECENT:]):
            if each.keyframe == keyframe and _is_same(each.placement, placement):
                each.count += 1
                return
        self.seen.append(Pattern(keyframe, placement))
        del self.seen[:-_CAPACITY]

    def standing(self, world_from_keyframe: KeyframePoses) -> Standing:
        """Where those stand whose keyframe has a place in the map."""
        rows = np.array([_row(each) for each in self.seen]).reshape(-1, _NUMBERS)
        known = np.ones(len(rows), np.bool_)
        for keyframe in np.unique(rows[:, 0]):
            own, pose = rows[:, 0] == keyframe, world_from_keyframe(int(keyframe))
            if pose is None:
                known &= ~own
                continue
            rows[own, 2:5] = transform_points(pose, rows[own, 2:5])
            rows[own, 5:8], rows[own, 8:11] = rows[own, 5:8] @ pose[:3, :3].T, rows[own, 8:11] @ pose[:3, :3].T
        rows = rows[known]
        return Standing(rows[:, 2:5], rows[:, 5:8], rows[:, 8:11], rows[:, 11:13], rows[:, 1])

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """A row of numbers for each."""
        return {"rows": np.array([_row(each) for each in self.seen], np.float64).reshape(-1, _NUMBERS)}

    @classmethod
    def from_arrays(cls, arrays: dict[str, NDArray[np.generic]]) -> Self:
        """Restore what `to_arrays` gave; nothing where an older map has none.

        Raises:
            ValueError: the rows are none of patterns.
        """
        rows = np.asarray(arrays.get("rows", np.zeros((0, _NUMBERS))), np.float64)
        if rows.ndim != 2 or rows.shape[1] != _NUMBERS or len(rows) > _CAPACITY or not np.isfinite(rows).all():
            raise ValueError("patterns of a map have a wrong shape")
        if (rows[:, 1] < 1.0).any() or (rows[:, 11:] < 0.0).any() or (np.abs(rows[:, 5:11]) > 1.0 + 1e-6).any():
            raise ValueError("patterns of a map have no size or face nowhere")
        return cls([_pattern(row.tolist()) for row in rows])


def without_patterned(places: Sequence[Place], patterns: Standing, config: PatternConfig) -> list[Place]:
    """The places of texts that are likelier texts than pieces of patterns; those of none speak against others."""
    if not any(each.is_text for each in places):
        return []
    asked = [each for each in places if each.is_text]
    reach = [config.twin_reach * each.width for each in asked]
    all_near = KDTree([each.position for each in places]).query_ball_point([each.position for each in asked], reach)
    kept = []
    for place, near in zip(asked, all_near, strict=True):
        twins = sum(_is_twin(place.name, places[row].name) for row in near) - 1
        if patterned_odds(place, patterns.at(place, config), twins, config) <= 0.0:
            kept.append(place)
    return kept


def _is_twin(name: str, other: str) -> bool:
    """Whether a text close by is another piece of one pattern: it is equal, or the same shapes were read otherwise.

    Few words lack no shape of their neighbour, but some do (OPPO, FOOD): neither must be spelt as texts are, and the
    one that is asked of must be spelt as patterns are.
    """
    if comparison_key(name) == comparison_key(other):
        return True
    if pattern_odds(name) < SUSPECT or pattern_odds(other) < -SUSPECT:
        return False
    own, theirs = shapes_of(name), shapes_of(other)
    return bool(own and theirs) and (own <= theirs or theirs <= own)


def patterned_odds(place: Place, refused: int, twins: int, config: PatternConfig) -> float:
    """Log odds that a place is a piece of a pattern.

    Args:
        place: with its readings.
        refused: how many boxes were refused there.
        twins: pieces close by that say the same, or have the same shapes.
        config: what a refusal and a twin weigh.
    """
    read = place.observations
    prior = log(config.probability / (1.0 - config.probability))
    votes = _log_beta(refused, read, *config.refused_of_patterns) - _log_beta(refused, read, *config.refused_of_texts)
    return prior + pattern_odds(place.name) + votes + config.twin * min(twins, config.most_twins)


def _log_beta(refused: int, read: int, refuse: float, take: float) -> float:
    """Logarithm of how likely so many views are refused and read, the share of refused ones being beta-distributed."""
    return _beta(refused + refuse, read + take) - _beta(refuse, take)


def _beta(a: float, b: float) -> float:
    return lgamma(a) + lgamma(b) - lgamma(a + b)


def _is_same(first: Placement, second: Placement) -> bool:
    apart = float(np.linalg.norm(np.array(first.position) - np.array(second.position)))
    sizes = np.array([[each.width, each.height] for each in (first, second)])
    return apart < 0.5 * float(sizes.min()) and bool((sizes.max(axis=0) < 1.5 * sizes.min(axis=0)).all())


def _row(pattern: Pattern) -> list[float]:
    where = pattern.placement
    return [pattern.keyframe, pattern.count, *where.position, *where.normal, *where.baseline, where.width, where.height]


def _pattern(row: list[float]) -> Pattern:
    position, normal, baseline = ((row[at], row[at + 1], row[at + 2]) for at in (2, 5, 8))
    return Pattern(int(row[0]), Placement(position, normal, baseline, row[11], row[12], 0.0), int(row[1]))
