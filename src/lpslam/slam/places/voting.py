"""Keyframes that say the same of where a place is: several must, each by its own keypoints."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import LoopConfig
from lpslam.slam.advice import Recalled
from lpslam.slam.map import SlamMap
from lpslam.slam.places.located import Located
from lpslam.slam.places.locating import Locator
from lpslam.slam.places.loop_correction import Tie

_Matrix = NDArray[np.float64]


@dataclass(slots=True)
class Hypothesis:
    """A place that was found again, and the keyframes that say so.

    Attributes:
        ties: of the keyframes that agree, the newest first.
        inliers: of the newest.
        version: of the map in which they were located.
        is_told: something else than appearance says it.
        missed: keyframes since that did not see the place.
    """

    ties: list[Tie]
    inliers: int
    version: int
    is_told: bool = False
    missed: int = 0


class Voting:
    """Gathers votes for a place.

    Args:
        slam_map: in which it is.
        locator: verifies votes.
        config: thresholds.
        locate: locates one keyframe at a place, in what is old for another.
        reject: told why a vote was none.
    """

    def __init__(
        self,
        slam_map: SlamMap,
        locator: Locator,
        config: LoopConfig,
        locate: Callable[[int, Recalled, int], Located | None],
        reject: Callable[[str], None],
    ) -> None:
        self._map, self._locator, self._config = slam_map, locator, config
        self._locate, self._reject = locate, reject

    def joined(self, pending: Hypothesis | None, keyframe: int, located: Located, version: int) -> Hypothesis:
        """Add a keyframe to those that found the same correction before; another correction begins anew."""
        tie = Tie(keyframe, located.keyframe, located.camera_from_world, located.points)
        if (
            pending is None
            or pending.version != version
            or not all(self._same_correction(tie, other) for other in pending.ties)
        ):
            return Hypothesis([tie], located.inliers, version, located.is_told)
        others = [other for other in pending.ties if self._map.is_alive(other.keyframe)]
        kept = [other for other in others if self._is_another_view(tie.keyframe, other.keyframe)]
        return Hypothesis([tie, *kept], located.inliers, version, located.is_told or pending.is_told)

    def ask_neighbours(self, hypothesis: Hypothesis) -> None:
        """Locate covisible keyframes too: quicker than to wait for the next ones."""
        slam_map, config, first = self._map, self._config, hypothesis.ties[0]
        asked = 0
        with slam_map.lock:
            neighbours = slam_map.covisible(first.keyframe, config.covisible_points).tolist()
        for neighbour in neighbours:
            if len(hypothesis.ties) >= config.votes or asked >= config.vote_neighbours:
                return
            if not all(self._is_another_view(neighbour, tie.keyframe) for tie in hypothesis.ties):
                continue
            asked += 1
            located = self._locate(neighbour, self._seen_beside(neighbour, hypothesis), first.keyframe)
            if located is None:
                continue
            tie = Tie(neighbour, located.keyframe, located.camera_from_world, located.points)
            if not self._same_correction(first, tie):
                self._reject("neighbours disagree")
                return
            hypothesis.ties.append(tie)

    def _seen_beside(self, neighbour: int, hypothesis: Hypothesis) -> Recalled:
        """Where a covisible keyframe is sought: where it must be, if more than appearance says where the first is."""
        first = hypothesis.ties[0]
        if not hypothesis.is_told:
            return Recalled(first.candidate)
        with self._map.lock:
            old_from_new_world = first.old_from_new_world(self._map)
            expected = self._map.camera_from_world(neighbour) @ inverse_transform(old_from_new_world)
        return Recalled(first.candidate, expected)

    def is_mutual(self, tie: Tie, is_told: bool) -> bool:
        """Whether the old keyframe is located in the new part as well, at the pose that follows."""
        slam_map = self._map
        with slam_map.lock:
            if not (slam_map.is_alive(tie.keyframe) and slam_map.is_alive(tie.candidate)):
                return False
            new = np.zeros(slam_map.keyframe_count, np.bool_)
            new[slam_map.covisible(tie.keyframe, 1)] = True
            expected = slam_map.camera_from_world(tie.candidate) @ tie.old_from_new_world(slam_map)
            located = self._locator.locate(
                slam_map.features(tie.candidate),
                tie.keyframe,
                new,
                guess=expected if is_told else None,
                is_anywhere=False,
            )
        return located is not None and self.agree(located.camera_from_world, expected)

    def _same_correction(self, one: Tie, other: Tie) -> bool:
        """Whether two keyframes ask for the same correction, judged where the first one stands."""
        slam_map = self._map
        with slam_map.lock:
            submaps = slam_map.submaps()
            if submaps[one.candidate] != submaps[other.candidate] or submaps[one.keyframe] != submaps[other.keyframe]:
                return False
            moved = slam_map.camera_from_world(one.keyframe) @ inverse_transform(other.old_from_new_world(slam_map))
        return self.agree(one.camera_from_world, moved)

    def agree(self, one: _Matrix, other: _Matrix) -> bool:
        """Whether two poses (4×4) are the same but for noise."""
        metres, degrees = apart(one, other)
        return metres <= self._config.agreement_distance and degrees <= self._config.agreement_turn

    def _is_another_view(self, keyframe: int, other: int) -> bool:
        slam_map, config = self._map, self._config
        with slam_map.lock:
            metres, degrees = apart(slam_map.camera_from_world(keyframe), slam_map.camera_from_world(other))
        return keyframe != other and (metres >= config.vote_distance or degrees >= config.vote_turn)


def apart(one: _Matrix, other: _Matrix) -> tuple[float, float]:
    """Metres and degrees between two 4×4 poses of a camera."""
    relative = one @ inverse_transform(other)
    turn = np.arccos(np.clip((np.trace(relative[:3, :3]) - 1) / 2, -1, 1))
    return float(np.linalg.norm(relative[:3, 3])), float(np.degrees(turn))
