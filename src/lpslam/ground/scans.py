"""What keyframes saw, kept small: depth and colour in a few thousand directions each.

A scan hangs on its keyframe, so the ground moves with every correction of the map. It is taken once and read when a
grid or a coloured cloud is asked for.
"""

import copy
from collections.abc import Callable, Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, transform_points
from lpslam.config import RoomConfig
from lpslam.small_depth import SmallDepth

Array = NDArray[np.float64]
Pose = Callable[[int], Array | None]
"""From a keyframe to its 4×4 pose in the map frame; None where it has no place there."""

_MILLIMETRES = 1000.0
_FARTHEST = 65.0  # metres: what sixteen bits of millimetres hold
_FEW = 64  # scans, two megabytes: fewer are not worth a look


class Scans:
    """Small depth and colour images of keyframes, without lens distortion.

    Args:
        camera: of the frames.
        width: pixels across a scan.

    Attributes:
        intrinsics: (fx, fy, cx, cy) of the small images.
        size: width and height of them.
    """

    def __init__(self, camera: PinholeCamera, width: int) -> None:
        self._small = SmallDepth(camera, min(width, camera.width))
        self.size, self.intrinsics = self._small.size, self._small.intrinsics
        self._depths: dict[int, NDArray[np.uint16]] = {}
        self._colours: dict[int, NDArray[np.uint8]] = {}
        self._next_look = _FEW

    def __len__(self) -> int:
        return len(self._depths)

    @property
    def keyframes(self) -> list[int]:
        """Ids of the keyframes that have a scan, in the order in which they were taken."""
        return list(self._depths)

    def copy(self) -> "Scans":
        """The same scans, to which later ones are not added."""
        other = copy.copy(self)
        other._depths, other._colours = dict(self._depths), dict(self._colours)
        return other

    def take(self, keyframe: int, rgb: NDArray[np.uint8], depth: NDArray[np.float32]) -> None:
        """Keep what a keyframe sees: colour (h, w, 3) and depth (h, w) in metres."""
        self._depths[keyframe] = (self._small.read(depth, _FARTHEST) * _MILLIMETRES).astype(np.uint16)
        small = cv2.resize(rgb, self.size, interpolation=cv2.INTER_AREA)
        self._colours[keyframe] = np.asarray(small, np.uint8)

    def add(self, other: "Scans") -> None:
        """Take the scans of another, of the same camera and width, too."""
        self._depths |= other._depths
        self._colours |= other._colours

    def drop(self, is_gone: Callable[[int], bool]) -> None:
        """Forget the scans of keyframes that are gone; asked for only once the scans have grown by half."""
        if len(self) < self._next_look:
            return
        for keyframe in [each for each in self.keyframes if is_gone(each)]:
            del self._depths[keyframe], self._colours[keyframe]
        self._next_look = len(self) + max(len(self) // 2, _FEW)

    def depth(self, keyframe: int) -> NDArray[np.float32]:
        """(h, w) metres, 0 where there is none."""
        return (self._depths[keyframe] / _MILLIMETRES).astype(np.float32)

    def colour(self, keyframe: int) -> NDArray[np.uint8]:
        """(h, w, 3) red, green, blue."""
        return self._colours[keyframe]

    def points(self, keyframe: int) -> Array:
        """(h, w, 3) metres in the camera's frame; NaN where there is no depth."""
        return self.back_projected(self.depth(keyframe))

    def back_projected(self, metres: NDArray[np.float32]) -> Array:
        """(h, w, 3) metres in the camera's frame, of what `depth` gives; NaN where there is none."""
        depth = metres.astype(np.float64)
        depth[depth == 0] = np.nan
        fx, fy, cx, cy = self.intrinsics
        rows, columns = np.mgrid[: self.size[1], : self.size[0]]
        return np.stack([(columns - cx) / fx * depth, (rows - cy) / fy * depth, depth], axis=2)

    def cloud(self, world_from_keyframe: Callable[[int], Array | None]) -> tuple[Array, NDArray[np.uint8]]:
        """(n, 3) points of all scans that have a place, metres, map frame, and their (n, 3) red, green, blue."""
        points, colours = [np.empty((0, 3))], [np.empty((0, 3), np.uint8)]
        for keyframe in self.keyframes:
            pose = world_from_keyframe(keyframe)
            if pose is None:
                continue
            seen = self.points(keyframe).reshape(-1, 3)
            known = np.isfinite(seen).all(axis=1)
            points.append(transform_points(pose, seen[known]))
            colours.append(self.colour(keyframe).reshape(-1, 3)[known])
        return np.concatenate(points), np.concatenate(colours)

    def to_arrays(self, kept: list[int] | None = None) -> dict[str, NDArray[Any]]:
        """As arrays, for a file: of some keyframes, or of all."""
        wanted = None if kept is None else set(kept)
        ids = [each for each in self.keyframes if wanted is None or each in wanted]
        shape = self.size[::-1]
        return {
            "keyframe": np.array(ids, np.int32),
            "depth": np.array([self._depths[each] for each in ids], np.uint16).reshape(-1, *shape),
            "colour": np.array([self._colours[each] for each in ids], np.uint8).reshape(-1, *shape, 3),
        }

    @classmethod
    def from_arrays(cls, camera: PinholeCamera, arrays: Mapping[str, NDArray[Any]], width: int) -> "Scans":
        """From arrays of a file; none where the map has no scans, as those of older programs.

        Raises:
            ValueError: the arrays do not belong together.
        """
        if not arrays:
            return cls(camera, width)
        ids, depth, colour = (arrays[name] for name in ("keyframe", "depth", "colour"))
        if depth.ndim != 3 or not 2 <= depth.shape[2] <= camera.width:
            raise ValueError(f"scans of shape {depth.shape}")
        scans = cls(camera, depth.shape[2])
        expected = (len(ids), *scans.size[::-1])
        if ids.ndim != 1 or ids.dtype != np.int32 or depth.shape != expected or depth.dtype != np.uint16:
            raise ValueError(f"scans of {ids.dtype} {ids.shape} and {depth.dtype} {depth.shape}")
        if colour.shape != (*expected, 3) or colour.dtype != np.uint8:
            raise ValueError(f"colours of scans of {colour.dtype} {colour.shape}")
        for keyframe, metres, shades in zip(ids.tolist(), depth, colour, strict=True):
            scans._depths[keyframe], scans._colours[keyframe] = metres, shades
        if len(scans) != len(ids):
            raise ValueError("two scans of one keyframe")
        return scans


def room_from_above(
    points: Array, colours: NDArray[np.uint8], walked: Array, config: RoomConfig | None = None
) -> tuple[Array, NDArray[np.uint8]]:
    """Points of a room, lowest first and without what a ceiling would hide the room with, and their colours.

    Args:
        points: (n, 3) metres, map frame.
        colours: (n, 3) red, green, blue.
        walked: (m, 3) where the camera was.
        config: thresholds; the defaults without.
    """
    heights = walked[:, 2][np.isfinite(walked[:, 2])]
    highest = (float(np.median(heights)) if len(heights) else 0.0) + (config or RoomConfig()).over_the_camera
    lower = np.flatnonzero(points[:, 2] < highest)
    shown = lower[np.argsort(points[lower, 2], kind="stable")]
    return points[shown], colours[shown]
