"""From light on the sensor to an 8-bit picture: automatic exposure and white balance, vignetting, noise, a cover."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.simulation.worlds.sensing.noise import NoiseFields

AIM = 112.0  # mean grey value that the exposure aims at
MAX_GAIN = 2.4  # on the scale of displayed brightness: a dark place stays dark
USUAL_SHUTTER = 0.010  # seconds; a shorter one needs more gain, which brings more noise

Picture = NDArray[np.float32]


def exposure_gains(
    brightness: NDArray[np.float64], rng: np.random.Generator, fps: float, hunts: bool
) -> NDArray[np.float64]:
    """(frames, 3) factors for red, green and blue that automatic exposure and white balance set.

    Args:
        brightness: (frames,) mean grey value of each frame before exposure.
        rng: draws how the control behaves.
        fps: frames a second.
        hunts: whether the control overshoots and wanders, or settles slowly.
    """
    step = 1.0 / fps
    speed = float(rng.uniform(5.0, 8.0)) if hunts else float(rng.uniform(1.5, 3.0))  # radians a second
    damping = float(rng.uniform(0.12, 0.3)) if hunts else 1.0
    aims = np.log(np.clip(AIM / np.maximum(brightness, 1e-3), 0.25, MAX_GAIN))
    value, rate = float(aims[0]), 0.0
    gains = np.empty(len(aims))
    for i, aim in enumerate(aims):
        for _ in range(8):
            rate += (speed**2 * (aim - value) - 2 * damping * speed * rate) * step / 8
            value += rate * step / 8
        gains[i] = np.exp(min(value, np.log(MAX_GAIN)))
    times = np.arange(len(aims)) * step
    tint = np.array([rng.uniform(-0.06, 0.06), 0.0, rng.uniform(-0.08, 0.08)])
    colour = np.ones((len(aims), 3)) + tint
    if hunts:
        for channel in (0, 2):
            wave = np.sin(times * rng.uniform(0.5, 2.5) + rng.uniform(0, 6)) * np.sin(times * rng.uniform(0.2, 0.7))
            colour[:, channel] += rng.uniform(0.04, 0.1) * wave
    return np.asarray(gains[:, None] * colour)


class Sensor:
    """A colour sensor's noise and vignetting.

    Args:
        vignette: (height, width) brightness factors.
        grain: 1 for a usual sensor.
        shutter_time: seconds.
    """

    def __init__(self, vignette: Picture, grain: float, shutter_time: float) -> None:
        height, width = vignette.shape
        self._vignette = vignette
        self._noise = NoiseFields(width, height, (0.6, 0.9))
        self._grain = grain * np.sqrt(USUAL_SHUTTER / shutter_time)

    def develop(
        self, rng: np.random.Generator, light: Picture, level: float, gains: NDArray[np.float64], cover: float
    ) -> NDArray[np.uint8]:
        """Expose one frame.

        Args:
            rng: of this frame.
            light: (height, width, 3) on the scale of 0 to 255.
            level: brightness of the lamps.
            gains: (3,) of red, green and blue.
            cover: 0 to 1, how much of the image something dark covers, from below.
        """
        grain = self._grain * (0.5 + 0.5 * float(gains[1]))
        layers = [self._noise.draw(rng, kind) for kind in (0, 0, 0, 1)]
        return _develop(light, level * gains, self._vignette, layers[0], layers[1], layers[2], layers[3], grain, cover)


@njit(cache=True, nogil=True, fastmath=True)
def _develop(
    light: Picture,
    gains: NDArray[np.float64],
    vignette: Picture,
    noise_red: Picture,
    noise_green: Picture,
    noise_blue: Picture,
    noise_grey: Picture,
    grain: float,
    cover: float,
) -> NDArray[np.uint8]:
    height, width = vignette.shape
    out = np.empty((height, width, 3), np.uint8)
    # By whole grey values: a square root for every value would cost as much as all the rest.
    sigma = np.empty(257)
    for value in range(257):
        sigma[value] = grain * (0.7 + 0.09 * math.sqrt(value))
    for row in range(height):
        # What covers the lens is out of focus: its edge is soft.
        bare = min(max((1.15 - cover * 1.3 - row / height) / 0.15, 0.0), 1.0)
        for column in range(width):
            shade = vignette[row, column] * bare
            for c in range(3):
                value = light[row, column, c] * gains[c] * shade
                if value > 215.0:
                    over = (value - 215.0) / 40.0
                    value = 215.0 + 40.0 * over / (1.0 + over)
                own = noise_red[row, column]
                if c == 1:
                    own = noise_green[row, column]
                elif c == 2:
                    own = noise_blue[row, column]
                value += (0.8 * own + 0.5 * noise_grey[row, column]) * sigma[int(min(max(value, 0.0), 256.0))]
                out[row, column, c] = np.uint8(min(max(value + 2.5, 0.0), 255.0))
    return out
