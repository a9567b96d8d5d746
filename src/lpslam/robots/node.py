"""The node: a robot's pictures in; where it is, what the signs say and where one can walk out."""

import threading
import time
from collections.abc import Callable
from typing import Any

from lpslam.camera import PinholeCamera
from lpslam.config import Config, RobotConfig
from lpslam.errors import LpSlamError, UserError
from lpslam.ground.grid import Grid
from lpslam.language.model import LanguageModel
from lpslam.mapfile.language_map import LanguageMap
from lpslam.robots import building, types
from lpslam.robots.bus import Bus, Send
from lpslam.robots.incoming import Incoming, Shot
from lpslam.robots.services import Moment, Services
from lpslam.robots.transforms import Transform, Transforms
from lpslam.session.pace import Pace
from lpslam.session.session import Session
from lpslam.session.step import Step
from lpslam.sources.bags.lenses import camera_of

_MOMENT = 0.05
"""Seconds between two looks for the camera's calibration."""

Note = Callable[[str], None]


class RobotNode:
    """Maps what a robot's camera publishes, and tells the robot.

    Args:
        bus: carries the messages.
        config: thresholds, and the topics in `robots`.
        open_session: makes the map's session when the camera is known.
        language: answers `ask`; the embedded model without.
        say: called with a line for whoever looks after the robot.
        on_goal: called with the `PoseStamped` of every goal that was asked for and found.

    Attributes:
        frames: how many were mapped.
        session: None until the camera is known.
    """

    def __init__(
        self,
        bus: Bus,
        config: Config,
        open_session: Callable[[PinholeCamera], Session],
        language: LanguageModel | None = None,
        say: Note = lambda line: None,
        on_goal: Callable[[Any], None] = lambda pose: None,
    ) -> None:
        self.frames = 0
        self.session: Session | None = None
        self._bus, self._config, self._robots = bus, config, config.robots
        self._open_session, self._say, self._on_goal = open_session, say, on_goal
        self._camera: PinholeCamera | None = None
        self._camera_frame = ""
        self._complained: set[str] = set()
        self._silent: set[str] = set()
        self._transforms = Transforms(config.robots.transform_s)
        self._incoming, self._tolerance = Incoming(config.pairing, config.live.backlog), config.pairing.tolerance_s
        self._hung: tuple[str, Transform] | None = None
        self._now = 0
        self._grid: Grid | None = None
        self._ended = threading.Event()
        self._news = threading.Event()
        self._telling: threading.Thread | None = None
        self._told_skipped = 0.0
        self._skipped_before = 0
        self._connect(self._robots, language)

    def _connect(self, robots: RobotConfig, language: LanguageModel | None) -> None:
        bus, name = self._bus, robots.namespace.rstrip("/")
        self._tell_pose = self._publisher(f"{name}/pose", types.POSE)
        self._tell_markers = self._publisher(f"{name}/markers", types.MARKERS, latched=True)
        self._tell_detections = self._publisher(f"{name}/landmarks", types.DETECTIONS, latched=True)
        self._tell_grid = self._publisher(f"{name}/grid", types.GRID, latched=True)
        self._tell_path = self._publisher(f"{name}/path", types.PATH, latched=True)
        self._tell_transform = self._publisher("/tf", types.TRANSFORMS)
        services = Services(
            lambda: self.session,
            lambda: self._grid,
            self._config,
            language,
            lambda: Moment(self._now, robots.map_frame),
            self._take_goal,
        )
        bus.serve(f"{name}/ask", types.ASK, services.ask)
        bus.serve(f"{name}/goal", types.GOAL, services.goal)
        bus.subscribe("/tf_static", types.TRANSFORMS, lambda data: self._take_transforms(data, True), latched=True)
        bus.subscribe("/tf", types.TRANSFORMS, lambda data: self._take_transforms(data, False))
        bus.subscribe(robots.info_topic, types.CAMERA_INFO, self._take_info, reliable=robots.reliable)
        for topic, is_depth in ((robots.colour_topic, False), (robots.depth_topic, True)):
            self._subscribe_pictures(topic, is_depth)

    def _publisher(self, topic: str, kind: str, *, latched: bool = False) -> Send:
        """As the bus's, but what cannot be sent, as when the bus is taken down first, does not end the mapping."""
        send = self._bus.publisher(topic, kind, latched=latched)

        def tried(message: Any) -> None:
            try:
                send(message)
            except Exception as error:
                self._complain(f"{topic} cannot be told ({type(error).__name__})")

        return tried

    def _subscribe_pictures(self, topic: str, is_depth: bool) -> None:
        is_packed = topic.rpartition("/")[2] in ("compressed", "compressedDepth")
        kind = types.COMPRESSED if is_packed else types.IMAGE
        self._bus.subscribe(
            topic,
            kind,
            lambda data: self._incoming.put(data, kind, is_depth=is_depth),
            reliable=self._robots.reliable,
        )

    def run(
        self,
        should_stop: Callable[[], bool],
        *,
        patience: float | None = None,
        max_frames: int | None = None,
        on_step: Callable[[Step], None] = lambda step: None,
    ) -> LanguageMap | None:
        """Map until told to stop; the map, or None if no frame came.

        Args:
            should_stop: asked before every frame.
            patience: seconds within which the first frame must come; for ever without.
            max_frames: end after so many.
            on_step: called after every frame.

        Raises:
            UserError: nothing came in time; says what is missing.
        """
        began = time.monotonic()

        def is_over() -> bool:
            if not self.frames and patience is not None and time.monotonic() - began > patience:
                raise UserError(f"no frame came within {patience:g} s: {self._missing()}")
            self._say_what_is_wrong(began)
            return should_stop() or (max_frames is not None and self.frames >= max_frames)

        while self._camera is None:
            if is_over():
                return None
            time.sleep(_MOMENT)
        with self._open_session(self._camera) as session:
            self.session = session
            self._telling = threading.Thread(target=self._tell_beside, args=(session,), name="telling", daemon=True)
            self._telling.start()
            # What came while the networks were loaded was not too fast.
            self._incoming.dropped = 0
            for shot in self._incoming.shots(self._camera, is_over):
                if shot is not None and (step := self._step(session, shot)) is not None:
                    on_step(step)
            self._end_telling()
            session.frames_dropped, session.frames_skipped = self._incoming.dropped, self._incoming.skipped.total
            if not self.frames:
                return None
            world = session.close()
        self._tell_last(world)
        return world

    def close(self) -> None:
        """End all threads and let go of the bus."""
        self._end_telling()
        self._incoming.close()
        self._bus.close()

    @property
    def skipped(self) -> str:
        """What could not be used, in a line; empty where all could."""
        return self._incoming.skipped.said()

    @property
    def dropped(self) -> int:
        """Frames that came too fast."""
        return self._incoming.dropped

    def _take_info(self, data: bytes) -> None:
        if self._camera is not None:
            return
        topic = self._robots.info_topic
        try:
            info = types.decoded(data, types.CAMERA_INFO)
            self._camera_frame = str(info.header.frame_id).lstrip("/")
            self._camera = camera_of(info, topic, is_rectified="rect" in self._robots.colour_topic)
        except LpSlamError as error:
            self._incoming.skipped.note(str(error))
            self._complain(str(error))

    def _take_transforms(self, data: bytes, is_static: bool) -> None:
        try:
            self._transforms.add(types.decoded(data, types.TRANSFORMS), is_static=is_static)
        except LpSlamError as error:
            self._incoming.skipped.note(str(error))

    def _step(self, session: Session, shot: Shot) -> Step | None:
        try:
            step = session.step(shot.rgb, shot.depth, shot.nanoseconds / 1e9)
        except UserError as error:
            self._incoming.skipped.note(_without_figures(str(error)))
            return None
        self.frames += 1
        self._now = shot.nanoseconds
        if step.pose is not None:
            self._tell_where(step.pose, shot)
        if step.new_landmarks or step.renamed_landmarks:
            self._news.set()
        return step

    def _tell_where(self, map_from_camera: Transform, shot: Shot) -> None:
        robots, stamp = self._robots, shot.nanoseconds
        camera = shot.frame_id.lstrip("/") or self._camera_frame or "camera"
        place = map_from_camera
        if robots.base_frame:
            camera_from_base = self._transforms.between(camera, robots.base_frame, stamp)
            if camera_from_base is None:
                self._complain(f"no transform leads from {camera} to {robots.base_frame}; the camera's pose is told")
            else:
                place = map_from_camera @ camera_from_base
        self._tell_pose(building.pose_stamped(place, stamp, robots.map_frame))
        # A frame has one parent: whatever the camera hangs on in the end is hung below the map.
        child = robots.odom_frame or self._transforms.top(camera, robots.map_frame)
        camera_from_child = self._transforms.between(camera, child, stamp)
        if camera_from_child is not None:
            self._hung = child, map_from_camera @ camera_from_child
        elif self._hung is None or self._hung[0] != child:
            self._complain(f"no transform leads from {camera} to {child}; tf is not told")
            return
        self._tell_transform(building.transforms([(robots.map_frame, *self._hung)], stamp))

    def _tell_landmarks(self, session: Session | LanguageMap) -> None:
        marks, frame = session.landmarks(), self._robots.map_frame
        self._tell_markers(building.markers(marks, self._now, frame))
        self._tell_detections(building.detections(marks, self._now, frame))

    def _tell_last(self, world: LanguageMap) -> None:
        self._tell_landmarks(world)
        self._show(world)

    def _tell_beside(self, session: Session) -> None:
        """Landmarks and ground, in a thread of their own: they wait for a frame that is read, and copy the map."""
        landmarks, ground = Pace(self._robots.landmarks_s), Pace(self._robots.grid_s)
        ground.is_due(time.monotonic())
        while not self._ended.is_set():
            has_news = self._news.wait(_MOMENT)
            self._news.clear()
            now = time.monotonic()
            if self.frames and (landmarks.is_due(now) or has_news):
                self._tell_landmarks(session)
            if self.frames and ground.is_due(now):
                self._show(session.snapshot())

    def _end_telling(self) -> None:
        self._ended.set()
        self._news.set()
        if self._telling is not None:
            self._telling.join()

    def _show(self, world: LanguageMap) -> None:
        grid = world.grid(self._config.ground)
        if grid is not None:
            self._grid = grid
            self._tell_grid(building.occupancy_grid(grid, self._now, self._robots.map_frame))

    def _take_goal(self, pose: Any, path: Any) -> None:
        self._tell_path(path)
        self._on_goal(pose)

    def _missing(self) -> str:
        robots, heard = self._robots, self._incoming.heard
        topics = [] if self._camera is not None else [robots.info_topic]
        pictures = ((robots.colour_topic, False), (robots.depth_topic, True))
        topics += [topic for topic, is_depth in pictures if is_depth not in heard]
        if topics:
            return f"nothing came on {', '.join(topics)}; is the camera's driver running, and is the topic right?"
        if self._incoming.pairs:
            return self.skipped or "pictures come, and the map is still being opened"
        return self.skipped or f"colour and depth are never within {1000 * self._tolerance:g} ms of each other"

    def _say_what_is_wrong(self, began: float) -> None:
        now = time.monotonic()
        if now - max(began, self._told_skipped) < self._robots.silence_s:
            return
        self._told_skipped = now
        if not self.frames and not self._incoming.pairs:
            self._say(f"waiting: {self._missing()}")
        for topic, is_depth in ((self._robots.colour_topic, False), (self._robots.depth_topic, True)):
            is_silent = bool(self.frames) and now - self._incoming.heard.get(is_depth, began) > self._robots.silence_s
            if is_silent != (topic in self._silent):
                self._silent ^= {topic}
                self._say(f"nothing comes on {topic} any more" if is_silent else f"{topic} is back")
        skipped = self._incoming.skipped.total
        if skipped > self._skipped_before:
            self._skipped_before = skipped
            self._say(f"{skipped} messages or frames could not be used: {self.skipped}")

    def _complain(self, line: str) -> None:
        """Say it once."""
        if line not in self._complained:
            self._complained.add(line)
            self._say(line)


def _without_figures(reason: str) -> str:
    """Reasons that differ in a time are of one kind."""
    return "its time is not later than that of the frame before" if reason.startswith("the time of") else reason
