"""How a map compares with what is known of its recording: trajectory error, share tracked, landmarks, reading."""

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lpslam.config import EvaluationConfig
from lpslam.errors import UserError
from lpslam.evaluation.landmarks import LandmarkScore, score_landmarks
from lpslam.evaluation.remembering import ReadingCost, reading_cost, remembering_delays
from lpslam.evaluation.signs import TrueSign, read_signs
from lpslam.evaluation.trajectory import AteResult, absolute_trajectory_error, align_poses
from lpslam.mapfile.language_map import LanguageMap
from lpslam.poses import StampedPoses
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Scores of one map.

    Attributes:
        ate: absolute trajectory error after rigid alignment without scale.
        path_length: metres, of the true trajectory over the time that is compared.
        frames, frames_mapped, frames_tracked: in the recording, seen by the run that made the map, and with a pose.
        landmarks: against the true signs; None where the recording lists none.
        delays: seconds from when each expected sign could first be read to when it was remembered, by its id; None for
            one that never was.
        reading: what reading cost; None where nothing was read.
    """

    ate: AteResult
    path_length: float
    frames: int
    frames_mapped: int
    frames_tracked: int
    landmarks: LandmarkScore | None
    delays: dict[int | str, float | None]
    reading: ReadingCost | None

    @property
    def median_delay(self) -> float | None:
        """Seconds, over the signs that were remembered; None without."""
        known = [delay for delay in self.delays.values() if delay is not None]
        return float(np.median(known)) if known else None

    @property
    def share_tracked(self) -> float:
        """Of the recording's frames."""
        return self.frames_tracked / max(self.frames, 1)


def evaluate_recording(
    world: LanguageMap, folder: Path, config: EvaluationConfig | None = None, camera_file: Path | None = None
) -> Evaluation:
    """Score a map against the ground truth in a recording's folder.

    Args:
        world: the map.
        folder: the recording that it was made of.
        config: when an estimate counts as right.
        camera_file: the calibration, for a recording without one.

    Raises:
        UserError: the recording cannot be opened or has no ground truth.
    """
    source = open_source(folder, camera_file)
    truth = read_ground_truth(folder)
    if truth is None:
        raise UserError(f"{folder} has no ground truth; looked for groundtruth.txt or frame-NNNNNN.pose.txt")
    frames, mapped = len(source), world.trajectory.frame_count
    if mapped > frames and not world.trajectory.session:
        raise UserError(
            f"the map is of {mapped} frames, and {folder} has {frames}: it was made of {world.source}; give that one"
        )
    if world.source and world.source != source.name and not world.trajectory.session:
        logger.warning("the map was made of %s and is scored against %s: are they the same?", world.source, source.name)
    return evaluate(world, truth, read_signs(folder), frames, config)


def evaluate(
    world: LanguageMap,
    truth: StampedPoses,
    signs: list[TrueSign] | None,
    frames: int,
    config: EvaluationConfig | None = None,
) -> Evaluation:
    """Score a map against true camera poses and, if there are any, true signs in the same frame.

    Raises:
        UserError: the map has fewer than three poses, or they and the true ones have too few frames in common.
    """
    config = config or EvaluationConfig()
    estimate = world.frame_poses()
    if len(estimate) < 3:
        raise UserError(f"map of {world.source}: {len(estimate)} tracked frames; the trajectory error needs at least 3")
    ate = absolute_trajectory_error(truth, estimate, config.association_tolerance)
    scored, delays = None, {}
    if signs is not None:
        truth_from_map = align_poses(truth, estimate, config.association_tolerance)
        scored = score_landmarks(world.landmarks(), signs, truth_from_map, config)
        long_term = world.text.long_term
        delays = remembering_delays(long_term, world.world_from_keyframe, signs, truth_from_map, config)
    seconds = float(np.ptp(estimate.timestamps))
    return Evaluation(
        ate=ate,
        path_length=_path_length(truth, ate),
        frames=frames,
        frames_mapped=world.trajectory.frame_count,
        frames_tracked=len(estimate),
        landmarks=scored,
        delays=delays,
        reading=reading_cost(world.statistics.get("reading", {}), seconds),
    )


def _path_length(truth: StampedPoses, ate: AteResult) -> float:
    """Metres walked between the first and the last pose that were compared."""
    first, last = np.argmin(np.abs(truth.timestamps[:, None] - ate.timestamps[[0, -1]]), axis=0)
    return StampedPoses(truth.timestamps[first : last + 1], truth.world_from_camera[first : last + 1]).path_length
