"""Reading and remembering apart from SLAM: rendered malls with their true poses.

Run: python benchmarks/text_mapping.py [SEED ...]

For each mall: of the signs readable in ten or more frames the share that became landmarks with the right text
(recall), the share of landmarks that are a sign of their own (precision), the median distance of the two, how many
names are exact, and the CPU time of reading. Every fifth frame is drawn and read; every thirtieth is a keyframe.
"""

import argparse
import time

import cv2
import numpy as np

from lpslam.camera import inverse_transform
from lpslam.config import Config
from lpslam.evaluation.landmarks import score_landmarks
from lpslam.evaluation.signs import TrueSign
from lpslam.language.registry import language_model
from lpslam.simulation.source import MallSource
from lpslam.slam.state import TrackedFrame, TrackingState
from lpslam.text.distilling import distil
from lpslam.text.mapper import TextMapper
from lpslam.text.spotting import PaddleSpotter

FRAMES_A_READING = 5
FRAMES_A_KEYFRAME = 30


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", nargs="*", type=int, default=[0, 1, 2])
    cv2.setNumThreads(1)
    config, language = Config().text, language_model(None)
    for seed in parser.parse_args().seeds:
        source = MallSource(seed)
        world_from_camera = source.ground_truth.world_from_camera
        mapper = TextMapper(source.camera, PaddleSpotter(config.spotting), config, language)
        seconds = 0.0
        for index in range(0, len(source), FRAMES_A_READING):
            frame = source.frame(index)
            keyframe = index - index % FRAMES_A_KEYFRAME
            keyframe_from_camera = inverse_transform(world_from_camera[keyframe]) @ world_from_camera[index]
            tracked = TrackedFrame(
                index,
                frame.timestamp,
                TrackingState.TRACKING,
                keyframe,
                keyframe_from_camera,
                world_from_camera[index],
                matches=0,
                is_keyframe=index == keyframe,
            )
            started = time.process_time()
            mapper.observe(frame, tracked)
            seconds += time.process_time() - started

        landmarks = distil(mapper.text_map, world_from_camera.__getitem__, language).landmarks
        signs = [
            TrueSign(
                sign.id,
                sign.text,
                sign.aliases,
                sign.kind,
                _vector(sign.centre),
                _vector(sign.normal),
                sign.readable_frames,
            )
            for sign in source.signs
        ]
        score = score_landmarks(landmarks, signs, np.eye(4))
        print(f"{source.name}: {score.readable_signs} readable signs, {score.landmarks} landmarks,", end=" ")
        print(f"recall {score.recall:.3f}, precision {score.precision:.3f},", end=" ")
        print(f"position {score.median_position_error:.3f} m, exact names {score.exact_name_share:.3f},", end=" ")
        print(f"reading {seconds:.0f} s CPU for {mapper.statistics.frames_read} of {len(source)} frames")
        for miss in score.misses:
            print(f"  missed {miss.text!r}, readable in {miss.readable_frames} frames")
        for stray in score.strays:
            print(f"  stray {stray.name!r}, likest {stray.likest!r} {stray.distance:.2f} m away")


def _vector(array: np.ndarray) -> tuple[float, float, float]:
    return float(array[0]), float(array[1]), float(array[2])


if __name__ == "__main__":
    main()
