"""New points where two keyframes see the same and depth is missing or far (ORB-SLAM, VI-C; ORB-SLAM2, III-A)."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import MappingConfig
from lpslam.slam.kernels import graph, matching, triangulation
from lpslam.slam.kernels.reprojection import CHI2_DEPTH, CHI2_PIXEL, MIN_DEPTH
from lpslam.slam.map import SlamMap
from lpslam.slam.sensor import SensorModel

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class FreeKeypoints:
    """Copies of a keyframe's keypoints that see no map point yet.

    Attributes:
        keyframe: id.
        camera_from_world: 4×4.
        rows: (n,) which of its keypoints they are.
        pixels: (n, 2).
        seen: their directions, octaves and descriptors.
        depth: (n,) metres, 0 where there is none.
        angle: (n,) radians.
    """

    keyframe: int
    camera_from_world: _Matrix
    rows: NDArray[np.int64]
    pixels: NDArray[np.float32]
    seen: triangulation.Rays
    depth: NDArray[np.float32]
    angle: NDArray[np.float32]

    @classmethod
    def of(cls, slam_map: SlamMap, keyframe: int, ray_from_pixel: _Matrix) -> "FreeKeypoints":
        """Copy them from the map; `keyframe` must be alive. `ray_from_pixel` is the inverse of the camera matrix."""
        m, slot = slam_map.columns, int(slam_map.columns.keyframe_slot[keyframe])
        rows = np.flatnonzero(m.point[slot, : m.feature_count[slot]] < 0)
        pixels = m.pixels[slot, rows]
        depth = np.where(m.has_depth[slot, rows], m.depth[slot, rows], 0).astype(np.float32)
        seen = triangulation.Rays(
            pixels @ ray_from_pixel[:, :2].T + ray_from_pixel[:, 2], m.octave[slot, rows], m.descriptor[slot, rows]
        )
        pose = m.camera_from_world[keyframe].copy()
        return cls(keyframe, pose, rows, pixels, seen, depth, m.angle[slot, rows])


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """Keypoints of a new keyframe that see the same as keypoints of its neighbours; n pairs.

    Attributes:
        own: (n,) rows of the new keyframe's free keypoints.
        neighbour: (n,) which of the neighbours.
        other: (n,) rows of that neighbour's free keypoints.
        feature: (n,) which of all its keypoints these are.
    """

    own: NDArray[np.int64]
    neighbour: NDArray[np.int64]
    other: NDArray[np.int64]
    feature: NDArray[np.int64]

    def kept(self, chosen: NDArray[np.int64]) -> "Matches":
        """Some of them."""
        return Matches(self.own[chosen], self.neighbour[chosen], self.other[chosen], self.feature[chosen])


@dataclass(frozen=True, slots=True, eq=False)
class Intersection:
    """Where rays of two cameras meet; n rows.

    Attributes:
        points: (n, 3) the middle of the shortest line between the rays.
        first, second: (n,) how far along each ray, in lengths of its direction; not positive behind the camera.
        sine: (n,) of the parallax, the angle between the rays.
    """

    points: _Matrix
    first: _Matrix
    second: _Matrix
    sine: _Matrix


def intersect_rays(rays: _Matrix, other_rays: _Matrix, other_centres: _Matrix) -> Intersection:
    """Intersect rays from the origin with rays from other centres, all (n, 3) and in one frame.

    Parallel rays meet nowhere: their sine is 0 and their point is not finite.
    """
    aa, bb, ab = (np.einsum("ni,ni->n", p, q) for p, q in ((rays, rays), (other_rays, other_rays), (rays, other_rays)))
    ca, cb = (np.einsum("ni,ni->n", other_centres, q) for q in (rays, other_rays))
    # By the cross product: aa·bb − ab² loses all digits where rays are nearly parallel.
    determinant = np.square(np.cross(rays, other_rays)).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (ca * bb - cb * ab) / determinant, (ca * ab - cb * aa) / determinant
        points = (first[:, None] * rays + other_centres + second[:, None] * other_rays) / 2
    return Intersection(points, first, second, np.sqrt(determinant / (aa * bb)))


class Triangulator:
    """Makes points of keypoints that two keyframes see and that depth alone did not make points of.

    Gathering and adding hold the map's lock; searching and intersecting work on copies.
    """

    def __init__(self, slam_map: SlamMap, sensor: SensorModel, config: MappingConfig) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._config = config
        fx, fy, cx, cy, bf = sensor.intrinsics
        self._pixel_from_ray = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        self._ray_from_pixel = np.linalg.inv(self._pixel_from_ray)
        self._least_baseline = bf / fx
        self._pixel_variance = 1.0 / sensor.pixel_information.astype(np.float64)

    def process(self, keyframe: int) -> _Rows:
        """Make new points of what a new keyframe and its neighbours see; returns their ids, rising."""
        with self._map.lock:
            version = self._map.version
            views = [keyframe, *self._neighbours(keyframe).tolist()]
            own, *neighbours = (FreeKeypoints.of(self._map, view, self._ray_from_pixel) for view in views)
        if not neighbours or not len(own.rows):
            return np.empty(0, np.int32)
        matches = self._match(own, neighbours)
        chosen, positions = self._intersect(own, neighbours, matches)
        with self._map.lock:
            # A loop has been closed meanwhile: these points lie in the world as it was before.
            if self._map.version != version or not len(positions):
                return np.empty(0, np.int32)
            return self._add(own, neighbours, matches.kept(chosen), positions)

    def _neighbours(self, keyframe: int) -> _Rows:
        """The best covisible keyframes that are farther off than the sensor's own baseline."""
        slam_map = self._map
        covisible = slam_map.covisible(keyframe, self._config.covisible_points)
        poses = slam_map.columns.camera_from_world[covisible]
        centres = -np.einsum("nji,nj->ni", poses[:, :3, :3], poses[:, :3, 3])
        baselines = np.linalg.norm(centres - slam_map.world_from_keyframe(keyframe)[:3, 3], axis=1)
        far: _Rows = covisible[baselines > self._least_baseline]
        return far[: self._config.triangulated_neighbours]

    # Solving -----------------------------------------------------------------------------------------------------

    def _match(self, own: FreeKeypoints, neighbours: list[FreeKeypoints]) -> Matches:
        """Match one's own keypoints with those of each neighbour."""
        fx, fy = self._sensor.intrinsics[:2].tolist()
        pairs: list[NDArray[np.int64]] = []
        for number, other in enumerate(neighbours):
            match = triangulation.match_epipolar(
                own.seen,
                other.seen,
                other.camera_from_world @ inverse_transform(own.camera_from_world),
                (fx, fy),
                CHI2_DEPTH * self._pixel_variance,
                self._config.fuse_hamming,
                self._config.triangulation_ratio,
            )
            matching.keep_consistent_rotations(match, own.angle, other.angle)
            found = np.flatnonzero(match >= 0)
            pairs.append(np.stack([match[found], np.full(len(found), number), found, other.rows[found]]))
        return Matches(*np.concatenate(pairs, axis=1))

    def _intersect(
        self, own: FreeKeypoints, neighbours: list[FreeKeypoints], matches: Matches
    ) -> tuple[NDArray[np.int64], _Matrix]:
        """The best match of each keypoint that gives a sound point: which (k,), and the points (k, 3) in the world."""
        count = len(matches.own)
        starts = np.searchsorted(matches.neighbour, np.arange(len(neighbours) + 1))
        other_rays, centres, other_depths = np.empty((count, 3)), np.empty((count, 3)), np.zeros(count)
        variances, other_pixels, scales = np.empty(count), np.empty((count, 2)), np.empty(count)
        own_from_other = np.empty((len(neighbours), 4, 4))
        for number, (other, (first, last)) in enumerate(zip(neighbours, pairwise(starts), strict=True)):
            rows, between = matches.other[first:last], slice(first, last)
            own_from_other[number] = own.camera_from_world @ inverse_transform(other.camera_from_world)
            other_rays[between] = other.seen.direction[rows] @ own_from_other[number, :3, :3].T
            centres[between] = own_from_other[number, :3, 3]
            other_depths[between] = other.depth[rows]
            other_pixels[between] = other.pixels[rows]
            variances[between] = self._pixel_variance[other.seen.octave[rows]]
            scales[between] = self._sensor.scales[other.seen.octave[rows]]
        rays = own.seen.direction[matches.own]
        depths = own.depth[matches.own].astype(np.float64)
        own_variances = self._pixel_variance[own.seen.octave[matches.own]]
        own_scales = self._sensor.scales[own.seen.octave[matches.own]]

        # Three witnesses of where along its ray a point lies: the rays' parallax and the two depth readings.
        meeting = intersect_rays(rays, other_rays, centres)
        focal = self._sensor.intrinsics[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            spread = np.abs(meeting.first) * np.sqrt(own_variances + variances) / (focal * meeting.sine)
        spread = np.where((meeting.first > 0) & (meeting.second > 0), spread, np.inf)
        reading = centres + other_depths[:, None] * other_rays
        candidates = np.stack([meeting.points, depths[:, None] * rays, reading])
        sigmas = np.stack([spread, self._depth_sigma(depths), self._depth_sigma(other_depths)])
        sharpest = sigmas.argmin(axis=0)
        points = np.take_along_axis(candidates, sharpest[None, :, None], axis=0)[0]
        sigma = sigmas.min(axis=0)

        turned_back = own_from_other[matches.neighbour, :3, :3]
        in_other = np.einsum("nji,nj->ni", turned_back, points - centres)
        distances, other_distances = (np.linalg.norm(p, axis=1) for p in (points, in_other))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            scale_ratio = (other_distances / distances) / (scales / own_scales)
            sound = (
                (points[:, 2] > MIN_DEPTH)
                & (in_other[:, 2] > MIN_DEPTH)
                & (sigma < self._config.max_depth_uncertainty * points[:, 2])
                & (self._pixel_errors(points, own.pixels[matches.own]) < CHI2_PIXEL * own_variances)
                & (self._pixel_errors(in_other, other_pixels) < CHI2_PIXEL * variances)
                & self._agrees(points[:, 2], sigma, depths)
                & self._agrees(in_other[:, 2], sigma, other_depths)
                & (np.maximum(scale_ratio, 1 / scale_ratio) < self._config.scale_tolerance)
            )
        # Neighbours compete for a keypoint: whoever knows best how far it is.
        order = np.flatnonzero(sound)
        order = order[np.lexsort((sigma[order], matches.own[order]))]
        _, firsts = np.unique(matches.own[order], return_index=True)
        chosen = order[firsts]
        world_from_own = inverse_transform(own.camera_from_world)
        return chosen, points[chosen] @ world_from_own[:3, :3].T + world_from_own[:3, 3]

    def _depth_sigma(self, depths: _Matrix) -> _Matrix:
        """(n,) metres; infinite where there is no reading."""
        sensor = self._sensor
        return np.where(depths > 0, sensor.depth_sigma + sensor.depth_sigma_quadratic * depths**2, np.inf)

    def _agrees(self, z: _Matrix, sigma: _Matrix, depths: _Matrix) -> NDArray[np.bool_]:
        """Whether depths z (n,) of points known to `sigma` fit the readings (n,); those without reading do."""
        fits: NDArray[np.bool_] = (z - depths) ** 2 < CHI2_DEPTH * (sigma**2 + self._depth_sigma(depths) ** 2)
        return fits | (depths <= 0)

    def _pixel_errors(self, points: _Matrix, pixels: NDArray[np.floating]) -> _Matrix:
        """(n,) squared distances, pixels², of points (n, 3) of a camera frame from where they were seen."""
        projected = points @ self._pixel_from_ray.T
        return np.asarray(np.square(projected[:, :2] / projected[:, 2:] - pixels).sum(axis=1))

    # Adding ------------------------------------------------------------------------------------------------------

    def _add(self, own: FreeKeypoints, neighbours: list[FreeKeypoints], matches: Matches, positions: _Matrix) -> _Rows:
        """Put points (k, 3) into the map whose two keypoints are still free."""
        slam_map, m = self._map, self._map.columns
        slots = m.keyframe_slot[[other.keyframe for other in neighbours]]
        own_rows = own.rows[matches.own]
        slot = int(m.keyframe_slot[own.keyframe])
        free = (slots[matches.neighbour] >= 0) & (m.point[slot, own_rows] < 0)
        free &= m.point[slots[matches.neighbour], matches.feature] < 0
        first = slam_map.add_points(own.keyframe, own_rows[free].astype(np.int32), positions[free])
        points = np.arange(first, slam_map.point_count, dtype=np.int32)
        m = slam_map.columns
        for number in np.unique(matches.neighbour[free]):
            mine = matches.neighbour[free] == number
            seen = np.full(int(m.feature_count[slots[number]]), -1, np.int32)
            seen[matches.feature[free][mine]] = points[mine]
            graph.link_all(m, seen, int(slots[number]))
        graph.refresh_points(m, points, slam_map.scales)
        return points
