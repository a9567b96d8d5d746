"""Finding the way back: twenty blank frames, then another place that is mapped, or one that is not yet."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lpslam.frames import RgbdFrame
from lpslam.poses import StampedPoses
from lpslam.simulation.source import MallSource
from lpslam.simulation.worlds.source import WorldSource
from lpslam.slam.map import SlamMap
from lpslam.slam.state import EventKind, TrackedFrame
from lpslam.slam.system import RgbdSlam
from lpslam.sources.prefetch import Prefetched
from slam_recordings import Recording
from slam_report import Report, spread
from slam_scores import pose_error, run, true_pose

BLANK = 20  # frames in which nothing is seen
LEAD_IN = 5  # frames of the old walk before them
GOOD, PATIENCE = 15, 45  # frames to be found within, and until it is given up
CHECKED = 5  # frames whose pose is compared once it is found
WRONG = (0.2, 5.0)  # metres, degrees
FPS = 30.0


def measure(recordings: Sequence[Recording], trials: int, report: Report) -> None:
    """Random places of the same walk seen anew and of another walk, then parts that were not mapped before."""
    rows = [row for recording in recordings for row in _elsewhere(recording, trials, report)]
    headings = ["Mall", "Carried to", f"Found within {GOOD}", "Found later", "Never", "False", "Frames until found"]
    report.table(headings, rows)
    print()
    headings = ["Mall", "Sub-map after", "Merged after", "In the map", "Wrong ties", "ATE RMSE m"]
    report.table(headings, [_unmapped(recording, report) for recording in recordings])


def _elsewhere(recording: Recording, trials: int, report: Report) -> Iterator[list[str]]:
    source, truth = recording.open(), recording.truth
    frames: list[RgbdFrame] = []
    slam = RgbdSlam(source.camera)
    mapped = run(slam, keeping_the_last(Prefetched(source), frames))
    arrays = slam.map.to_arrays()
    truth_from_map = mapped.ate(truth).truth_from_estimate
    for visit, place in ((0, "the same walk, new noise"), (1, "another walk")):
        mall = recording.mall(visit)
        rng = np.random.default_rng([int(recording.name.rsplit("-", 1)[1]), visit])
        waits: list[int] = []
        verdicts: Counter[str] = Counter()
        for trial in range(trials):
            start = int(rng.integers(0, len(mall) - PATIENCE))
            again = RgbdSlam(source.camera, base=SlamMap.from_arrays(arrays))
            verdict, waited, error = carry(again, frames, mall, start, trial + 1, truth_from_map)
            verdicts[verdict] += 1
            if waited is not None:
                waits.append(waited)
            report.line(
                mall=recording.name, carried_to=place, trial=trial, start=start, verdict=verdict, frames=waited,
                error_m=error, events=[f"{event.kind}: {event.reason}" for event in again.events],
            )  # fmt: skip
        yield [
            recording.name,
            place,
            f"{verdicts['found']} of {trials}",
            *(str(verdicts[each]) for each in ("later", "never", "false")),
            spread(waits, 0) if waits else "-",
        ]


def keeping_the_last(frames: Prefetched, kept: list[RgbdFrame]) -> Iterator[RgbdFrame]:
    """The frames, of which the last few are kept: those that come before the blank ones."""
    for frame in frames:
        kept.append(frame)
        del kept[:-LEAD_IN]
        yield frame


class Processor(Protocol):
    """Tracks frames: `RgbdSlam`, or whatever stands around it."""

    def process(self, frame: RgbdFrame) -> TrackedFrame:
        """Track one frame."""
        ...


def carry(
    slam: Processor,
    before: Sequence[RgbdFrame],
    mall: MallSource | WorldSource,
    start: int,
    noise: int,
    truth_from_map: NDArray[np.float64],
    fps: float = FPS,
    is_mapped: Callable[[RgbdFrame, NDArray[np.float64]], bool] = lambda frame, pose: True,
) -> tuple[str, int | None, float | None]:
    """Blank the camera and uncover it elsewhere: found, later, never, false or unmapped; frames; metres of error.

    Frames are counted from the first that shows a mapped place: `is_mapped` says so of a frame and its true pose.
    """
    for frame in (*before, *blank_frames(before[-1], BLANK, fps)):
        slam.process(frame)
    clock = before[-1].timestamp + (BLANK + 1) / fps
    first: int | None = None
    mapped: int | None = None
    errors: list[float] = []
    for step in range(min(PATIENCE, len(mall) - start)):
        if first is not None and step >= first + CHECKED:
            break
        true = mall.ground_truth.world_from_camera[start + step]
        frame = mall.frame(start + step, noise)
        if mapped is None and is_mapped(frame, true):
            mapped = step
        index = before[-1].index + BLANK + 1 + step
        tracked = slam.process(replace(frame, index=index, timestamp=clock + step / fps))
        if tracked.world_from_camera is None:
            continue
        first = step if first is None else first
        metres, degrees = pose_error(truth_from_map @ tracked.world_from_camera, true)
        errors.append(metres)
        if metres > WRONG[0] or degrees > WRONG[1]:
            if tracked.is_doubted:
                # Said to be unsure until signs have been compared: the camera is not found yet.
                first, errors = None, []
                continue
            return "false", first + 1, round(metres, 3)
    if first is None:
        return "unmapped" if mapped is None else "never", None, None
    waited = first - (first if mapped is None else min(mapped, first))
    return "found" if waited < GOOD else "later", waited + 1, round(max(errors), 3)


def blank_frames(last: RgbdFrame, count: int, fps: float = FPS) -> list[RgbdFrame]:
    """Frames in which nothing is seen, after a last one."""
    return [
        RgbdFrame(
            last.index + 1 + i, last.timestamp + (i + 1) / fps, np.zeros_like(last.rgb), np.zeros_like(last.depth)
        )
        for i in range(count)
    ]


def _unmapped(recording: Recording, report: Report) -> list[str]:
    """Map half the round, blank, go on further ahead: a new sub-map, which is merged where the round closes."""
    source, truth = recording.open(), recording.truth
    count = len(source)
    half, ahead = count // 2, round(0.6 * count)
    slam = RgbdSlam(source.camera)
    done = run(slam, _with_a_gap(Prefetched(source), half, ahead))
    mapped_until, away_until = truth.timestamps[half - 1], truth.timestamps[ahead]
    reached = _first_back(truth, mapped_until, away_until)
    facts: dict[str, Any] = {"mall": recording.name, "frames_seen_anew": count - ahead}
    begun = [e for e in slam.events if e.kind is EventKind.NEW_SUBMAP]
    merged = [e for e in slam.events if e.kind is EventKind.MERGE]
    facts["submap_after_frames"] = round((begun[0].timestamp - away_until) * FPS) if begun else None
    facts["merged_after_frames"] = round((merged[0].timestamp - reached) * FPS) if merged else None
    facts |= {
        "in_map": done.tracked,
        "wrong_ties": done.wrong_loops(truth),
        "ate_rmse_m": round(done.ate(truth).rmse, 4),
        "events": [f"{event.frame} {event.kind}: {event.reason}" for event in slam.events],
    }
    report.line(**facts)
    report.picture(f"{recording.name}-unmapped", truth, done.estimate, done.ate(truth))
    return [
        recording.name,
        "never" if facts["submap_after_frames"] is None else f"{facts['submap_after_frames']} frames",
        "never" if facts["merged_after_frames"] is None else f"{facts['merged_after_frames']} frames",
        f"{done.tracked} of {half + count - ahead}",
        str(facts["wrong_ties"]),
        f"{facts['ate_rmse_m']:.4f}",
    ]


def _with_a_gap(frames: Prefetched, half: int, ahead: int) -> Iterator[RgbdFrame]:
    """The first half, blank frames right after it, and all from `ahead` on; what lies between is left out."""
    for position, frame in enumerate(frames):
        if position < half or position >= ahead:
            yield frame
        if position == half - 1:
            yield from blank_frames(frame, BLANK)


def _first_back(truth: StampedPoses, until: float, since: float) -> float:
    """Seconds at which the camera first sees again, from within 1 m and 30 degrees, what it saw early on."""
    early = truth.world_from_camera[truth.timestamps <= until]
    for timestamp in truth.timestamps[truth.timestamps >= since]:
        pose = true_pose(truth, timestamp)
        near = np.linalg.norm(early[:, :3, 3] - pose[:3, 3], axis=1) < 1.0
        if (early[near][:, :3, 2] @ pose[:3, 2] > np.cos(np.radians(30.0))).any():
            return float(timestamp)
    return float("nan")
