"""One run over a recording, and how it compares with the truth."""

import time
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.evaluation.trajectory import AteResult, absolute_trajectory_error
from lpslam.frames import RgbdFrame
from lpslam.poses import StampedPoses
from lpslam.slam.map import SlamMap
from lpslam.slam.state import EventKind, TrackedFrame
from lpslam.slam.system import RgbdSlam

WRONG_LOOP = (0.1, 3.0)  # metres, degrees: a tie between keyframes that is farther off is a wrong one


@dataclass(frozen=True)
class Run:
    """A finished run.

    Attributes:
        frames, tracked: how many came, and how many have a pose in the map.
        tracking_ms: (n,) processor time of the frames that did not become keyframes.
        all_ms: (frames,) of all.
    """

    slam: RgbdSlam
    frames: int
    estimate: StampedPoses
    tracking_ms: NDArray[np.float64]
    all_ms: NDArray[np.float64]

    @property
    def tracked(self) -> int:
        """Frames with a pose in the map."""
        return len(self.estimate)

    def ate(self, truth: StampedPoses) -> AteResult:
        """The trajectory's error."""
        return absolute_trajectory_error(truth, self.estimate)

    def count(self, kind: EventKind) -> int:
        """How often something happened."""
        return sum(event.kind is kind for event in self.slam.events)

    def wrong_loops(self, truth: StampedPoses) -> int:
        """Ties whose keyframes do not stand to each other as they do in truth."""
        return sum(
            metres > WRONG_LOOP[0] or degrees > WRONG_LOOP[1]
            for metres, degrees in (_tie_error(self.slam.map, truth, a, b) for a, b in self.slam.map.loop_edges)
        )

    def closing_gap(self, truth: StampedPoses) -> float:
        """Metres by which the last pose is wrong as seen from where the camera was there before; NaN if never."""
        last = self.estimate.world_from_camera[-1]
        early = self.estimate.timestamps < self.estimate.timestamps[0] + 0.4 * np.ptp(self.estimate.timestamps)
        true_last = true_pose(truth, self.estimate.timestamps[-1])
        true_early = np.array([true_pose(truth, t) for t in self.estimate.timestamps[early]])
        away = np.linalg.norm(true_early[:, :3, 3] - true_last[:3, 3], axis=1)
        nearest = int(away.argmin())
        if away[nearest] > 1.0:
            return float("nan")
        seen = inverse_transform(self.estimate.world_from_camera[early][nearest]) @ last
        return pose_error(seen, inverse_transform(true_early[nearest]) @ true_last)[0]


@dataclass
class Clock:
    """Processor time of frames."""

    tracking_ms: list[float] = field(default_factory=list)
    all_ms: list[float] = field(default_factory=list)

    def process(self, slam: RgbdSlam, frame: RgbdFrame) -> TrackedFrame:
        """Process a frame while the clock of this thread runs."""
        before = time.thread_time()
        tracked = slam.process(frame)
        spent = 1000.0 * (time.thread_time() - before)
        self.all_ms.append(spent)
        if not tracked.is_keyframe:
            self.tracking_ms.append(spent)
        return tracked


def run(slam: RgbdSlam, frames: Iterable[RgbdFrame]) -> Run:
    """Process all frames in step."""
    clock = Clock()
    for frame in frames:
        clock.process(slam, frame)
    slam.finish()
    poses = StampedPoses(*slam.trajectory.world_from_camera(slam.map))
    return Run(slam, len(clock.all_ms), poses, np.array(clock.tracking_ms), np.array(clock.all_ms))


def true_pose(truth: StampedPoses, timestamp: float) -> NDArray[np.float64]:
    """World from camera (4×4) at the true pose nearest in time."""
    return np.asarray(truth.world_from_camera[np.abs(truth.timestamps - timestamp).argmin()])


def pose_error(pose: NDArray[np.float64], true: NDArray[np.float64]) -> tuple[float, float]:
    """Metres and degrees between two poses."""
    off = inverse_transform(true) @ pose
    degrees = np.degrees(np.arccos(np.clip((np.trace(off[:3, :3]) - 1) / 2, -1, 1)))
    return float(np.linalg.norm(off[:3, 3])), float(degrees)


def _tie_error(slam_map: SlamMap, truth: StampedPoses, a: int, b: int) -> tuple[float, float]:
    true_a, true_b = (true_pose(truth, slam_map.frame_of(k)[1]) for k in (a, b))
    b_from_a = slam_map.camera_from_world(b) @ slam_map.world_from_keyframe(a)
    return pose_error(b_from_a, inverse_transform(true_b) @ true_a)
