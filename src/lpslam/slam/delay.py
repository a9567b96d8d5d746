"""How much later than the colour image its depth was taken, found while running.

Few cameras measure depth at the instant of the colour image, and not all of them say so. In motion depth then lies
beside what it belongs to: at a radian a second and 20 ms by ten pixels. What a map point's depth should be is known; so
the depth image is read where the point was or will be some milliseconds away, for many such times, and the time at
which most points agree is the delay.

Only slanted and curved surfaces that move through the view tell, and what comes nearer. A camera that always moves the
same way tells nothing: there a delay cannot be told from depth that is registered beside the colour, so views that move
one way and the other are asked in equal parts.
"""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import DepthDelayConfig, FeatureConfig
from lpslam.slam.kernels.image import sample_depth
from lpslam.slam.medians import weighted_median
from lpslam.slam.sensor import SensorModel

_Matrix = NDArray[np.float64]


class PointsInView(NamedTuple):
    """Points of the map seen in one frame.

    Attributes:
        pixels: (n, 2) undistorted, as seen.
        depth: (n,) metres, of the points as the map has them.
        image: (height, width) metres.
        twist: (6,) of the world in the camera frame, a second.
    """

    pixels: NDArray[np.float32]
    depth: _Matrix
    image: NDArray[np.float32]
    twist: _Matrix


class _Vote(NamedTuple):
    """What one frame says: seconds, 1/σ² of it, and the mean motion of its points in pixels a second (2,)."""

    seconds: float
    weight: float
    motion: _Matrix


class DepthDelay:
    """Estimates the delay of depth behind colour.

    Args:
        camera, sensor: of the colour image.
        features: which depths are trusted.
        config: thresholds.

    Attributes:
        seconds: the delay, negative where depth comes first; 0 while nothing else is certain.
    """

    def __init__(
        self, camera: PinholeCamera, sensor: SensorModel, features: FeatureConfig, config: DepthDelayConfig
    ) -> None:
        self._camera = camera
        self._sensor = sensor
        self._features = features
        self._config = config
        self.seconds = 0.0
        self._candidates = np.linspace(-config.longest, config.longest, 2 * config.steps + 1)
        self._votes: deque[_Vote] = deque(maxlen=config.views)
        self._noted_at = -np.inf

    @property
    def reason(self) -> str:
        """What is known of it, in words."""
        if self.seconds == 0.0:
            return "depth and colour are taken together after all"
        order = "after" if self.seconds > 0 else "before"
        return f"depth is taken {1000 * abs(self.seconds):.0f} ms {order} colour"

    def is_due(self, timestamp: float, twist: _Matrix) -> bool:
        """Whether a frame should be asked: it moves, and none was asked just before."""
        config = self._config
        interval = config.settled_interval if len(self._votes) == config.views else config.interval
        moves = self._sensor.intrinsics[0] * float(np.linalg.norm(twist[3:]) + np.linalg.norm(twist[:3]) / _FAR)
        return timestamp - self._noted_at >= interval and moves > config.least_motion

    def note(self, timestamp: float, seen: PointsInView) -> bool:
        """Ask a frame; returns whether the delay is another one by it."""
        self._noted_at = timestamp
        vote = self._vote(seen)
        if vote is None:
            return False
        self._votes.append(vote)
        return self._reconsider()

    def _vote(self, seen: PointsInView) -> _Vote | None:
        config = self._config
        read, nearer, motion = self._depths(seen)
        usable = (read > 0).all(axis=0)
        if np.count_nonzero(usable) < config.min_points:
            return None
        z = seen.depth[usable]
        off = (read[:, usable] - nearer[:, usable] - z) / self._sensor.depth_sigma_at(z)
        cost = np.minimum(np.square(off), _GATE).sum(axis=1)
        least = int(cost.argmin())
        if not 0 < least < len(cost) - 1:
            return None
        before, here, after = cost[least - 1 : least + 2]
        bend = before + after - 2.0 * here
        step = self._candidates[1] - self._candidates[0]
        if bend <= 0.0 or 2.0 * step**2 / bend > config.largest_sigma**2:
            return None
        seconds = self._candidates[least] + 0.5 * step * (before - after) / bend
        return _Vote(float(seconds), float(bend / (2.0 * step**2)), motion[usable].mean(axis=0))

    def _depths(self, seen: PointsInView) -> tuple[_Matrix, _Matrix, _Matrix]:
        """Depths (k, n) read for every candidate, what the motion adds to them (k, n), and pixels a second (n, 2)."""
        fx, fy, cx, cy, _ = self._sensor.intrinsics
        z = seen.depth
        rays = (seen.pixels - np.array([cx, cy])) / np.array([fx, fy])
        points = np.column_stack([rays * z[:, None], z])
        speed = np.cross(seen.twist[3:], points) + seen.twist[:3]
        motion: _Matrix = (speed[:, :2] - rays * speed[:, 2:]) / z[:, None] * np.array([fx, fy])
        at = seen.pixels + self._candidates[:, None, None] * motion
        raw = self._camera.distort(at.reshape(-1, 2)).astype(np.float32)
        trusted = self._features
        read = sample_depth(
            seen.image, raw, trusted.depth_edge_radius, trusted.depth_edge_tolerance, trusted.min_depth,
            trusted.max_depth,
        )  # fmt: skip
        return read.reshape(at.shape[:2]).astype(np.float64), np.outer(self._candidates, speed[:, 2]), motion

    def _reconsider(self) -> bool:
        """Whether views that move one way and views that move the other agree on another delay."""
        config = self._config
        motions = np.array([vote.motion for vote in self._votes])
        axis = np.linalg.eigh(motions.T @ motions)[1][:, 1]
        ways = motions @ axis > 0
        middles, variances = [], []
        for way in (ways, ~ways):
            if np.count_nonzero(way) < config.min_views:
                return False
            values, weights = np.array([vote[:2] for vote, of in zip(self._votes, way, strict=True) if of]).T
            middles.append(middle := weighted_median(values, weights))
            share = weights / weights.sum()
            variances.append((1.5 * weighted_median(np.abs(values - middle), weights)) ** 2 * np.square(share).sum())
        seconds, sigma = float(np.mean(middles)), 0.5 * float(np.sqrt(sum(variances)))
        if abs(seconds - self.seconds) <= max(config.least_change, config.certain_sigmas * sigma):
            return False
        self.seconds = seconds if abs(seconds) > config.least_change else 0.0
        return True


_GATE = 9.0
"""χ² at which a depth that does not fit counts no more."""

_FAR = 2.0
"""Metres at which a metre a second counts as half a radian a second."""
