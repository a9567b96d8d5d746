"""A map in a few facts."""

from typing import Any

from lpslam.mapfile.language_map import LanguageMap


def map_facts(world: LanguageMap) -> dict[str, Any]:
    """What a map holds, as plain values."""
    poses = world.frame_poses()
    landmarks = world.landmarks()
    run = world.statistics.get("run", {})
    seconds = run.get("seconds", 0.0)
    return {
        "source": world.source,
        "frames": len(world.trajectory),
        "frames_tracked": world.trajectory.tracked_count,
        "frames_skipped": int(run.get("frames_skipped", 0)),
        "path_length_m": round(poses.path_length, 2),
        "keyframes": len(world.slam.living_keyframes()),
        "points": len(world.slam.living_points()),
        "landmarks": len(landmarks),
        "judged_as_landmark": sum(mark.is_landmark is True for mark in landmarks),
        "question": world.text.question,
        "frames_read": int(world.statistics.get("reading", {}).get("frames_read", 0)),
        "seconds": round(seconds, 1),
        "frames_per_second": round(len(world.trajectory) / seconds, 1) if seconds else None,
    }
