"""The camera found in a saved map, a frame at a time; the map is only read."""

import time

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import Config
from lpslam.frames import RgbdFrame
from lpslam.mapfile.compatibility import refuse_other_camera
from lpslam.mapfile.language_map import LanguageMap
from lpslam.poses import StampedPoses
from lpslam.session.checks import checked_colour, checked_depth, checked_time, refuse_no_camera, refuse_no_metres
from lpslam.session.parts import load_spotter
from lpslam.session.step import Step
from lpslam.session.turns import Turns
from lpslam.slam.advice import NO_ADVICE
from lpslam.slam.state import SlamEvent, TrackedFrame, TrackingState
from lpslam.slam.system import RgbdSlam
from lpslam.text.advice.advising import TextAdvisor
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.spotting import TextSpotter


class Localiser:
    """Finds each frame in a saved map.

    Frames are read while the camera is lost or its pose is guessed, and when it was found among signs, until they have
    been compared. `step` is called from one thread at a time.

    Args:
        camera: of the frames; the camera that made the map.
        world: the map.
        config: thresholds; defaults without.
        spotter: finds and reads text; the networks of the configuration without, loaded when first needed.
        text: whether the signs of the map help to find the camera, and to doubt where it was found.

    Raises:
        UserError: the map was made with another camera.

    Attributes:
        frames: how many were taken.
        seconds_tracking: of processor and waiting time, without reading.
    """

    def __init__(
        self,
        camera: PinholeCamera,
        world: LanguageMap,
        config: Config | None = None,
        *,
        spotter: TextSpotter | None = None,
        text: bool = True,
    ) -> None:
        refuse_no_camera(camera)
        self._config = config = config or Config()
        refuse_other_camera(world.camera, camera, "the map", config.same_camera)
        self.camera, self.frames, self.seconds_tracking = camera, 0, 0.0
        self._spotter = spotter
        self._reads = text and config.text.advice.enabled and bool(world.text.memory.classes)
        self._words = TextAdvisor(config.text.advice, world.text.memory.classes)
        advisor = self._words if self._reads else NO_ADVICE
        self._slam = RgbdSlam(camera, config.slam, base=world.slam, grows=False, advisor=advisor)
        self._reader: TextMapper | None = None
        self._turns = Turns()
        self._latest = -np.inf
        self._events_told = 0

    def step(self, rgb: NDArray[np.uint8], depth: NDArray[np.float32], timestamp: float) -> Step:
        """Find one frame.

        Args:
            rgb, depth, timestamp: as `Session.step` takes them.

        Returns:
            The pose, or why there is none.

        Raises:
            UserError: the frame is not as it should be, and was not taken.
        """
        colour, metres = checked_colour(rgb, self.camera), checked_depth(depth, self.camera)
        with self._turns:
            seconds = checked_time(timestamp, self._latest, self.frames)
            if not self.frames:
                refuse_no_metres(metres)
            return self._take(RgbdFrame(self.frames, seconds, colour, metres))

    def take(self, frame: RgbdFrame) -> Step:
        """As `step`, for a frame that is known to be in order, with an index of the caller's.

        Raises:
            UserError: another frame is being taken.
        """
        with self._turns:
            return self._take(frame)

    def _take(self, frame: RgbdFrame) -> Step:
        before = time.perf_counter()
        tracked = self._slam.process(frame)
        self.seconds_tracking += time.perf_counter() - before
        self.frames += 1
        self._latest = frame.timestamp
        if self._reads and (tracked.is_doubted or tracked.is_coasted or tracked.state is TrackingState.LOST):
            self._read(frame, tracked)
        events = self._slam.events
        fresh, self._events_told = tuple(events[self._events_told :]), len(events)
        return Step(tracked, events=fresh)

    def _read(self, frame: RgbdFrame, tracked: TrackedFrame) -> None:
        self._reader = self._reader or TextMapper(
            self.camera,
            self._spotter or load_spotter(self._config.text.spotting, 0),
            self._config.text,
            on_doubtful=self._words.note_doubtful,
            on_view=self._words.note_view,
        )
        self._reader.observe(self._slam.measured(frame), tracked)

    @property
    def events(self) -> list[SlamEvent]:
        """What happened to tracking so far."""
        return self._slam.events

    @property
    def poses(self) -> StampedPoses:
        """Of the frames that were found so far, in the map's frame; later frames may have placed earlier ones."""
        return StampedPoses(*self._slam.trajectory.world_from_camera(self._slam.map))

    def finish(self) -> None:
        """Whatever frames wait for a later one are settled: none comes any more."""
        self._slam.finish()
