"""Runs over worlds: accuracy, tracking, cost and text, by factor."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.config import Config
from lpslam.errors import UserError
from lpslam.slam.state import EventKind
from lpslam.slam.system import RgbdSlam
from lpslam.sources.prefetch import Prefetched
from side_by_side import beside
from slam_recordings import Recording
from slam_report import Report
from slam_scores import Run, run
from text_malls import map_recording
from worlds_recordings import WorldRecording
from worlds_report import by_factor, in_ratios, text_by_factor, worst


@dataclass(frozen=True)
class Task:
    """One world to be run from several starts with one configuration."""

    recording: WorldRecording
    config: Path | None
    starts: int
    with_text: bool


def measure(
    recordings: Sequence[WorldRecording],
    configs: Sequence[Path | None],
    starts: int,
    with_text: bool,
    processes: int,
    report: Report,
) -> None:
    """Run every world, with one configuration or with two."""
    every: list[list[dict[str, Any]]] = []
    for config in configs:
        tasks = [Task(recording, config, starts, with_text) for recording in recordings]
        rows = []
        for facts in beside(_run, tasks, processes):
            report.line(config=str(config or "defaults"), **facts)
            rows.append(facts)
        every.append(rows)
        print(f"\n## {config or 'defaults'}")
        by_factor(rows, report)
        worst(rows, report)
        if with_text:
            text_by_factor(rows, report)
    if len(every) == 2:
        in_ratios(every[0], every[1], report)


def _run(task: Task) -> dict[str, Any]:
    import cv2

    cv2.setNumThreads(1)
    config = Config.from_yaml(task.config) if task.config else Config()
    recording = task.recording
    facts: dict[str, Any] = {
        "world": recording.name,
        "factors": recording.world.factors(),
        "length_m": round(recording.length, 2),
    }
    facts["runs"] = [_one(recording, config, start) for start in range(task.starts)]
    if task.with_text:
        facts["text"] = _text(recording, config)
    return facts


def _one(recording: WorldRecording, config: Config, start: int) -> dict[str, Any]:
    source, truth = recording.open(), recording.truth
    done = run(RgbdSlam(source.camera, config.slam), islice(Prefetched(source), start, None))
    blind = set(recording.facts["blind"])
    seeing = [float(t) for i, t in enumerate(source.timestamps) if i >= start and i not in blind]
    frames = done.slam.trajectory.to_arrays()
    anywhere = frames["timestamp"][frames["keyframe"] >= 0]
    return {
        "frames": done.frames,
        "seeing": len(seeing),
        "tracked": _share_of(seeing, anywhere),
        "joined": _share_of(seeing, done.estimate.timestamps if done.tracked else np.empty(0)),
        **_accuracy(done, recording),
        "loops": done.count(EventKind.LOOP),
        "merges": done.count(EventKind.MERGE),
        "submaps": done.count(EventKind.NEW_SUBMAP),
        "wrong": done.wrong_loops(truth),
        "lost": done.count(EventKind.LOST),
        "tracking_ms": round(float(np.median(done.tracking_ms)), 2) if len(done.tracking_ms) else 0.0,
        "all_ms": round(float(done.all_ms.mean()), 2),
        "keyframes": len(done.slam.map.living_keyframes()),
    }


def _share_of(seeing: Sequence[float], known: NDArray[np.float64]) -> float:
    """Of the times at which the camera sees anything, the share with a pose."""
    return round(float(np.isin(np.round(seeing, 4), np.round(known, 4)).mean()) if seeing else 0.0, 4)


def _accuracy(done: Run, recording: WorldRecording) -> dict[str, Any]:
    try:
        ate = done.ate(recording.truth)
    except UserError:
        return {"ate_m": None, "ate_percent": None}
    return {"ate_m": round(ate.rmse, 5), "ate_percent": round(100 * ate.rmse / max(recording.length, 0.1), 4)}


def _text(recording: WorldRecording, config: Config) -> dict[str, Any]:
    """Signs expected and found, landmarks and how many are right."""
    try:
        mapped = map_recording(Recording(recording.name, "world", recording.folder), "in step", config)
    except UserError as error:
        return {"error": str(error)}
    score = mapped.landmarks
    return {
        "expected": score.readable_signs,
        "found": score.readable_signs - len(score.misses),
        "landmarks": score.landmarks,
        "right": len(score.matches),
        "missed": [f"{sign.text} ({sign.readable_frames} frames)" for sign in score.misses],
        "strays": [f"{stray.name} (likest {stray.likest}, {stray.distance:.2f} m)" for stray in score.strays],
    }
