"""Loop closing on recordings with ground truth: loops found, wrong ones, and the error with and without.

    python benchmarks/loops.py FOLDER...

Each folder is a recording with a ground truth. A loop is wrong where the two keyframes that it ties end farther than
0.1 m or 3 degrees from their true relative pose. Then each map is offered to each other one as a sub-map that might be
merged: places of different recordings must never be taken for one another. Recordings of the same place do not belong
in one call.
"""

import argparse
import itertools
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import SlamConfig
from lpslam.evaluation.trajectory import absolute_trajectory_error
from lpslam.poses import StampedPoses
from lpslam.slam.map import SlamMap
from lpslam.slam.places.index import PlaceIndex
from lpslam.slam.places.locating import Locator
from lpslam.slam.places.loop_closing import LoopCloser
from lpslam.slam.sensor import SensorModel
from lpslam.slam.system import RgbdSlam
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source

WRONG_METRES, WRONG_DEGREES = 0.1, 3.0


@dataclass(frozen=True)
class Run:
    """One recording, mapped in step."""

    slam: RgbdSlam
    rmse: float
    seconds_a_frame: float
    tracked: int
    errors: list[tuple[float, float]]  # metres, degrees of each tie


def run(folder: Path, config: SlamConfig) -> Run:
    """Map a recording and compare it with its ground truth."""
    source = open_source(folder)
    truth = read_ground_truth(folder)
    if truth is None:
        raise SystemExit(f"{folder} has no ground truth")
    slam = RgbdSlam(source.camera, config)
    spent = 0.0
    for frame in source:
        started = time.thread_time()
        slam.process(frame)
        spent += time.thread_time() - started
    slam.finish()
    timestamps, poses = slam.trajectory.world_from_camera(slam.map)
    rmse = absolute_trajectory_error(truth, StampedPoses(timestamps, poses)).rmse
    errors = [_tie_error(slam.map, truth, a, b) for a, b in slam.map.loop_edges]
    return Run(slam, rmse, spent / len(slam.trajectory), len(timestamps), errors)


def _tie_error(slam_map: SlamMap, truth: StampedPoses, a: int, b: int) -> tuple[float, float]:
    """Metres and degrees between the relative pose of two keyframes in the map and in truth."""
    true = [truth.world_from_camera[np.abs(truth.timestamps - slam_map.frame_of(k)[1]).argmin()] for k in (a, b)]
    b_from_a = slam_map.camera_from_world(b) @ slam_map.world_from_keyframe(a)
    off = inverse_transform(inverse_transform(true[1]) @ true[0]) @ b_from_a
    turn = np.degrees(np.arccos(np.clip((np.trace(off[:3, :3]) - 1) / 2, -1, 1)))
    return float(np.linalg.norm(off[:3, 3])), float(turn)


def side_by_side(first: SlamMap, second: SlamMap) -> SlamMap:
    """One map with the second as a sub-map beside the first."""
    a, b = first.to_arrays(), second.to_arrays()
    keyframes, points, slots = len(a["keyframe_slot"]), len(a["head"]), len(a["slot_keyframe"])
    capacity = a["point"].shape[1]
    if b["point"].shape[1] != capacity:
        raise SystemExit("the maps have slots of different size")
    shifts = {
        "keyframe_slot": slots, "slot_keyframe": keyframes, "parent": keyframes, "first_keyframe": keyframes,
        "point": points, "head": slots * capacity, "next_observation": slots * capacity, "free_slots": slots,
        "submap": int(a["submap"].max()) + 1, "loop_edges": keyframes,
    }  # fmt: skip
    joined: dict[str, NDArray[np.generic]] = {}
    for name, column in b.items():
        shifted = column
        if name in shifts:
            shifted = np.where(column >= 0, column + shifts[name], column).astype(column.dtype)
        joined[name] = a[name] if name in ("scales", "home") else np.concatenate([a[name], shifted])
    return SlamMap.from_arrays(joined)


def mistakes(first: SlamMap, second: SlamMap, sensor: SensorModel, config: SlamConfig) -> tuple[int, Counter[str]]:
    """How often keyframes of the second map are taken to be in the first one, and why the others are not."""
    both = side_by_side(first, second)
    places = PlaceIndex.of(both)
    closer = LoopCloser(both, sensor, places, Locator(both, sensor, config.tracking, config.locating), config)
    own = [k for k in both.living_keyframes().tolist() if k >= first.keyframe_count]
    edges = len(both.loop_edges)
    for keyframe in own:
        closer.process(keyframe)
    between = [(a, b) for a, b in both.loop_edges[edges:] if min(a, b) < first.keyframe_count <= max(a, b)]
    return len(between), closer.counts.rejected


def main() -> None:
    """Run the recordings named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--once", action="store_true", help="leave out the run without loop closing")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    config = SlamConfig()
    never = SlamConfig(loops=config.loops.model_copy(update={"min_keyframes_apart": 10**9}))
    print("recording     tracked  ties  wrong  worst m / deg   ATE m  without    ms a frame")
    maps: list[Run] = []
    for folder in arguments.folders:
        done = run(folder, config)
        without = "      -" if arguments.once else f"{run(folder, never).rmse:7.4f}"
        wrong = sum(metres > WRONG_METRES or degrees > WRONG_DEGREES for metres, degrees in done.errors)
        worst = max((e[0] for e in done.errors), default=0.0), max((e[1] for e in done.errors), default=0.0)
        print(
            f"{folder.name:12s} {done.tracked:8d} {len(done.errors):5d} {wrong:6d}  {worst[0]:.3f} / {worst[1]:.2f}  "
            f"{done.rmse:7.4f}  {without}  {1e3 * done.seconds_a_frame:7.1f}",
            flush=True,
        )
        maps.append(done)
    for (one, first), (other, second) in itertools.permutations(zip(arguments.folders, maps, strict=True), 2):
        if first.slam.sensor.image_size != second.slam.sensor.image_size:
            continue
        merged, why = mistakes(first.slam.map, second.slam.map, first.slam.sensor, config)
        print(f"{other.name} taken for {one.name}: {merged} times; {dict(why.most_common())}", flush=True)


if __name__ == "__main__":
    main()
