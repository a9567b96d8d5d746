"""Plain reading on photographs of signs: which lines are read, how well, and what it costs.

Run: python benchmarks/reading.py [FOLDER]

FOLDER holds `labels.json`, {"images": {file: [line, ...]}}, and the photographs; by default `../shared/data/signs`
beside the repository. A line counts as read when some text of its photograph reaches similarity 0.8 (Eq. 3, case and
spaces ignored), as exact when it is the same but for case and spaces.
"""

import argparse
import json
import time
from pathlib import Path

import cv2
import numpy as np

from lpslam.config import SpottingConfig
from lpslam.text.similarity import comparison_key, similarity
from lpslam.text.spotting import PaddleSpotter, letter_heights, touches_border

DEFAULT_FOLDER = Path(__file__).parents[2] / "shared" / "data" / "signs"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=DEFAULT_FOLDER)
    parser.add_argument("--engine", choices=["auto", "openvino", "onnxruntime"], default="auto")
    arguments = parser.parse_args()

    cv2.setNumThreads(1)
    config = SpottingConfig(engine=arguments.engine)
    spotter = PaddleSpotter(config)
    labels = json.loads((arguments.folder / "labels.json").read_text(encoding="utf-8"))["images"]
    wanted = read = exact = letters = edits = spurious = texts = 0
    detection = recognition = 0.0
    for name, lines in labels.items():
        image = np.asarray(cv2.cvtColor(cv2.imread(str(arguments.folder / name)), cv2.COLOR_BGR2RGB), np.uint8)
        started = time.process_time()
        boxes, _ = spotter.detect(image)
        detected = time.process_time()
        # A photograph is framed by a person: nothing is cut off, so only boxes on the very edge are dropped.
        boxes = boxes[~touches_border(boxes, image.shape[:2], 0.0)]
        boxes = boxes[letter_heights(boxes) >= config.min_letter_height]
        readings = [text for text, sure in spotter.recognise(image, boxes) if sure >= config.min_confidence]
        detection += detected - started
        recognition += time.process_time() - detected

        keys, line_keys = [comparison_key(each) for each in readings], [comparison_key(each) for each in lines]
        texts += len(keys)
        spurious += sum(max(similarity(key, line) for line in line_keys) < 0.5 for key in keys)
        for line, key in zip(lines, line_keys, strict=True):
            best = max((similarity(key, each) for each in keys), default=0.0)
            wanted += 1
            read += best >= 0.8
            exact += best == 1.0
            letters += len(key)
            edits += round((1.0 - best) * len(key))
            if best < 0.8:
                print(f"  {name}: {line!r} not read (best similarity {best:.2f})")
    print(f"lines read {read} of {wanted}, exactly {exact}; letters right {100 * (1 - edits / letters):.1f} %")
    print(f"texts like no line {spurious} of {texts}")
    print(f"CPU a photograph: detection {1e3 * detection / len(labels):.0f} ms, ", end="")
    print(f"recognition {1e3 * recognition / len(labels):.0f} ms ({1e3 * recognition / max(1, texts):.0f} ms a text)")


if __name__ == "__main__":
    main()
