"""A telephone's LiDAR: a few hundred dots, and a network that fills in 256 × 192 depths from the colour image.

The result is smooth and without holes. Errors are alike over wide patches (about 1 % of the range: Luetzenburg et al.,
Scientific Reports 2021), and where depth jumps the map slopes from one side to the other, and looks as sure there as
elsewhere.
"""

import cv2
import numpy as np

from lpslam.simulation.worlds.sensing.noise import NoiseFields
from lpslam.simulation.worlds.sensing.surfaces import Picture, Surfaces

WIDTH, HEIGHT = 256, 192  # pixels
PATCHY = (0.003, 0.010)  # share of the range
FINE = 0.002  # metres
SMOOTHING = 1.4  # pixels
FARTHEST = 5.0  # metres; beyond, the range is guessed too short
GIVEN_UP = 7.5  # metres; beyond, nothing is said
NEAREST = 0.25  # metres


class PhoneLidar:
    """An iPhone or iPad.

    Args:
        noise: 0 to 1, where in the published range.
    """

    def __init__(self, width: int, height: int, noise: float) -> None:
        self._fields = NoiseFields(width, height, (7.0, 1.2))
        self.patchy = PATCHY[0] + noise * (PATCHY[1] - PATCHY[0])

    def measure(self, rng: np.random.Generator, seen: Surfaces) -> Picture:
        """(height, width) metres, 0 where nothing is said."""
        known = (seen.depth > 0).astype(np.float32)
        # In logarithms, as such networks predict: a slope between two sides passes near the nearer one longer.
        log = np.where(seen.depth > 0, np.log(np.maximum(seen.depth, 0.05)), 0).astype(np.float32)
        weight = np.asarray(cv2.GaussianBlur(known, (0, 0), SMOOTHING), np.float32)
        smooth = np.exp(cv2.GaussianBlur(log, (0, 0), SMOOTHING) / np.maximum(weight, 1e-3))
        depth = smooth * (1 + self.patchy * self._fields.draw(rng, 0)) + FINE * self._fields.draw(rng, 1)
        depth = np.where(depth > FARTHEST, FARTHEST + 0.6 * (depth - FARTHEST), depth)
        kept = (weight > 0.4) & (smooth < GIVEN_UP) & (depth > NEAREST)
        return np.where(kept, depth, 0).astype(np.float32)
