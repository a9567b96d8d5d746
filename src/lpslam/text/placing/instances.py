"""From a class's observations to the places where it stands (paper, III-H)."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage

from lpslam.config import InstanceConfig

Array = NDArray[np.float64]

# Share of a distance that rounding leaves below it.
_SURELY_WITHIN = 1.0 - 1e-9

# Takes a keyframe's id to the 4×4 `world_from_keyframe` as the map knows it now. It is asked for every keyframe that a
# text was hung on, also one that the map has culled since. None is a keyframe whose place in the map is not known.
KeyframePoses = Callable[[int], Array | None]


def trimmed_position(positions: Array, rounds: int, drop_share: float) -> tuple[Array, NDArray[np.intp]]:
    """Average positions without their outliers (III-H).

    In each round the mean, which is the optimum of least squares, is taken, and the farthest share from it is dropped
    (rounded down, so fewer than five observations all stay).

    Args:
        positions: (n, 3) metres, n >= 1.
        rounds: the paper's N.
        drop_share: the paper's 20 %.

    Returns:
        The mean (3,) of those kept, and their row numbers, ascending.
    """
    kept = np.arange(len(positions))
    for _ in range(rounds):
        remaining = len(kept) - int(len(kept) * drop_share)
        if remaining == len(kept):
            break
        distances = np.linalg.norm(positions[kept] - positions[kept].mean(axis=0), axis=1)
        kept = np.sort(kept[np.argsort(distances, kind="stable")[:remaining]])
    return positions[kept].mean(axis=0), kept


def split_places(
    positions: Array, normals: Array, frames: NDArray[np.int64], config: InstanceConfig
) -> list[NDArray[np.intp]]:
    """Split the observations of one class by where they stand and where they face.

    One class may hang in several places: every exit says EXIT. Average linkage puts together what is nearer than
    `place_distance`; facing counts as a distance too, so the two faces of a pillar are two places. Only the two sides
    of something thin, a hanging sign, are one.

    Args:
        positions: (n, 3) metres, world.
        normals: (n, 3) unit, world.
        frames: (n,) in which frame each was seen. What was seen twice in one frame stands in two places.
        config: distances.

    Returns:
        Row numbers of each place, in the order of their first observation.
    """
    # Opposite normals are 2 apart.
    features = np.hstack([positions, normals * (config.facing_distance / 2.0)])
    places = []
    for rows in _linked(features, np.arange(len(features)), config.place_distance):
        # Facing told them apart already: within a frame it is noise.
        apart = _distance_within_frames(positions[rows], frames[rows])
        places += _linked(positions, rows, 0.5 * apart) if apart is not None else [rows]
    places = _both_sides(places, positions, normals, config.sign_thickness)
    return sorted(places, key=lambda rows: int(rows[0]))


def _linked(features: Array, rows: NDArray[np.intp], distance: float) -> list[NDArray[np.intp]]:
    own = features[rows]
    # No mean distance is longer than the diagonal of the box around all: what fits in is one place, without linking.
    if len(rows) < 2 or np.linalg.norm(np.ptp(own, axis=0)) < _SURELY_WITHIN * distance:
        return [rows]
    labels = fcluster(linkage(own, "average"), distance, "distance")
    return [rows[labels == label] for label in np.unique(labels)]


def _both_sides(
    places: list[NDArray[np.intp]], positions: Array, normals: Array, thickness: float
) -> list[NDArray[np.intp]]:
    """Join places that stand back to back no farther apart than a sign is thick."""
    if len(places) == 1:
        return places
    joined: list[NDArray[np.intp]] = []
    for rows in sorted(places, key=len, reverse=True):
        middle, facing = positions[rows].mean(axis=0), normals[rows].mean(axis=0)
        for number, other in enumerate(joined):
            near = np.linalg.norm(positions[other].mean(axis=0) - middle) <= thickness
            if near and normals[other].mean(axis=0) @ facing < 0.0:
                joined[number] = np.sort(np.concatenate([other, rows]))
                break
        else:
            joined.append(rows)
    return joined


def _distance_within_frames(positions: Array, frames: NDArray[np.int64]) -> float | None:
    """How far apart sightings of the same frame are, if two or more frames saw the class more than once."""
    if len(set(frames.tolist())) == len(frames):
        return None
    first, second = np.triu_indices(len(frames), 1)
    same = frames[first] == frames[second]
    if len(np.unique(frames[first[same]])) < 2:
        return None
    return float(np.median(np.linalg.norm(positions[first[same]] - positions[second[same]], axis=1)))
