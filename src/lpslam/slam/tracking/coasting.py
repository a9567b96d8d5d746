"""Going on for a moment by the motion alone, where a frame shows too little to say where it was taken."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.slam.kernels.geometry import exponential, logarithm
from lpslam.slam.map import SlamMap

_Matrix = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class Coasting:
    """The frames that are passed over since the last one with a pose of its own.

    Args:
        seconds: for which it is believed; by then the camera may be anywhere.

    Attributes:
        since: time of the first such frame; None while there is none.
    """

    seconds: float
    since: float | None = None
    _frames: list[tuple[int, float]] = field(default_factory=list)

    def goes_on(self, timestamp: float) -> bool:
        """Whether a frame that shows too little may be passed over."""
        return self.seconds > 0.0 and (self.since is None or timestamp - self.since <= self.seconds)

    def pass_over(self, index: int, timestamp: float) -> None:
        """Take a frame that gets the pose that the motion predicts, until it is known better."""
        if self.since is None:
            self.since = timestamp
        self._frames.append((index, timestamp))

    def end(self) -> None:
        """Forget them: the camera was found again, or is lost."""
        self.since = None
        self._frames.clear()

    def bridged(
        self,
        slam_map: SlamMap,
        reference: int,
        before: tuple[float, _Matrix],
        after: tuple[float, _Matrix],
    ) -> dict[int, _Matrix]:
        """Poses in a keyframe's frame (4×4), by frame index, on the even way between two known poses.

        Args:
            slam_map: of the keyframe.
            reference: on which the frames hang.
            before, after: seconds and camera from world (4×4) of the last frame and of the next one that were seen.
        """
        (started, first), (ended, last) = before, after
        velocity = logarithm(last @ inverse_transform(first)) / max(ended - started, 1e-6)
        reference_from_world = slam_map.camera_from_world(reference)
        return {
            index: reference_from_world @ inverse_transform(exponential(velocity * (timestamp - started)) @ first)
            for index, timestamp in self._frames
        }
