"""Plain reading on photographs of signs: which lines are read, how well, and what it costs."""

import json
import time
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from lpslam.config import SpottingConfig
from lpslam.evaluation.reading import LineScore, score_lines
from lpslam.text.reading.borders import cut_by_border
from lpslam.text.reading.boxes import letter_heights
from lpslam.text.reading.spotting import PaddleSpotter, accepted_texts


def measure(folders: Sequence[Path], config: SpottingConfig) -> None:
    """Read folders of photographs with `labels.json`, {"images": {file: [line, ...]}}."""
    spotter = PaddleSpotter(config)
    for folder in folders:
        labels = json.loads((folder / "labels.json").read_text(encoding="utf-8"))["images"]
        total = LineScore()
        detection = recognition = 0.0
        for name, lines in labels.items():
            picture = cv2.imread(str(folder / name))
            if picture is None:
                raise SystemExit(f"{folder / name} is no picture")
            image = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)
            started = time.process_time()
            boxes, _ = spotter.detect(image)
            detected = time.process_time()
            boxes = boxes[~cut_by_border(image, boxes)]
            boxes = boxes[letter_heights(boxes) >= config.min_letter_height]
            accepted = accepted_texts(boxes, spotter.recognise(image, boxes), config)
            texts = [each.text for each in accepted if each is not None]
            detection += detected - started
            recognition += time.process_time() - detected
            score = score_lines(texts, lines)
            for line in score.unread:
                print(f"  {name}: {line!r} not read; texts {texts}")
            total += score
        right = 1 - total.wrong_letters / max(1, total.letters)
        print(f"{folder.name}: lines found {total.found} of {total.lines}, read {total.read}, exactly {total.exact};")
        print(f"  letters right {right:.1%}; texts like no line {total.spurious} of {total.texts};")
        print(f"  processor time a photograph: detection {1e3 * detection / len(labels):.0f} ms, ", end="")
        print(f"recognition {1e3 * recognition / len(labels):.0f} ms")
