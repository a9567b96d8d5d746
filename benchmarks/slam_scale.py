"""A long run around the same mall, each round with new noise: memory, time and keyframes must level off."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from lpslam.evaluation.trajectory import absolute_trajectory_error
from lpslam.frames import RgbdFrame
from lpslam.poses import StampedPoses
from lpslam.simulation.replay import NoisyAgain
from lpslam.slam.system import RgbdSlam
from lpslam.sources.prefetch import Prefetched
from slam_recordings import Recording
from slam_report import Report
from slam_scores import Clock, pose_error

FPS = 30.0


def measure(recording: Recording, minutes: float, report: Report) -> None:
    """Go round for so many minutes of the camera's time."""
    source, truth = recording.open(), recording.truth
    again = where_it_was_before(truth)
    slam = RgbdSlam(source.camera)
    clock, rounds, rows = 0, 0, []
    lost = 0
    while clock < minutes * 60 * FPS:
        spent, times, true = Clock(), [], []
        before = slam.map.keyframe_count
        for frame in _round(NoisyAgain(source, rounds), 0 if rounds == 0 else again):
            moved = replace(frame, index=clock, timestamp=clock / FPS)
            lost += not spent.process(slam, moved).is_tracked
            times.append(moved.timestamp)
            true.append(frame.timestamp)
            clock += 1
        poses = StampedPoses(*slam.trajectory.world_from_camera(slam.map))
        walked = _of_round(poses, times)
        ate = absolute_trajectory_error(_truth_of_round(truth, times, true), walked)
        facts = {
            "recording": recording.name,
            "round": rounds,
            "minutes": round(clock / FPS / 60, 2),
            "rss_mb": round(resident_mb()),
            "map_mb": round(_map_mb(slam), 1),
            "keyframes": len(slam.map.living_keyframes()),
            "keyframes_made": slam.map.keyframe_count - before,
            "points": len(slam.map.living_points()),
            "tracking_median_ms": round(float(np.median(spent.tracking_ms)), 2),
            "all_mean_ms": round(float(np.mean(spent.all_ms)), 2),
            "lost": lost,
            "ate_rmse_m": round(ate.rmse, 4),
        }
        report.line(**facts)
        rows.append([str(value) for value in list(facts.values())[1:]])
        rounds += 1
    slam.finish()
    report.table(list(facts)[1:], thinned(rows))


def _round(source: NoisyAgain, start: int) -> Iterator[RgbdFrame]:
    for position, frame in enumerate(Prefetched(source)):
        if position >= start:
            yield frame


def where_it_was_before(truth: StampedPoses) -> int:
    """Number of the early frame that is seen from nearest to where the walk ends, so that the round goes on there."""
    last = truth.world_from_camera[-1]
    early = truth.world_from_camera[: len(truth) // 3]
    errors = np.array([pose_error(pose, last) for pose in early])
    return int((errors[:, 0] + errors[:, 1] / 20.0).argmin())


def _of_round(poses: StampedPoses, times: Sequence[float]) -> StampedPoses:
    inside = (poses.timestamps >= times[0] - 1e-6) & (poses.timestamps <= times[-1] + 1e-6)
    return StampedPoses(poses.timestamps[inside], poses.world_from_camera[inside])


def _truth_of_round(truth: StampedPoses, times: Sequence[float], recorded: Sequence[float]) -> StampedPoses:
    rows = np.abs(truth.timestamps[None, :] - np.array(recorded)[:, None]).argmin(axis=1)
    return StampedPoses(np.array(times), truth.world_from_camera[rows])


def resident_mb(process: str = "self") -> float:
    """Resident memory of a process; not a number once it is gone."""
    try:
        status = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    except OSError:
        return float("nan")
    sizes = (float(line.split()[1]) / 1024 for line in status.splitlines() if line.startswith("VmRSS:"))
    return next(sizes, float("nan"))


def _map_mb(slam: RgbdSlam) -> float:
    return sum(array.nbytes for array in slam.map.to_arrays().values()) / 2**20


def thinned(rows: list[list[str]]) -> list[list[str]]:
    """At most a dozen rows, the first and the last among them."""
    chosen = sorted(set(np.linspace(0, len(rows) - 1, min(12, len(rows))).round().astype(int).tolist()))
    return [rows[i] for i in chosen]
