"""Watches tracked frames for depth that comes later or earlier than its colour, and says so."""

import numpy as np
from numpy.typing import NDArray

from lpslam.config import DepthDelayConfig
from lpslam.slam.association import Estimate
from lpslam.slam.delay import DepthDelay, PointsInView
from lpslam.slam.kernels.reprojection import MIN_DEPTH
from lpslam.slam.state import EventKind
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.whereabouts import Whereabouts


class DelayWatch:
    """Hands to the estimator what the map knows of a frame.

    Args:
        where: the camera is.
        delay: the estimator.
        config: which points are asked, and how many.
    """

    def __init__(self, where: Whereabouts, delay: DepthDelay, config: DepthDelayConfig) -> None:
        self._where = where
        self._delay = delay
        self._config = config

    def note(self, picture: Picture, estimate: Estimate, twist: NDArray[np.float64]) -> None:
        """Take a frame that was matched with the map, and its velocity (6,) a second."""
        if not self._delay.is_due(picture.timestamp, twist):
            return
        m, pose, config = self._where.map.columns, estimate.camera_from_world, self._config
        rows = np.flatnonzero((estimate.points >= 0) & (m.observations[estimate.points] >= config.min_observers))
        if len(rows) > config.most_points:
            # Keypoints come level by level: evenly chosen ones are of all levels and parts of the image.
            rows = rows[np.linspace(0, len(rows) - 1, config.most_points).astype(np.int64)]
        depth = m.position[estimate.points[rows]] @ pose[2, :3] + pose[2, 3]
        before = depth > MIN_DEPTH
        seen = PointsInView(picture.seen.pixels[rows[before]], depth[before], picture.frame.depth, twist)
        if self._delay.note(picture.timestamp, seen):
            self._where.tell(EventKind.DEPTH_DELAY, picture.frame, self._delay.reason)
