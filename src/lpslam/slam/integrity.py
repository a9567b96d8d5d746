"""Whether the columns of a map fit together: kernels trust every row number that they meet."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import are_rigid

_FARTHEST = 1e7
"""Metres: farther than anything is mapped from its origin."""
_LATEST = 1e12
"""Seconds: beyond any clock."""
_MOST_LEVELS, _LARGEST_SCALE = 64, 1e3
"""Of a pyramid of pictures."""


def refuse_misshapen_columns(arrays: dict[str, NDArray[Any]], tables: Iterable[tuple[str, ...]]) -> None:
    """Raise ValueError where a column has another shape than its like, or those of one table differ in length."""
    shapes = (arrays["point"].ndim, arrays["scales"].ndim, arrays["free_slots"].ndim, arrays["home"].shape)
    if shapes != (2, 1, 1, (1,)) or arrays["home"].dtype != np.int32:
        raise ValueError("columns point, scales, free_slots or home have another shape or type")
    if arrays["loop_edges"].shape[1:] != (2,) or arrays["loop_edges"].dtype != np.int32:
        raise ValueError("column loop_edges has another shape or type")
    for table in tables:
        if len({len(arrays[name]) for name in table}) != 1:
            raise ValueError(f"columns {', '.join(table)} differ in length")


def refuse_broken_columns(arrays: dict[str, NDArray[Any]]) -> None:
    """Refuse columns that would lead a kernel out of the map, into a circle or to numbers that are none.

    Args:
        arrays: columns by name as in `SlamMap.to_arrays`, of the right types and shapes.

    Raises:
        ValueError: the first fault found.
    """
    _check_numbers(arrays)
    _check_keyframes(arrays)
    _check_observations(arrays)


def _require(holds: bool | np.bool_, fault: str) -> None:
    if not holds:
        raise ValueError(f"the map does not fit together: {fault}")


def _check_numbers(a: dict[str, NDArray[Any]]) -> None:
    for name in ("camera_from_world", "keyframe_from_parent", "position", "scales"):
        _require(np.isfinite(a[name]).all(), f"{name} holds numbers that are not finite")
    _require((np.abs(a["position"]) <= _FARTHEST).all(), "position lies on another planet")
    _require(are_rigid(a["camera_from_world"]), "camera_from_world holds what is no pose")
    for name in ("pixels", "distance_range", "timestamp"):
        _require(np.isfinite(a[name]).all(), f"{name} holds numbers that are not finite")
    _require((np.abs(a["timestamp"]) <= _LATEST).all(), "timestamp is beyond any clock")
    scales = a["scales"]
    _require(
        0 < len(scales) <= _MOST_LEVELS and (scales >= 1).all() and (scales <= _LARGEST_SCALE).all(), "scales are none"
    )
    _require((a["octave"] < len(a["scales"])).all(), "octave names a pyramid level that does not exist")


def _check_keyframes(a: dict[str, NDArray[Any]]) -> None:
    keyframes, (slots, capacity) = len(a["keyframe_slot"]), a["point"].shape
    slot_of, keyframe_of, free = a["keyframe_slot"], a["slot_keyframe"], a["free_slots"]
    _require(_within(slot_of, -1, slots), "keyframe_slot names a slot that does not exist")
    _require(_within(keyframe_of, -1, keyframes), "slot_keyframe names a keyframe that does not exist")
    living, used = np.flatnonzero(slot_of >= 0), np.flatnonzero(keyframe_of >= 0)
    _require(
        len(living) == len(used) and (keyframe_of[slot_of[living]] == living).all(),
        "keyframe_slot and slot_keyframe contradict each other",
    )
    _require(np.array_equal(np.sort(free), np.flatnonzero(keyframe_of < 0)), "free_slots are not the unused slots")
    _require(_within(a["feature_count"], 0, capacity + 1), "feature_count exceeds the room of a slot")
    # A parent is older than its child, so that every chain of removed keyframes ends at a living root.
    ids, parent, submap = np.arange(keyframes), a["parent"], a["submap"]
    roots = np.flatnonzero(parent < 0)
    _require((parent < ids).all() and (parent >= -1).all(), "parent is no earlier keyframe")
    _require((parent[:1] == -1).all() and (slot_of[roots] >= 0).all(), "a root of the spanning tree was removed")
    _require((submap >= 0).all(), "submap is negative")
    children = np.flatnonzero(parent >= 0)
    _require((submap[children] == submap[parent[children]]).all(), "a keyframe and its parent differ in their sub-map")
    loops = a["loop_edges"]
    _require(_within(loops, 0, keyframes), "loop_edges names a keyframe that does not exist")
    _require((submap[loops[:, 0]] == submap[loops[:, 1]]).all(), "a loop ties different sub-maps")
    _require(a["home"].shape == (1,) and (keyframes == 0 or a["home"][0] in submap), "home is no sub-map")


def _check_observations(a: dict[str, NDArray[Any]]) -> None:
    points, capacity = len(a["head"]), a["point"].shape[1]
    point, following = a["point"].reshape(-1), a["next_observation"].reshape(-1)
    _require(_within(point, -1, points), "point names a point that does not exist")
    _require(_within(a["head"], -1, point.size), "head names an observation that does not exist")
    _require(_within(following, -1, point.size), "next_observation names an observation that does not exist")
    _require(_within(a["first_keyframe"], 0, len(a["keyframe_slot"])), "first_keyframe does not exist")
    sigma = a["inverse_sigma"]
    _require((np.isfinite(sigma) & (sigma >= 0.0)).all(), "inverse_sigma is no uncertainty")

    linked = np.flatnonzero(point >= 0)
    slot, feature = np.divmod(linked, capacity)
    in_use = (a["slot_keyframe"][slot] >= 0) & (feature < a["feature_count"][slot])
    _require(in_use.all(), "a point is observed by a keypoint that does not exist")
    pairs = np.unique(np.column_stack([slot, point[linked]]), axis=0)
    _require(len(pairs) == len(linked), "a point is observed twice by one keyframe")
    counts = np.bincount(point[linked], minlength=points)
    _require(np.array_equal(counts, a["observations"]), "observations miscounts")
    _require(np.array_equal(a["point_alive"], counts > 0), "point_alive contradicts the observations")

    # Walk all lists at once, one observation further at a time; none can be longer than there are slots.
    owner = np.flatnonzero(a["head"] >= 0)
    observation = a["head"][owner]
    walked = 0
    for _ in range(len(a["point"]) + 1):
        _require((point[observation] == owner).all(), "a list of observations strays to another point")
        walked += len(observation)
        owner, observation = owner[following[observation] >= 0], following[observation]
        observation = observation[observation >= 0]
    _require(len(observation) == 0 and walked == len(linked), "a list of observations is broken")


def _within(rows: NDArray[Any], first: int, end: int) -> bool:
    return bool(((rows >= first) & (rows < end)).all())
