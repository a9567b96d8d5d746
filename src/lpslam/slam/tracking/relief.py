"""Faint patterns of pictures: what stands out from its surroundings, and how far it has moved as a whole.

A bare wall has grain that no corner detector finds. It is a grey value deep, as is the noise, but thousands of pixels
have it: compared all at once they tell a shift to a fraction of a pixel.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

_Matrix = NDArray[np.float64]
_Image = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Shift:
    """A shift between two pictures.

    Attributes:
        across, down: pixels.
        lead: how many times the next best shift it is as likely.
    """

    across: int
    down: int
    lead: float

    def turn(self, intrinsics: _Matrix) -> _Matrix:
        """(3,) rotation vector of the camera's turn that moves the middle of the picture so."""
        return np.array([-np.arctan(self.down / intrinsics[1]), np.arctan(self.across / intrinsics[0]), 0.0])


def relief(shades: _Image, around: float) -> _Image:
    """Grey values (h, w) less those about them, weighed over `around` pixels.

    What lamps and the lens make of a picture stays where it is when the camera moves, and changes slowly over it.
    """
    rim = min(int(np.ceil(3 * around)), *(side - 1 for side in shades.shape))
    # Continued as it slopes, so that a picture that darkens towards its border has no step there.
    padded = np.pad(shades, rim, mode="reflect", reflect_type="odd")
    raised = cv2.GaussianBlur(padded, (0, 0), _GRAIN) - cv2.GaussianBlur(padded, (0, 0), around)
    return np.asarray(raised[rim:-rim, rim:-rim], np.float32)


def shift_between(before: _Image, now: _Image, turn: _Matrix, intrinsics: _Matrix) -> Shift:
    """How far a relief (h, w) lies from where an earlier one is after a turn of the camera (3×3)."""
    height, width = now.shape
    matrix = np.array([[intrinsics[0], 0.0, intrinsics[2]], [0.0, intrinsics[1], intrinsics[3]], [0.0, 0.0, 1.0]])
    warp = matrix @ turn @ np.linalg.inv(matrix)
    ahead = cv2.warpPerspective(before, warp, (width, height))
    known = cv2.warpPerspective(np.ones_like(before), warp, (width, height))
    return shift_of(np.asarray(ahead * known, np.float32), now)


def shift_of(one: _Image, other: _Image) -> Shift:
    """How far a relief (h, w), 0 where it is not known, lies from another one.

    By the peak of their correlation, whose frequencies are levelled by half (Kuglin 1975; Knapp 1976): all of it, and a
    few have all the noise; none, and a large bright thing outweighs the rest.
    """
    height, width = other.shape
    # Smooth to nothing at the border, which else is the strongest pattern of all.
    window = np.outer(np.hanning(height + 2)[1:-1], np.hanning(width + 2)[1:-1]).astype(np.float32)
    cross = np.fft.rfft2(other * window) * np.conj(np.fft.rfft2(one * window))
    likely = np.fft.irfft2(cross / np.sqrt(np.abs(cross) + _NOTHING), s=other.shape)
    down, across = (int(each) for each in np.unravel_index(int(likely.argmax()), likely.shape))
    peak = float(likely[down, across])
    near = np.arange(-_PEAK, _PEAK + 1)
    likely[np.ix_((down + near) % height, (across + near) % width)] = 0.0
    lead = peak / max(float(likely.max()), _NOTHING)
    return Shift(across - width * (2 * across > width), down - height * (2 * down > height), lead)


def likeness(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """By how many sigmas grey values (n,) of neighbouring pixels are more alike than those of different things."""
    spread = float(one.std() * other.std())
    if not spread > 0.0:
        return 0.0
    correlation = float(np.mean((one - one.mean()) * (other - other.mean()))) / spread
    return correlation * float(np.sqrt(len(one) / _ALIKE_TOGETHER))


_GRAIN = 0.8
"""Pixels: smoothing before pictures are compared; finer patterns are noise."""

_PEAK = 3
"""Pixels around the best shift that are as good as it: as wide as grain is."""

_NOTHING = 1e-9
"""Against pictures without any pattern."""

_ALIKE_TOGETHER = 30.0
"""Pixels of a relief that are alike as neighbours are, and say a thing once."""
