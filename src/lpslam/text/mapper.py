"""Runtime text mapping (paper, Fig. 1): read, classify, remember, name, place."""

from collections import deque
from time import perf_counter

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform
from lpslam.config import ReadingConfig, TextConfig
from lpslam.frames import RgbdFrame
from lpslam.language.model import LanguageModel
from lpslam.slam.state import TrackedFrame
from lpslam.text.memory import Pool, TextClass
from lpslam.text.naming import name_class, needs_name
from lpslam.text.placement import PlacementFault, place_text
from lpslam.text.spots import Spots
from lpslam.text.spotting import TextSpotter, accepted_texts, letter_heights, touches_border
from lpslam.text.text_map import TextMap
from lpslam.text.types import BoxFate, FrameReading, SpottedText, TextObservation, TextStatistics

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
    ) -> None:
        self.text_map = text_map or TextMap(config)
        self.statistics = TextStatistics()
        self._camera = camera
        self._spotter = spotter
        self._config = config
        self._language = language
        self._gate = ReadingGate(config.reading)
        self._spots = Spots()

    def observe(self, frame: RgbdFrame, tracked: TrackedFrame) -> FrameReading | None:
        """Take one frame: let memory fade, and read the frame if its turn has come.

        Args:
            frame: every frame, in order of time.
            tracked: what tracking said of it.

        Returns:
            What was read, or None when the frame was not read.
        """
        self.statistics.frames_seen += 1
        self.text_map.memory.forget(frame.timestamp)
        if tracked.keyframe_from_camera is None or tracked.world_from_camera is None:
            self.statistics.frames_untracked += 1
            return None
        if not self._gate.is_due(frame.timestamp):
            return None
        if not self._gate.is_sharp(frame):
            self.statistics.frames_blurred += 1
            return None
        self._gate.taken(frame.timestamp)

        boxes, fates, texts = self._read(frame.rgb)
        started = perf_counter()
        poses = (
            tracked.keyframe_from_camera,
            tracked.world_from_camera @ inverse_transform(tracked.keyframe_from_camera),
        )
        remembered = [self._remember(text, frame, tracked.keyframe, *poses) for text in texts]
        self.statistics.mapping_ms += 1000.0 * (perf_counter() - started)
        return FrameReading(frame.index, boxes, tuple(fates), tuple(texts), tuple(filter(None, remembered)))

    def _read(self, rgb: NDArray[np.uint8]) -> tuple[Array, list[BoxFate], list[SpottedText]]:
        """Detect, drop what is cut off or too small, recognise the rest."""
        self.statistics.frames_read += 1
        boxes, fates, texts = np.zeros((0, 4, 2)), np.zeros(0, dtype=object), list[SpottedText]()
        # A reader may raise anything, on one image in a thousand; the map is worth more than that image.
        try:
            started = perf_counter()
            boxes, _ = self._spotter.detect(rgb)
            self.statistics.detection_ms += 1000.0 * (perf_counter() - started)
            config = self._config.spotting
            fates = np.full(len(boxes), BoxFate.KEPT, dtype=object)
            fates[letter_heights(boxes) < config.min_letter_height] = BoxFate.SMALL
            fates[touches_border(boxes, rgb.shape[:2], config.border_margin)] = BoxFate.BORDER

            kept = np.flatnonzero(fates == BoxFate.KEPT)
            started = perf_counter()
            readings = self._spotter.recognise(rgb, boxes[kept]) if len(kept) else []
            self.statistics.recognition_ms += 1000.0 * (perf_counter() - started)
            for row, reading in zip(kept, readings, strict=True):
                accepted = accepted_texts(boxes[row : row + 1], [reading], config)
                texts += accepted
                if not accepted:
                    fates[row] = BoxFate.UNREAD
        except Exception:
            self.statistics.reader_errors += 1
            return np.zeros((0, 4, 2)), [], []
        self.statistics.boxes_detected += len(boxes)
        self.statistics.boxes_at_border += int((fates == BoxFate.BORDER).sum())
        self.statistics.boxes_too_small += int((fates == BoxFate.SMALL).sum())
        self.statistics.texts_rejected += int((fates == BoxFate.UNREAD).sum())
        self.statistics.texts_read += len(texts)
        return boxes, fates.tolist(), texts

    def _remember(
        self,
        text: SpottedText,
        frame: RgbdFrame,
        keyframe: int,
        keyframe_from_camera: Array,
        world_from_keyframe: Array,
    ) -> TextObservation | None:
        """Place a text (III-F), classify and strengthen it (III-C, III-D), name what has become long-term (III-E)."""
        memory, config = self.text_map.memory, self._config.placement
        placement = place_text(text.box, frame.depth, self._camera, keyframe_from_camera, config)
        if isinstance(placement, PlacementFault):
            self.statistics.observations_without_depth += 1
            self._name_if_due(memory.sight(text.text, text.confidence, frame.timestamp))
            return None

        here = self._spots.classes_at(placement, world_from_keyframe)
        text_class = memory.sight(text.text, text.confidence, frame.timestamp, here)
        observation = TextObservation(frame.index, frame.timestamp, keyframe, text.text, text.confidence, placement)
        text_class.observations.append(observation)
        self._spots.add(text_class.id, placement, world_from_keyframe)
        self._name_if_due(text_class)
        self.statistics.observations += 1
        return observation

    def _name_if_due(self, text_class: TextClass) -> None:
        if text_class.pool is not Pool.LONG_TERM or not needs_name(text_class):
            return
        if not name_class(text_class, self._language, self._config.spotting.max_length):
            self.statistics.language_errors += 1


class ReadingGate:
    """Decides which frames are read: at a set interval, and rather a little later than blurred."""

    def __init__(self, config: ReadingConfig) -> None:
        self._config = config
        self._last_read: float | None = None
        self._sharpness: deque[float] = deque(maxlen=config.blur_window)

    def is_due(self, timestamp: float) -> bool:
        """Whether the interval since the last reading has passed."""
        # Half a millisecond of grace: timestamps are rounded.
        return self._last_read is None or timestamp - self._last_read >= self._config.interval - 5e-4

    def is_sharp(self, frame: RgbdFrame) -> bool:
        """Whether a frame is not blurred against those before it, or no sharper one has come for too long."""
        grey = cv2.cvtColor(frame.rgb[::2, ::2], cv2.COLOR_RGB2GRAY)
        sharpness = float(cv2.Laplacian(grey, cv2.CV_32F).var())
        usual = float(np.median(self._sharpness)) if self._sharpness else sharpness
        self._sharpness.append(sharpness)
        if sharpness >= self._config.blur_share * usual:
            return True
        waited = frame.timestamp - (self._last_read or frame.timestamp)
        return waited >= (1.0 + self._config.blur_patience) * self._config.interval

    def taken(self, timestamp: float) -> None:
        """Note that a frame is read now."""
        self._last_read = timestamp
