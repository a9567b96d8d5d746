"""The map by columns: keyframes, points and observations as growing arrays with ids as row numbers."""

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform, transform_points
from lpslam.config import PictureConfig
from lpslam.slam import carrying
from lpslam.slam.features import Features
from lpslam.slam.integrity import refuse_broken_columns, refuse_misshapen_columns
from lpslam.slam.kernels import graph
from lpslam.slam.kernels.graph import MapColumns
from lpslam.slam.mapping.relative_poses import RelativePoses
from lpslam.slam.ranges.curve import DepthCurve
from lpslam.slam.state import Beginning

_FEATURE_COLUMNS: dict[str, tuple[tuple[int, ...], Any, float]] = {
    "pixels": ((2,), np.float32, 0),
    "u_right": ((), np.float32, 0),
    "depth": ((), np.float32, 0),
    "has_depth": ((), np.bool_, 0),
    "octave": ((), np.uint8, 0),
    "angle": ((), np.float32, 0),
    "descriptor": ((4,), np.uint64, 0),
    "disparity_information": ((), np.float32, 0),
    "point": ((), np.int32, -1),
    "next_observation": ((), np.int32, -1),
}
_POINT_COLUMNS: dict[str, tuple[tuple[int, ...], Any, float]] = {
    "position": ((3,), np.float64, 0),
    "point_descriptor": ((4,), np.uint64, 0),
    "normal": ((3,), np.float32, 0),
    "distance_range": ((2,), np.float32, 0),
    "visible": ((), np.int32, 0),
    "found": ((), np.int32, 0),
    "head": ((), np.int32, -1),
    "observations": ((), np.int32, 0),
    "first_keyframe": ((), np.int32, -1),
    "point_alive": ((), np.bool_, 0),
    "inverse_sigma": ((), np.float32, 0),
}
_KEYFRAME_COLUMNS: dict[str, tuple[tuple[int, ...], Any, float]] = {
    "camera_from_world": ((4, 4), np.float64, 0),
    "keyframe_slot": ((), np.int32, -1),
    "timestamp": ((), np.float64, 0),
    "frame_index": ((), np.int64, -1),
    "parent": ((), np.int32, -1),
    "keyframe_from_parent": ((4, 4), np.float64, 0),
    "submap": ((), np.int32, 0),
}


class SlamMap:
    """Keyframes, points and the observations between them.

    Keyframe and point ids are row numbers and are never used again. Keypoints live in slots, which are: a keyframe that
    is removed gives its slot back, and its pose lives on relative to its parent.

    What was mapped after tracking had been lost for long is a sub-map with a world frame of its own, until it is merged
    (ORB-SLAM3's atlas). Each has one root, a keyframe without parent; the world frame of the map is that of `home`.

    Attributes:
        lock: held by whoever reads or changes the map while other threads may change it.
        version: rises with every change of a world frame; what was computed from an older version does not fit.
        home: the sub-map whose frame is the map's.
        loop_edges: pairs of keyframes between which a loop was closed or sub-maps were joined.
        depth_curve: by which readings of depth were corrected.
        relative_poses: what pictures say of pairs of keyframes; not saved.
        blurred: keyframes that may have moved while they were exposed; not saved.
        beginnings: by the first keyframe of a sub-map that a seeing camera began, where it was last; not saved.
    """

    def __init__(self, features_per_keyframe: int, scales: NDArray[np.float64]) -> None:
        self.scales = np.asarray(scales, dtype=np.float64)
        self.keyframe_count = 0
        self.point_count = 0
        self.lock = threading.RLock()
        self.version = 0
        self.home = 0
        self.loop_edges: list[tuple[int, int]] = []
        self.depth_curve = DepthCurve.straight()
        self.relative_poses = RelativePoses(PictureConfig())
        self.blurred: set[int] = set()
        self.beginnings: dict[int, Beginning] = {}
        self._capacity = features_per_keyframe
        self._arrays: dict[str, NDArray[Any]] = {}
        for table, rows in ((_KEYFRAME_COLUMNS, 64), (_POINT_COLUMNS, 8192)):
            for name, (shape, dtype, fill) in table.items():
                self._arrays[name] = np.full((rows, *shape), fill, dtype)
        for name, (shape, dtype, fill) in _FEATURE_COLUMNS.items():
            self._arrays[name] = np.full((64, features_per_keyframe, *shape), fill, dtype)
        self._arrays["slot_keyframe"] = np.full(64, -1, np.int32)
        self._arrays["feature_count"] = np.zeros(64, np.int32)
        self._slot_count = 0
        self._free_slots: list[int] = []
        self._columns: MapColumns | None = None

    @property
    def features_per_keyframe(self) -> int:
        """The most keypoints that a keyframe can have."""
        return self._capacity

    @property
    def columns(self) -> MapColumns:
        """Views for kernels; valid until the map grows."""
        # Kept in a variable: another thread that lets the map grow may forget the views meanwhile.
        columns = self._columns
        if columns is None:
            columns = self._columns = MapColumns(*(self._arrays[name] for name in MapColumns._fields))
        return columns

    # Growth ------------------------------------------------------------------------------------------------------

    def _reserve(self, names: Any, rows: int, fills: dict[str, tuple[tuple[int, ...], Any, float]]) -> None:
        for name in names:
            old = self._arrays[name]
            if len(old) >= rows:
                return
            grown = np.full((max(rows, 2 * len(old)), *old.shape[1:]), fills[name][2], old.dtype)
            grown[: len(old)] = old
            self._arrays[name] = grown
        self._columns = None

    def _take_slot(self) -> int:
        if self._free_slots:
            return self._free_slots.pop()
        slot = self._slot_count
        self._slot_count += 1
        self._reserve(_FEATURE_COLUMNS, self._slot_count, _FEATURE_COLUMNS)
        slot_tables = {"slot_keyframe": ((), np.int32, -1.0), "feature_count": ((), np.int32, 0.0)}
        self._reserve(slot_tables, self._slot_count, slot_tables)  # type: ignore[arg-type]
        return slot

    # Keyframes ---------------------------------------------------------------------------------------------------

    def add_keyframe(
        self,
        camera_from_world: NDArray[np.float64],
        features: Features,
        disparity_information: NDArray[np.float32],
        timestamp: float,
        frame_index: int,
        parent: int,
    ) -> int:
        """Append a keyframe with its keypoints, none of them linked to a point yet; returns its id.

        Without a parent (-1) it is the root of a new sub-map.
        """
        count = features.rows
        if count > self._capacity:
            raise ValueError(f"{count} keypoints do not fit a slot of {self._capacity}")
        keyframe = self.keyframe_count
        self.keyframe_count += 1
        self._reserve(_KEYFRAME_COLUMNS, self.keyframe_count, _KEYFRAME_COLUMNS)
        slot = self._take_slot()
        a = self._arrays
        a["camera_from_world"][keyframe] = camera_from_world
        a["keyframe_slot"][keyframe] = slot
        a["timestamp"][keyframe] = timestamp
        a["frame_index"][keyframe] = frame_index
        a["parent"][keyframe] = parent
        a["keyframe_from_parent"][keyframe] = np.eye(4)
        a["submap"][keyframe] = a["submap"][parent] if parent >= 0 else a["submap"][:keyframe].max(initial=-1) + 1
        a["slot_keyframe"][slot] = keyframe
        a["feature_count"][slot] = count
        for name in ("pixels", "u_right", "depth", "has_depth", "octave", "angle", "descriptor"):
            a[name][slot, :count] = getattr(features, name)
        a["disparity_information"][slot, :count] = disparity_information
        a["point"][slot] = -1
        a["next_observation"][slot] = -1
        return keyframe

    def remove_keyframe(self, keyframe: int) -> None:
        """Drop a redundant keyframe: its observations go, its parent takes its children and carries its pose.

        Raises:
            ValueError: it is a root, which holds the world frame of its sub-map, or it was removed before.
        """
        a = self._arrays
        if self.is_root(keyframe) or not self.is_alive(keyframe):
            raise ValueError(f"keyframe {keyframe} cannot be removed: it is the first of its sub-map, or gone")
        slot, parent = int(a["keyframe_slot"][keyframe]), int(a["parent"][keyframe])
        for feature in np.flatnonzero(a["point"][slot, : a["feature_count"][slot]] >= 0):
            graph.unlink(self.columns, slot, int(feature))
        children = a["parent"][: self.keyframe_count] == keyframe
        # Frames and texts that hang on a removed keyframe follow its parent's later corrections through this link.
        living = a["keyframe_slot"][: self.keyframe_count] >= 0
        a["parent"][: self.keyframe_count][children & living] = parent
        a["keyframe_from_parent"][keyframe] = a["camera_from_world"][keyframe] @ self.world_from_keyframe(parent)
        a["keyframe_slot"][keyframe] = -1
        a["slot_keyframe"][slot] = -1
        a["feature_count"][slot] = 0
        self._free_slots.append(slot)

    def is_alive(self, keyframe: int) -> bool:
        """Whether a keyframe still has its keypoints."""
        return bool(self._arrays["keyframe_slot"][keyframe] >= 0)

    def is_root(self, keyframe: int) -> bool:
        """Whether a keyframe is the first of its sub-map: it holds the world frame and is never removed."""
        return bool(self._arrays["parent"][keyframe] < 0)

    def living_keyframes(self) -> NDArray[np.int32]:
        """Ids of the keyframes that were not removed, rising."""
        return np.flatnonzero(self._arrays["keyframe_slot"][: self.keyframe_count] >= 0).astype(np.int32)

    def camera_from_world(self, keyframe: int) -> NDArray[np.float64]:
        """4×4 pose of a keyframe, also of a removed one (through its parent)."""
        chain = np.eye(4)
        while not self.is_alive(keyframe):
            chain = chain @ self._arrays["keyframe_from_parent"][keyframe]
            keyframe = int(self._arrays["parent"][keyframe])
        return np.asarray(chain @ self._arrays["camera_from_world"][keyframe])

    def world_from_keyframe(self, keyframe: int) -> NDArray[np.float64]:
        """4×4, the inverse of `camera_from_world`."""
        return inverse_transform(self.camera_from_world(keyframe))

    def points_seen_by(self, keyframe: int) -> NDArray[np.float64]:
        """(n, 3) metres, in its camera's frame: the points that a keyframe sees, or one that stands for it."""
        with self.lock:
            seen_by = np.array([self.living_ancestor(keyframe)], np.int32)
            points = graph.points_of(self.columns, seen_by, self.point_count)
            points = points[self.columns.inverse_sigma[points] == 0]
            return transform_points(self.camera_from_world(keyframe), self.columns.position[points])

    def features(self, keyframe: int) -> Features:
        """The keypoints of a living keyframe, as views that are valid until the map grows.

        Raises:
            ValueError: the keyframe was removed.
        """
        slot = int(self._arrays["keyframe_slot"][keyframe])
        if slot < 0:
            raise ValueError(f"keyframe {keyframe} was removed and has no keypoints")
        count = int(self._arrays["feature_count"][slot])
        return Features(*(self._arrays[name][slot, :count] for name in Features._fields))

    def submaps(self) -> NDArray[np.int32]:
        """(K,) the sub-map of every keyframe by id, removed ones too."""
        return self._arrays["submap"][: self.keyframe_count]

    def is_home(self, keyframe: int) -> bool:
        """Whether a keyframe's world frame is the map's."""
        return bool(self._arrays["submap"][keyframe] == self.home)

    def settle(self) -> None:
        """Make the sub-map with most keyframes home, the oldest of equals: its frame becomes the map's."""
        living = self.living_keyframes()
        if len(living):
            self.home = int(np.bincount(self.submaps()[living]).argmax())

    def parents(self) -> NDArray[np.int32]:
        """(K,) the parent of every keyframe in the spanning tree by id, -1 of roots; older than its child."""
        return self._arrays["parent"][: self.keyframe_count]

    def living_ancestor(self, keyframe: int) -> int:
        """The keyframe itself, or the nearest of its ancestors that was not removed."""
        while not self.is_alive(keyframe):
            keyframe = int(self._arrays["parent"][keyframe])
        return keyframe

    def frame_of(self, keyframe: int) -> tuple[int, float]:
        """Index and timestamp in seconds of the frame that became a keyframe."""
        return int(self._arrays["frame_index"][keyframe]), float(self._arrays["timestamp"][keyframe])

    def timestamps(self) -> NDArray[np.float64]:
        """(K,) seconds, of all keyframes by id."""
        return self._arrays["timestamp"][: self.keyframe_count]

    def covisible(self, keyframe: int, least: int) -> NDArray[np.int32]:
        """Keyframes that share at least `least` points with one, most shared first; none with a removed one."""
        slot = int(self._arrays["keyframe_slot"][keyframe])
        if slot < 0:
            return np.empty(0, np.int32)
        counts = graph.count_shared_points(self.columns, self._arrays["point"][slot], self.keyframe_count)
        counts[keyframe] = 0
        order = np.argsort(-counts, kind="stable").astype(np.int32)
        return order[: int(np.count_nonzero(counts >= max(least, 1)))]

    # Points ------------------------------------------------------------------------------------------------------

    def add_points(self, keyframe: int, features: NDArray[np.int32], positions: NDArray[np.float64]) -> int:
        """Append points seen by keypoints of one keyframe; returns the id of the first of them.

        Args:
            keyframe: the observer.
            features: (n,) its keypoints.
            positions: (n, 3) world frame, metres.
        """
        first = self.point_count
        self.point_count += len(features)
        self._reserve(_POINT_COLUMNS, self.point_count, _POINT_COLUMNS)
        graph.add_points(self.columns, first, keyframe, features, positions, self.scales)
        return first

    def living_points(self) -> NDArray[np.int32]:
        """Ids of the points that were not removed, rising."""
        return np.flatnonzero(self._arrays["point_alive"][: self.point_count]).astype(np.int32)

    def point_positions(self) -> NDArray[np.float64]:
        """(n, 3) map frame, of the living points of the home sub-map."""
        points = self.living_points()
        at_home = self.submaps()[self._arrays["first_keyframe"][points]] == self.home
        at_home &= self._arrays["inverse_sigma"][points] == 0
        return np.asarray(self._arrays["position"][points[at_home]])

    # The whole ---------------------------------------------------------------------------------------------------

    def transform(self, new_from_old_world: NDArray[np.float64], submap: int | None = None) -> None:
        """Change the world frame (4×4, rigid) of one sub-map, the home one without; removed keyframes follow."""
        a = self._arrays
        submap = self.home if submap is None else submap
        keyframes = np.flatnonzero(self.submaps() == submap)
        a["camera_from_world"][keyframes] = a["camera_from_world"][keyframes] @ inverse_transform(new_from_old_world)
        points = np.flatnonzero(self.submaps()[a["first_keyframe"][: self.point_count]] == submap)
        rotation, shift = new_from_old_world[:3, :3], new_from_old_world[:3, 3]
        a["position"][points] = a["position"][points] @ rotation.T + shift
        a["normal"][points] = (a["normal"][points] @ rotation.T).astype(np.float32)
        self.version += 1

    def carry(self, keyframes: NDArray[np.int32], camera_from_world: NDArray[np.float64]) -> None:
        """Give keyframes new poses (n, 4, 4); others follow their parents, points their first keyframe."""
        a, count = self._arrays, self.keyframe_count
        poses = a["camera_from_world"][:count]
        new_from_old = carrying.corrections(poses, self.parents(), keyframes, camera_from_world)
        carrying.carry_keyframes(poses, new_from_old)
        first = a["first_keyframe"][: self.point_count]
        carrying.carry_points(a["position"][: self.point_count], a["normal"][: self.point_count], first, new_from_old)
        self.version += 1

    def join(self, kept: int, gone: int, near: int) -> None:
        """Make one sub-map of two whose world frames are the same already.

        The younger root becomes the child of an older keyframe of the other sub-map.

        Args:
            kept, gone: sub-maps; the second one's keyframes become the first one's.
            near: the keyframe that should be the parent, if it is older than the root and of the other sub-map.
        """
        a, count = self._arrays, self.keyframe_count
        parts = [np.flatnonzero(self.submaps() == part) for part in (kept, gone)]
        older, younger = sorted(parts, key=lambda ids: int(ids[0]))
        root = int(younger[0])
        possible = older[(older < root) & (a["keyframe_slot"][older] >= 0)]
        a["parent"][root] = near if near in possible else possible[-1]
        a["submap"][:count][parts[1]] = kept
        if self.home == gone:
            self.home = kept
        self.version += 1

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Everything needed to rebuild the map, as named arrays."""
        rows = {
            **dict.fromkeys(_KEYFRAME_COLUMNS, self.keyframe_count),
            **dict.fromkeys(_POINT_COLUMNS, self.point_count),
            **dict.fromkeys((*_FEATURE_COLUMNS, "slot_keyframe", "feature_count"), self._slot_count),
        }
        arrays = {name: self._arrays[name][:count].copy() for name, count in rows.items()}
        if not self.depth_curve.is_straight:
            arrays["depth_table"] = self.depth_curve.table.copy()
        return {
            **arrays,
            "scales": self.scales.copy(),
            "free_slots": np.array(self._free_slots, np.int32),
            "home": np.array([self.home], np.int32),
            "loop_edges": np.array(self.loop_edges, np.int32).reshape(-1, 2),
        }

    @classmethod
    def from_arrays(cls, arrays: dict[str, NDArray[Any]]) -> "SlamMap":
        """Rebuild a map from `to_arrays`.

        Raises:
            KeyError, ValueError: a column is missing, has another shape, or does not fit the others.
        """
        # Maps of older versions have sure points alone.
        arrays = {"inverse_sigma": np.zeros(len(arrays["head"]), np.float32), **arrays}
        slot_columns = (*_FEATURE_COLUMNS, "slot_keyframe", "feature_count")
        refuse_misshapen_columns(arrays, (tuple(_KEYFRAME_COLUMNS), tuple(_POINT_COLUMNS), slot_columns))
        slam_map = cls(int(arrays["point"].shape[1]), arrays["scales"])
        slam_map.keyframe_count = len(arrays["keyframe_slot"])
        slam_map.home = int(arrays["home"].item())
        slam_map.loop_edges = [(int(a), int(b)) for a, b in arrays["loop_edges"]]
        if "depth_table" in arrays:
            slam_map.depth_curve = DepthCurve.of(arrays["depth_table"])
        slam_map.point_count = len(arrays["head"])
        slam_map._slot_count = len(arrays["slot_keyframe"])
        slam_map._free_slots = [int(slot) for slot in arrays["free_slots"]]
        for name, old in slam_map._arrays.items():
            saved = arrays[name]
            if saved.shape[1:] != old.shape[1:] or saved.dtype != old.dtype:
                raise ValueError(f"column {name} is {saved.dtype}{saved.shape}")
            fill = {**_FEATURE_COLUMNS, **_POINT_COLUMNS, **_KEYFRAME_COLUMNS}.get(name, ((), None, -1))[2]
            grown = np.full((max(len(saved), len(old)), *old.shape[1:]), fill, old.dtype)
            grown[: len(saved)] = saved
            slam_map._arrays[name] = grown
        refuse_broken_columns(arrays)
        slam_map._columns = None
        return slam_map
