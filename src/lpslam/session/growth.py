"""How far a map has grown, for whoever watches it."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.ground.scans import Scans
from lpslam.slam.map import SlamMap
from lpslam.slam.trajectory import Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """A growing map at one moment; nothing in it changes later.

    Attributes:
        poses: (n, 4, 4) `world_from_camera` of all tracked frames, in order of time.
        keyframes: `world_from_keyframe`, 4×4, of the keyframes that have a scan and a place in the map frame.
        scans: new scans, as `Scans.to_arrays` gives them.
    """

    poses: NDArray[np.float64]
    keyframes: Mapping[int, NDArray[np.float64]]
    scans: Mapping[str, NDArray[Any]]


def growth_of(
    slam: SlamMap, trajectory: Trajectory, scans: Scans | None, known: Collection[int], most: int | None = None
) -> Growth:
    """How far a map has grown.

    Args:
        slam, trajectory, scans: of the map.
        known: keyframes whose scans whoever asks has already.
        most: new scans that are given at once; all of them without.
    """
    _, poses = trajectory.world_from_camera(slam)
    kept = [] if scans is None else [each for each in scans.keyframes if slam.is_alive(each)]
    new = [each for each in kept if each not in known][:most]
    at_home = {each: slam.world_from_keyframe(each) for each in kept if slam.is_home(each)}
    return Growth(poses, at_home, {} if scans is None else scans.to_arrays(new))


def submap_count(slam: SlamMap) -> int:
    """Parts of a map that are not joined; whoever asks holds its lock."""
    return len(np.unique(slam.submaps()[slam.living_keyframes()]))
