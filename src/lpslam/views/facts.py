"""A map in a few facts, as JSON and as lines for the terminal."""

from typing import Any

from lpslam.mapfile.language_map import LanguageMap
from lpslam.views.drawable import printable


def map_facts(world: LanguageMap) -> dict[str, Any]:
    """What a map holds, as plain values."""
    poses = world.frame_poses()
    landmarks = world.landmarks()
    run = world.statistics.get("run", {})
    seconds = run.get("seconds", 0.0)
    return {
        "source": world.source,
        "frames": world.trajectory.frame_count,
        "frames_tracked": world.trajectory.tracked_count,
        "frames_skipped": int(run.get("frames_skipped", 0)),
        "frames_dropped": int(run.get("frames_dropped", 0)),
        "frames_read": int(world.statistics.get("reading", {}).get("frames_read", 0)),
        "frames_unread_for_lack_of_time": int(run.get("frames_unread_for_lack_of_time", 0)),
        "path_length_m": round(poses.path_length, 2),
        "keyframes": len(world.slam.living_keyframes()),
        "points": len(world.slam.living_points()),
        "landmark_count": len(landmarks),
        "words": [mark.name for mark in sorted(landmarks, key=lambda mark: (-mark.observations, mark.id))],
        "judged_as_landmark": sum(mark.is_landmark is True for mark in landmarks),
        "question": world.text.question,
        "seconds": round(seconds, 1),
        "frames_per_second": round(world.trajectory.frame_count / seconds, 1) if seconds else None,
    }


def fact_lines(facts: dict[str, Any]) -> dict[str, str]:
    """The facts of `map_facts` in words, with their units."""
    words = [printable(word) for word in facts["words"]]
    unread = facts["frames_unread_for_lack_of_time"]
    left_out = {"skipped": facts["frames_skipped"], "dropped, since they came too fast": facts["frames_dropped"]}
    judged = f"{facts['judged_as_landmark']} by the question “{facts['question']}”" if facts["question"] else "not yet"
    return {
        "source": facts["source"],
        "frames": f"{facts['frames']}, of which {facts['frames_tracked']} tracked"
        + "".join(f"; {count} more {why}" for why, count in left_out.items() if count),
        "read": f"{facts['frames_read']} frames" + (f"; {unread} more for lack of time not" if unread else ""),
        "path": f"{facts['path_length_m']:.2f} m",
        "keyframes": str(facts["keyframes"]),
        "points": str(facts["points"]),
        "texts": f"{facts['landmark_count']} in long-term memory" + (f": {', '.join(words)}" if words else ""),
        "judged landmarks": judged,
        "time": f"{facts['seconds']:.1f} s"
        + (f", {facts['frames_per_second']:.1f} frames/s" if facts["frames_per_second"] else ""),
    }
