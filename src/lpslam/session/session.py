"""A map that grows one frame at a time: the one way in which maps are made (paper, Fig. 1)."""

import threading
import time
from collections.abc import AsyncIterator, Callable, Collection
from contextlib import ExitStack
from dataclasses import replace
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import Config
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.language.model import LanguageModel
from lpslam.language.offline import embedded_model
from lpslam.mapfile.compatibility import refuse_other_camera
from lpslam.mapfile.language_map import LanguageMap
from lpslam.navigation.asking import Answer, answer
from lpslam.navigation.directory import Directory
from lpslam.navigation.known import last_view
from lpslam.session.announcing import AnnouncingMapper
from lpslam.session.checks import checked_colour, checked_depth, checked_time, refuse_no_camera, refuse_no_metres
from lpslam.session.copying import copied, poses_now
from lpslam.session.costs import Costs
from lpslam.session.growth import Growth, growth_of, submap_count
from lpslam.session.listeners import Listeners
from lpslam.session.news import News
from lpslam.session.parts import naming_beside, opened_spotter, reading_thread, scans_of
from lpslam.session.step import Step
from lpslam.session.time_screen import Picture, TimeScreen
from lpslam.session.turns import Turns
from lpslam.slam.advice import NO_ADVICE
from lpslam.slam.state import SlamEvent
from lpslam.slam.system import RgbdSlam
from lpslam.text.advice.advising import TextAdvisor
from lpslam.text.correcting.changing import Change, correct, take_back
from lpslam.text.correcting.corrections import Corrections
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.reading.reading_thread import ReadingThread
from lpslam.text.reading.spotting import TextSpotter
from lpslam.text.text_map import TextMap
from lpslam.text.types import Landmark


class Session:
    """Tracks a camera, maps what it sees, and reads and remembers the words, a frame at a time.

    Use it as a context manager, or call `close`. `step` is called from one thread at a time; `landmarks`, `ask`,
    `pose` and `snapshot` from any. `async for step in session` gives the steps that another thread makes.

    Args:
        camera: of the frames.
        config: thresholds; defaults without.
        language: names classes of misread strings and answers `ask`; the embedded model without. Mapping never waits
            for another: the embedded model names at once, and the other's name takes its place when it comes.
        base: a map of an earlier recording that this one continues; it is changed.
        live: frames come from a camera: mapping and reading have threads of their own, and of frames that come faster
            than they can be read the newest is. Implies that reading is not sequential.
        sequential: read in step with tracking: the same frames give the same map; else in a thread beside it.
        spotter: finds and reads text; the networks of the configuration without.
        text: whether to read at all.
        name: of the recording, kept in the map.
        on_landmark: called by `step` and `close`, in their thread, for every new or renamed landmark.
        on_event: the same for whatever happens to tracking and to the map.

    Raises:
        UserError: `base` was made with another camera or other keypoints.

    Attributes:
        frames: how many were taken.
        frames_skipped, frames_dropped: what the caller left out, for the map's statistics.
    """

    def __init__(
        self,
        camera: PinholeCamera,
        config: Config | None = None,
        *,
        language: LanguageModel | None = None,
        base: LanguageMap | None = None,
        live: bool = False,
        sequential: bool = True,
        spotter: TextSpotter | None = None,
        text: bool = True,
        name: str = "session",
        on_landmark: Callable[[Landmark], None] = lambda landmark: None,
        on_event: Callable[[SlamEvent], None] = lambda event: None,
    ) -> None:
        refuse_no_camera(camera)
        self._config = config = config or Config()
        if base is not None:
            refuse_other_camera(base.camera, camera, "the map", config.continued_camera)
        self.camera, self.name = camera, name
        self.frames = self.frames_skipped = self.frames_dropped = 0
        self._language, self._live = language, live
        self._text = base.text if base else TextMap(config.text)
        self._scans = scans_of(base, camera, config.ground)
        self._words = TextAdvisor(config.text.advice, self._text.memory.classes)
        advisor = self._words if text and config.text.advice.enabled else NO_ADVICE
        self._slam = RgbdSlam(camera, config.slam, live=live, base=base.slam if base else None, advisor=advisor)
        # Whoever needs both takes the text map's lock first: reading takes long, and a step must not wait for it.
        self._stepping = threading.RLock()
        self._turns = Turns()
        self._news = News(on_landmark, on_event)
        self._screen: TimeScreen | None = None
        self._latest = -np.inf
        self._pose: NDArray[np.float64] | None = None
        self._listeners = Listeners()
        self._result: LanguageMap | None = None
        self._has_ended = False
        self._beside = naming_beside(language) if text else None
        self._mapper: AnnouncingMapper | None = None
        self._reader: ReadingThread | None = None
        self._first_index, self._hurries = 0, True
        self._resources = ExitStack()
        with ExitStack() as opened:
            # Whatever goes wrong in between, its threads end.
            opened.callback(self._slam.finish)
            self._open(opened, base, spotter, text, sequential)
            self._resources = opened.pop_all()
        self._costs = Costs()

    def _open(
        self, opened: ExitStack, base: LanguageMap | None, spotter: TextSpotter | None, text: bool, sequential: bool
    ) -> None:
        config, live = self._config, self._live
        if base is not None:
            self._slam.trajectory, self._first_index = base.trajectory, base.trajectory.begin_session()
        if not text:
            return
        self._mapper = AnnouncingMapper(
            self.camera,
            spotter or opened_spotter(opened, config.text.spotting, live),
            config.text,
            embedded_model(),
            self._text,
            self._beside,
            on_sighting=self._words.note,
            on_doubtful=self._words.note_doubtful,
            on_view=self._words.note_view,
            points_seen_by=self._slam.map.points_seen_by,
            on_news=self._note_landmarks,
            on_reading=self._news.readings.append,
        )
        if base is not None:
            self._mapper.resume(base.world_from_keyframe)
            self._news.begin(base.landmarks())
        if live:
            # After all that waits is read, and before its process ends.
            opened.callback(self._end_reading)
        if live or not sequential:
            self._reader = opened.enter_context(reading_thread(self._mapper, config.text.reading, live))

    def step(self, rgb: NDArray[np.uint8], depth: NDArray[np.float32], timestamp: float) -> Step:
        """Take one frame.

        The arrays are kept, not copied: do not write to them afterwards.

        Args:
            rgb: (height, width, 3) uint8, in the order red, green, blue. OpenCV's images are blue, green, red, which
                cannot be told from the numbers: `cv2.cvtColor(image, cv2.COLOR_BGR2RGB)`.
            depth: (height, width) float32, metres along the optical axis, registered to the colour; 0 or not-a-number
                where there is none.
            timestamp: seconds, later than that of the frame before. A frame that lies more than ten seconds ahead
                waits for the next one, and is taken with it if that one's time follows; it is left out if not.

        Returns:
            The pose, or why there is none, and what is new.

        Raises:
            UserError: the frame is not as above, and was not taken, or the session is closed.
        """
        colour, metres = checked_colour(rgb, self.camera), checked_depth(depth, self.camera)
        with self._turns:
            self._refuse_closed()
            seconds = checked_time(timestamp, self._latest, self.frames)
            if self._screen is None:
                refuse_no_metres(metres)
                step = self._take_picture((seconds, colour, metres))
                self._screen = TimeScreen(self._config.times, seconds)
                return step
            return self._screen.steps((seconds, colour, metres), self._take_picture, self._first_index + self.frames)

    def take(self, frame: RgbdFrame) -> Step:
        """As `step`, for a frame that is known to be in order, with an index of the caller's.

        Raises:
            UserError: the session is closed, or another frame is being taken.
        """
        with self._turns:
            self._refuse_closed()
            return self._take(frame)

    def _refuse_closed(self) -> None:
        if self._has_ended:
            raise UserError("the session is closed: it takes no more frames; open another one, with base=… to go on")

    def _take_picture(self, picture: Picture) -> Step:
        seconds, colour, depth = picture
        return self._take(RgbdFrame(self.frames, checked_time(seconds, self._latest, self.frames), colour, depth))

    def _take(self, frame: RgbdFrame) -> Step:
        if self._first_index:
            frame = replace(frame, index=self._first_index + frame.index)
        with self._stepping:
            begun = time.perf_counter()
            tracked = self._slam.process(frame)
            self._costs.seconds_tracking += time.perf_counter() - begun
            frame = self._slam.measured(frame)
            self.frames += 1
            self._latest, self._pose = frame.timestamp, tracked.world_from_camera
            if tracked.is_keyframe and self._scans is not None:
                self._scans.take(tracked.keyframe, frame.rgb, frame.depth)
                self._scans.drop(lambda keyframe: not self._slam.map.is_alive(keyframe))
        if self._reader is not None:
            self._reader.observe(frame, tracked)
            if not self._live:
                self._reader.wait_for_place()
        elif self._mapper is not None:
            self._mapper.observe(frame, tracked)
        step = Step(tracked, *self._news.take(self._slam.events))
        self._news.tell(step.new_landmarks, step.renamed_landmarks, step.events)
        self._listeners.tell(step)
        return step

    @property
    def pose(self) -> NDArray[np.float64] | None:
        """`world_from_camera` of the latest frame, 4×4, map frame; None where it is not known."""
        return self._pose

    @property
    def keyframes(self) -> int:
        """How many the map has."""
        return len(self._slam.map.living_keyframes())

    @property
    def submaps(self) -> int:
        """Parts of the map that are not joined: 1 when all is one, 0 before the first keyframe."""
        with self._slam.map.lock:
            return submap_count(self._slam.map)

    @property
    def texts(self) -> int:
        """How many are in long-term memory."""
        return len(self._text.memory.long_term)

    @property
    def seconds(self) -> float:
        """Since the session is open."""
        return self._costs.seconds

    def landmarks(self) -> list[Landmark]:
        """All landmarks as known now, by id. May wait until the frame at hand is read."""
        with self._text_lock():
            return self._text.landmarks(self._keyframe_poses())

    def cloud(self) -> NDArray[np.float64]:
        """(n, 3) positions of the map points as known now, metres, map frame."""
        with self._stepping, self._slam.map.lock:
            return self._slam.map.point_positions()

    @property
    def corrections(self) -> Corrections:
        """What a person has said of landmarks."""
        return self._text.corrections

    @property
    def question(self) -> str | None:
        """By which landmarks are judged; None before anything was."""
        return self._text.question

    def correct(self, change: Change, revision: int | None = None) -> None:
        """Say something of a landmark; it wins over what is read, and is kept in the map.

        Raises:
            ConflictError, NoSuchCorrectionError, UserError: as `text.correcting.changing.correct`.
        """
        with self._text_lock():
            correct(self._text, self._keyframe_poses(), change, embedded_model(), revision)

    def take_back(self, number: int, revision: int | None = None) -> None:
        """Take a correction back, by its number; raises as `correct`."""
        with self._text_lock():
            take_back(self._text, number, revision)

    def growth(self, known: Collection[int], most: int) -> Growth:
        """How far the map has grown; costs tracking a millisecond or two.

        Args:
            known: keyframes whose scans whoever asks has already.
            most: new scans that are given at once.
        """
        with self._stepping, self._slam.map.lock:
            return growth_of(self._slam.map, self._slam.trajectory, self._scans, known, most)

    def ask(
        self,
        question: str,
        *,
        language: LanguageModel | None = None,
        position: NDArray[np.float64] | None = None,
        heading: float | None = None,
        excluded: Collection[int] = (),
    ) -> Answer:
        """Where to go, by what is mapped so far; the arguments are those of `lpslam.ask`. No step waits for the model.

        Raises:
            UserError: the question is empty.
        """
        known = Directory(self.landmarks(), self._config.navigation)
        with self._stepping, self._slam.map.lock:
            _, poses = self._slam.trajectory.world_from_camera(self._slam.map)
        return answer(question, known, last_view(poses), language or self._language, position, heading, excluded)

    def snapshot(self) -> LanguageMap:
        """The map as it is now, which later frames do not change: to save, to distil, to draw."""
        if self._result is not None:
            return copied(self._result)
        with self._text_lock(), self._stepping, self._slam.map.lock:
            return copied(self._whole())

    def close(self, *, hurry: bool = False) -> LanguageMap:
        """End the session and give its map; once more, the same.

        Args:
            hurry: leave what waits to be read unread, and names that a language model has not given yet.

        Raises:
            UserError: the session ended by an error.
        """
        with self._turns.end():
            return self._closed(hurry)

    def _closed(self, hurry: bool) -> LanguageMap:
        if self._result is not None:
            return self._result
        if self._has_ended:
            raise UserError("the session was given up after an error; it has no map")
        self._has_ended = True
        if hurry and self._reader is not None:
            self._reader.abandon()
        try:
            self._hurries = hurry
            self._resources.close()
            if not self._live:
                self._end_reading()
            if self._beside is not None:
                self._beside.finish(0.0 if hurry else self._config.language.patience_s)
            if self._mapper is not None:
                self._mapper.take_last_names()
            self._result = self._whole()
        finally:
            self._listeners.tell(None)
        self._news.tell(*self._news.take(self._slam.events)[:3])
        return self._result

    def _end_reading(self) -> None:
        if self._mapper is not None:
            self._mapper.finish(None if self._hurries else self._keyframe_poses)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        elif not self._has_ended:
            self._has_ended = True
            self._listeners.tell(None)
            self._resources.__exit__(kind, error, trace)

    def __aiter__(self) -> AsyncIterator[Step]:
        """The steps from now on, until the session is closed; call it in an event loop."""
        return self._listeners.listen()

    def _text_lock(self) -> threading.RLock:
        return self._mapper.lock if self._mapper is not None else self._stepping

    def _keyframe_poses(self) -> KeyframePoses:
        """Of the keyframes on which texts hang, at one moment; with the lock of the text map held."""
        return poses_now(self._text, self._slam.map, self._stepping)

    def _note_landmarks(self) -> None:
        self._news.note(self._text.landmarks(self._keyframe_poses()))

    def _whole(self) -> LanguageMap:
        slam = self._slam
        return LanguageMap(
            camera=self.camera,
            slam=slam.map,
            trajectory=slam.trajectory,
            text=self._text,
            source=self.name,
            statistics=self._statistics(),
            events=slam.events,
            scans=self._scans,
        )

    def _statistics(self) -> dict[str, dict[str, float]]:
        skipped = self.frames_skipped + (self._screen.left_out if self._screen is not None else 0)
        frames = {"frames": self.frames, "frames_skipped": skipped, "frames_dropped": self.frames_dropped}
        return self._costs.statistics(frames, self._slam, self._reader, self._mapper)
