"""Find a recording's camera in a saved map: `localise.py MAP.lpmap RECORDING POSES.txt`."""

import sys
from pathlib import Path

import lpslam


def localise(map_file: str, recording: str, poses: str) -> None:
    """The map is only read."""
    world = lpslam.LanguageMap.load(map_file)
    found = lpslam.localise(lpslam.open_source(recording), world)
    found.poses.to_tum_file(Path(poses), ["camera optical frame in the map frame"])
    print(f"{len(found.poses)} of {found.frames} frames found")


if __name__ == "__main__":
    localise(*sys.argv[1:4])
