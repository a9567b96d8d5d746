"""Tracking: the pose of each frame against the map (ORB-SLAM, V; ORB-SLAM2, III).

Between frames keypoints are followed by optical flow; every few frames, and whenever too few are left, new keypoints
are matched with the local map, which keeps drift out and decides about keyframes. Where flow fails, the motion model
and then the reference keyframe give the first guess. A frame that fits nothing is lost and says why; lost frames are
looked for in the whole map, and after a while a new sub-map is begun.
"""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.advice import NO_ADVICE, LoopAdvisor
from lpslam.slam.association import Associator, Estimate, View
from lpslam.slam.features import FeatureExtractor, Features, gray_of, no_features
from lpslam.slam.kernels import graph
from lpslam.slam.map import SlamMap
from lpslam.slam.places.relocalising import Relocaliser
from lpslam.slam.sensor import SensorModel
from lpslam.slam.shutter.revising import EarlyFrames
from lpslam.slam.shutter.straightening import RollingShutter
from lpslam.slam.state import EventKind, SlamEvent, TrackedFrame, TrackingState
from lpslam.slam.tracking.anchoring import Anchoring
from lpslam.slam.tracking.coasting import Coasting
from lpslam.slam.tracking.doubt import Doubt
from lpslam.slam.tracking.guesses import FirstGuess, Followed, LastFrame, Search
from lpslam.slam.tracking.guessing import Guesser
from lpslam.slam.tracking.keyframes import Keyframes
from lpslam.slam.tracking.motion import ConstantVelocity, UsualSharpness

_Matrix = NDArray[np.float64]
_Rows = NDArray[np.int32]


class Tracker:
    """Follows the camera through frames that come in order of time.

    Args:
        extractor, sensor: of the camera.
        slam_map: where the frames are looked for; keyframes are added to it if the map `grows`.
        relocaliser: finds lost frames.
        shutter: straightens what is seen in motion.
        config: all thresholds.
        grows: whether new places are mapped; else the map is only read.
        on_event: told every change of state.
        is_mapping_idle: whether no keyframe waits for local mapping; else one that is not urgent is not made.
        advisor: may speak against a place in which the camera was found again.
    """

    def __init__(
        self,
        extractor: FeatureExtractor,
        sensor: SensorModel,
        slam_map: SlamMap,
        relocaliser: Relocaliser,
        shutter: RollingShutter,
        config: SlamConfig,
        grows: bool = True,
        on_event: Callable[[SlamEvent], None] = lambda event: None,
        is_mapping_idle: Callable[[], bool] = lambda: True,
        advisor: LoopAdvisor = NO_ADVICE,
    ) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._config = config.tracking
        self._keyframe_config = config.keyframes
        self._extractor = extractor
        self._associator = Associator(slam_map, sensor, config.tracking)
        self._relocaliser = relocaliser
        self._keyframes = Keyframes(slam_map, sensor, config.keyframes)
        self._grows = grows
        self._on_event = on_event
        self._is_mapping_idle = is_mapping_idle
        founds = grows and slam_map.keyframe_count == 0
        self.state = TrackingState.INITIALISING if founds else TrackingState.LOST
        self._reference = slam_map.keyframe_count - 1
        self._last: LastFrame | None = None
        self._seen = no_features()
        self._is_repeated = False
        self._motion = ConstantVelocity()
        self._shutter = shutter
        self.early_frames = EarlyFrames(
            slam_map, self._associator, shutter, config.shutter.revised_frames, config.shutter.longest_gap
        )
        self._guesser = Guesser(extractor, sensor, slam_map, self._associator, self._motion, self._shutter, config)
        self._anchoring = Anchoring(sensor, config.tracking)
        self._coasting = Coasting(config.tracking.coast_seconds)
        self._strict_until = -np.inf
        self._unknown_since: float | None = None
        self._doubt = Doubt(slam_map, advisor, config.tracking.doubt_seconds)
        self.disowned_since: float | None = None
        self.bridged: dict[int, _Matrix] = {}
        self._unmapped: list[int] = []
        self._sharpness = UsualSharpness()

    def track(self, frame: RgbdFrame) -> TrackedFrame:
        """Find the pose of a frame; a frame that should become a keyframe is added to the map."""
        gray = gray_of(frame.rgb)
        self._is_repeated = self._last is not None and np.array_equal(gray, self._last.gray)
        if self._doubt.is_open and self._last is not None:
            self._settle_doubt(frame, self._last)
        followed = self._follow(frame, gray)
        if followed is not None and not self._must_match(frame, followed):
            with self._map.lock:
                if followed.version == self._map.version:
                    self._seen = followed.seen
                    return self._accept(frame, gray, followed.features, followed.estimate)
        features = self._seen = self._extractor.extract(frame, gray)
        with self._map.lock:
            if self.state is TrackingState.INITIALISING:
                return self._initialise(frame, gray, features)
            # A loop was closed while the frame was followed: its pose lies in the world as it was before.
            fits = followed is not None and followed.version == self._map.version
            straight = self._shutter.straighten(features, self._motion.twist)
            return self._match(frame, gray, View.of(straight, self._sensor), followed if fits else None)

    # Between matches with the map: optical flow -----------------------------------------------------------------

    def _follow(self, frame: RgbdFrame, gray: NDArray[np.uint8]) -> Followed | None:
        """Follow the last frame's keypoints, unless the frame is easy to predict and will be matched anyway."""
        last = self._last
        is_predictable = self._anchoring.is_steady and last is not None and self._guesser.can_predict(last, frame)
        if last is None or (self._anchoring.is_due(frame.timestamp) and is_predictable):
            return None
        followed = self._guesser.follow(last, frame, gray)
        if followed is not None:
            self._anchoring.begin_following(last.timestamp, followed.asked)
        return followed

    def _must_match(self, frame: RgbdFrame, followed: Followed) -> bool:
        """Whether flow is not enough: the picture has moved on, or too little is left of what was followed first."""
        return self._anchoring.is_due(frame.timestamp) or self._anchoring.is_failing(followed)

    # Matching with the map --------------------------------------------------------------------------------------

    def _match(self, frame: RgbdFrame, gray: NDArray[np.uint8], view: View, followed: Followed | None) -> TrackedFrame:
        """Search the local map from the best first guess that leads to enough matches."""
        lost = self.state is TrackingState.LOST
        best = self._best_search(frame, view, self._lost_starts(view) if lost else self._starts(frame, view, followed))
        if best is None and not lost:
            if followed is not None and self._holds(followed):
                self._seen = followed.seen
                return self._accept(frame, gray, followed.features, followed.estimate, is_sure=False)
            # Nothing near where it should be: a frame is given up only after the whole map was searched.
            best, lost = self._best_search(frame, view, self._lost_starts(view), strict=True), True
        if best is None:
            return self._miss(frame, gray, view.features)
        before, coasted = self._last, self._coasting.since
        self._note(best)
        if lost:
            # Nothing leads from where the camera was before to here.
            self._last = None
            self._motion.forget()
        features, estimate = self._straightened(frame, view.features, best.estimate)
        if lost:
            self._strict_until = frame.timestamp + self._config.strict_seconds
            self._tell(EventKind.RELOCALISED, frame, f"{best.estimate.matches} map points matched")
            self._doubt.begin(self._reference, frame.timestamp)
        if best.is_sure:
            self._anchoring.matched(frame.timestamp)
            self._anchoring.saw(features)
        tracked = self._accept(frame, gray, features, estimate, is_matched=True, is_sure=best.is_sure)
        if coasted is not None:
            self._bridge(before, coasted, frame, estimate)
        return tracked

    def _best_search(
        self, frame: RgbdFrame, view: View, starts: Iterator[FirstGuess], strict: bool = False
    ) -> Search | None:
        """The search with most matches, if they are enough; the first that is sure and has enough ends it."""
        config = self._config
        gap = 0.0 if self._last is None else frame.timestamp - self._last.timestamp
        strict = strict or self.state is TrackingState.LOST or frame.timestamp < self._strict_until
        needed = config.min_recovery_inliers if strict or gap > config.long_gap else config.min_inliers
        best: Search | None = None
        for start in starts:
            search = self._search_local_map(view, start)
            if search is not None and (best is None or search.estimate.matches > best.estimate.matches):
                best = search
            if best is not None and best.is_sure and best.estimate.matches >= needed:
                return best
        if best is None or best.estimate.matches >= config.min_recovery_inliers:
            return best
        # Where the view is new, few map points and many of the last view's own may hold the pose together.
        held = best.estimate.matches >= config.min_pose_inliers and best.estimate.inliers >= 2 * needed
        return best if best.is_sure and held and not strict else None

    def _holds(self, followed: Followed) -> bool:
        """Whether flow alone may carry the pose over a frame that the map does not explain: a blurred one, say."""
        config, estimate = self._config, followed.estimate
        return estimate.agreement >= config.min_agreement and estimate.matches >= config.min_inliers

    def _bridge(self, before: LastFrame | None, since: float, frame: RgbdFrame, estimate: Estimate) -> None:
        """The frames that were coasted over lie between the last pose and this one, if both are of one world."""
        last, submaps = self._last, self._map.submaps()
        self.disowned_since = since
        if before is not None and last is not None and submaps[before.reference] == submaps[last.reference]:
            seen_last, seen_now = self._guesser.pose(before), self._guesser.pose(last)
            if self._anchoring.may_be_one_way(seen_last, seen_now):
                self.disowned_since = None
                self.bridged = self._coasting.bridged(
                    self._map, before.reference, (before.timestamp, seen_last), (frame.timestamp, seen_now)
                )
        self._coasting.end()

    def _straightened(self, frame: RgbdFrame, features: Features, estimate: Estimate) -> tuple[Features, Estimate]:
        """Straighten the keypoints by the velocity that the frame turns out to have, and optimise its pose again."""
        if self._last is None:
            return features, estimate
        twist, used = self._guesser.twist(self._last, frame, estimate.camera_from_world), self._motion.twist
        if twist is not None and (used is None or self._shutter.bends(twist, used)):
            straight = self._shutter.straighten(self._seen, twist)
            again = self._associator.optimise_on_map(straight, estimate.camera_from_world, estimate.points)
            if again is not None:
                return straight, again
        return features, estimate

    def _starts(self, frame: RgbdFrame, view: View, followed: Followed | None) -> Iterator[FirstGuess]:
        if followed is not None:
            yield FirstGuess.near(followed.estimate, view.features.rows)
        if self._last is not None:
            yield from self._guesser.from_motion(self._last, frame, view)
        # Asked for only if that led nowhere: it compares every descriptor with every other.
        yield from self._guesser.from_reference(self._last, view, self._reference)

    def _lost_starts(self, view: View) -> Iterator[FirstGuess]:
        located = self._relocaliser.find(view.features, self._reference)
        if located is not None:
            yield FirstGuess(located.camera_from_world, located.points, located.points)

    def _search_local_map(self, view: View, start: FirstGuess) -> Search | None:
        """Search the points of covisible keyframes near their projections, and optimise with all matches."""
        slam_map, associator = self._map, self._associator
        m = slam_map.columns
        local = associator.around(start.nearby, self._config.local_keyframes)
        if not len(local):
            return None
        candidates = graph.points_of(m, local, slam_map.point_count)
        held = start.points[start.points >= 0]
        is_held = np.zeros(slam_map.point_count, np.bool_)
        is_held[held] = True
        predicted = associator.predict(candidates[~is_held[candidates]], start.camera_from_world)
        found = associator.match_predicted(view, predicted, start.points >= 0)
        points = np.where(found >= 0, found, start.points)
        refined = associator.optimise_on_map(view.features, start.camera_from_world, points)
        if refined is not None and refined.matches < self._config.weak_inliers:
            # Few map points at the rim of a new view hold a pose badly: what the last view saw of it helps.
            refined = associator.optimise_on_map(view.features, start.camera_from_world, points, start.loose)
        if refined is None:
            return None
        expected = np.concatenate([predicted.points, held])
        return Search(refined, int(local[0]), expected, start.agreement >= self._config.min_agreement)

    def _note(self, search: Search) -> None:
        """Take the outcome of a search for the frame's: what was seen of what should be, and the keyframe nearest."""
        if self._grows:
            self._map.columns.visible[search.expected] += 1
            self._map.columns.found[search.estimate.points[search.estimate.points >= 0]] += 1
        self._reference = search.reference

    def _settle_doubt(self, frame: RgbdFrame, last: LastFrame) -> None:
        """After a relocalisation, give the place up again where the signs that are read there are others."""
        since = self._doubt.since
        with self._map.lock:
            is_right = self._doubt.settle(self._reference, frame.timestamp)
            if is_right:
                self._relocaliser.forget()
            if is_right is not False:
                return
            self._tell(EventKind.LOST, frame, f"the signs read since {since:.2f} s are not those of the place")
            self._relocaliser.disown(self._reference, self._guesser.pose(last))
            self._forget_provisional()
        self.state, self._last, self.disowned_since = TrackingState.LOST, None, since
        self._coasting.end()
        self._motion.forget()

    def _forget_provisional(self) -> None:
        """Take back the keyframes made while the place was doubted: it is another one."""
        for keyframe in reversed(self._unmapped):
            if self._map.is_alive(keyframe) and not self._map.is_root(keyframe):
                self._map.remove_keyframe(keyframe)
        self._unmapped.clear()
        self._reference = self._map.living_ancestor(self._reference)

    def finish(self) -> None:
        """The last frame has come: what was only predicted is not confirmed any more."""
        self.disowned_since = self._coasting.since
        self._coasting.end()

    def released_keyframes(self) -> list[int]:
        """New keyframes that are to be worked into the map; while the place is doubted they are held back."""
        if self._doubt.is_open:
            return []
        released, self._unmapped = self._unmapped, []
        return released

    # What becomes of the frame ----------------------------------------------------------------------------------

    def _initialise(self, frame: RgbdFrame, gray: NDArray[np.uint8], features: Features) -> TrackedFrame:
        """The first frame with enough depth founds the map."""
        depths, needed = int(features.has_depth.sum()), self._keyframe_config.min_start_depths
        if depths < needed:
            return self._without_pose(
                frame, f"waiting for a first view: {depths} of {features.rows} keypoints have depth, {needed} needed"
            )
        self._tell(EventKind.INITIALISED, frame, f"{depths} keypoints with depth")
        return self._found(frame, gray, features, inverse_transform(_FIRST_WORLD_FROM_CAMERA))

    def _found(
        self, frame: RgbdFrame, gray: NDArray[np.uint8], features: Features, camera_from_world: _Matrix
    ) -> TrackedFrame:
        """Begin a map or sub-map: every keypoint with depth is a point."""
        self.state, self._unknown_since, self._reference = TrackingState.TRACKING, None, -1
        self._relocaliser.forget()
        self._sharpness.begin(frame)
        nothing_seen = Estimate(camera_from_world, np.full(features.rows, -1, np.int32), 0)
        estimate = self._add_keyframe(frame, features, nothing_seen)
        self._anchoring.matched(frame.timestamp)
        self._anchoring.saw(features)
        return self._commit(frame, gray, features, estimate, is_keyframe=True, reason="")

    def _miss(self, frame: RgbdFrame, gray: NDArray[np.uint8], features: Features) -> TrackedFrame:
        """Nothing fits: coast for a moment, then be lost."""
        last = self._last
        if last is None or self.state is TrackingState.LOST or not self._coasting.goes_on(frame.timestamp):
            return self._lose(frame, gray, features)
        self._coasting.pass_over(frame.index, frame.timestamp)
        if self._unknown_since is None and features.has_depth.sum() >= self._keyframe_config.min_start_depths:
            self._unknown_since = frame.timestamp
        reason = f"coasting: {self._why(frame, features)}"
        if self.state is not TrackingState.WEAK:
            self._tell(EventKind.WEAK, frame, reason)
        self.state = TrackingState.WEAK
        predicted = self._guesser.predicted(last, frame)
        world_from_camera = inverse_transform(predicted)
        return TrackedFrame(
            frame.index,
            frame.timestamp,
            self.state,
            last.reference,
            self._map.camera_from_world(last.reference) @ world_from_camera,
            world_from_camera if self._map.is_home(last.reference) else None,
            0,
            False,
            reason,
            is_coasted=True,
        )

    def _why(self, frame: RgbdFrame, features: Features) -> str:
        """What a frame shows, for a reason."""
        parts = [f"{features.rows} keypoints"]
        if features.rows:
            parts.append(f"{features.has_depth.mean():.0%} of them with depth")
        if self._sharpness.share(frame) < self._config.blur_ratio:
            parts.append(self._sharpness.fault(frame))
        return ", ".join(parts)

    def _lose(self, frame: RgbdFrame, gray: NDArray[np.uint8], features: Features) -> TrackedFrame:
        """Say why; after usable but unknown views for long, begin a sub-map where the camera was last known to be."""
        depths = int(features.has_depth.sum())
        reason = f"no place in the map matched, {self._why(frame, features)}"
        if self._coasting.since is not None:
            self.disowned_since = self._coasting.since
            self._coasting.end()
        if self.state is not TrackingState.LOST:
            self._tell(EventKind.LOST, frame, reason)
        self.state, self._last = TrackingState.LOST, None
        self._doubt.end()
        self._motion.forget()
        if depths < self._keyframe_config.min_start_depths or not self._grows:
            self._unknown_since = None
        elif self._unknown_since is None:
            self._unknown_since = frame.timestamp
        elif frame.timestamp - self._unknown_since >= self._config.submap_after:
            self._tell(EventKind.NEW_SUBMAP, frame, f"unknown for {self._config.submap_after:g} s ({reason})")
            return self._found(frame, gray, features, self._map.camera_from_world(self._reference))
        return self._without_pose(frame, reason)

    def _without_pose(self, frame: RgbdFrame, reason: str) -> TrackedFrame:
        return TrackedFrame(frame.index, frame.timestamp, self.state, self._reference, None, None, 0, False, reason)

    def _accept(
        self,
        frame: RgbdFrame,
        gray: NDArray[np.uint8],
        features: Features,
        estimate: Estimate,
        *,
        is_matched: bool = False,
        is_sure: bool = True,
    ) -> TrackedFrame:
        """Take a pose for the frame's; a keyframe is made only of one that was matched with the map, and is sure."""
        sharpness = self._sharpness.note(frame)
        weak = True
        if estimate.matches < self._config.weak_inliers:
            reason = f"{estimate.matches} map points matched"
        elif not is_sure:
            reason = "most of what was followed disagrees"
        elif self._is_repeated:
            reason = "its picture repeats the one before: it may be of a moment gone by"
        elif sharpness < self._config.blur_ratio:
            reason = self._sharpness.fault(frame)
        else:
            weak, reason = False, ""
        if weak != (self.state is TrackingState.WEAK):
            kind = EventKind.WEAK if weak else EventKind.TRACKING
            self._tell(kind, frame, reason or f"{estimate.matches} map points matched")
        self.state, self._unknown_since = TrackingState.WEAK if weak else TrackingState.TRACKING, None
        is_keyframe = (
            is_matched
            and is_sure
            and self._grows
            and self._keyframes.wants(frame.timestamp, features, estimate.points >= 0, self._is_mapping_idle())
            and not self._keyframes.is_known_view(estimate, self._reference)
        )
        if is_keyframe:
            estimate = self._add_keyframe(frame, features, estimate)
        return self._commit(frame, gray, features, estimate, is_keyframe, reason, is_matched and is_sure)

    def _commit(
        self,
        frame: RgbdFrame,
        gray: NDArray[np.uint8],
        features: Features,
        estimate: Estimate,
        is_keyframe: bool,
        reason: str,
        is_matched: bool = True,
    ) -> TrackedFrame:
        """Keep the frame as the one that the next is predicted from."""
        world_from_camera = inverse_transform(estimate.camera_from_world)
        reference_from_world = self._map.camera_from_world(self._reference)
        twist = None
        if self._last is not None and frame.timestamp > self._last.timestamp:
            seconds = frame.timestamp - self._last.timestamp
            before, predicted = self._guesser.pose(self._last), self._guesser.predicted(self._last, frame)
            self._anchoring.moved(before, estimate.camera_from_world, predicted)
            self._motion.note(before, estimate.camera_from_world, seconds)
            twist = self._motion.twist if self._guesser.tells_velocity(self._last, frame) else None
        keyframe_from_camera = reference_from_world @ world_from_camera
        self._last = LastFrame(
            frame.timestamp,
            gray,
            features,
            self._seen,
            estimate.points,
            self._reference,
            inverse_transform(keyframe_from_camera),
        )
        self._shutter.note(self._last, twist, is_matched, is_keyframe)
        self.early_frames.keep(frame.index, self._last, is_keyframe)
        is_home = self._map.is_home(self._reference)
        return TrackedFrame(
            frame.index,
            frame.timestamp,
            self.state,
            self._reference,
            keyframe_from_camera,
            world_from_camera if is_home else None,
            estimate.matches,
            is_keyframe,
            reason
            if is_home
            else ", ".join(part for part in (reason, "in a sub-map not joined to the map yet") if part),
            self._doubt.is_open,
        )

    def _tell(self, kind: EventKind, frame: RgbdFrame, reason: str) -> None:
        self._on_event(SlamEvent(kind, frame.index, frame.timestamp, reason))

    def _add_keyframe(self, frame: RgbdFrame, features: Features, estimate: Estimate) -> Estimate:
        self._reference, estimate = self._keyframes.add(frame, features, estimate, self._reference)
        self._unmapped.append(self._reference)
        return estimate


_FIRST_WORLD_FROM_CAMERA = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""The map frame starts at the first camera with REP-103 axes: x forward, y left, z up."""
