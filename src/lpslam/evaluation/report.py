"""How a map compares with what is known of its recording: trajectory error, share tracked, landmarks."""

from dataclasses import dataclass
from pathlib import Path

from lpslam.config import EvaluationConfig
from lpslam.errors import UserError
from lpslam.evaluation.landmarks import LandmarkScore, score_landmarks
from lpslam.evaluation.signs import TrueSign, read_signs
from lpslam.evaluation.trajectory import AteResult, absolute_trajectory_error
from lpslam.mapfile.language_map import LanguageMap
from lpslam.poses import StampedPoses
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Scores of one map.

    Attributes:
        ate: absolute trajectory error after rigid alignment without scale.
        path_length: metres, of the true trajectory.
        frames, frames_tracked: in the recording, and with a pose.
        landmarks: against the true signs; None where the recording lists none.
    """

    ate: AteResult
    path_length: float
    frames: int
    frames_tracked: int
    landmarks: LandmarkScore | None

    @property
    def share_tracked(self) -> float:
        """Of the recording's frames."""
        return self.frames_tracked / max(self.frames, 1)


def evaluate_recording(world: LanguageMap, folder: Path, config: EvaluationConfig | None = None) -> Evaluation:
    """Score a map against the ground truth in a recording's folder.

    Raises:
        UserError: the recording cannot be opened or has no ground truth.
    """
    truth = read_ground_truth(folder)
    if truth is None:
        raise UserError(f"{folder} has no ground truth; looked for groundtruth.txt or frame-NNNNNN.pose.txt")
    return evaluate(world, truth, read_signs(folder), len(open_source(folder)), config)


def evaluate(
    world: LanguageMap,
    truth: StampedPoses,
    signs: list[TrueSign] | None,
    frames: int,
    config: EvaluationConfig | None = None,
) -> Evaluation:
    """Score a map against true camera poses and, if there are any, true signs in the same frame.

    Raises:
        UserError: the trajectories have too few frames in common.
    """
    config = config or EvaluationConfig()
    estimate = world.frame_poses()
    ate = absolute_trajectory_error(truth, estimate, config.association_tolerance)
    scored = None if signs is None else score_landmarks(world.landmarks(), signs, ate.truth_from_estimate, config)
    return Evaluation(ate, truth.path_length, frames, len(estimate), scored)
