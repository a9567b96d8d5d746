"""The map's columns as kernels see them, and walks over the graph of keyframes, points and observations.

An observation is a number, slot · capacity + keypoint. The observations of a point form a linked list through the
`next_observation` column, so that adding one costs nothing and a walk needs no Python object.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import hamming, median

_DESCRIPTORS_COMPARED = 16
"""Observations whose descriptors compete to be a point's; the newest ones, for the point looks as it did last."""


class MapColumns(NamedTuple):
    """All columns of the map. K keyframes, S slots of F keypoints each, P points; rows beyond the counts are unused.

    Attributes:
        camera_from_world: (K, 4, 4).
        keyframe_slot: (K,) slot of the keypoints; -1 once the keyframe is removed.
        slot_keyframe: (S,) the keyframe of a slot; -1 when the slot is free.
        feature_count: (S,).
        pixels, u_right, depth, has_depth, octave, angle, descriptor: (S, F[, ·]) see `Features`.
        disparity_information: (S, F) 1/σ² of u − u_r.
        point: (S, F) the map point of a keypoint, or -1.
        next_observation: (S, F) the next observation of the same point, or -1.
        position: (P, 3) world frame, metres.
        point_descriptor: (P, 4) the most typical descriptor.
        normal: (P, 3) unit mean direction from the point to its observers.
        distance_range: (P, 2) metres, nearest and farthest distance at which the patch matches a pyramid level.
        visible, found: (P,) in how many frames the point was predicted, and matched.
        head: (P,) first observation, or -1.
        observations: (P,) how many keyframes observe the point.
        first_keyframe: (P,) the keyframe that created it.
        point_alive: (P,).
        inverse_sigma: (P,) 1/m, by which the inverse depth in its first keyframe is uncertain; 0 of a sure point.
    """

    camera_from_world: NDArray[np.float64]
    keyframe_slot: NDArray[np.int32]
    slot_keyframe: NDArray[np.int32]
    feature_count: NDArray[np.int32]
    pixels: NDArray[np.float32]
    u_right: NDArray[np.float32]
    depth: NDArray[np.float32]
    has_depth: NDArray[np.bool_]
    octave: NDArray[np.uint8]
    angle: NDArray[np.float32]
    descriptor: NDArray[np.uint64]
    disparity_information: NDArray[np.float32]
    point: NDArray[np.int32]
    next_observation: NDArray[np.int32]
    position: NDArray[np.float64]
    point_descriptor: NDArray[np.uint64]
    normal: NDArray[np.float32]
    distance_range: NDArray[np.float32]
    visible: NDArray[np.int32]
    found: NDArray[np.int32]
    head: NDArray[np.int32]
    observations: NDArray[np.int32]
    first_keyframe: NDArray[np.int32]
    point_alive: NDArray[np.bool_]
    inverse_sigma: NDArray[np.float32]


@njit(cache=True, nogil=True)
def link(m: MapColumns, point: int, slot: int, feature: int) -> None:
    """Make a keypoint an observation of a point."""
    m.point[slot, feature] = point
    m.next_observation[slot, feature] = m.head[point]
    m.head[point] = slot * m.point.shape[1] + feature
    m.observations[point] += 1


@njit(cache=True, nogil=True)
def unlink(m: MapColumns, slot: int, feature: int) -> None:
    """Take an observation away from its point; a point without any dies."""
    point = m.point[slot, feature]
    if point < 0:
        return
    capacity = m.point.shape[1]
    target = slot * capacity + feature
    if m.head[point] == target:
        m.head[point] = m.next_observation[slot, feature]
    else:
        o = m.head[point]
        while o >= 0:
            following = m.next_observation[o // capacity, o % capacity]
            if following == target:
                m.next_observation[o // capacity, o % capacity] = m.next_observation[slot, feature]
                break
            o = following
    m.point[slot, feature] = -1
    m.next_observation[slot, feature] = -1
    m.observations[point] -= 1
    if m.observations[point] <= 0:
        m.point_alive[point] = False


@njit(cache=True, nogil=True)
def remove_point(m: MapColumns, point: int) -> None:
    """Kill a point and forget its observations."""
    capacity = m.point.shape[1]
    o = m.head[point]
    while o >= 0:
        slot, feature = o // capacity, o % capacity
        o = m.next_observation[slot, feature]
        m.point[slot, feature] = -1
        m.next_observation[slot, feature] = -1
    m.head[point] = -1
    m.observations[point] = 0
    m.point_alive[point] = False


@njit(cache=True, nogil=True)
def observed_in(m: MapColumns, point: int, slot: int) -> bool:
    """Whether a slot's keyframe already observes a point."""
    capacity = m.point.shape[1]
    o = m.head[point]
    while o >= 0:
        if o // capacity == slot:
            return True
        o = m.next_observation[o // capacity, o % capacity]
    return False


@njit(cache=True, nogil=True)
def merge_points(m: MapColumns, gone: int, kept: int) -> None:
    """Hand the observations of one point to another and kill the first; where one stands somewhere, so do both."""
    if m.inverse_sigma[gone] == 0.0 and m.inverse_sigma[kept] > 0.0:
        m.inverse_sigma[kept] = 0.0
        for a in range(3):
            m.position[kept, a] = m.position[gone, a]
    capacity = m.point.shape[1]
    o = m.head[gone]
    m.head[gone] = -1
    while o >= 0:
        slot, feature = o // capacity, o % capacity
        o = m.next_observation[slot, feature]
        m.point[slot, feature] = -1
        m.next_observation[slot, feature] = -1
        if not observed_in(m, kept, slot):
            link(m, kept, slot, feature)
    m.visible[kept] += m.visible[gone]
    m.found[kept] += m.found[gone]
    m.observations[gone] = 0
    m.point_alive[gone] = False


@njit(cache=True, nogil=True)
def count_shared_points(m: MapColumns, points: NDArray[np.int32], keyframe_count: int) -> NDArray[np.int32]:
    """(K,) how many of the given points (rows, -1 ignored) each keyframe observes."""
    capacity = m.point.shape[1]
    counts = np.zeros(keyframe_count, np.int32)
    for p in points:
        if p < 0:
            continue
        o = m.head[p]
        while o >= 0:
            slot = o // capacity
            counts[m.slot_keyframe[slot]] += 1
            o = m.next_observation[slot, o % capacity]
    return counts


@njit(cache=True, nogil=True)
def points_of(m: MapColumns, keyframes: NDArray[np.int32], point_count: int) -> NDArray[np.int32]:
    """Rows of all living points that the given keyframes observe, each once."""
    seen = np.zeros(point_count, np.bool_)
    result = np.empty(point_count, np.int32)
    n = 0
    for k in keyframes:
        slot = m.keyframe_slot[k]
        if slot < 0:
            continue
        for f in range(m.feature_count[slot]):
            p = m.point[slot, f]
            if p >= 0 and not seen[p]:
                seen[p] = True
                result[n] = p
                n += 1
    return result[:n].copy()


@njit(cache=True, nogil=True)
def add_points(
    m: MapColumns,
    first: int,
    keyframe: int,
    features: NDArray[np.int32],
    positions: NDArray[np.float64],
    scales: NDArray[np.float64],
) -> None:
    """Fill the rows from `first` on with new points seen by one keyframe.

    Args:
        m: columns, with room for the new rows.
        first: row of the first new point.
        keyframe: the observer.
        features: (n,) its keypoints.
        positions: (n, 3) world frame.
        scales: size of each pyramid level.
    """
    slot = m.keyframe_slot[keyframe]
    for i in range(features.shape[0]):
        p = first + i
        for a in range(3):
            m.position[p, a] = positions[i, a]
        for word in range(4):
            m.point_descriptor[p, word] = m.descriptor[slot, features[i], word]
        m.visible[p] = 1
        m.found[p] = 1
        m.head[p] = -1
        m.observations[p] = 0
        m.first_keyframe[p] = keyframe
        m.point_alive[p] = True
        m.inverse_sigma[p] = 0.0
        link(m, p, slot, features[i])
        refresh_view(m, p, scales)


@njit(cache=True, nogil=True)
def refresh_view(m: MapColumns, p: int, scales: NDArray[np.float64]) -> None:
    """Derive a point's normal and distance range from its observations (ORB-SLAM, III-C).

    The distance range follows the observer that saw the point at the finest pyramid level relative to its distance.
    """
    capacity = m.point.shape[1]
    normal = np.zeros(3)
    direction = np.empty(3)
    farthest = 0.0
    o = m.head[p]
    if o < 0:
        return
    while o >= 0:
        slot, feature = o // capacity, o % capacity
        c = m.camera_from_world[m.slot_keyframe[slot]]
        length = 0.0
        for a in range(3):
            centre = -(c[0, a] * c[0, 3] + c[1, a] * c[1, 3] + c[2, a] * c[2, 3])
            direction[a] = centre - m.position[p, a]
            length += direction[a] ** 2
        length = math.sqrt(length) + 1e-12
        for a in range(3):
            normal[a] += direction[a] / length
        farthest = max(farthest, length * scales[m.octave[slot, feature]])
        o = m.next_observation[slot, feature]
    length = math.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2) + 1e-12
    for a in range(3):
        m.normal[p, a] = normal[a] / length
    m.distance_range[p, 1] = farthest
    m.distance_range[p, 0] = farthest / scales[-1]


@njit(cache=True, nogil=True)
def refresh_descriptor(m: MapColumns, p: int) -> None:
    """Give a point its most typical descriptor: the one whose median Hamming distance to the others is least."""
    capacity = m.point.shape[1]
    seen = np.empty((_DESCRIPTORS_COMPARED, 4), np.uint64)
    distances = np.empty(_DESCRIPTORS_COMPARED)
    n = 0
    o = m.head[p]
    while o >= 0 and n < _DESCRIPTORS_COMPARED:
        slot, feature = o // capacity, o % capacity
        for word in range(4):
            seen[n, word] = m.descriptor[slot, feature, word]
        n += 1
        o = m.next_observation[slot, feature]
    if n == 0:
        return
    best, best_median = 0, 257.0
    if n > 2:
        for i in range(n):
            for j in range(n):
                distances[j] = hamming(seen[i], seen[j])
            middle = median(distances, n)
            if middle < best_median:
                best, best_median = i, middle
    for word in range(4):
        m.point_descriptor[p, word] = seen[best, word]


@njit(cache=True, nogil=True)
def refresh_points(m: MapColumns, points: NDArray[np.int32], scales: NDArray[np.float64]) -> None:
    """Derive what follows from the observations of many points (rows; -1 ignored)."""
    for p in points:
        if p >= 0 and m.point_alive[p]:
            refresh_view(m, p, scales)
            refresh_descriptor(m, p)


@njit(cache=True, nogil=True)
def link_all(m: MapColumns, points: NDArray[np.int32], slot: int) -> None:
    """Make the keypoints of a slot observations of their points ((n,) rows, -1 for none), each point once."""
    for feature in range(points.shape[0]):
        if points[feature] >= 0 and not observed_in(m, points[feature], slot):
            link(m, points[feature], slot, feature)


@njit(cache=True, nogil=True)
def remove_points(m: MapColumns, points: NDArray[np.int32]) -> None:
    """`remove_point` for many rows."""
    for p in points:
        remove_point(m, p)


@njit(cache=True, nogil=True)
def redundant_share(m: MapColumns, keyframe: int, min_observers: int, max_depth: float) -> float:
    """Share of a keyframe's close points that enough others see at most one level coarser (ORB-SLAM2, III-C).

    Args:
        m: columns.
        keyframe: to be judged.
        min_observers: how many other keyframes must see a point.
        max_depth: metres; points beyond are not counted.
    """
    capacity = m.point.shape[1]
    slot = m.keyframe_slot[keyframe]
    counted, redundant = 0, 0
    for f in range(m.feature_count[slot]):
        p = m.point[slot, f]
        if p < 0 or not m.has_depth[slot, f] or m.depth[slot, f] > max_depth:
            continue
        counted += 1
        if m.observations[p] <= min_observers:
            continue
        others = 0
        o = m.head[p]
        while o >= 0 and others < min_observers:
            s, g = o // capacity, o % capacity
            if s != slot and m.octave[s, g] <= m.octave[slot, f] + 1:
                others += 1
            o = m.next_observation[s, g]
        if others >= min_observers:
            redundant += 1
    return redundant / max(counted, 1)


@njit(cache=True, nogil=True)
def covisible_pairs(
    head: NDArray[np.int32],
    point: NDArray[np.int32],
    next_observation: NDArray[np.int32],
    keyframe_slot: NDArray[np.int32],
    slot_keyframe: NDArray[np.int32],
    least: int,
) -> NDArray[np.int32]:
    """(e, 2) pairs of keyframes, the earlier first, that share at least so many points.

    Args:
        head: (P,) first observation of each point.
        point, next_observation: (S, F) see `MapColumns`.
        keyframe_slot: (K,).
        slot_keyframe: (S,).
        least: shared points.
    """
    capacity = point.shape[1]
    keyframes = keyframe_slot.shape[0]
    pairs = np.empty((max(8 * keyframes, 16), 2), np.int32)
    count = 0
    shared = np.zeros(keyframes, np.int32)
    touched = np.empty(keyframes, np.int32)
    for k in range(keyframes):
        if keyframe_slot[k] < 0:
            continue
        n = 0
        for f in range(capacity):
            p = point[keyframe_slot[k], f]
            o = head[p] if p >= 0 else -1
            while o >= 0:
                slot = o // capacity
                other = slot_keyframe[slot]
                if other > k:
                    if shared[other] == 0:
                        touched[n] = other
                        n += 1
                    shared[other] += 1
                o = next_observation[slot, o % capacity]
        for i in range(n):
            other = touched[i]
            if shared[other] >= least:
                if count == pairs.shape[0]:
                    grown = np.empty((2 * count, 2), np.int32)
                    grown[:count] = pairs
                    pairs = grown
                pairs[count, 0], pairs[count, 1] = k, other
                count += 1
            shared[other] = 0
    return pairs[:count].copy()
