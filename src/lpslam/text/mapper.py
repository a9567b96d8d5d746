"""Runtime text mapping (paper, Fig. 1): read, classify, remember, name, place."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform
from lpslam.config import TextConfig
from lpslam.frames import RgbdFrame
from lpslam.language.model import LanguageModel
from lpslam.slam.state import TrackedFrame, TrackingState
from lpslam.text.again.crops import Crop, cut_out
from lpslam.text.again.looking import look_again
from lpslam.text.boards.surroundings import surroundings
from lpslam.text.frame_reader import FrameReader
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.spots import Spots
from lpslam.text.placing.views import bearing_of
from lpslam.text.reading.certainty import probability_right
from lpslam.text.reading.gate import ReadingGate
from lpslam.text.reading.legibility import UNPLACED, SeenSize, frontal_cosine
from lpslam.text.reading.spotting import TextSpotter
from lpslam.text.reading.windows import Windows
from lpslam.text.remembering.evidence import Glance
from lpslam.text.remembering.known_names import ends_are_there
from lpslam.text.remembering.memory import Pool, TextClass
from lpslam.text.remembering.naming import BesideNaming, name_class, needs_name, rename_class
from lpslam.text.remembering.similarity import comparison_key, is_fragment
from lpslam.text.remembering.waiting import CutText, WaitingTexts
from lpslam.text.sightings import Sighting, pictured
from lpslam.text.sorting import BoxSorter
from lpslam.text.text_map import TextMap
from lpslam.text.types import NOWHERE, FrameReading, Placement, Shot, SpottedText, TextObservation, TextStatistics

Array = NDArray[np.float64]


class TextMapper:
    """Turns tracked frames into a map of words.

    Calls must come one after the other, from one thread at a time; which thread does not matter.

    Attributes:
        text_map: what is remembered so far.
        statistics: what it cost and what was lost.
    """

    def __init__(
        self,
        camera: PinholeCamera,
        spotter: TextSpotter,
        config: TextConfig,
        language: LanguageModel | None = None,
        text_map: TextMap | None = None,
        beside: BesideNaming | None = None,
        on_sighting: Callable[[int, TextObservation], None] = lambda text_class, observation: None,
        on_doubtful: Callable[[TextObservation], None] = lambda observation: None,
        on_view: Callable[[int, Sequence[TextObservation]], None] | None = None,
        points_seen_by: Callable[[int], Array] = lambda keyframe: np.zeros((0, 3)),
    ) -> None:
        self.text_map = text_map or TextMap(config)
        self.statistics = TextStatistics()
        self._camera = camera
        self._spotter = spotter
        self._config = config
        self._language = language
        self._beside = beside
        self._on_sighting = on_sighting
        self._on_doubtful = on_doubtful
        self._on_view = on_view
        self._named_beside: set[int] = set()
        self._gate = ReadingGate(config.reading)
        self._windows = Windows(camera, config)
        self._spots = Spots()
        self._sorter = BoxSorter(camera, config, self.text_map.memory, self._spots, points_seen_by)
        self._reader = FrameReader(spotter, self._sorter, config, self.statistics)
        self._waiting = WaitingTexts(config.memory.visit_pause)

    def resume(self, world_from_keyframe: KeyframePoses) -> None:
        """Go on with a text map of an earlier recording: its clock stands still, and its texts are where they were."""
        self.text_map.memory.clock = None
        for text_class in self.text_map.memory.classes:
            for each in text_class.observations:
                pose = world_from_keyframe(each.keyframe)
                if pose is not None and each.placement is not None:
                    seen = SeenSize(each.letter_height, frontal_cosine(each.placement, np.eye(4)))
                    self._spots.add(text_class.id, each.text, each.placement, pose, seen, each.whole)

    def observe(self, frame: RgbdFrame, tracked: TrackedFrame) -> FrameReading | None:
        """Take one frame: let memory fade, and read the frame if its turn has come.

        Args:
            frame: every frame, in order of time.
            tracked: what tracking said of it.

        Returns:
            What was read, or None when the frame was not read.
        """
        self.text_map.memory.forget(frame.timestamp)
        return self.read(frame, tracked) if self.wants(frame, tracked) else None

    def wants(self, frame: RgbdFrame, tracked: TrackedFrame) -> bool:
        """Decide, in little time, whether a frame is worth reading: tracked or lost, due, and sharp.

        May be called from the tracking thread while another frame is being read.
        """
        self.statistics.frames_seen += 1
        if not tracked.is_tracked:
            self.statistics.frames_untracked += 1
            if tracked.state is not TrackingState.LOST or self._on_view is None:
                return False
        if not self._gate.is_due(frame.timestamp):
            return False
        if not self._gate.is_sharp(frame):
            self.statistics.frames_blurred += 1
            return False
        self._gate.taken(frame.timestamp)
        return True

    def read(self, frame: RgbdFrame, tracked: TrackedFrame) -> FrameReading | None:
        """Read a frame and remember what it says; None without a pose or a cause to search, or when it failed."""
        if tracked.is_coasted or tracked.keyframe_from_camera is None:
            # Where it was taken is a guess, or not known: what is written there is not remembered, but may tell it.
            self._read_lost(frame)
            return None
        self.text_map.memory.forget(frame.timestamp)
        self.take_names()
        # In a sub-map that is not joined to the map yet, where a text stands is no evidence.
        world_from_keyframe = None
        if tracked.world_from_camera is not None and not tracked.is_doubted:
            world_from_keyframe = tracked.world_from_camera @ inverse_transform(tracked.keyframe_from_camera)
        shot = Shot(frame, tracked.keyframe, tracked.keyframe_from_camera, world_from_keyframe)
        window = self._windows.next(shot, lambda: self._sorter.expected_in(shot, np.zeros((0, 4, 2)))[1])
        reading = self._reader.read(shot, window) if window is not None else None
        if reading is None:
            return None
        if tracked.is_doubted:
            # Where a text stands would be wrong with the place: nothing is remembered until that is known.
            for text, where in reading.texts.standing():
                if self._sorter.is_sure(where):
                    self._on_doubtful(self._observation(shot, text, where))
            self._tell_view(frame, [(text, None) for text, _ in reading.texts])
            self._gate.hurry(frame.timestamp)
            return reading
        started = perf_counter()
        observations, seen = [], []
        is_new = False
        for text, placement in reading.texts:
            glance = self._glance(shot, text, placement)
            observation = self._observation(shot, text, placement, glance.right)
            seen.append(observation)
            room = self._sorter.room_of(shot, text, placement)
            text_class = self._remember(text, glance, observation, world_from_keyframe, room)
            if text_class.count < self._config.reading.settled_sightings:
                is_new = True
                self._windows.hold(shot, text.box, placement)
            if placement is not None:
                self._keep_crop(text_class, shot, text, glance)
                self._keep_picture(text_class, shot, text, placement, glance)
                if self._sorter.is_sure(placement):
                    self._on_sighting(text_class.id, observation)
                observations.append(observation)
        if self._on_view is not None:
            self._on_view(tracked.keyframe, seen)
        is_new |= self._wait_for_rest(reading, shot)
        for placement in reading.patterns:
            if self._sorter.is_sure(placement):
                self.text_map.patterns.add(tracked.keyframe, placement)
        self.take_waiting(frame.timestamp)
        if is_new:
            self._gate.hurry(frame.timestamp)
        self.statistics.observations += len(observations)
        self.statistics.mapping_ms += 1000.0 * (perf_counter() - started)
        return replace(reading, observations=tuple(observations))

    def _read_lost(self, frame: RgbdFrame) -> None:
        """Tell what a lost camera sees and where before it; nothing is remembered, since it stands nowhere."""
        if self._on_view is None:
            return
        reading = self._reader.read(Shot(frame, NOWHERE, np.eye(4), None))
        if reading is not None:
            self._tell_view(frame, reading.texts)

    def _tell_view(self, frame: RgbdFrame, texts: Iterable[tuple[SpottedText, Placement | None]]) -> None:
        """Tell what a camera sees, and in which directions from itself, wherever it is."""
        if self._on_view is not None:
            shot = Shot(frame, NOWHERE, np.eye(4), None)
            self._on_view(NOWHERE, [self._observation(shot, text, placement) for text, placement in texts])

    def _observation(
        self, shot: Shot, text: SpottedText, placement: Placement | None, right: float | None = None
    ) -> TextObservation:
        size = (placement.width, placement.height) if placement is not None else None
        around = surroundings(shot.frame.rgb, text.box, size)
        return TextObservation(
            shot.frame.index,
            shot.frame.timestamp,
            shot.keyframe,
            text.text,
            text.confidence,
            placement,
            text.letter_height,
            around.ground,
            bearing_of(text.box, self._camera, shot.keyframe_from_camera),
            right,
            ink=around.ink,
            bare=around.bare,
            clear=around.clear,
        )

    def _keep_crop(self, text_class: TextClass, shot: Shot, text: SpottedText, glance: Glance) -> None:
        """Keep what a text looks like while its name is unsure, for a second look."""
        config, text_map = self._config.again, self.text_map
        is_sure = text_class.pool is Pool.LONG_TERM and not text_map.is_unsure(text_class.id)
        if not config.enabled or is_sure:
            return
        left, top, rgb = cut_out(shot.frame.rgb, text.box, config.margin * text.letter_height)
        seen = SeenSize(glance.height, glance.frontal)
        crop = Crop(shot.frame.timestamp, shot.keyframe, shot.keyframe_from_camera.copy(), left, top, rgb, seen)
        text_map.crops.keep(text_class.id, crop, text_map.is_unsure)

    def _keep_picture(
        self, text_class: TextClass, shot: Shot, text: SpottedText, placement: Placement, glance: Glance
    ) -> None:
        """Keep what a text looks like where it is seen better than before."""
        store, seen = self.text_map.sightings, SeenSize(glance.height, glance.frontal).effective
        if store.config.enabled and store.wants(text_class.id, shot.keyframe, seen):
            jpeg = pictured(shot.frame.rgb, text.box, text.letter_height, store.config)
            sighting = Sighting(shot.keyframe, placement.position, seen, jpeg)
            store.keep(text_class.id, sighting, self.text_map.is_remembered)

    def look_again(self, world_from_keyframe: KeyframePoses, should_stop: Callable[[], bool] = lambda: False) -> None:
        """Look once more at texts whose names are unsure, for a set share of what reading has searched."""
        if not self._config.again.enabled or not len(self.text_map.crops):
            return
        pixels = self._config.again.share * self._windows.searched * self._camera.width * self._camera.height
        started = perf_counter()
        try:
            looked = look_again(
                self.text_map, world_from_keyframe, self._camera, self._spotter, self._name, pixels, should_stop
            )
        except Exception as error:
            self.statistics.first_reader_error = self.statistics.first_reader_error or f"second look: {error!r}"
            self.statistics.reader_errors += 1
            return
        self.statistics.second_looks += looked.texts
        self.statistics.second_readings += looked.readings
        self.statistics.second_look_ms += 1000.0 * (perf_counter() - started)

    def _glance(self, shot: Shot, text: SpottedText, placement: Placement | None) -> Glance:
        is_placed = placement is not None and self._sorter.is_sure(placement)
        frontal = (
            frontal_cosine(placement, shot.keyframe_from_camera) if placement is not None and is_placed else UNPLACED
        )
        right = probability_right(
            text.text, text.confidence, text.slots, text.sharpness, text.letter_height, frontal, text.has_hole
        )
        return Glance(text.letter_height, frontal, right, text.slots, is_placed)

    def _wait_for_rest(self, reading: FrameReading, shot: Shot) -> bool:
        """Keep what is cut off; whether any of it may be whole in a moment, and was not read often."""
        is_new, world_from_keyframe = False, shot.world_from_keyframe
        if world_from_keyframe is None:
            return False
        for text, placement in reading.parts.standing():
            glance = self._glance(shot, text, placement)
            observation = self._observation(shot, text, placement, glance.right)
            room = self._sorter.room_of(shot, text, placement, is_cut=True)
            is_known = self._says_what_is_known(text, placement, world_from_keyframe)
            if is_known or self._spots.is_as_long_at(text.text, placement, world_from_keyframe):
                self._remember(text, glance, observation, world_from_keyframe, room)
            else:
                self._strengthen_whole(text, placement, shot.frame.timestamp, world_from_keyframe)
                alike = self._waiting.add(CutText(text, placement, glance, observation, world_from_keyframe, room))
                if alike < self._config.reading.settled_sightings:
                    is_new = True
                    self._windows.hold(shot, text.box, placement)
        return is_new

    def _says_what_is_known(self, text: SpottedText, placement: Placement, world_from_keyframe: Array) -> bool:
        """Whether what may be cut was read so, as a whole, where it stands."""
        return comparison_key(text.text) in self._spots.spellings_at(placement, world_from_keyframe)

    def _strengthen_whole(
        self, text: SpottedText, placement: Placement, timestamp: float, world_from_keyframe: Array
    ) -> None:
        """Count a part for what was read twice as a whole where it stands: that it is there needs no more letters."""
        if not self._sorter.is_sure(placement):
            return
        for text_class in self.text_map.memory.classes_of(self._spots.classes_at(placement, world_from_keyframe)):
            if any(is_fragment(text.text, spelling) for spelling in text_class.read_again):
                self.text_map.memory.confirm(text_class.id, timestamp)

    def take_waiting(self, timestamp: float | None = None) -> None:
        """Remember what was only ever seen in parts, once it is out of view; without a time, at the end, all of it."""
        for cuts in self._waiting.gone(timestamp, self._names_at, self.text_map.memory.is_remembered):
            for cut in cuts:
                self._remember(cut.text, cut.glance, cut.observation, cut.world_from_keyframe, cut.room)

    def _names_at(self, placement: Placement, world_from_keyframe: Array) -> list[str]:
        long_term = self.text_map.memory.long_term
        here = sorted(self._spots.classes_at(placement, world_from_keyframe) & set(long_term))
        return [text for each in here for text in (long_term[each].name, *long_term[each].read_again)]

    def _remember(
        self,
        text: SpottedText,
        glance: Glance,
        observation: TextObservation,
        world_from_keyframe: Array | None,
        room: tuple[float, float],
    ) -> TextClass:
        """Classify a text by what it says and where it stands, strengthen its class and name it (III-C to III-E)."""
        observation = replace(observation, whole=ends_are_there(text.text, room))
        memory, placement = self.text_map.memory, observation.placement
        if placement is None or world_from_keyframe is None or not self._sorter.is_sure(placement):
            text_class = memory.sight(text.text, text.confidence, observation.timestamp, glance=glance)
            if observation.bearing is not None:
                self._sorter.directions.add(observation.keyframe, text_class.id, observation.bearing, glance.height)
        else:
            here = self._spots.classes_at(placement, world_from_keyframe)
            again = self._says_what_is_known(text, placement, world_from_keyframe)
            text_class = memory.sight(text.text, text.confidence, observation.timestamp, here, glance, again)
            seen = SeenSize(glance.height, glance.frontal)
            self._spots.add(text_class.id, text.text, placement, world_from_keyframe, seen, room)
        text_class.observations.append(observation)
        if text_class.pool is Pool.LONG_TERM and needs_name(text_class):
            self._name(text_class)
        return text_class

    def _name(self, text_class: TextClass) -> None:
        """Name a class that has become long-term, or whose evidence has grown since (III-E)."""
        if text_class.id in self._named_beside:
            # The slow model's name stays until it has seen the new evidence too.
            text_class.named_at_count = text_class.count
        elif not name_class(text_class, self._language, self._config):
            self.statistics.language_errors += 1
        if self._beside is not None:
            self._beside.ask(text_class.id, text_class.readings(self._config.memory))

    def take_names(self) -> None:
        """Take the names that a slow model has found meanwhile; call it once more at the end."""
        for key, naming in self._beside.answers() if self._beside is not None else ():
            text_class = self.text_map.memory.long_term[key]
            if rename_class(text_class, naming, self._config.spotting.max_length):
                self._named_beside.add(key)
            else:
                self.statistics.language_errors += 1
