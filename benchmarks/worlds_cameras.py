"""The map of a world, found in by other cameras that pass through it: their frames are resampled to that of the map."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from lpslam.config import Config
from lpslam.simulation.worlds.source import WorldSource
from lpslam.slam.map import SlamMap
from lpslam.slam.system import RgbdSlam
from lpslam.sources.prefetch import Prefetched
from lpslam.sources.seen_by import SeenBy
from side_by_side import beside
from slam_report import Report
from slam_scores import pose_error, run, true_pose
from worlds_carried import aligned
from worlds_recordings import WorldRecording

FRAMES = 150
CAMERAS: dict[str, dict[str, Any]] = {
    "its own": {},
    "wide, 640x480": {"size": "640x480", "view": "wide", "field_of_view": 85.0},
    "narrow, 640x480": {"size": "640x480", "view": "narrow", "field_of_view": 60.0},
    "1280x720": {"size": "1280x720"},
    "320x240": {"size": "320x240"},
    "strong lens, 848x480": {"size": "848x480", "lens": "strong", "distortion": (-0.25, 0.08, 0.001, -0.001, -0.01)},
}


def measure(recordings: Sequence[WorldRecording], processes: int, report: Report) -> None:
    """Map every world; then other cameras make another pass through it, which only localises."""
    table = []
    for facts in beside(_found, recordings, processes):
        for row in facts:
            report.line(**row)
            table.append([str(value) for value in row.values()])
    print()
    report.table(["World", "Camera", "Share of the view", "Found", "Of", "Median, m", "95 %, m", "Most, m"], table)


def _found(recording: WorldRecording) -> list[dict[str, Any]]:
    import cv2

    cv2.setNumThreads(1)
    config, source = Config(), recording.open()
    mapped = run(RgbdSlam(source.camera, config.slam), Prefetched(source))
    truth_from_map, arrays = aligned(recording.truth, mapped.estimate), mapped.slam.map.to_arrays()
    rows = []
    for name, changed in CAMERAS.items():
        passed = WorldSource(replace(recording.world, **changed), 1)
        frames = SeenBy(passed, source.camera)
        slam = RgbdSlam(source.camera, config.slam, base=SlamMap.from_arrays(arrays), grows=False)
        errors, count = [], 0
        for frame in islice(frames, FRAMES):
            count += 1
            pose = slam.process(frame).world_from_camera
            if pose is not None:
                true = true_pose(passed.ground_truth, frame.timestamp)
                errors.append(pose_error(truth_from_map @ pose, true)[0])
        far = [round(float(np.percentile(errors, share)), 4) for share in (50, 95, 100)] if errors else [None] * 3
        rows.append({
            "world": recording.name, "camera": name, "share": round(frames.share, 2), "found": len(errors),
            "of": count, "median_m": far[0], "most_of_them_m": far[1], "worst_m": far[2],
        })  # fmt: skip
    return rows
