"""At a camera's pace: frames come when they were taken, mapping and loop closing have threads of their own."""

import os
import time
from collections.abc import Iterator, Sequence

import numpy as np

from lpslam.config import Config
from lpslam.evaluation.trajectory import absolute_trajectory_error
from lpslam.frames import FrameSource, RgbdFrame
from lpslam.poses import StampedPoses
from lpslam.slam.state import EventKind
from lpslam.slam.system import RgbdSlam
from lpslam.sources.pacing import Paced
from lpslam.sources.prefetch import Prefetched
from slam_recordings import Recording
from slam_report import Report
from slam_scores import run


class _Held:
    """A `FrameSource` whose frames are decoded before the first is asked for; 2 MB each."""

    def __init__(self, source: FrameSource) -> None:
        self.name, self.camera = source.name, source.camera
        self._frames = list(source)
        self.faults = source.faults

    def __len__(self) -> int:
        return len(self._frames)

    def __iter__(self) -> Iterator[RgbdFrame]:
        return iter(self._frames)


def measure(recordings: Sequence[Recording], report: Report) -> None:
    """Run every recording in step and live."""
    rows = []
    for recording in recordings:
        source, truth = recording.open(), recording.truth
        in_step = run(RgbdSlam(source.camera), Prefetched(source)).ate(truth).rmse
        load = os.getloadavg()[0]
        # In memory, so that decoding takes nothing from the machine: a camera's pictures need none.
        backlog = Config().live.backlog
        slam, paced, latencies, ends = RgbdSlam(source.camera, live=True), Paced(_Held(source), backlog), [], []
        for frame in paced:
            before = time.perf_counter()
            slam.process(frame)
            now = time.perf_counter()
            latencies.append(1000.0 * (now - before))
            ends.append(1000.0 * (now - frame.timestamp))
        before = time.perf_counter()
        slam.finish()
        stopping = time.perf_counter() - before
        estimate = StampedPoses(*slam.trajectory.world_from_camera(slam.map))
        if len(estimate) < 3:
            report.line(recording=recording.name, frames=len(source), dropped=paced.dropped, tracked=len(estimate))
            rows.append([recording.name, f"{len(estimate)} of {len(source)}", str(paced.dropped), *["-"] * 6])
            continue
        ate = absolute_trajectory_error(truth, estimate)
        p50, p95, p99 = np.percentile(latencies, (50, 95, 99))
        # From when a frame was there until its pose was known; the frame that was begun soonest did not wait.
        ages = np.array(ends) - min(np.array(ends) - np.array(latencies))
        report.line(
            recording=recording.name, frames=len(source), dropped=paced.dropped, tracked=len(estimate),
            latency_p50_ms=round(float(p50), 1), latency_p95_ms=round(float(p95), 1),
            latency_p99_ms=round(float(p99), 1), latency_max_ms=round(max(latencies), 1),
            age_p95_ms=round(float(np.percentile(ages, 95)), 1), age_p99_ms=round(float(np.percentile(ages, 99)), 1),
            ate_rmse_m=round(ate.rmse, 4), in_step_ate_rmse_m=round(in_step, 4), ratio=round(ate.rmse / in_step, 2),
            loops=sum(event.kind is EventKind.LOOP for event in slam.events), stopping_s=round(stopping, 2),
            load_average=round(load, 1),
        )  # fmt: skip
        report.picture(f"{recording.name}-live", truth, estimate, ate)
        rows.append(
            [recording.name, f"{len(estimate)} of {len(source)}", str(paced.dropped), f"{p50:.1f}", f"{p95:.1f}",
             f"{p99:.1f}", f"{ate.rmse:.4f}", f"{in_step:.4f}", f"{ate.rmse / in_step:.2f}"]
        )  # fmt: skip
    headings = ["Recording", "Tracked", "Dropped", "p50 ms", "p95 ms", "p99 ms", "ATE live m", "in step m", "Ratio"]
    report.table(headings, rows)
