"""Where the camera was: every frame kept relative to its reference keyframe, so that each correction reaches it.

A map may grow over several recordings, whose times may overlap: each is a session of its own.
"""

from array import array
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import are_rigid
from lpslam.slam.map import SlamMap
from lpslam.slam.state import TrackedFrame, TrackingState

_STATES = list(TrackingState)


class Trajectory:
    """All frames by columns, in the order in which they came."""

    def __init__(self) -> None:
        # Packed: a robot that walks all day has millions of frames, of 153 bytes each.
        self._indices = array("q")
        self._timestamps = array("d")
        self._states = array("B")
        self._keyframes = array("i")
        self._poses = array("d")
        self._sessions = array("i")
        self.session = 0

    def __len__(self) -> int:
        return len(self._indices)

    def begin_session(self) -> int:
        """What is appended from now on belongs to another recording; returns a frame index that is free from here."""
        self.session += 1
        return max(self._indices, default=-1) + 1

    def append(self, tracked: TrackedFrame) -> None:
        """Add one frame, tracked or not."""
        self._indices.append(tracked.index)
        self._timestamps.append(tracked.timestamp)
        self._states.append(_STATES.index(tracked.state))
        self._sessions.append(self.session)
        has_pose = tracked.keyframe_from_camera is not None
        self._keyframes.append(tracked.keyframe if has_pose else -1)
        pose = tracked.keyframe_from_camera if tracked.keyframe_from_camera is not None else np.eye(4)
        self._poses.frombytes(np.ascontiguousarray(pose, np.float64).tobytes())

    def disown(self, since: float) -> None:
        """Take back the poses of the newest session's frames from a time on, in seconds: they were of another place."""
        for row in range(len(self._indices) - 1, -1, -1):
            if self._sessions[row] != self.session or self._timestamps[row] < since:
                break
            self._states[row] = _STATES.index(TrackingState.LOST)
            self._keyframes[row] = -1
            self._poses[16 * row : 16 * (row + 1)] = array("d", np.eye(4).ravel())

    def revise(self, poses: Mapping[int, NDArray[np.float64]]) -> None:
        """Give frames of the newest session, by index, another pose (4×4) in their reference keyframe's frame."""
        first = min(poses, default=0)
        for row in range(len(self._indices) - 1, -1, -1):
            if self._sessions[row] != self.session or self._indices[row] < first:
                break
            if self._indices[row] in poses and self._keyframes[row] >= 0:
                self._poses[16 * row : 16 * (row + 1)] = array("d", poses[self._indices[row]].ravel())

    def place(self, poses: Mapping[int, tuple[int, NDArray[np.float64]]]) -> None:
        """Give frames of the newest session without a pose, by index, a reference keyframe and a pose (4×4) in it."""
        first = min(poses, default=0)
        for row in range(len(self._indices) - 1, -1, -1):
            if self._sessions[row] != self.session or self._indices[row] < first:
                break
            if self._indices[row] in poses and self._keyframes[row] < 0:
                self._keyframes[row], pose = poses[self._indices[row]]
                self._states[row] = _STATES.index(TrackingState.WEAK)
                self._poses[16 * row : 16 * (row + 1)] = array("d", pose.ravel())

    @property
    def frame_count(self) -> int:
        """Number of frames of the newest session."""
        return self._sessions.count(self.session)

    @property
    def tracked_count(self) -> int:
        """Number of frames of the newest session with a pose, in whichever sub-map."""
        return sum(k >= 0 and s == self.session for k, s in zip(self._keyframes, self._sessions, strict=True))

    def world_from_camera(
        self, slam_map: SlamMap, session: int | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Timestamps (n,) and poses (n, 4, 4) of a session's tracked frames as the map has them now.

        Frames in sub-maps that were never merged have no pose in the map frame and are left out.

        Args:
            slam_map: the map that they were tracked in.
            session: number of the recording; the newest without.
        """
        keyframes = np.array(self._keyframes, dtype=np.int64)
        at_home = np.append(slam_map.submaps() == slam_map.home, False)[keyframes]
        tracked = at_home & (np.array(self._sessions) == (self.session if session is None else session))
        relative = np.array(self._poses).reshape(-1, 4, 4)[tracked]
        used, rows = np.unique(keyframes[tracked], return_inverse=True)
        world_from_keyframe = np.array([slam_map.world_from_keyframe(int(k)) for k in used]).reshape(-1, 4, 4)
        poses = np.einsum("nij,njk->nik", world_from_keyframe[rows], relative)
        return np.array(self._timestamps)[tracked], poses

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """The columns, for the map file."""
        return {
            "index": np.array(self._indices, np.int64),
            "timestamp": np.array(self._timestamps, np.float64),
            "state": np.array(self._states, np.uint8),
            "keyframe": np.array(self._keyframes, np.int32),
            "keyframe_from_camera": np.array(self._poses, np.float64).reshape(-1, 4, 4),
            "session": np.array(self._sessions, np.int32),
        }

    @classmethod
    def from_arrays(cls, arrays: dict[str, NDArray[Any]]) -> "Trajectory":
        """The inverse of `to_arrays`.

        Raises:
            KeyError, ValueError: a column is missing, has another shape, or names a state that does not exist.
        """
        count = len(arrays["index"])
        for name in ("index", "timestamp", "state", "keyframe", "session"):
            if arrays[name].shape != (count,):
                raise ValueError(f"trajectory column {name} has shape {arrays[name].shape}, not {(count,)}")
        if arrays["keyframe_from_camera"].shape != (count, 4, 4):
            raise ValueError(f"trajectory column keyframe_from_camera is not {(count, 4, 4)}")
        if not ((arrays["state"] >= 0) & (arrays["state"] < len(_STATES))).all():
            raise ValueError("trajectory column state names a state that does not exist")
        for name, column_type in (("index", "iu"), ("timestamp", "f"), ("keyframe", "iu"), ("session", "iu")):
            if arrays[name].dtype.kind not in column_type:
                raise ValueError(f"trajectory column {name} is {arrays[name].dtype}")
        if not np.isfinite(arrays["timestamp"]).all() or (arrays["session"] < 0).any():
            raise ValueError("trajectory column timestamp or session holds what is none")
        has_pose = arrays["keyframe"] >= 0
        poses = np.asarray(arrays["keyframe_from_camera"])
        if poses.dtype != np.float64 or not np.isfinite(poses).all():
            raise ValueError("trajectory column keyframe_from_camera is not finite")
        if not are_rigid(poses[has_pose]):
            raise ValueError("trajectory column keyframe_from_camera holds what is no pose")
        trajectory = cls()
        for name, column in (
            ("index", trajectory._indices),
            ("timestamp", trajectory._timestamps),
            ("state", trajectory._states),
            ("keyframe", trajectory._keyframes),
            ("keyframe_from_camera", trajectory._poses),
            ("session", trajectory._sessions),
        ):
            column.frombytes(arrays[name].astype(column.typecode).tobytes())
        trajectory.session = max(trajectory._sessions, default=0)
        return trajectory
