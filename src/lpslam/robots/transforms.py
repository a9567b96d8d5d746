"""Where things stand on the robot at a moment: `tf_static` and the latest of `tf`."""

import threading
from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.sources.bags.messages import stamp_of
from lpslam.sources.bags.transforms import FixedFrames, rigid

Transform = NDArray[np.float64]

_KEPT = 400
"""Transforms that are kept of a moving frame: four seconds of a hundred a second."""
_MOST = 1000
"""Frames that are known at most; a robot has a hundred."""


class Transforms:
    """Frames of a robot, some of which move; safe in threads.

    Args:
        old: seconds from a moment within which a transform counts for it.
    """

    def __init__(self, old: float) -> None:
        self._old = round(old * 1e9)
        self._fixed: dict[tuple[str, str], Transform] = {}
        self._moving: dict[tuple[str, str], deque[tuple[int, Transform]]] = {}
        self._lock = threading.Lock()

    def add(self, message: Any, *, is_static: bool) -> None:
        """Add the entries of a `TFMessage`; what is no rigid motion is left out."""
        with self._lock:
            for each in message.transforms:
                matrix = rigid(each.transform)
                key = (each.header.frame_id.lstrip("/"), each.child_frame_id.lstrip("/"))
                is_known = key in self._fixed or key in self._moving
                if matrix is None or not (is_known or len(self._fixed) + len(self._moving) < _MOST):
                    continue
                if is_static:
                    self._fixed[key] = matrix
                else:
                    self._moving.setdefault(key, deque(maxlen=_KEPT)).append((stamp_of(each), matrix))

    def top(self, frame: str, below: str) -> str:
        """What a frame hangs on in the end: odometry, or the robot; not `below`, on which that is hung."""
        with self._lock:
            parents = {child: parent for parent, child in (*self._fixed, *self._moving) if parent != below}
        passed = {frame}
        while (parent := parents.get(frame)) is not None and parent not in passed:
            passed.add(parent)
            frame = parent
        return frame

    def between(self, to: str, origin: str, nanoseconds: int) -> Transform | None:
        """The 4×4 `to_from_origin` at a moment; None where nothing links the two, or nothing of that time."""
        frames = FixedFrames()
        with self._lock:
            for (parent, child), matrix in self._fixed.items():
                frames.link(parent, child, matrix)
            for (parent, child), kept in self._moving.items():
                stamp, matrix = min(kept, key=lambda each: abs(each[0] - nanoseconds))
                if abs(stamp - nanoseconds) <= self._old:
                    frames.link(parent, child, matrix)
        return frames.between(to, origin)
