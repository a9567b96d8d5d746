"""Bundle adjustment of a part of the map: gathered and written back under its lock, solved on a copy without it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.slam.carrying import inverses
from lpslam.slam.kernels import bundle, local_bundle
from lpslam.slam.kernels.relative import RelativeProblem
from lpslam.slam.map import SlamMap
from lpslam.slam.sensor import SensorModel

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]
_Solution = tuple[_Matrix, _Matrix, NDArray[np.bool_]]


@dataclass(frozen=True, slots=True, eq=False)
class Gathered:
    """An adjustment problem with the rows of the map that it came from.

    Attributes:
        version: of the map.
        problem: keyframes that are free come first.
        keyframes, points: ids.
        relative: relative poses of the problem's keyframes.
    """

    version: int
    problem: bundle.BundleProblem
    keyframes: _Rows
    points: _Rows
    relative: RelativeProblem

    @property
    def free(self) -> _Rows:
        """Ids of the keyframes that may move."""
        return self.keyframes[: self.problem.free_count]


_TORN_METRES, _TORN_SHARE, _TORN_DEGREES = 0.15, 0.5, 3.0
"""By which, and by which share of the way between them, a keyframe may move against its parent: tracking errs by less.
One that few points hold, some of a look-alike thing, would be torn away; what tracking knew besides is not in it."""


class Adjuster:
    """Adjusts keyframes and the points that they see; all others that see those points hold the frame, and so does a
    root.

    Args:
        slam_map: is changed by `apply` and `adjust` alone.
        sensor: of the camera.
    """

    def __init__(self, slam_map: SlamMap, sensor: SensorModel) -> None:
        self._map = slam_map
        self._sensor = sensor

    def gather(self, free: _Rows) -> Gathered:
        """Copy what the adjustment of keyframes needs; the caller holds the map's lock."""
        slam_map = self._map
        free = free[slam_map.columns.keyframe_slot[free] >= 0]
        roots = [k for k in free.tolist() if slam_map.is_root(k)]
        gathered = self._gathered(free, roots[0] if roots else -1)
        if not roots and len(free) and gathered.problem.free_count == len(gathered.keyframes):
            # Nobody else sees their points, where surfaces alone have carried the camera on: the oldest one holds.
            return self._gathered(free, int(free.min()))
        return gathered

    def _gathered(self, free: _Rows, held: int) -> Gathered:
        """The problem of keyframes of which one may be held."""
        slam_map = self._map
        columns, counts = slam_map.columns, (slam_map.keyframe_count, slam_map.point_count)
        problem, keyframes, points = local_bundle.gather_bundle(
            columns, free, *counts, self._sensor.pixel_information, held
        )
        relative = slam_map.relative_poses.among(keyframes, problem.free_count)
        return Gathered(slam_map.version, problem, keyframes, points, relative)

    def solve(self, gathered: Gathered, iterations: tuple[int, int], stop: NDArray[np.bool_]) -> _Solution | None:
        """Poses, positions and which observations agree; None where nothing can move.

        Args:
            gathered: the problem.
            iterations: at most, before outliers are dropped and after it.
            stop: (1,) set to True from another thread to end with what there is.
        """
        if gathered.problem.free_count == 0 or len(gathered.keyframes) < 2:
            return None
        return bundle.adjust_bundle(
            gathered.problem, self._sensor.intrinsics, *iterations, stop, relative=gathered.relative
        )

    def apply(self, gathered: Gathered, solution: _Solution) -> None:
        """Write a solution into the map, whose version is that of the copy; the caller holds the lock."""
        local_bundle.apply_bundle(
            self._map.columns, gathered.problem, gathered.keyframes, gathered.points, *solution, self._map.scales
        )

    def adjust(
        self, free: _Rows, iterations: tuple[int, int], stop: NDArray[np.bool_], *, keeps_part: bool = True
    ) -> None:
        """Gather, solve and apply; arguments as of `solve`.

        Args:
            keeps_part: whether a solution that was stopped on its way counts.
        """
        with self._map.lock:
            gathered = self.gather(free)
        solution = self.solve(gathered, iterations, stop)
        torn = self._torn(gathered, solution)
        if len(torn):
            with self._map.lock:
                gathered = self.gather(np.setdiff1d(gathered.free, torn).astype(np.int32))
            solution = self.solve(gathered, iterations, stop)
        if solution is None or (stop[0] and not keeps_part):
            return
        with self._map.lock:
            # A loop may have been closed meanwhile: this solution would lie in the world as it was before.
            if self._map.version == gathered.version:
                self.apply(gathered, solution)

    def _torn(self, gathered: Gathered, solution: _Solution | None) -> _Rows:
        """Ids of the free keyframes that a solution would tear away from their parents."""
        if solution is None:
            return np.empty(0, np.int32)
        with self._map.lock:
            before = self._map.columns.camera_from_world.copy()
            parents = self._map.parents()[gathered.free]
        after = before.copy()
        after[gathered.free] = solution[0][: gathered.problem.free_count]
        free, parents = gathered.free[parents >= 0], parents[parents >= 0]
        was, becomes = (poses[free] @ inverses(poses[parents]) for poses in (before, after))
        moved = becomes @ inverses(was)
        cosines = (np.trace(moved[:, :3, :3], axis1=1, axis2=2) - 1.0) / 2.0
        allowed = _TORN_METRES + _TORN_SHARE * np.linalg.norm(was[:, :3, 3], axis=1)
        is_torn = np.linalg.norm(becomes[:, :3, 3] - was[:, :3, 3], axis=1) > allowed
        torn: _Rows = free[is_torn | (cosines < np.cos(np.radians(_TORN_DEGREES)))]
        return torn
