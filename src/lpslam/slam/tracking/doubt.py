"""Whether the camera is where it was found again: look-alike places are told apart by what stands written there."""

import numpy as np

from lpslam.slam.advice import LoopAdvisor
from lpslam.slam.map import SlamMap


class Doubt:
    """Open after a relocalisation in a map of which an advisor knows more than its looks.

    While it is open nothing is mapped, so that a wrong place can be given up as if it had never been found.

    Args:
        slam_map: in which the camera was found; its lock is held by whoever calls.
        advisor: judges the place.
        seconds: after which an advisor that says nothing is not waited for any more.
        enough: map points that tell a place by themselves.

    Attributes:
        since: time in seconds at which the camera was found again; infinite while nothing is doubted.
        placed_since: time of the first frame whose pose rests on that place: it may have come before.
    """

    def __init__(self, slam_map: SlamMap, advisor: LoopAdvisor, seconds: float, enough: int) -> None:
        self._map = slam_map
        self._advisor = advisor
        self._seconds = seconds
        self._enough = enough
        self._rests_on_one_sign = False
        self._held: list[int] = []
        self.since = self.placed_since = np.inf

    @property
    def is_open(self) -> bool:
        """Whether the place is not believed yet."""
        return bool(np.isfinite(self.since))

    def begin(self, keyframe: int, timestamp: float, rests_on_one_sign: bool = False) -> None:
        """Doubt that the camera is near a keyframe, if there is anything to judge that by.

        A place that rests on one sign, and on shapes as there are many, is doubted until another sign or looks tell it.
        """
        self._rests_on_one_sign = rests_on_one_sign
        if self._advisor.knows(self._map, keyframe):
            self.since = self.placed_since = timestamp

    def reach_back(self, timestamp: float) -> None:
        """Frames from a time on, in seconds, have poses since the camera was found."""
        self.placed_since = min(self.placed_since, timestamp)

    def settle(self, keyframe: int, timestamp: float) -> bool | None:
        """Ask the advisor: whether the camera is near a keyframe; None while nobody knows. The answer ends the doubt.

        Args:
            keyframe: the reference.
            timestamp: of the frame, in seconds.
        """
        is_right = self._advisor.judges(self._map, keyframe, self.since)
        has_waited = timestamp - self.since > self._seconds and not self._rests_on_one_sign
        if is_right is not None or has_waited:
            self.end()
        return is_right

    def matched(self, points: int) -> None:
        """So many map points were matched with a frame."""
        self._rests_on_one_sign &= points < self._enough

    def end(self) -> None:
        """Doubt no more."""
        self.since = np.inf

    def hold(self, keyframe: int) -> None:
        """Take a new keyframe, which is to be worked into the map."""
        self._held.append(keyframe)

    def released(self) -> list[int]:
        """The new keyframes that may be worked into the map; while the place is doubted they are held back."""
        if self.is_open:
            return []
        released, self._held = self._held, []
        return released

    def take_back(self, reference: int) -> int:
        """Remove the keyframes that are held back: the place is another one. Returns the reference that is left."""
        for keyframe in reversed(self._held):
            if self._map.is_alive(keyframe) and not self._map.is_root(keyframe):
                self._map.remove_keyframe(keyframe)
        self._held.clear()
        return self._map.living_ancestor(reference)
