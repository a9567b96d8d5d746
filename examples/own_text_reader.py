"""Map a recording with a reader of one's own: `own_text_reader.py RECORDING MAP.lpmap`."""

import sys

import numpy as np

import lpslam
from lpslam.text.types import Recognition


class OneSign:
    """Finds the yellowest patch, and says that it reads TAXI; a reader of one's own does better."""

    def detect(self, rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Boxes (n, 4, 2) in pixels, from the top left clockwise, and how sure each is."""
        red, green, blue = (rgb[..., channel].astype(int) for channel in range(3))
        rows, columns = np.nonzero(np.minimum(red, green) - blue > 100)
        if len(rows) < 200:
            return np.zeros((0, 4, 2)), np.zeros(0)
        (left, right), (top, bottom) = np.percentile(columns, [5, 95]), np.percentile(rows, [5, 95])
        return np.array([[[left, top], [right, top], [right, bottom], [left, bottom]]]), np.ones(1)

    def recognise(self, rgb: np.ndarray, boxes: np.ndarray) -> list[Recognition]:
        """What the boxes say, and how sure that is."""
        return [Recognition("TAXI", 0.9) for _ in boxes]


if __name__ == "__main__":
    world = lpslam.run(sys.argv[1], spotter=OneSign())
    world.save(sys.argv[2])
    print([mark.name for mark in world.landmarks()])
