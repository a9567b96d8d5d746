"""Text mapping that others may look at meanwhile, and that says when landmarks may be new."""

import threading
from collections.abc import Callable
from typing import Any

from lpslam.frames import RgbdFrame
from lpslam.slam.state import TrackedFrame
from lpslam.text.mapper import TextMapper
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.types import FrameReading


class AnnouncingMapper(TextMapper):
    """A `TextMapper` that holds a lock while it remembers, and calls when landmarks may be new.

    Args:
        on_news: called, with the lock held, after a reading after which landmarks may be new or renamed.
        on_reading: called, with the lock held, with every reading.
        options: of `TextMapper`.

    Attributes:
        lock: held by whoever reads or changes the text map.
    """

    def __init__(
        self, *args: Any, on_news: Callable[[], None], on_reading: Callable[[FrameReading], None], **options: Any
    ) -> None:
        super().__init__(*args, **options)
        self.lock = threading.RLock()
        self._on_news, self._on_reading = on_news, on_reading
        self._before = self._known()

    def observe(self, frame: RgbdFrame, tracked: TrackedFrame) -> FrameReading | None:
        """As `TextMapper.observe`."""
        with self.lock:
            return super().observe(frame, tracked)

    def read(self, frame: RgbdFrame, tracked: TrackedFrame) -> FrameReading | None:
        """As `TextMapper.read`."""
        with self.lock:
            reading = super().read(frame, tracked)
            if reading is not None:
                self._on_reading(reading)
            self._announce()
            return reading

    def finish(self, poses: Callable[[], KeyframePoses] | None) -> None:
        """Remember what is cut off for good, and, unless somebody waits, look once more at what is unsure.

        Args:
            poses: gives those of the keyframes; None where somebody waits.
        """
        with self.lock:
            self.take_waiting()
            if poses is not None:
                self.look_again(poses())

    def take_last_names(self) -> None:
        """Take the names that a slow model found, at the end, and call once more."""
        with self.lock:
            self.take_names()
            self._on_news()

    def _announce(self) -> None:
        known = self._known()
        if known != self._before:
            self._before = known
            self._on_news()

    def _known(self) -> dict[int, tuple[str | None, int]]:
        """What landmarks may follow from: names, and whether sightings have doubled since they were last derived."""
        return {
            key: (each.naming.name if each.naming else None, len(each.observations).bit_length())
            for key, each in self.text_map.memory.long_term.items()
        }
