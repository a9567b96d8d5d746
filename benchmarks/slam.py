"""Accuracy and speed of tracking and mapping alone, on recordings or rendered malls.

    python benchmarks/slam.py FOLDER [FOLDER ...]        recordings with ground truth
    python benchmarks/slam.py --mall 31 --mall 32        malls rendered in memory, by seed

Frames are decoded before the clock runs; processor time is the tracking thread's own, on one core.
"""

import argparse
import json
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.evaluation.trajectory import StampedPoses, absolute_trajectory_error
from lpslam.frames import RgbdFrame
from lpslam.simulation.source import MallSource
from lpslam.slam.system import RgbdSlam
from lpslam.slam.warm_up import warm_up
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source
from lpslam.sources.prefetch import Prefetched


def measure(name: str, camera: PinholeCamera, frames: Iterable[RgbdFrame], truth: StampedPoses) -> dict[str, Any]:
    slam = RgbdSlam(camera)
    all_ms, tracking_ms = [], []
    for frame in frames:
        before = time.thread_time()
        tracked = slam.process(frame)
        spent = 1000.0 * (time.thread_time() - before)
        all_ms.append(spent)
        if not tracked.is_keyframe:
            tracking_ms.append(spent)
    slam.finish()
    ate = absolute_trajectory_error(truth, StampedPoses(*slam.trajectory.world_from_camera(slam.map)))
    return {
        "recording": name,
        "frames": len(slam.trajectory),
        "tracked": slam.trajectory.tracked_count,
        "path_m": round(truth.path_length, 1),
        "ate_rmse_m": round(ate.rmse, 4),
        "ate_share_of_path": round(ate.rmse / truth.path_length, 5),
        "tracking_median_ms": round(float(np.median(tracking_ms)), 1),
        "tracking_p95_ms": round(float(np.percentile(tracking_ms, 95)), 1),
        "all_mean_ms": round(float(np.mean(all_ms)), 1),
        "frames_per_second": round(1000.0 / float(np.mean(all_ms)), 1),
        "keyframes": len(slam.map.living_keyframes()),
        "points": len(slam.map.living_points()),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="*", type=Path)
    parser.add_argument("--mall", action="append", default=[], type=int, help="seed of a mall to render")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    print(f"kernels ready in {warm_up(print):.1f} s")
    for folder in arguments.recordings:
        source, truth = open_source(folder), read_ground_truth(folder)
        if truth is None:
            raise SystemExit(f"{folder} has no ground truth")
        print(json.dumps(measure(source.name, source.camera, Prefetched(source), truth)), flush=True)
    for seed in arguments.mall:
        mall = MallSource(seed)
        truth = StampedPoses(mall.ground_truth.timestamps, mall.ground_truth.world_from_camera)
        print(json.dumps(measure(mall.name, mall.camera, mall, truth)), flush=True)


if __name__ == "__main__":
    main()
