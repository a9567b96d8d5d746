"""Structured light: a pattern from a projector beside the camera, matched in whole steps of disparity.

After Khoshelham and Elberink, "Accuracy and Resolution of Kinect Depth Data" (Sensors 2012): disparity comes in eighths
of a pixel, so that depth comes in steps of z² / (8 f b), and its noise grows with z². Errors are alike over the few
pixels of the matched window. What the projector cannot see has no depth; nor has what is dark, shiny or grazed.
"""

import numpy as np
from numba import njit

from lpslam.simulation.worlds.sensing.noise import NoiseFields
from lpslam.simulation.worlds.sensing.surfaces import Picture, Surfaces

BASELINE = 0.075  # metres
STEPS = 8.0  # of disparity in a pixel
SIGMA = (0.0014, 0.0029)  # metres per square metre, of the noise with its rounding
NEAREST = 0.5  # metres
FOCAL = 580.0  # pixels at a width of 640


def sigma_of(noise: float) -> float:
    """Metres per square metre of a sensor, `noise` from 0 to 1."""
    return SIGMA[0] + noise * (SIGMA[1] - SIGMA[0])


class StructuredLight:
    """A Kinect or Xtion.

    Args:
        width, height: pixels.
        noise: 0 to 1, where in the published range.
        farthest: metres.
    """

    def __init__(self, width: int, height: int, noise: float, farthest: float) -> None:
        self._fields = NoiseFields(width, height, (1.3, 3.5))
        self._sigma, self._farthest = sigma_of(noise), farthest

    def measure(self, rng: np.random.Generator, seen: Surfaces) -> Picture:
        """(height, width) metres, 0 where nothing is measured."""
        focal_baseline = seen.camera.fx * BASELINE
        # The rounding's own share of the noise is taken out: published figures are of what the sensor gives.
        sigma = np.sqrt(max((self._sigma * focal_baseline) ** 2 - 1 / (12 * STEPS**2), 1e-6))
        error, aside, down = (self._fields.draw(rng, 0) for _ in range(3))
        clumps = self._fields.draw(rng, 1)
        glass = seen.glazing.astype(np.float32)
        return _measure(
            seen.depth, seen.slant, seen.brightness, seen.gloss, glass, error, aside, down, clumps, focal_baseline,
            sigma, self._farthest,
        )  # fmt: skip


@njit(cache=True, nogil=True, fastmath=True)
def _measure(
    depth: Picture,
    slant: Picture,
    brightness: Picture,
    gloss: Picture,
    glass: Picture,
    error: Picture,
    aside: Picture,
    down: Picture,
    clumps: Picture,
    focal_baseline: float,
    sigma: float,
    farthest: float,
) -> Picture:
    height, width = depth.shape
    out = np.zeros((height, width), np.float32)
    for row in range(height):
        # From the right: what lies left of the leftmost ray that the projector has sent so far is in shadow.
        reached = 1e9
        for column in range(width - 1, -1, -1):
            z = depth[row, column]
            if z <= 0.0:
                continue
            projected = column - focal_baseline / z
            hidden = projected > reached + 0.7
            reached = min(reached, projected)
            if hidden:
                continue
            x, y = min(column + 1, width - 1), min(row + 1, height - 1)
            left, above = depth[row, max(column - 1, 0)], depth[max(row - 1, 0), column]
            if abs(depth[row, x] - left) > 0.06 * z or abs(depth[y, column] - above) > 0.06 * z:
                # Windows that lie across an edge take one side or the other: edges are ragged.
                x = min(max(int(column + 1.2 * aside[row, column] + 0.5), 0), width - 1)
                y = min(max(int(row + 1.2 * down[row, column] + 0.5), 0), height - 1)
                z = depth[y, x]
                if clumps[row, column] > 0.5 or z <= 0.0:
                    continue
            if z < NEAREST or z > farthest:
                continue
            limit = 2.9 - 1.8 * gloss[row, column] - 0.02 * max(0.0, 34.0 - brightness[row, column]) * z
            limit -= 1.6 * (glass[row, column] > 0.0)
            if slant[row, column] < 0.25:
                limit -= (0.25 - slant[row, column]) * 20.0
            if clumps[row, column] > limit:
                continue
            disparity = focal_baseline / z + sigma * error[row, column]
            disparity = np.floor(disparity * STEPS + 0.5) / STEPS
            if disparity > 0.0:
                out[row, column] = focal_baseline / disparity
    return out
