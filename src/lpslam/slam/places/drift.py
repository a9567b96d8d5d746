"""What the way between two places may have drifted by, and so which corrections it rules out."""

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import LoopConfig
from lpslam.slam.map import SlamMap
from lpslam.slam.places.located import Located
from lpslam.slam.places.voting import apart

_Matrix = NDArray[np.float64]


class Drift:
    """Judges where a keyframe was located by the way that led there.

    Args:
        slam_map: its keyframes are the way.
        config: how far a way drifts.
    """

    def __init__(self, slam_map: SlamMap, config: LoopConfig) -> None:
        self._map = slam_map
        self._config = config

    def allows(self, keyframe: int, located: Located) -> bool:
        """Whether the way since can have drifted so far.

        Between sub-maps the way is known where one began while the camera saw: in the moment without a place it cannot
        have gone far. What looks the same elsewhere is then no place of it, unless something else than looks tells it.
        """
        with self._map.lock:
            submaps = self._map.submaps()
            if submaps[keyframe] == submaps[located.keyframe]:
                return self._is_near(keyframe, located)
            return located.is_told or self._agrees_with_beginnings(keyframe, located)

    def _is_near(self, keyframe: int, located: Located) -> bool:
        config, length = self._config, self._way(keyframe, located.keyframe)
        metres, degrees = apart(self._map.camera_from_world(keyframe), located.camera_from_world)
        return metres <= self._allowance(length) and degrees <= config.turn_allowance + config.turn_rate * length

    def _agrees_with_beginnings(self, keyframe: int, located: Located) -> bool:
        """Whether sub-maps joined so begin where the camera can have been when they did."""
        slam_map, submaps = self._map, self._map.submaps()
        there_from_here = inverse_transform(located.camera_from_world) @ slam_map.camera_from_world(keyframe)
        for first, begun in slam_map.beginnings.items():
            ends = {int(submaps[first]): first, int(submaps[begun.keyframe]): begun.keyframe}
            here, there = ends.get(int(submaps[keyframe])), ends.get(int(submaps[located.keyframe]))
            if here is None or there is None or here == there:
                continue
            centres = {
                first: slam_map.world_from_keyframe(first)[:, 3],
                begun.keyframe: slam_map.world_from_keyframe(begun.keyframe) @ begun.keyframe_from_camera[:, 3],
            }
            moved = there_from_here @ centres[here] - centres[there]
            length = self._way(keyframe, here) + self._way(located.keyframe, there)
            if float(np.linalg.norm(moved)) > begun.metres + self._allowance(length):
                return False
        return True

    def _allowance(self, length: float) -> float:
        """Metres by which a way of so many may be off."""
        return self._config.drift_allowance + self._config.drift_share * length

    def _way(self, one: int, other: int) -> float:
        """Metres of the way from keyframe to keyframe of one sub-map."""
        submaps, living = self._map.submaps(), self._map.living_keyframes()
        first, last = sorted((one, other))
        way = living[(living >= first) & (living <= last) & (submaps[living] == submaps[one])]
        poses = self._map.columns.camera_from_world[way]
        centres = -np.einsum("nji,nj->ni", poses[:, :3, :3], poses[:, :3, 3])
        return float(np.linalg.norm(np.diff(centres, axis=0), axis=1).sum())
