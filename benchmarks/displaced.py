"""How well it is found where depth lies: registered depth is seen again by a camera beside the colour's.

python benchmarks/displaced.py RECORDING... [--draws 3] [--seed 1]

Each draw has a focal length 0.8 to 1.6 times that of colour, up to 5 cm between the cameras, a shift of up to 3 % of
the width, and in one of three draws depth of two thirds of the size. What the recording itself is off by adds to the
error. A line for each: what was drawn, what was found, and by how many pixels they differ from 1 to 3 m.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from lpslam.config import CalibrationCheckConfig, RegistrationCheckConfig
from lpslam.frames import RgbdFrame
from lpslam.sources.image_pairs import ImagePairSource
from lpslam.sources.open import open_source
from lpslam.sources.registering.by_contours import find_displacement, looks_displaced
from lpslam.sources.registering.displacement import DepthDisplacement
from lpslam.sources.registering.registration import DepthRegistration, DepthRig

SCALES = (0.62, 0.75, 0.85, 0.9, 1.0, 1.1, 1.25)
BASELINE, SHIFT = (0.05, 0.015), 0.03
DISTANCES = (1.0, 2.0, 3.0)


def taken_apart(frames: Sequence[RgbdFrame], drawn: DepthDisplacement, depth_size: tuple[int, int]) -> list[RgbdFrame]:
    """The frames with depth as the camera beside would see it."""
    colour_size = (frames[0].rgb.shape[1], frames[0].rgb.shape[0])
    rig = drawn.rig(depth_size, colour_size)
    back = np.eye(4)
    back[:3, 3] = -rig.colour_from_depth[:3, 3]
    apart = DepthRegistration(DepthRig(rig.colour_camera, rig.depth_camera, back))
    return [replace(frame, depth=apart(frame.depth)) for frame in frames]


def score(source: ImagePairSource, draws: int, rng: np.random.Generator) -> None:
    config = RegistrationCheckConfig()
    frames = source.sample_frames(config.estimating_frames)
    colour_size = (source.camera.width, source.camera.height)
    for draw in range(draws):
        share = 2 / 3 if draw % 3 == 2 else 1.0
        size = (round(colour_size[0] * share), round(colour_size[1] * share))
        parallax = rng.uniform(-1, 1, 2) * BASELINE * source.camera.fx
        shift = rng.uniform(-SHIFT, SHIFT, 2) * colour_size[0]
        scale = float(rng.choice(SCALES)) * colour_size[0] / size[0]
        drawn = DepthDisplacement.of(np.array([scale, *shift, *parallax]))
        apart = taken_apart(frames, drawn, size)
        found = find_displacement(apart, config)
        if found is None:
            print(f"{source.name}: too few contours", flush=True)
            continue
        corners = np.array([[0.1, 0.1], [0.9, 0.1], [0.5, 0.5], [0.1, 0.9], [0.9, 0.9]]) * size
        off = [
            np.linalg.norm(
                found.displacement.moved(corners, np.full(5, z), size, colour_size)
                - drawn.moved(corners, np.full(5, z), size, colour_size),
                axis=1,
            )
            for z in DISTANCES
        ]
        told = "displaced" if found.is_displaced else "not displaced"
        noticed = "noticed" if looks_displaced(apart[:: len(apart) // config.frames], config) else "not noticed"
        print(
            f"{source.name} {size[0]}x{size[1]}: {told}, when opened {noticed}, moved {found.pixels:.1f} px, "
            f"off {np.sqrt(np.mean(np.square(off))):.1f} px, at most {np.max(off):.1f}; "
            f"drawn {np.round(drawn.numbers, 2)}, found {np.round(found.displacement.numbers, 2)}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="+", type=Path)
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    unchecked = CalibrationCheckConfig(registration=RegistrationCheckConfig(frames=0))
    for path in given.recordings:
        source = open_source(path, checks=unchecked)
        if isinstance(source, ImagePairSource):
            score(source, given.draws, np.random.default_rng(given.seed))


if __name__ == "__main__":
    main()
