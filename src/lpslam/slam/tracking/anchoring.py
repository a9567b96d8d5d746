"""When a frame that was followed by optical flow is matched with the map anyway."""

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import TrackingConfig
from lpslam.slam.features import Features
from lpslam.slam.sensor import SensorModel
from lpslam.slam.tracking.guesses import Followed


class Anchoring:
    """Judges by what the frames show: how far the picture has moved since the last match, and what is left of it.

    A camera that stands needs no new match, one that turns quickly needs one at every frame: flow follows only what
    was in view at the last match, and a keyframe can only be made of a frame that was matched.
    """

    def __init__(self, sensor: SensorModel, config: TrackingConfig) -> None:
        self._sensor = sensor
        self._config = config
        self._at = -np.inf
        self._travel = 0.0
        self._step = 0.0
        self._surprise = 0.0
        self._smear = 0.0
        self._followed_first = 0
        self._nearness = 1.0

    def matched(self, timestamp: float) -> None:
        """A frame was matched with the map."""
        self._at, self._travel = timestamp, 0.0

    def begin_following(self, timestamp: float, asked: int) -> None:
        """So many keypoints of the frame at a time are looked for in the next one."""
        if self._at == timestamp:
            self._followed_first = asked

    def moved(
        self, before: NDArray[np.float64], now: NDArray[np.float64], predicted: NDArray[np.float64], seconds: float
    ) -> None:
        """Take a frame's pose, that of the frame some seconds before and the one predicted: camera from world, 4×4."""
        self._step = self.pixels(before, now)
        self._smear = self._step * min(self._config.longest_exposure / seconds, 1.0)
        self._travel += self._step
        self._surprise = max(self.pixels(predicted, now), _MEMORY * self._surprise)

    def saw(self, features: Features) -> None:
        """Take keypoints: how near things are decides how far the picture moves when the camera does."""
        if features.has_depth.any():
            self._nearness = 1.0 / float(np.median(features.depth[features.has_depth]))

    def is_due(self, timestamp: float) -> bool:
        """Whether a frame will be matched whatever flow says: the picture has moved on, or time has passed."""
        config = self._config
        return (
            self._travel + self._step > config.anchor_travel * self._sensor.image_size[0]
            or timestamp - self._at >= config.anchor_interval
        )

    @property
    def may_be_blurred(self) -> bool:
        """Whether the picture moves so far while a frame is exposed, as long as that may take, that it is blurred."""
        return self._smear > self._config.pictured_travel * self._sensor.image_size[0]

    @property
    def is_steady(self) -> bool:
        """Whether constant velocity has lately said well where points would be seen."""
        return self._surprise < self._config.steady_share * self._config.motion_radius

    def may_be_one_way(self, one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
        """Whether a camera that was not seen for a moment may have gone from one pose to another, not been carried."""
        return self.pixels(one, other) <= self._config.bridged_travel * self._sensor.image_size[0]

    def is_failing(self, followed: Followed) -> bool:
        """Whether too little is left of what was followed first, or one motion does not explain it."""
        config, left = self._config, followed.estimate.inliers
        return (
            left < max(config.min_followed, config.min_followed_share * self._followed_first)
            or followed.estimate.matches < config.min_followed
            or followed.estimate.agreement < config.min_agreement
        )

    def pixels(self, one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
        """By how many pixels the picture moves between two poses (camera from world, 4×4), about."""
        relative = other @ inverse_transform(one)
        cosine = 0.5 * (float(np.trace(relative[:3, :3])) - 1.0)
        angle = float(np.arccos(min(max(cosine, -1.0), 1.0)))
        return float(self._sensor.intrinsics[0]) * (angle + float(np.linalg.norm(relative[:3, 3])) * self._nearness)


_MEMORY = 0.8
"""Share of the last surprise that is expected again: after ten steady frames it is a tenth."""
