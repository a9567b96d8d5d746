"""Tracking: the pose of each frame against the map (ORB-SLAM, V; ORB-SLAM2, III).

Between frames keypoints are followed by optical flow; every few frames, and whenever too few are left, new keypoints
are matched with the local map, which keeps drift out and decides about keyframes. Where flow fails, the motion model
and then the reference keyframe give the first guess. A frame that fits nothing is lost and says why; lost frames are
looked for in the whole map, and after a while a new sub-map is begun.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.advice import NO_ADVICE, LoopAdvisor
from lpslam.slam.association import Associator, Estimate, View
from lpslam.slam.delay import DepthDelay
from lpslam.slam.features import FeatureExtractor, gray_of
from lpslam.slam.map import SlamMap
from lpslam.slam.mapping.far_points import FarPoints
from lpslam.slam.places.located import Located
from lpslam.slam.places.relocalising import Relocaliser
from lpslam.slam.sensor import SensorModel
from lpslam.slam.shutter.revising import EarlyFrames
from lpslam.slam.shutter.straightening import RollingShutter
from lpslam.slam.state import EventKind, SlamEvent, TrackedFrame, TrackingState
from lpslam.slam.tracking.anchoring import Anchoring
from lpslam.slam.tracking.backtracking import Backtracking
from lpslam.slam.tracking.carrying_on import CarryingOn
from lpslam.slam.tracking.delay_watch import DelayWatch
from lpslam.slam.tracking.doubt import Doubt
from lpslam.slam.tracking.guesses import FirstGuess, Followed, LastFrame, Search
from lpslam.slam.tracking.guessing import Guesser
from lpslam.slam.tracking.keyframes import Keyframes
from lpslam.slam.tracking.local_search import LocalSearch
from lpslam.slam.tracking.losing import Hindsight, Losing, start_depths
from lpslam.slam.tracking.moving_on import MovingOn
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.quality import Quality
from lpslam.slam.tracking.refinding import Refinding
from lpslam.slam.tracking.stepping import Stepping
from lpslam.slam.tracking.surfaces import Surfaces
from lpslam.slam.tracking.turning import Turning
from lpslam.slam.tracking.whereabouts import Whereabouts

_Matrix = NDArray[np.float64]


class Tracker:
    """Follows the camera through frames that come in order of time.

    Args:
        extractor, sensor: of the camera.
        slam_map: where the frames are looked for; keyframes are added to it if the map `grows`.
        relocaliser: finds lost frames.
        shutter: straightens what is seen in motion.
        far_points: makes points where no depth was read.
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
        far_points: FarPoints,
        config: SlamConfig,
        grows: bool = True,
        on_event: Callable[[SlamEvent], None] = lambda event: None,
        is_mapping_idle: Callable[[], bool] = lambda: True,
        advisor: LoopAdvisor = NO_ADVICE,
    ) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._config = config.tracking
        self._beginnings = config.keyframes
        self._waiting_since: float | None = None
        self._extractor = extractor
        self._shutter = shutter
        self._grows = grows
        self._is_mapping_idle = is_mapping_idle
        founds = grows and slam_map.keyframe_count == 0
        state = TrackingState.INITIALISING if founds else TrackingState.LOST
        self._where = where = Whereabouts(slam_map, on_event, state, slam_map.keyframe_count - 1)
        self._associator = associator = Associator(slam_map, sensor, config.tracking)
        self._refinding = Refinding(relocaliser, associator, extractor, where, config)
        self._search = LocalSearch(slam_map, associator, config.tracking)
        self._keyframes = Keyframes(slam_map, sensor, far_points, config.keyframes)
        self._guesser = Guesser(extractor, sensor, slam_map, associator, where.motion, shutter, config)
        self._backtracking = Backtracking(extractor, sensor, slam_map, associator, self._search, shutter, config)
        self._anchoring = Anchoring(sensor, config.tracking)
        self._quality = Quality(config.tracking)
        self._doubt = Doubt(slam_map, advisor, config.tracking.doubt_seconds, config.locating.sure_inliers)
        surfaces = Surfaces(extractor.camera, sensor, config.surfaces)
        self._stepping = Stepping(slam_map, surfaces, config.pictures)
        turning = Turning(extractor.camera, config.turning, config.surfaces)
        carrying_on = CarryingOn(surfaces, turning, where.motion, config.surfaces.renewed_share)
        self._losing = Losing(where, self._anchoring, self._quality, carrying_on, self._refinding, config, grows)
        self.early_frames = EarlyFrames(
            slam_map, associator, shutter, config.shutter.revised_frames, config.shutter.longest_gap
        )
        delay = DepthDelay(extractor.camera, sensor, config.features, config.delay)
        watch = DelayWatch(where, delay, config.delay)
        self._moving_on = MovingOn(where, self._guesser, self._anchoring, shutter, self.early_frames, watch)
        self._strict_until = -np.inf

    @property
    def hindsight(self) -> Hindsight:
        """What the newest frame tells of those before it."""
        return self._losing.hindsight

    def track(self, frame: RgbdFrame) -> TrackedFrame:
        """Find the pose of a frame; a frame that should become a keyframe is added to the map."""
        gray = gray_of(frame.rgb)
        last = self._where.last
        is_repeated = last is not None and np.array_equal(gray, last.gray)
        if self._doubt.is_open and last is not None:
            self._settle_doubt(frame, last)
        if last is not None:
            self._guesser.look_at_step(last, frame, gray, self._stepping if self._anchoring.may_be_blurred else None)
        followed = self._follow(frame, gray)
        if followed is not None and not self._must_match(frame, followed):
            with self._map.lock:
                if followed.version == self._map.version:
                    picture = Picture(frame, gray, followed.features, followed.seen, is_repeated)
                    return self._accept(picture, followed.estimate)
        seen = self._extractor.extract(frame, gray)
        with self._map.lock:
            if self._where.state is TrackingState.INITIALISING:
                return self._initialise(Picture(frame, gray, seen, seen, is_repeated))
            # A loop was closed while the frame was followed: its pose lies in the world as it was before.
            fits = followed is not None and followed.version == self._map.version
            straight = self._shutter.straighten(seen, self._where.motion.twist)
            return self._match(Picture(frame, gray, straight, seen, is_repeated), followed if fits else None)

    def released_keyframes(self) -> list[int]:
        """New keyframes that are to be worked into the map; while the place is doubted they are held back."""
        return self._doubt.released()

    def finish(self) -> None:
        """The last frame has come."""
        self._losing.finish()

    # Between matches with the map: optical flow -----------------------------------------------------------------

    def _follow(self, frame: RgbdFrame, gray: NDArray[np.uint8]) -> Followed | None:
        """Follow the last frame's keypoints, unless the frame is easy to predict and will be matched anyway."""
        last = self._where.last
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

    def _match(self, picture: Picture, followed: Followed | None) -> TrackedFrame:
        """Search the local map from the best first guess that leads to enough matches."""
        where, view = self._where, View.of(picture.features, self._sensor)
        gap = 0.0 if where.last is None else picture.timestamp - where.last.timestamp
        if (
            self._doubt.is_open
            and where.last is not None
            and self._refinding.is_told_elsewhere(view.features, self._guesser.pose(where.last))
        ):
            self._give_up_place(picture.frame, where.last)
        if where.state is not TrackingState.LOST:
            starts, is_strict = self._starts(picture.frame, view, followed), picture.timestamp < self._strict_until
            prior = self._guesser.prior(where.last, picture.timestamp)
            found = self._search.best(view, starts, gap, is_strict, prior)
            if found is not None:
                pose, carried = found.estimate.camera_from_world, self._losing.expected(picture.timestamp)
                is_told = self._losing.is_way_told
                if self._guesser.can_have_come(where.last, pose, picture.timestamp, carried, is_told):
                    return self._take(picture, found)
            if followed is not None and self._holds(followed):
                picture = replace(picture, features=followed.features, seen=followed.seen)
                return self._accept(picture, followed.estimate, is_sure=False)
        # Nothing near where it should be: a frame is given up only after the whole map was searched.
        located = self._refinding.located(view.features, picture)
        if located is None:
            return self._miss(picture)
        # What a sign and the depth tell needs fewer keypoints beside them.
        start, is_strict = FirstGuess(located.camera_from_world, located.points, located.points), not located.is_fitted
        found = self._search.best(view, iter([start]), gap if is_strict else 0.0, is_strict)
        return self._miss(picture) if found is None else self._take(picture, found, located)

    def _take(self, picture: Picture, found: Search, located: Located | None = None) -> TrackedFrame:
        """Take the outcome of a search for the frame's, of a lost one where it was `located`."""
        where, before, coasted_since = self._where, self._where.last, self._losing.coasted_since
        if self._grows:
            self._search.count(found)
        where.reference = found.reference
        if located is not None:
            where.forget()
        picture, estimate = self._straightened(picture, found.estimate)
        if located is not None:
            self._strict_until = picture.timestamp + (0.0 if located.is_fitted else self._config.strict_seconds)
            where.tell(EventKind.RELOCALISED, picture.frame, f"{found.estimate.matches} map points matched")
            self._doubt.begin(where.reference, picture.timestamp, located.is_fitted)
        if found.is_sure:
            self._anchoring.matched(picture.timestamp)
            self._anchoring.saw(picture.features)
        tracked = self._accept(picture, estimate, is_matched=True, is_sure=found.is_sure)
        if coasted_since is not None and self._losing.bridge(before, coasted_since):
            self._backtracking.forget()
            placed_since = coasted_since
        else:
            placed_since = self._go_back()
        if located is not None:
            self._doubt.reach_back(placed_since)
        return tracked

    def _go_back(self) -> float:
        """Place the frames before this one that nothing placed when they came; the time of the first in seconds."""
        if self._where.last is None:
            return np.inf
        self.hindsight.placed = self._backtracking.back_from(self._where.last)
        return self._backtracking.since

    def _holds(self, followed: Followed) -> bool:
        """Whether flow alone may carry the pose over a frame that the map does not explain: a blurred one, say."""
        config, estimate = self._config, followed.estimate
        return estimate.agreement >= config.min_agreement and estimate.matches >= config.min_inliers

    def _straightened(self, picture: Picture, estimate: Estimate) -> tuple[Picture, Estimate]:
        """Straighten the keypoints by the velocity that the frame turns out to have, and optimise its pose again."""
        where = self._where
        if where.last is None:
            return picture, estimate
        twist, used = self._guesser.twist(where.last, picture.frame, estimate.camera_from_world), where.motion.twist
        if twist is not None and (used is None or self._shutter.bends(twist, used)):
            straight = self._shutter.straighten(picture.seen, twist)
            prior = self._guesser.prior(where.last, picture.timestamp)
            again = self._associator.optimise_on_map(straight, estimate.camera_from_world, estimate.points, prior=prior)
            if again is not None:
                return replace(picture, features=straight), again
        return picture, estimate

    def _starts(self, frame: RgbdFrame, view: View, followed: Followed | None) -> Iterator[FirstGuess]:
        last = self._where.last
        if followed is not None:
            yield FirstGuess.near(followed.estimate, view.features.rows)
        carried = self._losing.expected(frame.timestamp)
        if carried is not None and last is not None:
            yield FirstGuess.at(carried, view.features.rows, last.points)
        if last is not None:
            yield from self._guesser.from_motion(last, frame.timestamp, view)
        # Asked for only if that led nowhere: it compares every descriptor with every other.
        yield from self._guesser.from_reference(last, view, self._where.reference)
        if last is not None:
            # In another light, or in none, what is in view is shaped as before.
            guess = self._guesser.predicted(last, frame.timestamp) if carried is None else carried
            yield from self._refinding.by_depth(frame, view.features.rows, guess)

    # What becomes of the frame ----------------------------------------------------------------------------------

    def _initialise(self, picture: Picture) -> TrackedFrame:
        """The first frame with enough depth founds the map."""
        since = self._waiting_since = picture.timestamp if self._waiting_since is None else self._waiting_since
        needed = start_depths(self._beginnings, picture.timestamp - since)
        depths, rows = picture.depths, picture.features.rows
        if depths < needed:
            self._backtracking.keep(picture)
            why = f"{depths} of {rows} keypoints have depth, {needed} needed"
            if rows < needed:
                why = f"{rows} keypoints, {needed} needed; the picture is plain, dark or blurred"
            return self._where.unknown(picture.frame, f"waiting for a first view: {why}")
        self._where.tell(EventKind.INITIALISED, picture.frame, f"{depths} keypoints with depth")
        return self._found(picture, inverse_transform(_FIRST_WORLD_FROM_CAMERA))

    def _go_on(self, picture: Picture, camera_from_world: _Matrix) -> TrackedFrame:
        """Let the map go on with a keyframe that shares no point with it."""
        where = self._where
        where.state = TrackingState.TRACKING
        where.tell(EventKind.TRACKING, picture.frame, "the map goes on from where the camera was carried without it")
        self._losing.seen()
        self._backtracking.forget()
        return self._make_keyframe(picture, camera_from_world)

    def _found(self, picture: Picture, camera_from_world: _Matrix) -> TrackedFrame:
        """Begin a map or sub-map: every keypoint with depth is a point."""
        begun = self._losing.beginning(picture.timestamp)
        self._where.state, self._where.reference = TrackingState.TRACKING, -1
        self._losing.seen()
        self._refinding.forget()
        self._quality.begin(picture)
        tracked = self._make_keyframe(picture, camera_from_world)
        if begun is not None:
            self._map.beginnings[tracked.keyframe] = begun
        self._go_back()
        return tracked

    def _make_keyframe(self, picture: Picture, camera_from_world: _Matrix) -> TrackedFrame:
        """Make a keyframe of a frame that sees no point of the map."""
        nothing_seen = Estimate(camera_from_world, np.full(picture.features.rows, -1, np.int32), 0)
        estimate = self._add_keyframe(picture, nothing_seen)
        self._anchoring.matched(picture.timestamp)
        self._anchoring.saw(picture.features)
        return self._commit(picture, estimate, "", is_matched=True, is_keyframe=True)

    def _miss(self, picture: Picture) -> TrackedFrame:
        """Nothing fits: coast for a moment, then be lost, then begin a sub-map where the camera was last."""
        self._backtracking.keep(picture)
        coasted = self._losing.coast(picture)
        if coasted is not None:
            here = None if self._doubt.is_open else self._losing.continued(picture)
            if here is not None:
                return self._go_on(picture, here)
            if not self._losing.parts(picture):
                return coasted
        self._doubt.end()
        lost = self._losing.lose(picture)
        return self._found(picture, self._map.camera_from_world(self._where.reference)) if lost is None else lost

    def _settle_doubt(self, frame: RgbdFrame, last: LastFrame) -> None:
        """After a relocalisation, give the place up again where the signs that are read there are others."""
        with self._map.lock:
            is_right = self._doubt.settle(self._where.reference, frame.timestamp)
            if is_right:
                self._refinding.forget()
            if is_right is False:
                self._give_up_place(frame, last)

    def _give_up_place(self, frame: RgbdFrame, last: LastFrame) -> None:
        """The camera is not where it was found: forget what followed from that; the caller holds the map's lock."""
        where, since, placed_since = self._where, self._doubt.since, self._doubt.placed_since
        where.tell(EventKind.LOST, frame, f"the signs read since {since:.2f} s are not those of the place")
        self._refinding.disown(self._guesser.pose(last))
        where.reference = self._doubt.take_back(where.reference)
        self._doubt.end()
        where.state = TrackingState.LOST
        where.forget()
        self._losing.disown(placed_since)

    def _accept(
        self, picture: Picture, estimate: Estimate, *, is_matched: bool = False, is_sure: bool = True
    ) -> TrackedFrame:
        """Take a pose for the frame's; a keyframe is made only of one that was matched with the map, and is sure."""
        where, reason = self._where, self._quality.weakness(picture, estimate, is_sure)
        self._doubt.matched(estimate.matches)
        state = TrackingState.WEAK if reason else TrackingState.TRACKING
        if (state is TrackingState.WEAK) != (where.state is TrackingState.WEAK):
            kind = EventKind.WEAK if reason else EventKind.TRACKING
            where.tell(kind, picture.frame, reason or f"{estimate.matches} map points matched")
        where.state = state
        self._losing.seen()
        is_anchored = is_matched and is_sure
        is_keyframe = is_anchored and self._is_wanted(picture, estimate)
        if is_keyframe:
            estimate = self._add_keyframe(picture, estimate)
        return self._commit(picture, estimate, reason, is_matched=is_anchored, is_keyframe=is_keyframe)

    def _is_wanted(self, picture: Picture, estimate: Estimate) -> bool:
        """Whether a frame should become a keyframe."""
        keyframes, is_matched, last = self._keyframes, estimate.points >= 0, self._where.last
        interval = 0.0 if last is None else picture.timestamp - last.timestamp
        return (
            self._grows
            and keyframes.wants(picture.timestamp, picture.features, is_matched, self._is_mapping_idle(), interval)
            and not keyframes.is_known_view(estimate, self._where.reference)
        )

    def _add_keyframe(self, picture: Picture, estimate: Estimate) -> Estimate:
        where = self._where
        where.reference, estimate = self._keyframes.add(picture.frame, picture.features, estimate, where.reference)
        if self._anchoring.may_be_blurred:
            self._map.blurred.add(where.reference)
        self._doubt.hold(where.reference)
        return estimate

    def _commit(
        self, picture: Picture, estimate: Estimate, reason: str, *, is_matched: bool, is_keyframe: bool
    ) -> TrackedFrame:
        """Keep the frame as the one that the next is predicted from, and say what is known of it."""
        where, frame = self._where, picture.frame
        pose = self._moving_on.keep(picture, estimate, is_matched=is_matched, is_keyframe=is_keyframe)
        is_home = self._map.is_home(where.reference)
        if not is_home:
            reason = ", ".join(part for part in (reason, "in a sub-map not joined to the map yet") if part)
        return TrackedFrame(
            frame.index,
            frame.timestamp,
            where.state,
            where.reference,
            pose,
            inverse_transform(estimate.camera_from_world) if is_home else None,
            estimate.matches,
            is_keyframe,
            reason,
            self._doubt.is_open,
        )


_FIRST_WORLD_FROM_CAMERA = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""The map frame starts at the first camera with REP-103 axes: x forward, y left, z up."""
