"""The whole path on mock malls, rendered in memory: trajectory, landmarks and names, by seed.

python benchmarks/malls.py 31 32 33
"""

import argparse
import json

import cv2

from lpslam import pipeline
from lpslam.demo import true_signs
from lpslam.evaluation.report import evaluate
from lpslam.evaluation.trajectory import StampedPoses
from lpslam.simulation.source import MallSource
from lpslam.slam.warm_up import warm_up
from lpslam.views.scores import score_facts


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", nargs="+", type=int)
    cv2.setNumThreads(1)
    warm_up(print)
    for seed in parser.parse_args().seeds:
        mall = MallSource(seed)
        world = pipeline.run(mall)
        pipeline.distill(world)
        truth = StampedPoses(mall.ground_truth.timestamps, mall.ground_truth.world_from_camera)
        scores = evaluate(world, truth, true_signs(mall), len(mall))
        seconds = round(world.statistics["run"]["seconds"], 1)
        print(
            json.dumps({"mall": mall.name, "seconds": seconds, **score_facts(scores)}, ensure_ascii=False), flush=True
        )


if __name__ == "__main__":
    main()
