"""A map of thousands of keyframes: what asking for a place costs, and what closing a loop does.

Malls are mapped and their maps laid end to end, each copy somewhere else, as one long way of a single camera.
"""

import time
from collections.abc import Sequence

import numpy as np

from loops import side_by_side
from lpslam.config import SlamConfig
from lpslam.slam.map import SlamMap
from lpslam.slam.places.index import PlaceIndex
from lpslam.slam.places.loop_correction import LoopCorrector, Tie
from lpslam.slam.system import RgbdSlam
from lpslam.sources.prefetch import Prefetched
from slam_recordings import Recording
from slam_report import Report, spread
from slam_scores import run

APART = np.array([40.0, 0.0, 0.0])  # metres between the malls
DRIFT = np.array([0.6, -0.4, 0.1])  # metres by which the way is off where it is known again


def measure(recordings: Sequence[Recording], keyframes: int, report: Report) -> None:
    """Ask for places in a map of so many keyframes, then tie its end to its start."""
    maps: list[SlamMap] = []
    for recording in recordings:
        source = recording.open()
        slam = RgbdSlam(source.camera)
        run(slam, Prefetched(source))
        maps.append(slam.map)
    sensor = slam.sensor
    whole = maps[0]
    for copy in range(1, 1000):
        if len(whole.living_keyframes()) >= keyframes:
            break
        whole = _append(whole, maps[copy % len(maps)])
    living = whole.living_keyframes()

    started = time.process_time()
    places = PlaceIndex.of(whole)
    indexing = time.process_time() - started
    queries = []
    for keyframe in living[:: max(1, len(living) // 100)].tolist():
        descriptors = whole.features(keyframe).descriptor
        started = time.thread_time()
        places.query(descriptors)
        queries.append(1e3 * (time.thread_time() - started))

    config = SlamConfig()
    corrector = LoopCorrector(whole, sensor, config.loops, config.mapping)
    last, first = int(living[-1]), int(living[0])
    true = whole.camera_from_world(last).copy()
    true[:3, 3] += DRIFT
    expected = true @ whole.world_from_keyframe(first)
    nothing = np.full(whole.features(last).rows, -1, np.int32)
    stop = np.zeros(1, np.bool_)
    started, wall = time.process_time(), time.perf_counter()
    closed = corrector.close([Tie(last, first, true, nothing)], whole.version, stop)
    correction, waited = time.process_time() - started, time.perf_counter() - wall
    found = whole.camera_from_world(last) @ whole.world_from_keyframe(first)
    left = np.linalg.norm(found[:3, 3] - expected[:3, 3])
    report.line(
        keyframes=len(living), points=len(whole.living_points()), indexing_s=round(indexing, 2),
        place_query_median_ms=round(float(np.median(queries)), 2), place_query_max_ms=round(max(queries), 2),
        closed=closed, correction_cpu_s=round(correction, 2), correction_wall_s=round(waited, 2),
        left_m=round(float(left), 3),
    )  # fmt: skip
    report.table(
        ["Keyframes", "Points", "Indexing s", "Place query ms", "Loop correction s", "Gap left m"],
        [[str(len(living)), str(len(whole.living_points())), f"{indexing:.1f}", spread(queries, 2),
          f"{correction:.2f}", f"{left:.3f}"]],
    )  # fmt: skip


def _append(whole: SlamMap, part: SlamMap) -> SlamMap:
    """The way goes on in another mall: its first keyframe becomes the child of the last one."""
    before = whole.keyframe_count
    end = int(whole.living_keyframes()[-1])
    begin = np.eye(4)
    begin[:3, 3] = whole.world_from_keyframe(end)[:3, 3] + APART
    joined = side_by_side(whole, part)
    home, added = int(joined.home), joined.submaps()
    root = int(np.flatnonzero(np.arange(joined.keyframe_count) >= before)[0])
    shift = begin.copy()
    shift[:3, 3] -= joined.world_from_keyframe(root)[:3, 3]
    joined.transform(shift, int(added[root]))
    joined.join(home, int(added[root]), end)
    return joined
