"""RGB-D visual SLAM: frame in, pose out."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import SlamConfig
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.slam.advice import NO_ADVICE, LoopAdvisor
from lpslam.slam.features import FeatureExtractor, gray_of
from lpslam.slam.map import SlamMap
from lpslam.slam.mapping.back_end import BackEnd, Beside, InStep
from lpslam.slam.mapping.far_points import FarPoints
from lpslam.slam.mapping.levelling import floor_normal, level_rotation
from lpslam.slam.mapping.local_mapping import LocalMapper
from lpslam.slam.mapping.whole_pictures import WholePictures
from lpslam.slam.places.index import PlaceIndex
from lpslam.slam.places.locating import Locator
from lpslam.slam.places.loop_closing import LoopCloser, LoopEvent
from lpslam.slam.places.relocalising import Relocaliser
from lpslam.slam.ranges.learning import DepthRanges
from lpslam.slam.sensor import SensorModel
from lpslam.slam.shutter.straightening import RollingShutter
from lpslam.slam.state import EventKind, SlamEvent, TrackedFrame
from lpslam.slam.tracking.tracker import Tracker
from lpslam.slam.trajectory import Trajectory


class RgbdSlam:
    """Tracks a camera and maps what it sees.

    Frames are processed in the caller's thread, in order. In step, the same frames give the same map, to the bit; live,
    mapping and loop closing have threads of their own beside it, and another helps to find keypoints.

    Args:
        camera: of the frames.
        config: thresholds; defaults without.
        live: whether to map, close loops and find half of the keypoints in threads.
        base: a map to find the camera in; it grows, if the map `grows` at all.
        grows: whether new places are mapped; without, `base` is only read (localisation mode).
        advisor: what is known of places beyond their keypoints.

    Raises:
        UserError: the configured keypoints do not fit those of `base`.

    Attributes:
        map, trajectory: the result so far.
        events: every change of state.
    """

    def __init__(
        self,
        camera: PinholeCamera,
        config: SlamConfig | None = None,
        *,
        live: bool = False,
        base: SlamMap | None = None,
        grows: bool = True,
        advisor: LoopAdvisor = NO_ADVICE,
    ) -> None:
        config = config or SlamConfig()
        self.camera = camera
        self.sensor = SensorModel.of(camera, config)
        self.events: list[SlamEvent] = []
        self.trajectory = Trajectory()
        self._keypoints = ThreadPoolExecutor(1, thread_name_prefix="keypoints") if live else None
        extractor = FeatureExtractor(camera, config.features, self._keypoints)
        if base is not None:
            _refuse_other_features(base, extractor, grows)
        self.map = base if base is not None else SlamMap(extractor.capacity, self.sensor.scales)
        self._is_new = base is None
        places = PlaceIndex.of(self.map)
        locator = Locator(self.map, self.sensor, config.tracking, config.locating, config.fitting)
        relocaliser = Relocaliser(self.map, places, locator, config.tracking, config.locating, advisor)
        shutter = RollingShutter(self.sensor, self.map, config.tracking, config.shutter)
        far_points = FarPoints(self.map, self.sensor, config.far_points)
        self._tracker = Tracker(
            extractor,
            self.sensor,
            self.map,
            relocaliser,
            shutter,
            far_points,
            config,
            grows,
            self.events.append,
            lambda: self._back_end.is_idle,
            advisor,
        )
        self._ranges = DepthRanges(self.map, self.sensor, config.features.max_depth, config.ranges)
        self._pictures = WholePictures(self.map, camera, self.sensor, config)
        self._mapper = LocalMapper(self.map, self.sensor, shutter, self._ranges, self._pictures, far_points, config)
        self._loop_closer = LoopCloser(self.map, self.sensor, places, locator, config, advisor)
        self._back_end: BackEnd = (
            Beside(self._mapper, self._close_loops, self._loop_closer.interrupt)
            if live
            else InStep(self._mapper, self._close_loops)
        )
        self._levelling = config.levelling
        self._is_live = live
        self._curve = self.map.depth_curve
        self._depths: dict[int, NDArray[np.float32]] = {}
        self._floor_views: list[tuple[int, NDArray[np.float64]]] = []

    @property
    def keyframes_abandoned(self) -> int:
        """Keyframes that `finish` found waiting and left as tracking had made them."""
        return self._back_end.abandoned

    def process(self, frame: RgbdFrame) -> TrackedFrame:
        """Track one frame and let the map grow with it; its depth is corrected here, see `measured`."""
        frame = self.measured(frame)
        tracked = self._tracker.track(frame)
        self._tracker.hindsight.disown(self.trajectory)
        if tracked.is_keyframe:
            self._depths[tracked.keyframe] = frame.depth
            self._pictures.keep(tracked.keyframe, gray_of(frame.rgb), frame.depth)
        for keyframe in self._tracker.released_keyframes():
            if not self._is_live:
                self._look_for_floor(keyframe)
            self._back_end.take(keyframe)
        if tracked.is_keyframe:
            with self.map.lock:
                if self.map.is_home(tracked.keyframe):
                    tracked = replace(tracked, world_from_camera=self.map.world_from_keyframe(tracked.keyframe))
        self.trajectory.append(tracked)
        self._tracker.hindsight.revise(self.trajectory)
        self.trajectory.revise(self._tracker.early_frames.revise())
        self._tell_ranges(frame.index, frame.timestamp)
        return tracked

    def measured(self, frame: RgbdFrame) -> RgbdFrame:
        """A frame with its depth as the map takes it: corrected by what is known of its error by range."""
        curve = self.map.depth_curve
        return frame if curve.is_straight else replace(frame, depth=curve.true(frame.depth))

    def finish(self) -> None:
        """End all work and level the map by all views of the floor together; call after the last frame."""
        self._tracker.finish()
        self._tracker.hindsight.disown(self.trajectory)
        self._back_end.finish()
        self._mapper.finish()
        self.trajectory.revise(self._tracker.early_frames.revise())
        if self.map.keyframe_count:
            self._tell_ranges(*self.map.frame_of(self.map.keyframe_count - 1))
        if self._keypoints is not None:
            self._keypoints.shutdown()
        for event in self._loop_closer.join_parts():
            self._tell(event)
        if self._is_new:
            self.map.settle()
            views = [(k, normal) for k, normal in self._floor_views if self.map.is_home(k)]
            if views:
                self._level(np.median([self.map.world_from_keyframe(k)[:3, :3] @ n for k, n in views], axis=0))

    def _close_loops(self, keyframe: int) -> None:
        # Live, tracking need not wait for it.
        self._look_for_floor(keyframe)
        event = self._loop_closer.process(keyframe)
        if event is not None:
            self._tell(event)

    def _tell(self, event: LoopEvent) -> None:
        frame, timestamp = self.map.frame_of(event.keyframe)
        self.events.append(SlamEvent(event.kind, frame, timestamp, event.reason))

    def _tell_ranges(self, frame: int, timestamp: float) -> None:
        """Say how depth is corrected since it was said last."""
        if self.map.depth_curve is not self._curve:
            self._curve = self.map.depth_curve
            reading, true = self._curve.largest_change
            reason = f"depth is wrong by its range and is corrected: {reading:.2f} m stand for {true:.2f} m"
            self.events.append(SlamEvent(EventKind.DEPTH_RANGES, frame, timestamp, reason))

    def _look_for_floor(self, keyframe: int) -> None:
        """Turn the map so that z is up when the floor is first seen; later views serve `finish`."""
        depth = self._depths.pop(keyframe, None)
        if depth is None or not self._is_new:
            return
        with self.map.lock:
            camera_from_world = self.map.camera_from_world(keyframe)
            # Sub-maps are level each for itself: any of them may be the map in the end.
            submaps = self.map.submaps()
            views = sum(int(submaps[k] == submaps[keyframe]) for k, _ in self._floor_views)
        if views >= self._levelling.max_views:
            return
        normal = floor_normal(depth, self.camera, camera_from_world[:3, 2], self._levelling)
        if normal is None:
            return
        self._floor_views.append((keyframe, normal))
        if views == 0 and self.map.is_home(keyframe):
            self._level(camera_from_world[:3, :3].T @ normal)

    def _level(self, up_in_world: NDArray[np.float64]) -> None:
        with self.map.lock:
            self.map.transform(level_rotation(up_in_world))


def _refuse_other_features(base: SlamMap, extractor: FeatureExtractor, grows: bool) -> None:
    """Keypoints are compared level by level, and a map that grows must have room for them."""
    if len(base.scales) != len(extractor.scales) or not np.allclose(base.scales, extractor.scales):
        raise UserError(
            f"the map was made with {len(base.scales)} pyramid levels to {base.scales[-1]:.3g} times the pixel, the"
            f" configuration has {len(extractor.scales)} to {extractor.scales[-1]:.3g}; use the map's configuration"
        )
    if grows and extractor.capacity > base.features_per_keyframe:
        raise UserError(
            f"the map has room for {base.features_per_keyframe} keypoints a frame, the configuration wants"
            f" {extractor.capacity}; use the map's configuration"
        )
