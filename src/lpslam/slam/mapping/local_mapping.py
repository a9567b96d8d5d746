"""Local mapping: what happens to the map when a keyframe arrives (ORB-SLAM, V; ORB-SLAM2, III-C)."""

import numpy as np
from numpy.typing import NDArray

from lpslam.config import SlamConfig
from lpslam.slam.adjusting import Adjuster
from lpslam.slam.kernels import fusing, graph
from lpslam.slam.map import SlamMap
from lpslam.slam.mapping.far_points import FarPoints
from lpslam.slam.mapping.triangulation import Triangulator
from lpslam.slam.mapping.whole_pictures import WholePictures
from lpslam.slam.ranges.learning import DepthRanges
from lpslam.slam.rays import without_unsure
from lpslam.slam.sensor import SensorModel
from lpslam.slam.shutter.straightening import RollingShutter


class LocalMapper:
    """Keeps the part of the map around the newest keyframe accurate and free of what does not hold.

    Each step holds the map's lock for itself; the adjustment works on a copy without it.
    """

    def __init__(
        self,
        slam_map: SlamMap,
        sensor: SensorModel,
        shutter: RollingShutter,
        ranges: DepthRanges,
        pictures: WholePictures,
        far_points: FarPoints,
        config: SlamConfig,
    ) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._shutter = shutter
        self._ranges = ranges
        self._pictures = pictures
        self._far_points = far_points
        self._config = config.mapping
        self._close_depth = config.keyframes.close_depth
        self._adjuster = Adjuster(slam_map, sensor)
        self._triangulator = Triangulator(slam_map, sensor, self._config)
        self._recent_points = np.empty(0, np.int32)
        self._observations_needed = np.empty(0, np.int32)
        self._stop = np.zeros(1, np.bool_)

    def process(self, keyframe: int) -> None:
        """Work a new keyframe into the map."""
        self._stop[0] = False
        if self._measure_anew():
            self._adjust_part(keyframe)
        with self._map.lock:
            self._cull_points(keyframe)
            self._remember(self._born_in(keyframe), self._config.min_observations)
        self._remember(self._triangulator.process(keyframe), self._config.min_triangulated_observations)
        with self._map.lock:
            self._far_points.measure(keyframe)
            neighbours = self._neighbours(keyframe)
        self._fuse(keyframe, neighbours)
        self._pictures.compare(keyframe)
        around = self._around(keyframe)
        self._adjust(around)
        self._ranges.learn(around)
        with self._map.lock:
            self._cull_keyframes(keyframe)

    def finish(self) -> None:
        """The last keyframe has come: what all of them together say of the sensor is applied to all."""
        self._stop[0] = False
        for _ in range(_ROUNDS_AT_THE_END):
            with self._map.lock:
                everyone = self._map.living_keyframes()
                submaps = self._map.submaps()[everyone]
            self._ranges.learn(everyone)
            if not self._measure_anew():
                break
            for part in np.unique(submaps):
                self._adjust_part(int(everyone[submaps == part][0]))
        with self._map.lock:
            self._far_points.forget_unsure()

    def _measure_anew(self) -> bool:
        """Take other pixels and depths for what keyframes saw, where more has become known of the sensor."""
        change = self._ranges.apply()
        if change is not None:
            self._shutter.read_again(change)
            self._pictures.forget()
            with self._map.lock:
                # Steps had another length when they were placed.
                self._far_points.forget_unsure()
        return self._shutter.apply() or change is not None

    def _adjust_part(self, keyframe: int) -> None:
        """Adjust the whole sub-map of a keyframe."""
        with self._map.lock:
            everyone = self._map.living_keyframes()
            submaps = self._map.submaps()
        for _ in range(_ROUNDS_WHEN_MEASURED_ANEW):
            self._adjust(everyone[submaps[everyone] == submaps[keyframe]])

    def hurry(self) -> None:
        """End the running adjustment early: another keyframe waits. May be called from any thread."""
        self._stop[0] = True

    def _born_in(self, keyframe: int) -> NDArray[np.int32]:
        points = graph.points_of(self._map.columns, np.array([keyframe], np.int32), self._map.point_count)
        born: NDArray[np.int32] = points[self._map.columns.first_keyframe[points] == keyframe]
        return born

    def _remember(self, points: NDArray[np.int32], observations: int) -> None:
        """Watch new points until so many keyframes have seen them."""
        self._recent_points = np.concatenate([self._recent_points, points])
        self._observations_needed = np.concatenate(
            [self._observations_needed, np.full(len(points), observations, np.int32)]
        )

    def _cull_points(self, keyframe: int) -> None:
        """Points must earn their place within three keyframes of their birth."""
        m = self._map.columns
        alive = m.point_alive[self._recent_points]
        points, needed = self._recent_points[alive], self._observations_needed[alive]
        age = keyframe - m.first_keyframe[points]
        rarely_found = m.found[points] < self._config.min_found_share * m.visible[points]
        unconfirmed = (age >= 2) & (m.observations[points] < needed)
        drop = rarely_found | unconfirmed
        graph.remove_points(m, points[drop])
        watched = ~drop & (age < 3)
        self._recent_points, self._observations_needed = points[watched], needed[watched]

    def _neighbours(self, keyframe: int) -> NDArray[np.int32]:
        first = self._map.covisible(keyframe, 1)[: self._config.neighbours]
        second = [
            self._map.covisible(int(k), self._config.covisible_points)[: self._config.second_neighbours] for k in first
        ]
        everyone = np.concatenate([first, *second]) if len(first) else first
        unique, where = np.unique(everyone, return_index=True)
        in_order = unique[np.argsort(where)]
        others: NDArray[np.int32] = in_order[in_order != keyframe]
        return others

    def _fuse(self, keyframe: int, neighbours: NDArray[np.int32]) -> None:
        """Look for the keyframe's points in its neighbours and for theirs in it."""
        slam_map, sensor = self._map, self._sensor
        arguments = (
            sensor.intrinsics,
            sensor.image_size,
            sensor.scales,
            sensor.pixel_information,
            self._config.fuse_radius,
            self._config.fuse_hamming,
        )
        with slam_map.lock:
            own = graph.points_of(slam_map.columns, np.array([keyframe], np.int32), slam_map.point_count)
            own = without_unsure(slam_map, own)
        for neighbour in neighbours:
            with slam_map.lock:
                if slam_map.is_alive(int(neighbour)):
                    fusing.fuse_points(slam_map.columns, own, int(neighbour), *arguments)
        with slam_map.lock:
            theirs = graph.points_of(slam_map.columns, neighbours, slam_map.point_count)
            fusing.fuse_points(slam_map.columns, without_unsure(slam_map, theirs), keyframe, *arguments)
            own = graph.points_of(slam_map.columns, np.array([keyframe], np.int32), slam_map.point_count)
            graph.refresh_points(slam_map.columns, own, slam_map.scales)

    def _around(self, keyframe: int) -> NDArray[np.int32]:
        """The keyframe and its best covisible ones."""
        config = self._config
        with self._map.lock:
            covisible = self._map.covisible(keyframe, config.covisible_points)[: config.adjusted_keyframes - 1]
        return np.concatenate([np.array([keyframe], np.int32), covisible])

    def _adjust(self, free: NDArray[np.int32]) -> None:
        """Bundle adjustment of keyframes; one that is hurried counts as far as it came."""
        self._adjuster.adjust(free, (self._config.first_iterations, self._config.iterations), self._stop)

    def _cull_keyframes(self, keyframe: int) -> None:
        """Remove covisible keyframes whose close points others see as well."""
        config, slam_map = self._config, self._map
        for other in slam_map.covisible(keyframe, config.covisible_points):
            if slam_map.is_root(int(other)) or other == keyframe:
                continue
            share = graph.redundant_share(slam_map.columns, int(other), config.redundant_observers, self._close_depth)
            if share > config.redundant_share:
                slam_map.remove_keyframe(int(other))


_ROUNDS_WHEN_MEASURED_ANEW = 2
"""Adjustments of the whole sub-map when all its pixels or depths have changed: the first drops what no longer fits."""

_ROUNDS_AT_THE_END = 3
"""Times that depths may be corrected when a recording ends: a map made of wrong ones shows a part of their error."""
