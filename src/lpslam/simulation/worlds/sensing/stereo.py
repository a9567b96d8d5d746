"""Active stereo: two infrared cameras and a projector of dots, matched over windows.

The noise of depth is that of disparity, sigma_z = s z² / (f b) with s of 0.05 to 0.15 pixel (Intel, "Best-Known-Methods
for Tuning RealSense D400"; Ahn et al., ICRA 2019, find 0.08). A window that reaches over an edge takes the nearer side,
so near things are fat and their outlines smeared. Where there is little to match, dots are weak and far, patches are
missing or wrong.
"""

import cv2
import numpy as np
from numba import njit

from lpslam.simulation.worlds.sensing.noise import NoiseFields
from lpslam.simulation.worlds.sensing.surfaces import Picture, Surfaces

SUBPIXEL = (0.05, 0.15)  # pixels, of disparity's noise
STEPS = 32.0  # of disparity in a pixel
WINDOW = 7  # pixels
NEAREST = 0.28  # metres


class ActiveStereo:
    """A D435 or D455.

    Args:
        width, height: pixels.
        noise: 0 to 1, where in the published range.
        baseline: metres.
        farthest: metres.
    """

    def __init__(self, width: int, height: int, noise: float, baseline: float, farthest: float) -> None:
        self._fields = NoiseFields(width, height, (2.0, 4.0))
        self.subpixel = SUBPIXEL[0] + noise * (SUBPIXEL[1] - SUBPIXEL[0])
        self.baseline = baseline
        self._farthest = farthest

    def measure(self, rng: np.random.Generator, seen: Surfaces) -> Picture:
        """(height, width) metres, 0 where nothing is measured."""
        inverse = np.where(seen.depth > 0, 1 / np.maximum(seen.depth, 0.05), 0).astype(np.float32)
        near = np.asarray(cv2.dilate(inverse, np.ones((WINDOW, WINDOW), np.uint8)), np.float32)
        mean = np.asarray(cv2.blur(inverse, (WINDOW, WINDOW)), np.float32)
        texture = np.asarray(cv2.blur(seen.texture, (WINDOW, WINDOW)), np.float32)
        error, wrong = self._fields.draw(rng, 0), self._fields.draw(rng, 1)
        clumps, ragged = self._fields.draw(rng, 1), self._fields.draw(rng, 0)
        glass = seen.glazing.astype(np.float32)
        return _measure(
            inverse, near, mean, texture, seen.slant, seen.brightness, seen.gloss, glass, error, wrong, clumps, ragged,
            seen.camera.fx * self.baseline, self.subpixel, self._farthest,
        )  # fmt: skip


@njit(cache=True, nogil=True, fastmath=True)
def _measure(
    inverse: Picture,
    near: Picture,
    mean: Picture,
    texture: Picture,
    slant: Picture,
    brightness: Picture,
    gloss: Picture,
    glass: Picture,
    error: Picture,
    wrong: Picture,
    clumps: Picture,
    ragged: Picture,
    focal_baseline: float,
    subpixel: float,
    farthest: float,
) -> Picture:
    height, width = inverse.shape
    out = np.zeros((height, width), np.float32)
    for row in range(height):
        reached = 1e9
        for column in range(width - 1, -1, -1):
            nearness = inverse[row, column]
            seen_at = column - focal_baseline * nearness
            hidden = seen_at > reached + 1.5
            reached = min(reached, seen_at)
            if near[row, column] > 1.06 * nearness:
                # Beside something nearer: its depth, or one in between, reaches out over the background.
                choice = ragged[row, column]
                if choice > 0.1:
                    nearness = near[row, column]
                elif choice > -0.5:
                    nearness = mean[row, column]
                elif hidden or choice < -1.3:
                    continue
            elif hidden:
                continue
            if nearness <= 0.0:
                continue
            z = 1.0 / nearness
            if z < NEAREST or z > farthest:
                continue
            # Dots fade with the square of the range and on dark things; texture helps where there is light.
            dots = 40.0 * (0.35 + brightness[row, column] / 160.0) * slant[row, column] / (1.0 + 0.35 * z * z)
            trust = dots + 0.7 * texture[row, column]
            limit = 2.6 - 12.0 / (trust + 1.5) - 1.2 * gloss[row, column] - 1.2 * (glass[row, column] > 0.0)
            limit = min(limit, 2.6 - 10.0 * max(0.0, 0.2 - slant[row, column]))
            if clumps[row, column] > limit:
                continue
            disparity = focal_baseline * nearness
            spread = subpixel * (1.0 + 5.0 / (trust + 2.0))
            disparity += spread * error[row, column]
            if trust < 7.0 and wrong[row, column] > 2.0:
                disparity *= 1.0 + 0.25 * (wrong[row, column] - 1.6)
            disparity = np.floor(disparity * STEPS + 0.5) / STEPS
            if disparity > 0.0:
                z = focal_baseline / disparity
                out[row, column] = z if z <= 1.3 * farthest else 0.0
    return out
