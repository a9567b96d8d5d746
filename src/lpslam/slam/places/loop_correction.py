"""Making the map one where a place was found again (ORB-SLAM, VII-C, D; ORB-SLAM2, III-D; ORB-SLAM3, VI).

The drift is spread over the way by a pose graph of the strong edges of the map, duplicate points along the seam are
fused, and a full bundle adjustment follows. What takes long works on copies, without the map's lock.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import LoopConfig, MappingConfig
from lpslam.slam.adjusting import Adjuster
from lpslam.slam.carrying import inverses
from lpslam.slam.kernels import fusing, graph
from lpslam.slam.map import SlamMap
from lpslam.slam.places import pose_graph
from lpslam.slam.rays import without_unsure
from lpslam.slam.sensor import SensorModel

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Tie:
    """A keyframe that was located in another part of the map.

    Attributes:
        keyframe: of the new part.
        candidate: the keyframe of the old part that shows the same place.
        camera_from_world: 4×4 of `keyframe`, in the world as the old part has it.
        points: (n,) the old map point that each keypoint of `keyframe` sees, or -1.
    """

    keyframe: int
    candidate: int
    camera_from_world: _Matrix
    points: _Rows

    def old_from_new_world(self, slam_map: SlamMap) -> _Matrix:
        """4×4 that takes the new part of the map to where the old one has it."""
        return inverse_transform(self.camera_from_world) @ slam_map.camera_from_world(self.keyframe)


@dataclass(frozen=True, slots=True, eq=False)
class EssentialGraph:
    """A copy of what a pose graph of one sub-map needs.

    Attributes:
        version: of the map.
        keyframes: (n,) the living ones of the sub-map; the first, its root, holds the frame.
        camera_from_world: (K, 4, 4) of all.
        tree, loops: (e, 2) pairs of keyframes: child and parent; ends of earlier loops.
        ties, tied_from: (t, 2) pairs of keyframes newly tied, and (t, 4, 4) the first's camera from the second's.
        links: heads, points, next observations, slots of keyframes and keyframes of slots, as `covisible_pairs` takes.
    """

    version: int
    keyframes: NDArray[np.int32]
    camera_from_world: _Matrix
    tree: _Rows
    loops: _Rows
    ties: _Rows
    tied_from: _Matrix
    links: tuple[_Rows, _Rows, _Rows, _Rows, _Rows]


class LoopCorrector:
    """Corrects loops and merges sub-maps.

    Args:
        slam_map: is changed; its lock is taken by each step that touches it.
        sensor: of the camera.
        config, mapping: thresholds.
    """

    def __init__(self, slam_map: SlamMap, sensor: SensorModel, config: LoopConfig, mapping: MappingConfig) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._adjuster = Adjuster(slam_map, sensor)
        self._config = config
        self._mapping = mapping

    def close(self, ties: Sequence[Tie], version: int, stop: NDArray[np.bool_]) -> bool:
        """Bend the way between the two parts until they meet.

        Args:
            ties: what was found, the newest keyframe first.
            version: of the map in which it was found.
            stop: (1,) set to True from another thread to abandon it.

        Returns:
            False if it was abandoned, or the map has changed meanwhile.
        """
        with self._map.lock:
            if self._map.version != version:
                return False
            gathered = self.gather(ties)
        poses = self.solve(gathered, stop)
        if stop[0]:
            return False
        with self._map.lock:
            if not self.apply(gathered, poses):
                return False
        self._sew(ties, stop)
        return True

    def merge(self, ties: Sequence[Tie], version: int, stop: NDArray[np.bool_]) -> bool:
        """Bring two sub-maps into one frame: home stays, else the older one. Arguments and result as of `close`."""
        slam_map, tie = self._map, ties[0]
        with slam_map.lock:
            own, other = (int(slam_map.submaps()[k]) for k in (tie.keyframe, tie.candidate))
            if slam_map.version != version:
                return False
            other_from_own = tie.old_from_new_world(slam_map)
            if other == slam_map.home or (own != slam_map.home and other < own):
                slam_map.transform(other_from_own, own)
                slam_map.join(other, own, tie.candidate)
            else:
                slam_map.transform(inverse_transform(other_from_own), other)
                slam_map.join(own, other, tie.candidate)
            slam_map.loop_edges.append((tie.keyframe, tie.candidate))
        self._sew(ties, stop)
        return True

    # The pose graph ----------------------------------------------------------------------------------------------

    def gather(self, ties: Sequence[Tie]) -> EssentialGraph:
        """Copy what the pose graph needs; the caller holds the map's lock."""
        slam_map, m = self._map, self._map.columns
        count, submaps = slam_map.keyframe_count, slam_map.submaps()
        living = slam_map.living_keyframes()
        keyframes = living[submaps[living] == submaps[ties[0].keyframe]]
        parents = slam_map.parents()
        children = keyframes[parents[keyframes] >= 0]
        loops = [(slam_map.living_ancestor(a), slam_map.living_ancestor(b)) for a, b in slam_map.loop_edges]
        inside = [pair for pair in loops if pair[0] != pair[1] and submaps[pair[0]] == submaps[ties[0].keyframe]]
        tied_from = [tie.camera_from_world @ slam_map.world_from_keyframe(tie.candidate) for tie in ties]
        return EssentialGraph(
            slam_map.version,
            keyframes,
            m.camera_from_world[:count].copy(),
            np.column_stack([children, parents[children]]).astype(np.int32),
            np.array(inside, np.int32).reshape(-1, 2),
            np.array([(tie.keyframe, tie.candidate) for tie in ties], np.int32),
            np.array(tied_from),
            (
                m.head[: slam_map.point_count].copy(),
                m.point.copy(),
                m.next_observation.copy(),
                m.keyframe_slot[:count].copy(),
                m.slot_keyframe.copy(),
            ),
        )

    def solve(self, gathered: EssentialGraph, stop: NDArray[np.bool_]) -> _Matrix:
        """(n, 4, 4) new poses of the gathered keyframes, as near to their relative poses as the ties allow."""
        config, keyframes = self._config, gathered.keyframes
        row = np.full(len(gathered.camera_from_world), -1, np.int32)
        row[keyframes] = np.arange(len(keyframes))
        covisible = graph.covisible_pairs(*gathered.links, config.essential_points)
        known = row[np.concatenate([gathered.tree, covisible, gathered.loops])]
        pairs = np.unique(np.sort(known[(known >= 0).all(axis=1)], axis=1), axis=0)
        poses = gathered.camera_from_world[keyframes]
        a_from_b = poses[pairs[:, 0]] @ inverses(poses[pairs[:, 1]])
        # Drift grows with the way: an edge is the weaker, the longer it is.
        apart = np.maximum(np.linalg.norm(a_from_b[:, :3, 3], axis=1), _SHORTEST_EDGE)
        is_fixed = np.zeros(len(keyframes), np.bool_)
        is_fixed[0] = True
        problem = pose_graph.PoseGraph(
            poses,
            is_fixed,
            np.ascontiguousarray(np.concatenate([pairs, row[gathered.ties]])),
            np.concatenate([a_from_b, gathered.tied_from]),
            np.concatenate([1.0 / apart, np.full(len(gathered.ties), config.loop_weight / _SHORTEST_EDGE)]),
        )
        return pose_graph.optimise_poses(problem, config.iterations, config.lever, stop)

    def apply(self, gathered: EssentialGraph, poses: _Matrix) -> bool:
        """Move keyframes and all that hangs on them; False if the gathered world is gone. The caller holds the lock."""
        if self._map.version != gathered.version:
            return False
        alive = self._map.columns.keyframe_slot[gathered.keyframes] >= 0
        self._map.carry(gathered.keyframes[alive], poses[alive])
        self._map.loop_edges.extend((int(a), int(b)) for a, b in gathered.ties)
        return True

    # The seam ----------------------------------------------------------------------------------------------------

    def _sew(self, ties: Sequence[Tie], stop: NDArray[np.bool_]) -> None:
        """Fuse what both sides of the seam have, with an adjustment of the new side between."""
        slam_map = self._map
        with slam_map.lock:
            alive = [tie for tie in ties if slam_map.is_alive(tie.keyframe)]
            if not alive:
                return
            new = self._group([tie.keyframe for tie in alive])
            old = self._group([tie.candidate for tie in alive if slam_map.is_alive(tie.candidate)])
            for tie in alive:
                slot = int(slam_map.columns.keyframe_slot[tie.keyframe])
                fusing.replace_points(slam_map.columns, slot, tie.points)
        old = old[~np.isin(old, new)]
        self._weld(new, stop)
        for side, other in ((new, old), (old, new)):
            self._fuse(side, other)

    def _group(self, keyframes: Sequence[int]) -> _Rows:
        """Some keyframes with those that see the same, the nearest of them."""
        config = self._config
        unique = list(dict.fromkeys(keyframes))
        around = [self._map.covisible(k, config.covisible_points)[: config.seam_keyframes] for k in unique]
        return np.unique(np.concatenate([np.array(unique, np.int32), *around])).astype(np.int32)

    def _fuse(self, seen_from: _Rows, looked_for_in: _Rows) -> None:
        """Look for the points of some keyframes in others."""
        slam_map, sensor, mapping = self._map, self._sensor, self._mapping
        with slam_map.lock:
            points = without_unsure(slam_map, graph.points_of(slam_map.columns, seen_from, slam_map.point_count))
        for keyframe in looked_for_in.tolist():
            with slam_map.lock:
                if slam_map.is_alive(keyframe):
                    fusing.fuse_points(
                        slam_map.columns, points, keyframe, sensor.intrinsics, sensor.image_size, sensor.scales,
                        sensor.pixel_information, mapping.fuse_radius, mapping.fuse_hamming,
                    )  # fmt: skip
        with slam_map.lock:
            graph.refresh_points(slam_map.columns, points, slam_map.scales)

    # Bundle adjustment -------------------------------------------------------------------------------------------

    def _weld(self, keyframes: _Rows, stop: NDArray[np.bool_]) -> None:
        """Adjust the new side of the seam; the old side, which sees points of it now, holds it."""
        iterations = (self._mapping.first_iterations, self._mapping.iterations)
        self._adjuster.adjust(keyframes, iterations, stop, keeps_part=False)

    def adjust_fully(self, keyframe: int, stop: NDArray[np.bool_]) -> bool:
        """Bundle adjustment of the whole sub-map of a keyframe; False if it was abandoned.

        What came to the map meanwhile is carried along with its parents.
        """
        slam_map = self._map
        with slam_map.lock:
            living = slam_map.living_keyframes()
            gathered = self._adjuster.gather(living[slam_map.submaps()[living] == slam_map.submaps()[keyframe]])
        solution = self._adjuster.solve(gathered, (self._config.first_adjusting, self._config.adjusting), stop)
        with slam_map.lock:
            if solution is None or stop[0] or slam_map.version != gathered.version:
                return False
            adjusted = gathered.free
            alive = slam_map.columns.keyframe_slot[adjusted] >= 0
            slam_map.carry(adjusted[alive], solution[0][: len(adjusted)][alive])
            self._adjuster.apply(gathered, solution)
        return True


_SHORTEST_EDGE = 0.1
"""Metres; keyframes nearer to each other stray by noise, not by drift."""
