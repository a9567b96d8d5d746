"""The true poses that come with some recordings."""

import re
from pathlib import Path

import numpy as np

from lpslam.errors import UserError
from lpslam.poses import StampedPoses
from lpslam.regular_files import text_of
from lpslam.sources.clocks import in_seconds
from lpslam.sources.sevenscenes import FRAMES_PER_SECOND

_POSE = re.compile(r"frame-(\d+)\.pose\.txt", re.IGNORECASE)


def read_ground_truth(folder: Path | str) -> StampedPoses | None:
    """Read groundtruth.txt (TUM) or frame-NNNNNN.pose.txt (7-Scenes); None where there is neither.

    Poses of 7-Scenes that hold no finite rigid transform (its marks for "unknown") are left out.

    Raises:
        UserError: groundtruth.txt is malformed.
    """
    folder = Path(folder)
    if (folder / "groundtruth.txt").is_file():
        truth = StampedPoses.from_tum_file(folder / "groundtruth.txt")
        return StampedPoses(in_seconds(truth.timestamps)[0], truth.world_from_camera)
    timestamps: list[float] = []
    poses: list[np.ndarray[tuple[int, int], np.dtype[np.float64]]] = []
    for path in sorted(folder.glob("frame-*.pose.txt")):
        match = _POSE.fullmatch(path.name)
        try:
            numbers = [float(word) for word in text_of(path).split()]
        except (UserError, ValueError):
            continue
        if match is None or len(numbers) != 16:
            continue
        world_from_camera = np.array(numbers).reshape(4, 4)
        rotation = world_from_camera[:3, :3]
        if np.isfinite(world_from_camera).all() and np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-2):
            timestamps.append(int(match[1]) / FRAMES_PER_SECOND)
            poses.append(world_from_camera)
    if not poses:
        return None
    return StampedPoses(np.array(timestamps), np.stack(poses))
