"""What a session has cost and left out, for the map's statistics."""

import time
from collections.abc import Mapping
from dataclasses import asdict

from lpslam.slam.system import RgbdSlam
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.reading_thread import ReadingThread


class Costs:
    """Seconds since it was made, and those spent on tracking.

    Attributes:
        seconds_tracking: spent on tracking and mapping so far; whoever calls them adds to it.
    """

    def __init__(self) -> None:
        self._started = time.perf_counter()
        self.seconds_tracking = 0.0

    @property
    def seconds(self) -> float:
        """Since it was made."""
        return time.perf_counter() - self._started

    def statistics(
        self, frames: Mapping[str, int], slam: RgbdSlam, reader: ReadingThread | None, mapper: TextMapper | None
    ) -> dict[str, dict[str, float]]:
        """Of the run and of reading.

        Args:
            frames: how many there were and were left out, by name.
            slam: tracks and maps.
            reader: reads beside it, if anybody does.
            mapper: maps texts, if anybody does.
        """
        run = {
            **frames,
            "frames_tracked": slam.trajectory.tracked_count,
            "frames_unread_for_lack_of_time": reader.dropped if reader is not None else 0,
            "keyframes_abandoned": slam.keyframes_abandoned,
            "seconds": self.seconds,
            "seconds_tracking_and_mapping": self.seconds_tracking,
        }
        return {"run": run, "reading": asdict(mapper.statistics) if mapper is not None else {}}
