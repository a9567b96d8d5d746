"""Frames that wait to be read, packed: a tenth of the memory, so that ten times as many may wait."""

import zlib
from dataclasses import dataclass
from typing import Self

import cv2
import numpy as np

from lpslam.frames import RgbdFrame

# JPEG of this quality, with colours as fine as brightness: gold letters on red differ in colour alone.
_JPEG = [
    *(cv2.IMWRITE_JPEG_QUALITY, 95),
    *(cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444),
]
# Of zlib: higher levels take thrice the time for a tenth less.
_LEVEL = 1


@dataclass(frozen=True, slots=True, eq=False)
class PackedFrame:
    """A frame with its picture as JPEG and its depth compressed without loss.

    Attributes:
        index, timestamp: as those of the frame.
    """

    index: int
    timestamp: float
    _jpeg: bytes
    _depth: bytes
    _shape: tuple[int, int]

    @classmethod
    def of(cls, frame: RgbdFrame) -> Self:
        """Pack a frame; takes about ten milliseconds for 640 by 480 pixels."""
        _, jpeg = cv2.imencode(".jpg", frame.rgb[..., ::-1], _JPEG)
        height, width = frame.depth.shape
        return cls(
            frame.index,
            frame.timestamp,
            jpeg.tobytes(),
            zlib.compress(np.ascontiguousarray(frame.depth).data, _LEVEL),
            (height, width),
        )

    @property
    def nbytes(self) -> int:
        """That it takes."""
        return len(self._jpeg) + len(self._depth)

    def unpacked(self) -> RgbdFrame:
        """The frame, its picture nearly as it was."""
        rgb = cv2.imdecode(np.frombuffer(self._jpeg, np.uint8), cv2.IMREAD_COLOR_RGB)
        depth = np.frombuffer(zlib.decompress(self._depth), np.float32).reshape(self._shape)
        return RgbdFrame(self.index, self.timestamp, np.asarray(rgb, np.uint8), depth)
