"""Which keypoints of a view see which map points, and the pose that follows from them (ORB-SLAM, V)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.config import TrackingConfig
from lpslam.slam.features import Features
from lpslam.slam.kernels import graph, matching
from lpslam.slam.kernels.pose import PosePrior
from lpslam.slam.map import SlamMap
from lpslam.slam.posing import Posing, Sights, is_confirmed
from lpslam.slam.rays import sway
from lpslam.slam.sensor import SensorModel

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """A view's pose with the map points that hold it.

    Attributes:
        camera_from_world: 4×4.
        points: (n,) the map point of each keypoint, or -1; inliers only.
        inliers: how many keypoints agree with the pose, counting points that are not in the map.
        agreement: share of the points whose word counts that agree.
        loose: (n, 4) where the keypoints stand, in the world, that agree without being of the map, and by how many
            pixels² that is uncertain; else not a number.
    """

    camera_from_world: _Matrix
    points: _Rows
    inliers: int
    agreement: float = 1.0
    loose: _Matrix | None = None

    @property
    def matches(self) -> int:
        """How many keypoints see a map point."""
        return int((self.points >= 0).sum())


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """The keypoints of a frame or keyframe, bucketed for window searches."""

    features: Features
    keypoints: matching.Keypoints

    @classmethod
    def of(cls, features: Features, sensor: SensorModel) -> "View":
        """Bucket keypoints once for all searches."""
        starts, order, size = matching.build_grid(features.pixels, *sensor.image_size)
        keypoints = matching.Keypoints(
            features.pixels, features.u_right, features.has_depth, features.octave, features.descriptor,
            starts, order, size,
        )  # fmt: skip
        return cls(features, keypoints)


@dataclass(frozen=True, slots=True, eq=False)
class Predicted:
    """Map points that a camera at some pose should see.

    Attributes:
        points: (m,) ids.
        projections: (m, 3) u, v, u_r.
        levels: (m,) the pyramid level at which each should be found.
        cosines: (m,) between the direction from which it was seen and this one.
        sway: (m,) pixels by which it may stand beside, since its distance is not known.
    """

    points: _Rows
    projections: NDArray[np.float32]
    levels: _Rows
    cosines: NDArray[np.float32]
    sway: _Matrix


class Associator:
    """Matches views with the map by appearance and by projection, and optimises their poses."""

    def __init__(self, slam_map: SlamMap, sensor: SensorModel, config: TrackingConfig) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._config = config
        self._posing = Posing(slam_map, sensor, config)

    def optimise(
        self,
        features: Features,
        guess: _Matrix,
        match: _Rows,
        positions: _Matrix,
        points: _Rows,
        spread: _Matrix | None = None,
        prior: PosePrior | None = None,
    ) -> Estimate | None:
        """Pose from matches; None when too few keypoints agree with any.

        Args:
            features: the view's keypoints, n rows.
            guess: 4×4 camera from world to begin with.
            match: (n,) the row of `positions` and `points` that each keypoint sees, or -1.
            positions: (m, 3) world frame.
            points: (m,) ids of map points; -1 for positions that are not in the map.
            spread: (m,) pixels² by which the projections are uncertain since the positions are; none where not given.
            prior: what else tells the pose.
        """
        keypoints = np.flatnonzero(match >= 0)
        rows = match[keypoints]
        unsure = np.zeros(len(keypoints)) if spread is None else spread[rows]
        seen = Sights(keypoints, positions[rows], unsure, points[rows])
        camera_from_world, agreeing = self._posing.find(features, guess, seen, prior)
        if len(agreeing) < self._config.min_pose_inliers:
            return None
        judges = self._judges(seen.points)
        agreement, seen = float(judges[agreeing].sum() / judges.sum()), seen.kept(agreeing)
        held = np.full(features.rows, -1, np.int32)
        held[seen.keypoints] = seen.points
        loose = np.full((features.rows, 4), np.nan)
        others = seen.kept(seen.points < 0)
        loose[others.keypoints, :3], loose[others.keypoints, 3] = others.positions, others.spread
        return Estimate(camera_from_world, held, len(agreeing), agreement, loose)

    def _judges(self, points: _Rows) -> NDArray[np.bool_]:
        """Whose word counts: points that a second keyframe confirmed, for what moves seldom is; all where few were."""
        confirmed = is_confirmed(self._map, points)
        return confirmed if np.count_nonzero(confirmed) >= self._config.min_judges else np.ones(len(points), np.bool_)

    def optimise_on_map(
        self,
        features: Features,
        guess: _Matrix,
        points: _Rows,
        loose: _Matrix | None = None,
        prior: PosePrior | None = None,
    ) -> Estimate | None:
        """Pose from the map points (n,) that the keypoints see, -1 for none, from `loose` places of some others, and
        from what else tells it.
        """
        is_loose = np.zeros(features.rows, np.bool_) if loose is None else (points < 0) & ~np.isnan(loose[:, 0])
        seeing = np.flatnonzero((points >= 0) | is_loose)
        match = np.full(features.rows, -1, np.int32)
        match[seeing] = np.arange(len(seeing))
        ids = points[seeing]
        positions, spread = self._map.columns.position[ids], np.zeros(len(ids))
        if loose is not None:
            positions[ids < 0] = loose[seeing[ids < 0], :3]
            spread[ids < 0] = loose[seeing[ids < 0], 3]
        return self.optimise(features, guess, match, positions, ids, spread, prior)

    def match_descriptors(self, view: View, keyframe: int) -> _Rows:
        """(n,) points of a keyframe by appearance alone, wherever they are in the image; -1 for none."""
        m = self._map.columns
        slot = int(m.keyframe_slot[keyframe])
        if slot < 0:
            return np.full(view.features.rows, -1, np.int32)
        rows = np.flatnonzero(m.point[slot, : m.feature_count[slot]] >= 0).astype(np.int32)
        match = self.match_anywhere(view, m.descriptor[slot, rows], m.angle[slot, rows])
        points: _Rows = np.where(match >= 0, m.point[slot, rows][match] if len(rows) else -1, -1).astype(np.int32)
        return points

    def match_anywhere(self, view: View, descriptors: NDArray[np.uint64], angles: NDArray[np.float32]) -> _Rows:
        """(n,) for each keypoint the row of the descriptors (m, 4) that it is, by appearance alone; -1 for none."""
        config = self._config
        match = matching.match_brute_force(
            descriptors, view.features.descriptor, config.hamming_strict, config.ratio_brute_force
        )
        matching.keep_consistent_rotations(match, angles, view.features.angle)
        return match

    def match_windows(
        self,
        view: View,
        projections: NDArray[np.float32],
        octaves: _Rows,
        descriptors: NDArray[np.uint64],
        angles: NDArray[np.float32],
        radius: float,
    ) -> _Rows:
        """(n,) for each keypoint the row of the projection that it is, or -1.

        Args:
            view: where to look.
            projections: (m, 3) u, v, u_r.
            octaves, descriptors, angles: (m,) as they were last seen.
            radius: pixels at the finest level.
        """
        match = matching.search_windows(
            projections,
            (radius * self._sensor.scales[octaves]).astype(np.float32),
            octaves - 1,
            octaves + 1,
            descriptors,
            view.keypoints,
            np.zeros(view.features.rows, np.bool_),
            self._config.hamming_loose,
            1.0,
        )
        matching.keep_consistent_rotations(match, angles, view.features.angle)
        return match

    def predict(self, candidates: _Rows, camera_from_world: _Matrix) -> Predicted:
        """Which of some map points (ids) a camera should see, and where."""
        m, sensor = self._map.columns, self._sensor
        points, projections, levels, cosines = matching.project_candidates(
            candidates,
            m.position,
            m.normal,
            m.distance_range,
            camera_from_world,
            sensor.intrinsics,
            sensor.image_size,
            len(sensor.scales),
            sensor.log_scale,
            self._config.min_view_cosine,
        )
        aside = sway(self._map, points, camera_from_world, float(sensor.intrinsics[0]))
        return Predicted(points, projections, levels, cosines, aside)

    def match_predicted(
        self, view: View, predicted: Predicted, taken: NDArray[np.bool_], widening: float = 1.0
    ) -> _Rows:
        """(n,) the predicted map point that each keypoint sees, or -1.

        Args:
            view: where to look.
            predicted: map points with their projections.
            taken: (n,) keypoints that are not to be matched.
            widening: factor on the radius of the windows.
        """
        config = self._config
        frontal = predicted.cosines > config.frontal_cosine
        radius = widening * np.where(frontal, config.local_map_radius_frontal, config.local_map_radius)
        aside = np.minimum(predicted.sway, config.motion_radius)
        match = matching.search_windows(
            predicted.projections,
            (radius * self._sensor.scales[predicted.levels] + aside).astype(np.float32),
            predicted.levels - 1,
            predicted.levels,
            self._map.columns.point_descriptor[predicted.points],
            view.keypoints,
            taken,
            config.hamming_loose,
            config.ratio_local_map,
        )
        found = predicted.points[match] if len(predicted.points) else np.full(len(match), -1, np.int32)
        points: _Rows = np.where(match >= 0, found, -1).astype(np.int32)
        return points

    def around(self, points: _Rows, limit: int) -> _Rows:
        """Keyframes that share points (ids, -1 ignored), most first, then those that share points with them."""
        slam_map = self._map
        counts = graph.count_shared_points(slam_map.columns, points, slam_map.keyframe_count)
        order = np.argsort(-counts, kind="stable").astype(np.int32)
        first = order[: min(int(np.count_nonzero(counts)), limit)]
        if len(first) in (0, limit):
            return first
        further = graph.points_of(slam_map.columns, first, slam_map.point_count)
        counts = graph.count_shared_points(slam_map.columns, further, slam_map.keyframe_count)
        counts[first] = 0
        order = np.argsort(-counts, kind="stable").astype(np.int32)
        second = order[: min(int(np.count_nonzero(counts)), limit - len(first))]
        return np.concatenate([first, second])
