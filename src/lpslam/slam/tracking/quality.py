"""What a frame is worth: what speaks against believing its pose, and what it shows at all, in words with figures."""

from lpslam.config import TrackingConfig
from lpslam.slam.association import Estimate
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.sharpness import UsualSharpness


class Quality:
    """Judges frames by their picture and by what was matched in it."""

    def __init__(self, config: TrackingConfig) -> None:
        self._config = config
        self._sharpness = UsualSharpness()

    def begin(self, picture: Picture) -> None:
        """Take a first frame for the measure of those that follow."""
        self._sharpness.begin(picture.frame)

    def weakness(self, picture: Picture, estimate: Estimate, is_sure: bool) -> str:
        """Why a tracked frame's pose is weak; empty if it is not. What is usual is learned from every such frame.

        Args:
            picture: of the frame.
            estimate: its pose.
            is_sure: whether most of what led to it agrees.
        """
        sharpness = self._sharpness.note(picture.frame)
        if estimate.matches < self._config.weak_inliers:
            return f"{estimate.matches} map points matched"
        if not is_sure:
            return "most of what was followed disagrees"
        if picture.is_repeated:
            return "its picture repeats the one before: it may be of a moment gone by"
        return self._sharpness.fault(picture.frame) if sharpness < self._config.blur_ratio else ""

    def shown(self, picture: Picture) -> str:
        """What a frame shows in which nothing was recognised."""
        features = picture.features
        parts = [f"{features.rows} keypoints"]
        if features.rows:
            parts.append(f"{features.has_depth.mean():.0%} of them with depth")
        if self._sharpness.share(picture.frame) < self._config.blur_ratio:
            parts.append(self._sharpness.fault(picture.frame))
        return ", ".join(parts)
