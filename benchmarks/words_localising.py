"""What words add to localisation: the camera of a recording is looked for in the map of another that was read.

    python benchmarks/words_localising.py MAPPED THEN...        # recordings of one mall: all should be found, rightly
    python benchmarks/words_localising.py MAPPED TWIN --apart   # of a mall that only looks the same: nothing should be

Both have a ground truth in the same world. Each is localised by looks alone, by looks and words, and by words alone,
where looks propose no place. A frame is found rightly within 0.1 m and 3 degrees of the truth, after the map itself has
been laid over it.
"""

import argparse
from contextlib import nullcontext
from pathlib import Path
from unittest.mock import patch

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam import pipeline
from lpslam.config import Config
from lpslam.evaluation.trajectory import align_poses
from lpslam.mapfile.language_map import LanguageMap
from lpslam.slam.places.index import PlaceIndex
from lpslam.text.reading.spotting import PaddleSpotter
from slam_recordings import Recording
from slam_report import Report
from slam_scores import pose_error, true_pose
from words import WAYS

RIGHT = (0.1, 3.0)  # metres, degrees


def localised(
    world: LanguageMap, truth_from_world: NDArray[np.float64], recording: Recording, way: str, reader: PaddleSpotter
) -> dict[str, object]:
    """Look for the camera of a recording in a map, in one of the ways."""
    blind = patch.object(PlaceIndex, "query", lambda index, descriptors: np.zeros(1, np.float32))
    with blind if way == "words" else nullcontext():
        found = pipeline.localise(recording.open(), world, spotter=reader, text=way != "looks")
    errors = [
        pose_error(truth_from_world @ pose, true_pose(recording.truth, float(timestamp)))
        for timestamp, pose in zip(found.poses.timestamps, found.poses.world_from_camera, strict=True)
    ]
    return {
        "frames": found.frames,
        "found": len(errors),
        "right": sum(metres <= RIGHT[0] and degrees <= RIGHT[1] for metres, degrees in errors),
        "first_found": float(found.poses.timestamps[0] - recording.truth.timestamps[0]) if errors else None,
        "error_m": round(float(np.median([metres for metres, _ in errors])), 4) if errors else None,
        "given_up": sum("signs" in each.reason for each in found.events),
    }


def main() -> None:
    """Map the first recording, and look for the others in it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mapped", type=Path)
    parser.add_argument("then", type=Path, nargs="+")
    parser.add_argument("--apart", action="store_true", help="the others only look the same: no frame is found rightly")
    parser.add_argument("--out", type=Path, help="folder for results.jsonl")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    report, rows = Report(given.out), []
    reader = PaddleSpotter(Config().text.spotting)
    first = Recording.at(given.mapped)
    world = pipeline.run(first.open(), spotter=reader)
    truth_from_world = align_poses(first.truth, world.frame_poses())
    for recording in map(Recording.at, given.then):
        for way in WAYS:
            done = localised(world, truth_from_world, recording, way, reader)
            if given.apart:
                done["right"] = 0
            report.line(mapped=first.name, recording=recording.name, way=way, **done)
            rows.append([f"{first.name}, {recording.name}", way, *map(str, done.values())])
    report.table(["Recording", "By", "Frames", "Found", "Right", "First found s", "Error m", "Given up"], rows)


if __name__ == "__main__":
    main()
