"""Where cameras stand on the robot: `tf_static`, from whatever frame to whatever other."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from lpslam.camera import inverse_transform

Transform = NDArray[np.float64]


class FixedFrames:
    """Frames that do not move against each other, as a graph of transforms."""

    def __init__(self) -> None:
        self._neighbours: dict[str, dict[str, Transform]] = {}

    def add(self, transforms: Iterable[Any]) -> None:
        """Add the entries of a `TFMessage`; those that are no rigid motion are left out."""
        for each in transforms:
            parent_from_child = rigid(each.transform)
            if parent_from_child is not None:
                self.link(_name(each.header.frame_id), _name(each.child_frame_id), parent_from_child)

    def link(self, parent: str, child: str, parent_from_child: Transform) -> None:
        """Add one transform, 4×4, metres."""
        self._neighbours.setdefault(parent, {})[child] = parent_from_child
        self._neighbours.setdefault(child, {})[parent] = inverse_transform(parent_from_child)

    def between(self, to: str, origin: str) -> Transform | None:
        """The 4×4 `to_from_origin`; None where nothing links the two."""
        to, origin = _name(to), _name(origin)
        reached: dict[str, Transform] = {to: np.eye(4)}
        waiting = [to]
        while waiting and origin not in reached:
            frame = waiting.pop(0)
            for other, frame_from_other in self._neighbours.get(frame, {}).items():
                if other not in reached:
                    reached[other] = reached[frame] @ frame_from_other
                    waiting.append(other)
        return reached.get(origin)


def rigid(transform: Any) -> Transform | None:
    """A ROS `Transform` as 4×4; None if it is none."""
    q, t = transform.rotation, transform.translation
    quaternion, translation = np.array([q.x, q.y, q.z, q.w]), np.array([t.x, t.y, t.z])
    if not np.isfinite([*quaternion, *translation]).all() or np.linalg.norm(quaternion) < 0.5:
        return None
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    matrix[:3, 3] = translation
    return matrix


def _name(frame: str) -> str:
    return str(frame).lstrip("/")
