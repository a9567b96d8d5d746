"""Time of flight: the phase of light that comes back.

After Sarbolandi, Lefloch and Kolb (CVIU 2015) and Tölgyessy et al. (Sensors 2021): sigma is a millimetre or two near by
and grows as less light returns, from far, dark and slanted surfaces; a pixel that sees two surfaces measures one in
between (a flying pixel); light that takes a way around by another wall makes corners bulge away; and the range is wrong
by some millimetres in a wave along it.
"""

import cv2
import numpy as np
from numba import njit

from lpslam.simulation.worlds.sensing.noise import NoiseFields
from lpslam.simulation.worlds.sensing.surfaces import Picture, Surfaces

SIGMA = (0.0010, 0.0025)  # metres, of a bright wall at 1 m
WIGGLE = (0.002, 0.008)  # metres
WAVE = 0.47  # metres of range in which the wiggle comes again
NEAREST = 0.3  # metres
LEAST_AMPLITUDE = 0.011  # of a bright wall's at 1 m; less is no measurement
EDGE = 0.04  # share of the depth by which neighbours differ at an edge


class TimeOfFlight:
    """A Kinect v2 or Azure Kinect.

    Args:
        rng: draws its systematic errors.
        width, height: pixels.
        noise: 0 to 1, where in the published range.
        farthest: metres.
    """

    def __init__(self, rng: np.random.Generator, width: int, height: int, noise: float, farthest: float) -> None:
        self._fields = NoiseFields(width, height, (0.5, 0.0))
        self.sigma = SIGMA[0] + noise * (SIGMA[1] - SIGMA[0])
        self.wiggle = WIGGLE[0] + noise * (WIGGLE[1] - WIGGLE[0])
        self._phase, self._bulge = float(rng.uniform(0, 2 * np.pi)), float(rng.uniform(0.2, 0.6))
        self._filtered = float(rng.choice([0.0, 0.6]))  # share of flying pixels that the device itself takes out
        self._farthest = farthest

    def measure(self, rng: np.random.Generator, seen: Surfaces) -> Picture:
        """(height, width) metres, 0 where nothing is measured."""
        error, mixing = self._fields.draw(rng, 0), self._fields.draw(rng, 1)
        reach = max(3, seen.camera.width // 14) | 1
        # Around a corner the depth is less than in it; an edge's step says nothing of that and is held down.
        around = np.asarray(cv2.blur(seen.depth, (reach, reach)), np.float32)
        glass = seen.glazing.astype(np.float32)
        errors = (self.sigma, self.wiggle, self._phase, self._bulge, self._filtered, self._farthest)
        return _measure(seen.depth, seen.slant, seen.brightness, seen.gloss, glass, around, error, mixing, errors)


@njit(cache=True, nogil=True, fastmath=True)
def _measure(
    depth: Picture,
    slant: Picture,
    brightness: Picture,
    gloss: Picture,
    glass: Picture,
    around: Picture,
    error: Picture,
    mixing: Picture,
    errors: tuple[float, float, float, float, float, float],
) -> Picture:
    sigma, wiggle, phase, bulge, filtered, farthest = errors
    height, width = depth.shape
    out = np.zeros((height, width), np.float32)
    for row in range(height):
        above, below = max(row - 1, 0), min(row + 1, height - 1)
        for column in range(width):
            z = depth[row, column]
            if z <= 0.0:
                continue
            left, right = max(column - 1, 0), min(column + 1, width - 1)
            amplitude = (0.15 + brightness[row, column] / 130.0) * slant[row, column] / (z * z)
            # A pixel's light is a little of its neighbours' too: at an edge the phases mix.
            total, weight, is_edge = z * amplitude, amplitude, False
            for side in range(4):
                y = above if side == 0 else below if side == 1 else row
                x = left if side == 2 else right if side == 3 else column
                other = depth[y, x]
                if other > 0.0 and abs(other - z) > EDGE * z:
                    is_edge = True
                    share = max(0.0, 0.45 + 0.35 * mixing[row, column])
                    more = share * (0.15 + brightness[y, x] / 130.0) * max(slant[y, x], 0.05) / (other * other)
                    total += other * more
                    weight += more
            measured = total / max(weight, 1e-9)
            if is_edge and abs(mixing[column % height, row % width]) < 0.84 * filtered:
                continue
            limit = LEAST_AMPLITUDE * (1.0 + 0.3 * mixing[row, column])
            amplitude *= (1.0 - 0.7 * gloss[row, column]) * (0.3 if glass[row, column] == 2.0 else 1.0)
            if amplitude < limit or measured < NEAREST or measured > farthest:
                continue
            measured += bulge * min(max(z - around[row, column], 0.0), 0.08)
            measured += wiggle * np.sin(2.0 * np.pi * z / WAVE + phase)
            measured += sigma * (0.6 + 0.4 / np.sqrt(amplitude)) * error[row, column]
            out[row, column] = measured
    return out
