"""Where in the map a view could have been taken: for relocalising, closing loops and merging (ORB-SLAM, V-E, VII-B)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import centre_distance, inverse_transform
from lpslam.config import FittingConfig, LocatingConfig, TrackingConfig
from lpslam.slam.advice import Anchor
from lpslam.slam.association import Associator, Estimate, View
from lpslam.slam.consensus import largest_consensus
from lpslam.slam.features import Features
from lpslam.slam.kernels import graph, matching
from lpslam.slam.map import SlamMap
from lpslam.slam.places.anchored import anchored_pose
from lpslam.slam.places.fitting import Fitted
from lpslam.slam.places.located import Expected, Fit, Located, at_least
from lpslam.slam.places.parts import Parts
from lpslam.slam.places.twins import spread_over, twins
from lpslam.slam.rays import is_unsure
from lpslam.slam.sensor import SensorModel

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class _Alike:
    """Keypoints of a view that look like one point of a place each, and like no other of it: rows (n,), points (n,)."""

    keypoints: NDArray[np.intp]
    points: _Rows


class Locator:
    """Finds the pose of a view from appearance alone, and accepts it only where much of the map agrees."""

    def __init__(
        self,
        slam_map: SlamMap,
        sensor: SensorModel,
        tracking: TrackingConfig,
        config: LocatingConfig,
        fitting: FittingConfig | None = None,
    ) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._config = config
        self._fitting = fitting or FittingConfig()
        self._hamming, self._ratio = tracking.hamming_strict, tracking.ratio_brute_force
        self._associator = Associator(slam_map, sensor, tracking)

    def locate(
        self,
        features: Features,
        candidate: int,
        allowed: NDArray[np.bool_] | None = None,
        guess: _Matrix | None = None,
        anchor: Anchor | None = None,
        is_anywhere: bool = True,
        will_look: bool = False,
        fit: Fit | None = None,
    ) -> Located | None:
        """Match by appearance, PnP RANSAC, then guided matching in windows that narrow.

        Args:
            features: the view's keypoints.
            candidate: a keyframe that may show the same place.
            allowed: (K,) keyframes whose points may be used; all without.
            guess: 4×4 camera from world, where something else than appearance says it: tried first, ...
            anchor: ... or, better, what is seen and stands so nowhere else in the map.
            is_anywhere: nothing else says in which part of the map it was taken: the place must look like no other.
            will_look: the picture will be asked for what should be seen; how much of it was found as corners says less.
            fit: where the view's depth has it, if something else than appearance says where to begin.
        """
        config = self._config
        alike = self._alike(features, self._group(candidate, config.matched_keyframes, allowed))
        points = graph.points_of(
            self._map.columns, self._group(candidate, config.guided_keyframes, allowed), self._map.point_count
        )
        if anchor is not None:
            anchored = self._from_anchor(features, candidate, anchor, allowed)
            guess = guess if anchored is None else anchored
        if guess is not None:
            widenings = (config.guess_search, config.wide_search, 1.0)
            estimate = self._guided(features, guess, points, widenings)
            if estimate is not None:
                # What looks alike here and there need not tell the place: something else has.
                located = replace(self._judge(features, candidate, estimate, points, alike), is_told=True)
                if self._is_certain(features, located):
                    return located
        if fit is not None and (anchor is not None or guess is not None):
            fitted = fit(anchor, guess, self._placed(points))
            laid = None if fitted is None else self._fitted(features, candidate, fitted, allowed)
            if laid is not None:
                return laid
        found = self._from_appearance(features, alike)
        if found is None:
            return None
        held = self._held(features, candidate, found.camera_from_world, points, alike, will_look)
        doubt = self._fitting.looks_doubt
        if fit is not None and (fitted := fit(None, found.camera_from_world, self._placed(points), doubt)):
            # A far wall tells a pose to half a metre, whatever stands before it, if that looks like other things.
            again = self._held(features, candidate, fitted.camera_from_world, points, alike, will_look)
            held = max(held, again, key=lambda each: 0 if each is None else each.inliers)
        if held is None or not is_anywhere:
            return held
        is_one = self.fit_elsewhere(features, held, allowed) is None
        return held if is_one and self._is_unique(features, alike, held, allowed) else None

    def is_unique(self, features: Features, located: Located) -> bool:
        """Whether a place that holds for a view looks like no other of the map."""
        alike = self._alike(features, self._group(located.keyframe, self._config.matched_keyframes, None))
        return self._is_unique(features, alike, located, None)

    def _held(
        self,
        features: Features,
        keyframe: int,
        camera_from_world: _Matrix,
        points: _Rows,
        alike: _Alike,
        will_look: bool = False,
    ) -> Located | None:
        """The place around a first pose (4×4), where looks alone hold it."""
        estimate = self._guided(features, camera_from_world, points, (self._config.wide_search, 1.0))
        if estimate is None:
            return None
        located = self._judge(features, keyframe, estimate, points, alike)
        agrees = will_look or located.alike_agreement >= self._config.min_alike_agreement
        return located if agrees and self._is_certain(features, located, will_look) else None

    def _fitted(
        self, features: Features, candidate: int, fitted: Fitted, allowed: NDArray[np.bool_] | None
    ) -> Located | None:
        """The place where a view's depth has it, if as many keypoints as of any place are there.

        How much of the place is seen again is not asked: in another light, or from another side, it is little. Before
        pillars and doors that are all alike as many are there anyway, so the place is doubted until more tells it.
        """
        near = self._nearest(candidate, fitted.camera_from_world, allowed)
        points = graph.points_of(
            self._map.columns, self._group(near, self._config.guided_keyframes, allowed), self._map.point_count
        )
        estimate = self._guided(features, fitted.camera_from_world, points, (1.0,))
        if estimate is None:
            return None
        if centre_distance(estimate.camera_from_world, fitted.camera_from_world) > self._fitting.strays:
            return None
        alike = self._alike(features, self._group(near, self._config.matched_keyframes, allowed))
        located = replace(self._judge(features, near, estimate, points, alike), is_told=True, is_fitted=True)
        return located if self._is_certain(features, located) else None

    def _placed(self, points: _Rows) -> _Matrix:
        """(m, 3) where those of some points (ids) are of which more than the direction is known."""
        positions: _Matrix = self._map.columns.position[points[~is_unsure(self._map, points)]]
        return positions

    def _nearest(self, candidate: int, camera_from_world: _Matrix, allowed: NDArray[np.bool_] | None) -> int:
        """The keyframe nearest to a pose (4×4) in the world of a candidate that looks its way, or the candidate."""
        submaps, living = self._map.submaps(), self._map.living_keyframes()
        here = living[(submaps[living] == submaps[candidate]) & (True if allowed is None else allowed[living])]
        poses = np.array([self._map.world_from_keyframe(keyframe) for keyframe in here.tolist()]).reshape(-1, 4, 4)
        world_from_camera = inverse_transform(camera_from_world)
        looks_there = poses[:, :3, 2] @ world_from_camera[:3, 2] > _SAME_WAY
        if not looks_there.any():
            return candidate
        away = np.linalg.norm(poses[looks_there, :3, 3] - world_from_camera[:3, 3], axis=1)
        return int(here[looks_there][away.argmin()])

    def _guided(
        self, features: Features, camera_from_world: _Matrix, points: _Rows, widenings: Sequence[float]
    ) -> Estimate | None:
        """The pose that points seen around a first one ask for, in windows that narrow."""
        view, pose, estimate = View.of(features, self._sensor), camera_from_world, None
        for widening in widenings:
            predicted = self._associator.predict(points, pose)
            matched = self._associator.match_predicted(view, predicted, np.zeros(features.rows, np.bool_), widening)
            estimate = self._associator.optimise_on_map(features, pose, matched)
            if estimate is None:
                return None
            pose = estimate.camera_from_world
        return estimate if estimate is not None and estimate.matches >= self._config.min_inliers else None

    def _group(self, candidate: int, size: int, allowed: NDArray[np.bool_] | None) -> _Rows:
        covisible = self._map.covisible(candidate, 1)
        if allowed is not None:
            covisible = covisible[allowed[covisible]]
        return np.concatenate([np.array([candidate], np.int32), covisible[: size - 1]])

    def _alike(self, features: Features, group: _Rows) -> _Alike:
        """Match by descriptors with the group's points."""
        slots, rows, points = self._appearances(group)
        m = self._map.columns
        match = matching.match_brute_force(m.descriptor[slots, rows], features.descriptor, self._hamming, self._ratio)
        matching.keep_consistent_rotations(match, m.angle[slots, rows], features.angle)
        keypoints = np.flatnonzero(match >= 0)
        return _Alike(keypoints, points[match[keypoints]])

    def _from_appearance(self, features: Features, alike: _Alike) -> Estimate | None:
        """Pose by PnP in RANSAC over what looks alike."""
        config, keypoints = self._config, alike.keypoints
        if len(keypoints) < config.min_matches:
            return None
        found = largest_consensus(
            self._map.columns.position[alike.points],
            features.pixels[keypoints],
            self._sensor.intrinsics,
            config.trials,
            config.trial_pixels,
        )
        if found is None or len(found.rows) < config.min_trial_inliers:
            return None
        held = np.full(features.rows, -1, np.int32)
        held[keypoints[found.rows]] = alike.points[found.rows]
        return self._associator.optimise_on_map(features, found.camera_from_world, held)

    def _from_anchor(
        self, features: Features, candidate: int, anchor: Anchor, allowed: NDArray[np.bool_] | None
    ) -> _Matrix | None:
        """Pose by an anchor and by what looks alike around it, on the map and in the view."""
        config, m, intrinsics = self._config, self._map.columns, self._sensor.intrinsics
        slots, rows, points = self._appearances(self._group(candidate, config.matched_keyframes, allowed))
        reach, pixels = config.anchor_reach, anchor.pixels(intrinsics).mean(axis=1)
        away = np.linalg.norm(m.position[points][:, None] - anchor.middles, axis=2)
        near = (away < reach).any(axis=1)
        off = np.linalg.norm(features.pixels[:, None] - pixels, axis=2)
        seen = (off < reach * anchor.pixels_per_metre(intrinsics)).any(axis=1)
        slots, rows, points, keypoints = slots[near], rows[near], points[near], np.flatnonzero(seen)
        if not len(points) or not len(keypoints):
            return None
        descriptors = np.ascontiguousarray(features.descriptor[keypoints])
        match = matching.match_brute_force(m.descriptor[slots, rows], descriptors, self._hamming, self._ratio)
        matched = np.flatnonzero(match >= 0)
        found = anchored_pose(
            anchor,
            m.position[points[match[matched]]],
            features.pixels[keypoints[matched]],
            intrinsics,
            config.trial_pixels,
            config.min_anchored,
        )
        if found is None:
            return None
        held = np.full(features.rows, -1, np.int32)
        agreeing = matched[found[1]]
        held[keypoints[agreeing]] = points[match[agreeing]]
        estimate = self._associator.optimise_on_map(features, found[0], held)
        return None if estimate is None else estimate.camera_from_world

    def _appearances(self, group: _Rows) -> tuple[_Rows, _Rows, _Rows]:
        """Slot, keypoint and id of each point of the group, as the first of its keyframes sees it."""
        m = self._map.columns
        slots, rows, points = [], [], []
        for keyframe in group:
            slot = m.keyframe_slot[keyframe]
            seen = m.point[slot, : m.feature_count[slot]]
            mapped = np.flatnonzero(seen >= 0).astype(np.int32)
            slots.append(np.full(len(mapped), slot, np.int32))
            rows.append(mapped)
            points.append(seen[mapped])
        ids, first = np.unique(np.concatenate(points), return_index=True)
        sure = ~is_unsure(self._map, ids)
        ids, first = ids[sure], first[sure]
        return np.concatenate(slots)[first], np.concatenate(rows)[first], ids.astype(np.int32)

    def _judge(self, features: Features, candidate: int, estimate: Estimate, points: _Rows, alike: _Alike) -> Located:
        """Count what should be seen from the pose, except what the view's own depth shows to be hidden."""
        predicted = self._associator.predict(points, estimate.camera_from_world)
        expected = self._sensor.intrinsics[4] / (predicted.projections[:, 0] - predicted.projections[:, 2])
        hidden = _nearest_depth(features, predicted.projections[:, :2]) < (1 - self._config.hidden_share) * expected
        seeing = np.flatnonzero((estimate.points >= 0) & features.has_depth)
        seeing = seeing[~is_unsure(self._map, estimate.points[seeing])]
        position = self._map.columns.position[estimate.points[seeing]]
        pose = estimate.camera_from_world
        z = position @ pose[2, :3] + pose[2, 3]
        agrees = np.abs(z - features.depth[seeing]) < self._config.depth_tolerance * z
        found = np.isin(predicted.points, estimate.points[estimate.points >= 0])
        return Located(
            candidate,
            pose,
            estimate.points,
            estimate.matches,
            Expected(predicted.points[~hidden], predicted.projections[~hidden, :2], predicted.levels[~hidden]),
            Parts.of(predicted.projections[~hidden, :2], found[~hidden], self._sensor.image_size),
            float(agrees.mean()) if len(seeing) else 1.0,
            self._agreement(features, alike, pose),
        )

    def _agreement(self, features: Features, alike: _Alike, camera_from_world: _Matrix) -> float:
        """Share of what looks alike that is seen where a pose (4×4) has it, at least; 1 where too little says anything.

        A pattern, or fronts all alike, fit a wrong pose in their greater part; what tells their places apart does not.
        """
        if len(alike.keypoints) < self._config.min_matches:
            return 1.0
        return at_least(int(self._agrees(features, alike, camera_from_world).sum()), len(alike.keypoints))

    def _agrees(self, features: Features, alike: _Alike, camera_from_world: _Matrix) -> NDArray[np.bool_]:
        """(n,) whether what looks alike is seen where a pose (4×4) has it."""
        fx, fy, cx, cy = self._sensor.intrinsics[:4]
        points = self._map.columns.position[alike.points]
        x, y, z = (points @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]).T
        ahead = np.where(z > 0, z, np.inf)
        off = features.pixels[alike.keypoints] - np.column_stack([fx * x / ahead + cx, fy * y / ahead + cy])
        agrees: NDArray[np.bool_] = (z > 0) & (np.linalg.norm(off, axis=1) < self._config.trial_pixels)
        return agrees

    def _is_unique(
        self, features: Features, alike: _Alike, located: Located, allowed: NDArray[np.bool_] | None
    ) -> bool:
        """Whether enough of what looks alike agrees with the place and looks so nowhere else in the map.

        A floor whose tiles repeat fits in many places; so much of it as agrees says nothing.
        """
        config = self._config
        if len(alike.keypoints) < config.min_matches:
            return True
        asked = spread_over(np.arange(len(alike.keypoints)), _MOST_ASKED)
        sample = _Alike(alike.keypoints[asked], alike.points[asked])
        agrees = self._agrees(features, sample, located.camera_from_world)
        found = features.descriptor[sample.keypoints[agrees]], sample.points[agrees]
        unique = twins(self._map, *found, located.keyframe, config.rival_distance, allowed) < 0
        return at_least(int(unique.sum()), len(asked)) >= config.min_unique_agreement

    def fit_elsewhere(
        self, features: Features, located: Located, allowed: NDArray[np.bool_] | None = None
    ) -> Located | None:
        """Another place of the map that a part of a view fits: by what looks alike and is not where the first has it.

        Before a row of fronts all alike a view fits the map front for front, and a part of it as well as if the camera
        stood before the next one. Which of them it is, or one that is not mapped, its looks do not tell. Where nothing
        repeats, what disagrees does so by chance, and on no second pose.

        Args:
            features: the view's keypoints.
            located: the place that most of it fits.
            allowed: (K,) keyframes whose points may be used; all without.
        """
        config = self._config
        alike = self._alike(features, self._group(located.keyframe, config.guided_keyframes, allowed))
        stray = ~self._agrees(features, alike, located.camera_from_world)
        found = largest_consensus(
            self._map.columns.position[alike.points[stray]],
            features.pixels[alike.keypoints[stray]],
            self._sensor.intrinsics,
            config.trials,
            config.trial_pixels,
        )
        if found is None or len(found.rows) < config.min_trial_inliers:
            return None
        is_elsewhere = centre_distance(located.camera_from_world, found.camera_from_world) > config.rival_distance
        return replace(located, camera_from_world=found.camera_from_world) if is_elsewhere else None

    def _is_certain(self, features: Features, located: Located, will_look: bool = False) -> bool:
        """Look-alike places share patches: believe only what fills the view and contradicts little of the map."""
        config = self._config
        pixels = features.pixels[located.points >= 0]
        cells = np.floor(pixels / np.array(self._sensor.image_size) * config.spread_cells).astype(int)
        spread = len(np.unique(cells[:, 0] * config.spread_cells + cells[:, 1]))
        is_held = located.depth_agreement >= config.min_depth_agreement and spread >= config.min_spread
        least = config.min_told_share if located.is_told else config.min_seen_share
        is_seen = located.seen_share >= least and located.missing_share <= config.max_missing_share
        return is_held and (will_look or located.is_fitted or is_seen)


_SAME_WAY = 0.87
"""Cosine between the axes of cameras that look the same way: 30 degrees."""

_MOST_ASKED = 100
"""Keypoints that are looked for in the whole map: a share is known well enough by so many."""


def _nearest_depth(features: Features, pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Depth of the keypoint nearest to each pixel (m, 2); infinite where that one has none: nothing is known there."""
    from scipy.spatial import cKDTree

    if not features.rows or not len(pixels):
        return np.full(len(pixels), np.inf, np.float32)
    _, nearest = cKDTree(features.pixels).query(pixels)
    return np.where(features.has_depth[nearest], features.depth[nearest], np.float32(np.inf))
