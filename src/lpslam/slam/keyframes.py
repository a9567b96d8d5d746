"""When a frame becomes a keyframe (ORB-SLAM2, III-E)."""

import numpy as np
from numpy.typing import NDArray

from lpslam.config import KeyframeConfig
from lpslam.slam.features import Features


class KeyframePolicy:
    """Asks for keyframes where the view has moved on or close points are missing, not more often than useful.

    How far the view has moved is the share of matches left of the most since the last keyframe: unlike the points of
    the reference keyframe, that does not depend on how many keyframes have confirmed them.
    """

    def __init__(self, config: KeyframeConfig) -> None:
        self._config = config
        self._last_time = -np.inf
        self._most_matches = 0

    def wants(self, timestamp: float, features: Features, is_matched: NDArray[np.bool_]) -> bool:
        """Judge a tracked frame.

        Args:
            timestamp: seconds.
            features: its keypoints, n rows.
            is_matched: (n,) which of them see a map point.
        """
        config = self._config
        matches = int(is_matched.sum())
        self._most_matches = max(self._most_matches, matches)
        elapsed = timestamp - self._last_time
        if elapsed < config.min_interval:
            return False
        close = features.has_depth & (features.depth < config.close_depth)
        tracked, untracked = int((close & is_matched).sum()), int((close & ~is_matched).sum())
        needs_close = tracked < config.close_tracked and untracked > config.close_untracked
        thinned = matches < config.tracked_share * self._most_matches
        due = elapsed >= config.max_interval and matches < config.due_share * self._most_matches
        return thinned or needs_close or due

    def made(self, timestamp: float) -> None:
        """Note that a keyframe was made."""
        self._last_time = timestamp
        self._most_matches = 0
