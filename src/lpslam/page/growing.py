"""The points of a room that grows, scan by scan: who has seen a version is told what is new since.

Each scan's points stay as its keyframe saw them and move with it, so a corrected map costs a place for each keyframe
that moved and no point again.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.config import PageConfig
from lpslam.ground.scans import Scans
from lpslam.page.points import STEPS, cube_keys, in_sixteen

Array = NDArray[np.float64]

_HEAD = struct.Struct("<3If")  # version, whether this is all there is, records, spacing
_RECORD = struct.Struct("<4I12f")  # keyframe, what it tells, points, nothing; the place
_MOVED, _SEEN, _GONE = range(3)
_FAR = 3.0  # metres: how far from a camera what it sees usually is
_ORIGIN = 1 << 20  # the cube at the map's origin: none has a negative number
_SEED = 7  # of the order within a scan, so that the same run gives the same page


@dataclass(slots=True, eq=False)
class _Part:
    """A scan's points.

    Attributes:
        rows: (n, 4) uint16: x, y and z as shares of a box in the camera's frame, and the colour.
        low, size: (3,) metres, of that box.
        keys: (n,) the cubes of the room that are its own.
        pose: `world_from_keyframe` as it was told last.
        seen, moved: the versions of the room with its points and with its place.
    """

    rows: NDArray[np.uint16]
    low: Array
    size: Array
    keys: NDArray[np.int64]
    pose: Array
    seen: int
    moved: int

    def record(self, keyframe: int, kind: int) -> bytes:
        """What is told of it before its rows: its place takes shares to metres in the map frame, row by row."""
        place = np.column_stack([
            self.pose[:3, :3] * self.size, self.pose[:3, :3] @ self.low + self.pose[:3, 3]
        ])  # fmt: skip
        return _RECORD.pack(keyframe, kind, len(self.rows) if kind == _SEEN else 0, 0, *place.ravel().tolist())


@dataclass(slots=True, eq=False)
class GrowingPoints:
    """The points of all scans so far.

    Attributes:
        config: how many there may be, and how fine they are.
        version: rises with every change.
    """

    config: PageConfig
    version: int = 0
    _parts: dict[int, _Part] = field(default_factory=dict)
    _gone: dict[int, int] = field(default_factory=dict)
    _taken: set[int] = field(default_factory=set)
    _cube: float = 0.0

    def __len__(self) -> int:
        return sum(len(part.rows) for part in self._parts.values())

    def update(self, scans: Scans, keyframes: Mapping[int, Array]) -> bool:
        """Take what is new; whether anything was.

        Args:
            scans: all so far.
            keyframes: `world_from_keyframe`, 4×4, of those that have a place now.
        """
        self._cube = self._cube or self.config.growing_cube
        version = self.version + 1
        gone = [each for each in self._parts if each not in keyframes]
        for keyframe in gone:
            self._taken.difference_update(self._parts.pop(keyframe).keys.tolist())
            self._gone[keyframe] = version
        moved = self._moved(keyframes, version)
        new = [each for each in scans.keyframes if each in keyframes and each not in self._parts]
        for keyframe in new:
            self._parts[keyframe] = self._part(scans, keyframe, keyframes[keyframe], version)
            self._gone.pop(keyframe, None)
        if gone or moved or new:
            self.version = version
        if len(self) > self.config.growing_points:
            self._coarsen(scans, keyframes)
        return self.version == version

    def since(self, version: int) -> bytes:
        """What has changed since a version, little-endian; all of it where that is none of these.

        A head of four words (version, whether this is all, records, metres between neighbours), records of sixteen
        words (keyframe; 0 moved, 1 seen, 2 gone; points; nothing; 3×4 numbers that take shares to metres), and the
        points of the records in their order, eight bytes each.
        """
        is_whole = not 0 < version <= self.version
        version = 0 if is_whole else version
        records, rows = [], []
        for keyframe, part in self._parts.items():
            if part.seen > version:
                records.append(part.record(keyframe, _SEEN))
                rows.append(part.rows.astype("<u2").tobytes())
            elif part.moved > version:
                records.append(part.record(keyframe, _MOVED))
        if not is_whole:
            nowhere = [0.0] * 12
            records += [_RECORD.pack(each, _GONE, 0, 0, *nowhere) for each, at in self._gone.items() if at > version]
        head = _HEAD.pack(self.version, is_whole, len(records), self._cube or self.config.growing_cube)
        return b"".join([head, *records, *rows])

    def _moved(self, keyframes: Mapping[int, Array], version: int) -> int:
        """Note the keyframes whose points moved by a quarter of a cube, and count them."""
        if not self._parts:
            return 0
        ids = list(self._parts)
        now, told = np.array([keyframes[each] for each in ids]), np.array([self._parts[each].pose for each in ids])
        turned = np.linalg.norm(now[:, :3, :3] - told[:, :3, :3], axis=(1, 2)) * _FAR
        apart = np.linalg.norm(now[:, :3, 3] - told[:, :3, 3], axis=1) + turned
        rows = np.flatnonzero(apart > self._cube / 4)
        for row in rows.tolist():
            part = self._parts[ids[row]]
            part.pose, part.moved = now[row], version
        return len(rows)

    def _part(self, scans: Scans, keyframe: int, pose: Array, version: int) -> _Part:
        """The points of a scan that lie in cubes of the room in which there is none yet, in an order by chance."""
        seen = scans.points(keyframe).reshape(-1, 3)
        known = np.flatnonzero(np.isfinite(seen).all(axis=1))
        cells = np.floor(transform_points(pose, seen[known]) / self._cube).astype(np.int64) + _ORIGIN
        keys, first = np.unique(cube_keys(cells), return_index=True)
        is_new = np.fromiter((key not in self._taken for key in keys.tolist()), bool, len(keys))
        keys, chosen = keys[is_new], known[first[is_new]]
        self._taken.update(keys.tolist())
        chosen = np.random.default_rng((_SEED, keyframe)).permutation(chosen)
        points, colours = seen[chosen], scans.colour(keyframe).reshape(-1, 3)[chosen]
        low = points.min(axis=0) if len(points) else np.zeros(3)
        size = np.maximum(points.max(axis=0) - low, 1e-3) if len(points) else np.ones(3)
        shares = np.round((points - low) / size * STEPS).astype(np.uint16)
        rows = np.column_stack([shares, in_sixteen(colours.astype(np.float64))])
        return _Part(rows, low, size, keys, pose, version, version)

    def _coarsen(self, scans: Scans, keyframes: Mapping[int, Array]) -> None:
        """There are too many: all are taken once more in cubes of twice the side, of which a quarter is left."""
        while len(self) > self.config.growing_points and self._cube < _FAR:
            self._cube *= 2.0
            self._taken = set()
            for keyframe in [each for each in scans.keyframes if each in self._parts]:
                self._parts[keyframe] = self._part(scans, keyframe, keyframes[keyframe], self.version)
