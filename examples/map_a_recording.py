"""Map a recording, whatever its format, and list the words that it shows: `map_a_recording.py RECORDING MAP.lpmap`."""

import sys

import lpslam


def map_recording(recording: str, output: str) -> None:
    """The format is guessed from the path."""
    world = lpslam.run(lpslam.open_source(recording))
    lpslam.distill(world, "Is this a shop?")
    world.save(output)
    for mark in world.landmarks():
        kind = "shop" if mark.is_landmark else "text"
        print(f"{kind} {mark.name}: {mark.position.round(2)} m")


if __name__ == "__main__":
    map_recording(*sys.argv[1:3])
