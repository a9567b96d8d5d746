"""How sharp frames usually are, by which a blurred one is known."""

import cv2
import numpy as np

from lpslam.frames import RgbdFrame

_SHARPNESS_RATE = 0.03
"""Share of its difference by which a frame changes the usual sharpness: a second's worth, longer than a jerk."""

_DARK = 0.7
"""Share of the usual brightness below which missing sharpness is the light's fault: half of it is left then."""


class UsualSharpness:
    """How sharp frames are here, slowly forgotten: by which a blurred one is known."""

    def __init__(self) -> None:
        self._usual = 0.0
        self._brightness = 0.0

    def begin(self, frame: RgbdFrame) -> None:
        """Take a first frame for the measure."""
        self._usual, self._brightness = _sharpness(frame), _brightness(frame)

    def share(self, frame: RgbdFrame) -> float:
        """Sharpness of a frame as a share of the usual one; 1 where that is not known yet."""
        return _sharpness(frame) / self._usual if self._usual else 1.0

    def note(self, frame: RgbdFrame) -> float:
        """Take a frame that was tracked, and return its share."""
        if not self._usual:
            # Where a saved map goes on, its first frame is the only measure.
            self.begin(frame)
        share = self.share(frame)
        self._usual *= 1.0 + (share - 1.0) * _SHARPNESS_RATE
        self._brightness += (_brightness(frame) - self._brightness) * _SHARPNESS_RATE
        return share

    def fault(self, frame: RgbdFrame) -> str:
        """In words why a frame is less sharp than usual: it is blurred, unless it is dark."""
        why = "dark or blurred" if _brightness(frame) < _DARK * self._brightness else "blurred"
        return f"{why} (sharpness {self.share(frame):.0%} of the usual)"


def _sharpness(frame: RgbdFrame) -> float:
    """Mean squared difference of neighbouring grey values at half resolution; falls with blur."""
    green = frame.rgb[::2, ::2, 1]
    return float(np.square(cv2.subtract(green[:, 1:], green[:, :-1]), dtype=np.float32).mean())


def _brightness(frame: RgbdFrame) -> float:
    return float(frame.rgb[::8, ::8, 1].mean())
