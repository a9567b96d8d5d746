"""The pose that most of what a view sees agrees on, whatever moves in it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.config import TrackingConfig
from lpslam.slam.features import Features
from lpslam.slam.kernels import pose
from lpslam.slam.kernels.hypotheses import PointSights, best_hypothesis, truncated_cost
from lpslam.slam.kernels.pose import PosePrior, no_prior
from lpslam.slam.kernels.rays import RaySights
from lpslam.slam.map import SlamMap
from lpslam.slam.rays import is_unsure, ray_sights, sway
from lpslam.slam.sensor import SensorModel

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Sights:
    """What keypoints see, m of them.

    Attributes:
        keypoints: (m,) rows of the view's keypoints.
        positions: (m, 3) world frame.
        spread: (m,) pixels² by which the projections are uncertain since the positions are.
        points: (m,) ids of map points, or -1.
    """

    keypoints: _Rows
    positions: _Matrix
    spread: _Matrix
    points: NDArray[np.int32]

    def kept(self, chosen: _Rows | NDArray[np.bool_]) -> "Sights":
        """Some of them."""
        return Sights(self.keypoints[chosen], self.positions[chosen], self.spread[chosen], self.points[chosen])


@dataclass(frozen=True, slots=True, eq=False)
class _Measured:
    """Sights as kernels take them: which of them (m,) are rays, the others, and the rays."""

    is_ray: NDArray[np.bool_]
    near: PointSights
    rays: RaySights


class Posing:
    """Finds the poses of views from what their keypoints see.

    Args:
        slam_map: in which the points are.
        sensor: of the views.
        config: thresholds.
    """

    def __init__(self, slam_map: SlamMap, sensor: SensorModel, config: TrackingConfig) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._config = config
        # Always the same, so that the same frames make the same map.
        self._draws = np.random.default_rng(1).random((config.hypotheses, 6))

    def find(
        self, features: Features, guess: _Matrix, sights: Sights, prior: PosePrior | None = None
    ) -> tuple[_Matrix, _Rows]:
        """Pose (4×4, camera from world) from a guess, and the rows (of m sights) that agree with it.

        Least squares is pulled by what moves near the camera, and by a guess that is far off. So what confirmed points
        say alone is tried as well and, where many do not agree, what random few say. The least truncated cost decides.
        """
        measured, told = self._measured(features, sights), no_prior() if prior is None else prior
        found = self._refined(measured, guess, told)
        confirmed = is_confirmed(self._map, sights.points)
        are_some = self._config.min_judges <= np.count_nonzero(confirmed) < len(confirmed)
        is_doubtful = len(found[1]) < self._config.doubtful_share * len(confirmed)
        is_doubtful = is_doubtful and len(measured.near.points) >= self._config.min_pose_inliers
        if not are_some and not is_doubtful:
            return found
        weights = self._weights(features, sights, measured.is_ray, confirmed)
        judged = measured.near, measured.rays, weights, self._sensor.intrinsics
        candidates = [found]
        if are_some:
            first, _ = self._refined(self._measured(features, sights.kept(confirmed)), guess, told)
            candidates.append(self._agreeing_with(features, sights, first, told))
        if is_doubtful:
            hypothesis, _ = best_hypothesis(guess, *judged, self._draws)
            candidates.append(self._agreeing_with(features, sights, hypothesis, told))
        return min(candidates, key=lambda each: truncated_cost(each[0], *judged, np.inf))

    def _measured(self, features: Features, sights: Sights) -> _Measured:
        """Points and rays among sights, with what the view measured of them."""
        information = self._sensor.pixel_information[features.octave[sights.keypoints]]
        is_ray = is_unsure(self._map, sights.points)
        far = sights.kept(is_ray)
        rays = ray_sights(self._map, far.points, features.pixels[far.keypoints], information[is_ray])
        near, information = sights.kept(~is_ray), information[~is_ray]
        keypoints = near.keypoints
        points = PointSights(
            near.positions,
            features.pixels[keypoints],
            features.pixels[keypoints, 0] - features.u_right[keypoints],
            features.has_depth[keypoints],
            (information / (1.0 + near.spread * information)).astype(np.float32),
            self._sensor.disparity_information(features.depth[keypoints]),
        )
        return _Measured(is_ray, points, rays)

    def _refined(self, measured: _Measured, guess: _Matrix, prior: PosePrior) -> tuple[_Matrix, _Rows]:
        """Robust least squares from a guess; the pose, and the rows (of m sights) that agree."""
        agrees = np.empty(len(measured.is_ray), np.bool_)
        config = self._config
        camera_from_world, agrees[~measured.is_ray], _, agrees[measured.is_ray], _ = pose.optimise_pose(
            guess,
            *measured.near,
            measured.rays,
            prior,
            self._sensor.intrinsics,
            config.pose_rounds,
            config.pose_iterations,
        )
        return camera_from_world, np.flatnonzero(agrees)

    def _weights(
        self, features: Features, sights: Sights, is_ray: NDArray[np.bool_], confirmed: NDArray[np.bool_]
    ) -> _Matrix:
        """(m,) how much each says beside the others, points first and then rays.

        Keypoints on one thing move together with it: all that stand in one place are one witness, however many they
        are. Someone who walks by is new to the map again and again, and what a second keyframe confirmed seldom moves.
        """
        config = self._config
        places = sights.positions / config.crowd_metres
        aside = features.pixels[sights.keypoints] / (config.crowd_share * self._sensor.image_size[0])
        places[is_ray, :2], places[is_ray, 2] = aside[is_ray], _FAR_AWAY
        key = np.floor(places).astype(np.int64) @ _ONE_NUMBER
        _, cell, crowd = np.unique(key, return_inverse=True, return_counts=True)
        weights = np.where(confirmed, 1.0, config.unconfirmed_weight) / crowd[cell]
        return np.concatenate([weights[~is_ray], weights[is_ray]])

    def _agreeing_with(
        self, features: Features, sights: Sights, camera_from_world: _Matrix, prior: PosePrior
    ) -> tuple[_Matrix, _Rows]:
        """A pose refined with all who stand where it puts them, and who they are."""
        pixels = features.pixels[sights.keypoints]
        fx, fy, cx, cy, _ = self._sensor.intrinsics
        x, y, z = (sights.positions @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]).T
        projected = np.column_stack([fx * x, fy * y]) / np.maximum(z, 1e-3)[:, None] + [cx, cy]
        sigmas = self._sensor.pixel_information[features.octave[sights.keypoints]] ** -0.5
        allowed = self._config.agreeing_sigmas * sigmas + sway(self._map, sights.points, camera_from_world, fx)
        near = np.flatnonzero(np.linalg.norm(projected - pixels, axis=1) < allowed)
        refined, agreeing = self._refined(self._measured(features, sights.kept(near)), camera_from_world, prior)
        return refined, near[agreeing]


def is_confirmed(slam_map: SlamMap, points: NDArray[np.int32]) -> NDArray[np.bool_]:
    """(m,) which points (ids, -1 for none) a second keyframe has seen."""
    confirmed: NDArray[np.bool_] = (points >= 0) & (slam_map.columns.observations[points] > 1)
    return confirmed


_FAR_AWAY = -1e5
"""Marks cells of the picture among those of space."""

_ONE_NUMBER = np.array([1, 1 << 20, 1 << 40])
"""Makes one number of a cell's three."""
