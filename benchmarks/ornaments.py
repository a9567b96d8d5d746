"""How many drawn ornaments are read as text, and how many texts are taken for ornaments.

    python benchmarks/ornaments.py               pictures that nothing was tuned on
    python benchmarks/ornaments.py --set dev     those to develop on

Ornaments pass detection and recognition as in mapping; counted are those read surely enough to be remembered, and what
stays in a map of walls that are walked past. Texts are drawn with the box that a detector would give: refusing one
loses it, however well it could be read.
"""

import argparse
from collections import Counter

import cv2
import numpy as np

import ornament_pictures
from lpslam.config import SpottingConfig
from lpslam.language.offline import OfflineModel
from lpslam.text.reading.boxes import letter_heights
from lpslam.text.reading.ornaments import pattern_likenesses
from lpslam.text.reading.patterns import Likeness
from lpslam.text.reading.spotting import PaddleSpotter, accepted_texts
from ornament_walks import walk_past

SEEDS = {"dev": 0, "eval": 20000}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--set", choices=sorted(SEEDS), default="eval", help="which pictures (default eval)")
    parser.add_argument("--ornaments", type=int, default=20, help="pictures of each kind (default 20)")
    parser.add_argument("--walks", type=int, default=6, help="walls of each kind that are walked past (default 6)")
    parser.add_argument("--texts", type=int, default=4000, help="(default 4000)")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    measure_ornaments(SEEDS[given.set], given.ornaments)
    measure_walks(SEEDS[given.set], given.walks)
    measure_texts(SEEDS[given.set], given.texts)


def measure_ornaments(first: int, count: int) -> None:
    """Print, for each kind, how many boxes are found, read as text, and read as text in spite of the refusal."""
    config = SpottingConfig()
    spotter = PaddleSpotter(config)
    print("| Ornament | Boxes | Read as text | Of these not refused | As what |\n|---|---|---|---|---|")
    sums = np.zeros(3, int)
    for number, kind in enumerate(ornament_pictures.ORNAMENTS):
        counts, names = np.zeros(3, int), Counter[str]()
        for seed in range(first, first + count):
            image = ornament_pictures.ornament(kind, np.random.default_rng([seed, number]))
            boxes, _ = spotter.detect(image)
            boxes = boxes[letter_heights(boxes) >= config.min_letter_height]
            texts = accepted_texts(boxes, spotter.recognise(image, boxes), config)
            read = np.array([text is not None for text in texts], bool)
            refused = np.array(pattern_likenesses(image, boxes)) == Likeness.IS
            counts += len(boxes), int(read.sum()), int((read & ~refused).sum())
            names.update(text.text for text, each in zip(texts, refused, strict=True) if text is not None and not each)
        print(f"| {kind} | {counts[0]} | {counts[1]} | {counts[2]} | {', '.join(n for n, _ in names.most_common(5))} |")
        sums += counts
    print(f"| **all** | {sums[0]} | {sums[1]} | {sums[2]} | |")


def measure_walks(first: int, count: int, views: int = 16) -> None:
    """Print what is read of walls in passing, and what stays of it in a map."""
    spotter, model = PaddleSpotter(SpottingConfig()), OfflineModel()
    print("| Walked past | Read as text | Refused | Landmarks | As what |\n|---|---|---|---|---|")
    sums = np.zeros(3, int)
    for number, kind in enumerate(ornament_pictures.ORNAMENTS):
        counts, names = np.zeros(3, int), Counter[str]()
        for seed in range(first, first + count):
            walked = walk_past(kind, np.random.default_rng([seed, number, 5]), views, spotter, model)
            counts += walked.read, walked.refused, len(walked.landmarks)
            names.update(line.text for mark in walked.landmarks for line in mark.lines)
        said = ", ".join(name for name, _ in names.most_common(8))
        print(f"| {kind} | {counts[0]} | {counts[1]} | {counts[2]} | {said} |", flush=True)
        sums += counts
    print(f"| **all** | {sums[0]} | {sums[1]} | {sums[2]} | |")


def measure_texts(first: int, count: int) -> None:
    """Print how many texts are refused, and which."""
    refused = Counter[str]()
    for seed in range(first, first + count):
        word, image, box = ornament_pictures.text(np.random.default_rng([seed, 99]))
        if pattern_likenesses(image, box[None])[0] is Likeness.IS:
            refused[word] += 1
    share = sum(refused.values()) / count
    print(f"texts refused: {sum(refused.values())} of {count} ({share:.2%}): {dict(refused.most_common(8))}")


if __name__ == "__main__":
    main()
