"""A long walk around the same mall with reading: memory must level off, and nothing be forgotten or doubled."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from lpslam import pipeline
from lpslam.camera import PinholeCamera
from lpslam.config import Config
from lpslam.frames import FrameFault, RgbdFrame
from lpslam.sources.image_pairs import ImagePairSource
from slam_recordings import Recording
from slam_report import Report
from slam_scale import FPS, resident_mb, thinned, where_it_was_before

EVERY_S = 60.0  # between two lines of the report, in the camera's time


@dataclass(frozen=True)
class Rounds:
    """A `FrameSource` that goes round a closed recording again and again."""

    source: ImagePairSource
    again: int  # the frame from which a further round goes on
    frames: int
    faults: list[FrameFault] = field(default_factory=list)

    @property
    def name(self) -> str:
        """The recording's name."""
        return self.source.name

    @property
    def camera(self) -> PinholeCamera:
        """The recording's calibration."""
        return self.source.camera

    def __len__(self) -> int:
        return self.frames

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield frames with times that go on from round to round."""
        clock = 0
        while clock < self.frames:
            for frame in self.source:
                if (clock == frame.index or frame.index >= self.again) and clock < self.frames:
                    yield replace(frame, index=clock, timestamp=clock / FPS)
                    clock += 1


def measure(recording: Recording, minutes: float, live: bool, config: Config, report: Report) -> None:
    """Map so many minutes of the camera's time, at its pace or in step."""
    source = Rounds(recording.open(), where_it_was_before(recording.truth), round(minutes * 60 * FPS))
    rows: list[list[str]] = []

    def note(progress: pipeline.Progress) -> None:
        seconds = progress.frame.timestamp
        if seconds < EVERY_S * (len(rows) + 1):
            return
        facts: dict[str, Any] = {
            "minutes": round(seconds / 60, 1),
            "rss_mb": round(resident_mb()),
            "reader_rss_mb": round(float(np.nansum([resident_mb(child) for child in _children()]))),
            "keyframes": progress.keyframes,
            "landmarks": progress.landmarks,
        }
        report.line(recording=recording.name, **facts)
        rows.append([str(value) for value in facts.values()])

    world = pipeline.run(source, config, sequential=not live, live=live, on_progress=note)
    report.line(
        recording=recording.name,
        **world.statistics["run"],
        reading=world.statistics["reading"],
        landmarks=len(world.landmarks()),
    )
    report.table(["Minutes", "Resident MB", "Reader's MB", "Keyframes", "Landmarks"], thinned(rows))


def _children() -> list[str]:
    return [pid for task in Path("/proc/self/task").iterdir() for pid in (task / "children").read_text().split()]
