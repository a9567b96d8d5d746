"""Place recognition by appearance alone: how often the likeliest frame shows the place, and how fast it is found.

    python benchmarks/places.py FOLDER [FOLDER ...]      recordings with ground truth in which places come again

Every tenth frame is a keyframe and every fifth a query. A query may only find keyframes that are at least 100 frames
older or newer, and has found its place when camera and keyframe are near each other, by a strict and a wide measure.
Where several recordings of different places are given, each one's queries are also put to all others, where every
answer is wrong.
"""

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import FeatureConfig
from lpslam.slam.features import FeatureExtractor
from lpslam.slam.places.index import PlaceIndex
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source

STEP, KEYFRAME_STEP = 5, 10  # frames between queries and between keyframes
APART = 100  # frames between a query and what it may find
SAME = ((1.0, 30.0), (1.5, 40.0))  # metres and degrees within which a place is the same: strictly, and by what is seen


@dataclass(frozen=True, eq=False)
class Views:
    """Some frames of a recording: their numbers (n,), true poses (n, 4, 4) and descriptors (m, 4) of each."""

    frames: NDArray[np.int64]
    world_from_camera: NDArray[np.float64]
    descriptors: list[NDArray[np.uint64]]


def read_views(folder: Path) -> Views:
    source, truth = open_source(folder), read_ground_truth(folder)
    if truth is None:
        raise SystemExit(f"{folder} has no ground truth")
    extractor = FeatureExtractor(source.camera, FeatureConfig())
    frames, poses, descriptors = [], [], []
    for number, frame in enumerate(source):
        nearest = int(np.abs(truth.timestamps - frame.timestamp).argmin())
        if number % STEP == 0 and abs(truth.timestamps[nearest] - frame.timestamp) < 0.02:
            frames.append(number)
            poses.append(truth.world_from_camera[nearest])
            descriptors.append(extractor.extract(frame).descriptor)
    return Views(np.array(frames), np.array(poses), descriptors)


def index_of(views: Views) -> tuple[PlaceIndex, NDArray[np.int64]]:
    """An index of the keyframes among the views, and which views they are."""
    rows = np.flatnonzero(views.frames % KEYFRAME_STEP == 0)
    index = PlaceIndex()
    for keyframe, row in enumerate(rows.tolist()):
        index.add(keyframe, views.descriptors[row])
    return index, rows


def same_place(views: Views, near: float, aside: float) -> NDArray[np.bool_]:
    """(n, n) whether two views are within so many metres and degrees of each other."""
    centres, axes = views.world_from_camera[:, :3, 3], views.world_from_camera[:, :3, 2]
    apart = np.linalg.norm(centres[:, None] - centres[None], axis=2)
    return (apart < near) & (axes @ axes.T > np.cos(np.radians(aside)))


def measure(views: Views, others: list[PlaceIndex], metres: float, degrees: float) -> dict[str, Any]:
    index, keyframes = index_of(views)
    near = same_place(views, metres, degrees)[:, keyframes]
    top_right, top_wrong, in_five, spent = [], [], [], []
    for query, descriptors in enumerate(views.descriptors):
        eligible = np.abs(views.frames[keyframes] - views.frames[query]) >= APART
        if not (near[query] & eligible).any():
            continue
        before = time.thread_time()
        scores = index.query(descriptors, eligible)
        spent.append(1000 * (time.thread_time() - before))
        best = np.argsort(-scores, kind="stable")[:5]
        (top_right if near[query, best[0]] else top_wrong).append(float(scores[best[0]]))
        in_five.append(bool(near[query, best].any()))
    elsewhere = [float(max(other.query(each).max() for other in others)) for each in views.descriptors if others]
    wrong = top_wrong + elsewhere
    count = len(in_five)
    return {
        "queries": count,
        "keyframes": len(keyframes),
        "recall_at_1": round(len(top_right) / max(count, 1), 3),
        "recall_at_5": round(float(np.mean(in_five)), 3) if count else None,
        "score_right_p10_p50": np.round(np.percentile(top_right, [10, 50]), 3).tolist() if top_right else None,
        "score_elsewhere_p50_p99_max": np.round(np.percentile(wrong, [50, 99, 100]), 3).tolist() if wrong else None,
        "recall_above_all_wrong": round(float(np.mean(np.array(top_right) > max(wrong))), 3)
        if top_right and wrong
        else None,
        "query_ms": round(float(np.median(spent)), 2) if spent else None,
    }


def measure_speed(keyframes: int) -> dict[str, Any]:
    """Adding and querying at a size, with views of 1000 keypoints whose words are as good as random."""
    random = np.random.default_rng(0)
    index = PlaceIndex()
    words = index.vocabulary.tree[-index.vocabulary.size :]
    views = [words[random.integers(0, len(words), 1000)] for _ in range(200)]
    before = time.thread_time()
    for keyframe in range(keyframes):
        index.add(keyframe, views[random.integers(len(views))])
    added = time.thread_time() - before
    spent = []
    for view in views[:50]:
        before = time.thread_time()
        index.query(view)
        spent.append(1000 * (time.thread_time() - before))
    return {
        "keyframes": keyframes,
        "index_s": round(added, 2),
        "query_median_ms": round(float(np.median(spent)), 2),
        "query_max_ms": round(max(spent), 2),
        "megabytes": round(index.nbytes / 1e6, 1),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="*", type=Path)
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    measure_speed(10)
    for keyframes in (2_000, 10_000):
        print(json.dumps(measure_speed(keyframes)), flush=True)
    views = {folder.name: read_views(folder) for folder in arguments.recordings}
    indices = {name: index_of(each)[0] for name, each in views.items()}
    for name, each in views.items():
        others = [index for other, index in indices.items() if other != name]
        for metres, degrees in SAME:
            facts = {"recording": name, "within_m": metres, "within_degrees": degrees}
            print(json.dumps({**facts, **measure(each, others, metres, degrees)}), flush=True)


if __name__ == "__main__":
    main()
