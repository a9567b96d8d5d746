"""One half of a recording in the map of the other: how soon and how often a real room is known again.

The camera is set down in the other half ten seconds later, without a frame in between. Of either half the other is
mapped, and of either the rest only localises in the map, or continues it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lpslam.frames import RgbdFrame
from lpslam.slam.map import SlamMap
from lpslam.slam.system import RgbdSlam
from slam_recordings import Recording
from slam_report import Report
from slam_scores import pose_error, run, true_pose

AWAY = 10.0  # seconds between the halves
WRONG = 0.25  # metres from where the camera is; the poses of real rooms are given to a few centimetres


def measure(recordings: Sequence[Recording], report: Report) -> None:
    """Localise either half of each recording in the map of the other."""
    table = []
    for recording in recordings:
        source = recording.open()
        frames = list(source)
        half = len(frames) // 2
        for name, mapped, rest in (
            ("second in first", frames[:half], frames[half:]),
            ("first in second", frames[half:], frames[:half]),
        ):
            done = run(RgbdSlam(source.camera), iter(mapped))
            truth_from_map = done.ate(recording.truth).truth_from_estimate
            arrays = done.slam.map.to_arrays()
            for grows in (False, True):
                slam = RgbdSlam(source.camera, base=SlamMap.from_arrays(arrays), grows=grows)
                facts = _placed(slam, rest, frames[-1].timestamp + AWAY, recording, truth_from_map)
                report.line(recording=recording.name, half=name, grows=grows, **facts)
                table.append([
                    recording.name, name, "continues" if grows else "localises",
                    f"{facts['placed']} of {len(rest)}", str(facts["first"]), str(facts["wrong"]),
                    f"{facts['error_m']:.3f} m",
                ])  # fmt: skip
    print()
    report.table(
        ["Recording", "Half", "The map", "Frames placed", "First frame placed", "Wrong", "Error, median"], table
    )


def _placed(
    slam: RgbdSlam, frames: Sequence[RgbdFrame], clock: float, recording: Recording, truth_from_map: np.ndarray
) -> dict[str, int | float | None]:
    errors: list[float] = []
    first: int | None = None
    for step, frame in enumerate(frames):
        now = clock + frame.timestamp - frames[0].timestamp
        tracked = slam.process(replace(frame, index=len(frames) + step, timestamp=now))
        if tracked.world_from_camera is None:
            continue
        first = step if first is None else first
        true = true_pose(recording.truth, frame.timestamp)
        errors.append(pose_error(truth_from_map @ tracked.world_from_camera, true)[0])
    wrong = sum(error > WRONG for error in errors)
    median = float(np.median(errors)) if errors else float("nan")
    return {"placed": len(errors), "first": first, "wrong": wrong, "error_m": round(median, 4)}
