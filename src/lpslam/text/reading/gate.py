"""Which frames are read: at a set interval, sooner for new text, and rather a little later than blurred."""

from collections import deque

import cv2
import numpy as np

from lpslam.config import ReadingConfig
from lpslam.frames import RgbdFrame


class ReadingGate:
    """Decides which frames are read: at a set interval, sooner for new text, and rather a little later than blurred."""

    def __init__(self, config: ReadingConfig) -> None:
        self._config = config
        self._hurries_until = -np.inf
        self._last_read: float | None = None
        self._sharpness: deque[float] = deque(maxlen=config.blur_window)

    def is_due(self, timestamp: float) -> bool:
        """Whether the interval since the last reading has passed."""
        hurries = timestamp <= self._hurries_until
        interval = self._config.new_text_interval if hurries else self._config.interval
        # Half a millisecond of grace: timestamps are rounded.
        return self._last_read is None or timestamp - self._last_read >= interval - 5e-4

    def is_sharp(self, frame: RgbdFrame) -> bool:
        """Whether a frame is not blurred against those before it, or no sharper one has come for too long."""
        grey = cv2.cvtColor(frame.rgb[::2, ::2], cv2.COLOR_RGB2GRAY)
        sharpness = float(cv2.Laplacian(grey, cv2.CV_32F).var())
        usual = float(np.median(self._sharpness)) if self._sharpness else sharpness
        self._sharpness.append(sharpness)
        if sharpness >= self._config.blur_share * usual:
            return True
        waited = frame.timestamp - (frame.timestamp if self._last_read is None else self._last_read)
        return waited >= (1.0 + self._config.blur_patience) * self._config.interval

    def hurry(self, timestamp: float) -> None:
        """Note that a text was seen that is not settled yet: it may be gone soon."""
        self._hurries_until = max(self._hurries_until, timestamp + self._config.new_text_patience)

    def taken(self, timestamp: float) -> None:
        """Note that a frame is read now."""
        self._last_read = timestamp
