"""How often a wrong focal length is doubted, and a right one: each stretch of 60 frames of some recordings for itself.

python benchmarks/focal_check.py RECORDING...
"""

import sys
from dataclasses import replace

from lpslam.config import CalibrationCheckConfig, FocalCheckConfig
from lpslam.sources.focal_check import doubts_about_focal
from lpslam.sources.followed_pairs import pairs_of
from lpslam.sources.image_pairs import ImagePairSource
from lpslam.sources.open import open_source

FRAMES = 60
RATIOS = (0.5, 0.67, 0.77, 1.0, 1.3, 1.5, 2.0)


def score(source: ImagePairSource, checks: FocalCheckConfig) -> None:
    stretches, judged, doubted = 0, 0, dict.fromkeys(RATIOS, 0)
    for start in range(0, len(source) - FRAMES, FRAMES):
        times = source.timestamps[start : start + FRAMES]
        pairs = pairs_of(lambda number, start=start: source.frame(start + number), times, checks)
        stretches, judged = stretches + 1, judged + (len(pairs) >= checks.min_pairs)
        for ratio in RATIOS:
            stated = replace(source.camera, fx=source.camera.fx * ratio, fy=source.camera.fy * ratio)
            doubted[ratio] += bool(doubts_about_focal(pairs, stated, checks))
    counts = ", ".join(f"×{ratio:g}: {count}" for ratio, count in doubted.items())
    print(f"{source.name}: of {stretches} stretches {judged} have enough pairs; doubted {counts}", flush=True)


if __name__ == "__main__":
    for path in sys.argv[1:]:
        unchecked = CalibrationCheckConfig(focal=FocalCheckConfig(pairs=0))
        score(open_source(path, checks=unchecked), FocalCheckConfig())
