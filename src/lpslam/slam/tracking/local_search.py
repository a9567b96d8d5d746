"""The search of the local map: what covisible keyframes saw, looked for in a view (ORB-SLAM, V-D)."""

from collections.abc import Iterator

import numpy as np

from lpslam.config import TrackingConfig
from lpslam.slam.association import Associator, View
from lpslam.slam.kernels import graph
from lpslam.slam.kernels.pose import PosePrior, prior_chi2
from lpslam.slam.kernels.relative import CHI2_POSE
from lpslam.slam.map import SlamMap
from lpslam.slam.tracking.guesses import FirstGuess, Search


class LocalSearch:
    """Searches the map around first guesses of a view's pose, and says which outcome is to be believed."""

    def __init__(self, slam_map: SlamMap, associator: Associator, config: TrackingConfig) -> None:
        self._map = slam_map
        self._associator = associator
        self._config = config

    def best(
        self, view: View, starts: Iterator[FirstGuess], gap: float, is_strict: bool, prior: PosePrior | None = None
    ) -> Search | None:
        """The search with most matches, if they are enough; the first that is sure and has enough ends it.

        Args:
            view: what is looked for.
            starts: first guesses, likeliest first.
            gap: seconds since the last frame with a pose; after long ones more is asked.
            is_strict: whether as much is asked as of a camera that was lost.
            prior: what else than points tells the pose.
        """
        config = self._config
        needed = config.min_recovery_inliers if is_strict or gap > config.long_gap else config.min_inliers
        best: Search | None = None
        for start in starts:
            search = self._around(view, start, prior)
            if search is not None and (best is None or search.estimate.matches > best.estimate.matches):
                best = search
            if best is not None and best.is_sure and best.estimate.matches >= needed:
                return best
        if best is None or best.estimate.matches >= config.min_recovery_inliers:
            return best
        # Where the view is new, few map points and many of the last view's own may hold the pose together.
        held = best.estimate.matches >= config.min_pose_inliers and best.estimate.inliers >= 2 * needed
        return best if best.is_sure and held and not is_strict else None

    def _around(self, view: View, start: FirstGuess, prior: PosePrior | None) -> Search | None:
        """Search the points of covisible keyframes near their projections, and optimise with all matches."""
        slam_map, associator = self._map, self._associator
        local = associator.around(start.nearby, self._config.local_keyframes)
        if not len(local):
            return None
        candidates = graph.points_of(slam_map.columns, local, slam_map.point_count)
        held = start.points[start.points >= 0]
        is_held = np.zeros(slam_map.point_count, np.bool_)
        is_held[held] = True
        predicted = associator.predict(candidates[~is_held[candidates]], start.camera_from_world)
        found = associator.match_predicted(view, predicted, start.points >= 0)
        points = np.where(found >= 0, found, start.points)
        refined = associator.optimise_on_map(view.features, start.camera_from_world, points, prior=prior)
        if refined is not None and refined.matches < self._config.weak_inliers:
            # Few map points at the rim of a new view hold a pose badly: what the last view saw of it helps.
            refined = associator.optimise_on_map(view.features, start.camera_from_world, points, start.loose, prior)
        if refined is None:
            return None
        expected = np.concatenate([predicted.points, held])
        # Keypoints on streaks agree on little; that whole pictures tell the same says as much.
        is_sure = start.agreement >= self._config.min_agreement
        is_sure = is_sure or (prior is not None and prior_chi2(refined.camera_from_world, prior) <= CHI2_POSE)
        return Search(refined, int(local[0]), expected, is_sure)

    def count(self, search: Search) -> None:
        """Note in the map what was seen of what should be: points that are seldom found are culled by that."""
        self._map.columns.visible[search.expected] += 1
        self._map.columns.found[search.estimate.points[search.estimate.points >= 0]] += 1
