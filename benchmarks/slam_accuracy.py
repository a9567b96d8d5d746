"""Accuracy and cost in step, over several runs of each recording.

The same frames give the same map to the bit, so a second run says nothing new. Each further run leaves out one more
frame at the start instead: every later decision changes, the recording and its noise do not.
"""

from collections.abc import Sequence
from itertools import groupby, islice
from typing import Any

import numpy as np

from lpslam.evaluation.trajectory import AteResult
from lpslam.poses import StampedPoses
from lpslam.slam.state import EventKind
from lpslam.slam.system import RgbdSlam
from lpslam.sources.prefetch import Prefetched
from slam_recordings import Recording
from slam_report import Report, spread
from slam_scores import Run, run


def measure(recordings: Sequence[Recording], runs: int, report: Report) -> None:
    """Run every recording `runs` times."""
    rows, by_kind = [], []
    for kind, group in groupby(recordings, key=lambda recording: recording.kind):
        of_kind = []
        for recording in group:
            done = [_one(recording, start, report) for start in range(runs)]
            rows.append(_row(recording.name, done))
            of_kind.append(done)
        if len(of_kind) > 1:
            by_kind.append(_summary(kind, of_kind))
    headings = ["Recording", "Tracked", "ATE RMSE m", "Loops", "Wrong", "Gap m", "Tracking ms", "All ms", "Keyframes"]
    report.table(headings, rows)
    if by_kind:
        print()
        report.table(
            ["Kind", "Median ATE of the malls, by run", "Least tracked", "Unclosed", "Wrong", *headings[6:8]], by_kind
        )


def _one(recording: Recording, start: int, report: Report) -> dict[str, Any]:
    source, truth = recording.open(), recording.truth
    done = run(RgbdSlam(source.camera), islice(Prefetched(source), start, None))
    ate = done.ate(truth)
    facts = _facts(done, truth, ate)
    report.line(recording=recording.name, kind=recording.kind, run=start, **facts)
    report.picture(f"{recording.name}-run-{start}", truth, done.estimate, ate)
    return facts


def _facts(done: Run, truth: StampedPoses, ate: AteResult) -> dict[str, Any]:
    return {
        "frames": done.frames,
        "tracked": done.tracked,
        "path_m": round(truth.path_length, 1),
        "ate_rmse_m": round(ate.rmse, 5),
        "ate_max_m": round(ate.max, 4),
        "loops": done.count(EventKind.LOOP),
        "merges": done.count(EventKind.MERGE),
        "wrong_loops": done.wrong_loops(truth),
        "closing_gap_m": round(done.closing_gap(truth), 4),
        "lost": done.count(EventKind.LOST),
        "tracking_median_ms": round(float(np.median(done.tracking_ms)), 2),
        "tracking_p95_ms": round(float(np.percentile(done.tracking_ms, 95)), 2),
        "all_mean_ms": round(float(done.all_ms.mean()), 2),
        "keyframes": len(done.slam.map.living_keyframes()),
        "points": len(done.slam.map.living_points()),
    }


def _row(name: str, done: Sequence[dict[str, Any]]) -> list[str]:
    return [
        name,
        f"{min(d['tracked'] / d['frames'] for d in done):.1%} of {done[0]['frames']}",
        spread([d["ate_rmse_m"] for d in done]),
        spread([d["loops"] for d in done], 0),
        str(max(d["wrong_loops"] for d in done)),
        spread([d["closing_gap_m"] for d in done], 3),
        spread([d["tracking_median_ms"] for d in done], 1),
        spread([d["all_mean_ms"] for d in done], 1),
        spread([d["keyframes"] for d in done], 0),
    ]


def _summary(kind: str, malls: Sequence[Sequence[dict[str, Any]]]) -> list[str]:
    """Medians over the malls of a kind, one a run, with their spread over the runs."""
    flat = [d for mall in malls for d in mall]
    ate = [float(np.median([d["ate_rmse_m"] for d in of_run])) for of_run in zip(*malls, strict=True)]
    return [
        f"{kind} ({len(malls)} malls)",
        spread(ate),
        f"{min(d['tracked'] / d['frames'] for d in flat):.1%}",
        f"{sum(d['loops'] == 0 for d in flat)} of {len(flat)} runs",
        str(sum(d["wrong_loops"] for d in flat)),
        spread([d["tracking_median_ms"] for d in flat], 1),
        spread([d["all_mean_ms"] for d in flat], 1),
    ]
