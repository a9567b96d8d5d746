"""Watches tracked frames for depth that comes later or earlier than its colour, and says so."""

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.association import Estimate
from lpslam.slam.delay import DepthDelay, Sighted
from lpslam.slam.state import EventKind
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.whereabouts import Whereabouts


class DelayWatch:
    """Hands to the estimator what the map knows of a frame.

    Args:
        where: the camera is.
        delay: the estimator.
        min_observers: keyframes that must see a point.
    """

    def __init__(self, where: Whereabouts, delay: DepthDelay, min_observers: int) -> None:
        self._where = where
        self._delay = delay
        self._min_observers = min_observers

    def note(self, picture: Picture, estimate: Estimate, twist: NDArray[np.float64]) -> None:
        """Take a frame that was matched with the map, and its velocity (6,) a second."""
        if not self._delay.is_due(picture.timestamp, twist):
            return
        m = self._where.map.columns
        rows = np.flatnonzero((estimate.points >= 0) & (m.observations[estimate.points] >= self._min_observers))
        points, pose = estimate.points[rows], estimate.camera_from_world
        depth = m.position[points] @ pose[2, :3] + pose[2, 3]
        before, rows = rows, rows[depth > 0.0]
        depth = depth[np.isin(before, rows)]
        seen = Sighted(picture.seen.pixels[rows], depth, picture.frame.depth, twist)
        if self._delay.note(picture.timestamp, seen):
            self._where.tell(EventKind.DEPTH_DELAY, picture.frame, self._delay.reason)
