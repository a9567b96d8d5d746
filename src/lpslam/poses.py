"""Camera poses with timestamps, and the TUM text format that holds them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.regular_files import text_of
from lpslam.whole_files import written_whole

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class StampedPoses:
    """A trajectory.

    Attributes:
        timestamps: (n,) seconds, rising.
        world_from_camera: (n, 4, 4), the camera's optical frame in the world.
    """

    timestamps: Array
    world_from_camera: Array

    def __post_init__(self) -> None:
        """Put the poses in order of time; refuse shapes that are no trajectory."""
        timestamps = np.asarray(self.timestamps, dtype=np.float64).reshape(-1)
        poses = np.asarray(self.world_from_camera, dtype=np.float64).reshape(-1, 4, 4)
        if len(timestamps) != len(poses):
            raise ValueError(f"{len(timestamps)} timestamps for {len(poses)} poses")
        order = np.argsort(timestamps, kind="stable")
        object.__setattr__(self, "timestamps", timestamps[order])
        object.__setattr__(self, "world_from_camera", poses[order])

    def __len__(self) -> int:
        return len(self.timestamps)

    @property
    def positions(self) -> Array:
        """(n, 3) metres, the camera's centres in the world."""
        return self.world_from_camera[:, :3, 3]

    @property
    def path_length(self) -> float:
        """Metres walked, as the sum of the steps between successive poses."""
        return float(np.linalg.norm(np.diff(self.positions, axis=0), axis=1).sum())

    @classmethod
    def from_tum_file(cls, path: Path) -> "StampedPoses":
        """Read lines `timestamp tx ty tz qx qy qz qw`; `#` begins a comment.

        Raises:
            UserError: the file cannot be read, or a line is not a pose.
        """
        rows = _read_rows(path)
        norms = np.linalg.norm(rows[:, 4:], axis=1)
        if (norms < 1e-6).any():
            raise UserError(
                f"trajectory {path}: pose {int(np.argmin(norms)) + 1} has a zero quaternion; write qx qy qz qw"
            )
        world_from_camera = np.tile(np.eye(4), (len(rows), 1, 1))
        world_from_camera[:, :3, :3] = rotations_from_quaternions(rows[:, 4:])
        world_from_camera[:, :3, 3] = rows[:, 1:4]
        return cls(rows[:, 0], world_from_camera)

    def to_tum_file(self, path: Path, comments: Sequence[str] = ()) -> None:
        """Write the TUM format: microseconds, micrometres, quaternions to nine places.

        Raises:
            UserError: the file cannot be written.
        """
        quaternions = quaternions_from_rotations(self.world_from_camera[:, :3, :3])
        lines = [f"# {' '.join(comment.split())}" for comment in (*comments, "timestamp tx ty tz qx qy qz qw")]
        for timestamp, position, quaternion in zip(self.timestamps, self.positions, quaternions, strict=True):
            numbers = [*(f"{value:.6f}" for value in position), *(f"{value:.9f}" for value in quaternion)]
            lines.append(f"{timestamp:.6f} {' '.join(numbers)}")
        with written_whole(path, "trajectory") as part:
            part.write_text("\n".join(lines) + "\n", encoding="utf-8")


def rotations_from_quaternions(quaternions: Array) -> Array:
    """Turn (n, 4) quaternions x, y, z, w of any length but zero into (n, 3, 3) rotations."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows, dtype=np.float64).reshape(3, 3, -1), 2, 0)


def quaternions_from_rotations(rotations: Array) -> Array:
    """Turn (n, 3, 3) rotations into (n, 4) unit quaternions x, y, z, w with w >= 0."""
    r = rotations
    trace = np.trace(r, axis1=1, axis2=2)
    # 4 q q^T, whose longest column is the numerically safest source of q (Shepperd's method).
    outer = np.empty((len(r), 4, 4))
    for i in range(3):
        outer[:, i, i] = 1 + 2 * r[:, i, i] - trace
    outer[:, 3, 3] = 1 + trace
    for i, j in ((0, 1), (0, 2), (1, 2)):
        outer[:, i, j] = outer[:, j, i] = r[:, i, j] + r[:, j, i]
    for i, j, k in ((0, 2, 1), (1, 0, 2), (2, 1, 0)):
        outer[:, i, 3] = outer[:, 3, i] = r[:, j, k] - r[:, k, j]
    longest = np.argmax(np.diagonal(outer, axis1=1, axis2=2), axis=1)
    quaternions = outer[np.arange(len(r)), :, longest]
    quaternions = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    upright: Array = np.where(quaternions[:, 3:] < 0, -quaternions, quaternions)
    return upright


def _read_rows(path: Path) -> Array:
    """Read the (n, 8) numbers of a TUM trajectory."""
    text = text_of(path, "trajectory")
    rows: list[list[float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].replace(",", " ").split()
        if not words:
            continue
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = []
        if len(row) != 8 or not np.isfinite(row).all():
            raise UserError(f"trajectory {path}, line {number}: expected eight numbers: timestamp tx ty tz qx qy qz qw")
        rows.append(row)
    if not rows:
        raise UserError(f"trajectory {path} holds no poses")
    return np.array(rows, dtype=np.float64)
