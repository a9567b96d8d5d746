"""What all written recordings share: stamps with their nanoseconds, and pictures packed without loss."""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

_LARGEST = 65535


def raw_depth(depth: NDArray[np.float32], depth_scale: float) -> NDArray[np.uint16] | NDArray[np.float32]:
    """Depth (h, w) in whole raw units where they give every reading back to the last bit; else as it is, in metres."""
    raw = np.rint(depth.astype(np.float64) * depth_scale)
    if raw.max(initial=0) <= _LARGEST:
        whole = raw.astype(np.uint16)
        if np.array_equal(whole.astype(np.float32) * np.float32(1.0 / depth_scale), depth):
            return whole
    return depth


def stamp_of(timestamp: float) -> str:
    """Seconds with nine decimals."""
    return f"{timestamp:.9f}"


def nanoseconds_of(timestamp: float) -> int:
    """Whole nanoseconds that give the same seconds back: a product would round once more."""
    return int(stamp_of(timestamp).replace(".", ""))


def packed(suffix: str, picture: Any) -> bytes:
    """A picture in the format of a suffix; PNG quickly."""
    options = [cv2.IMWRITE_PNG_COMPRESSION, 1] if suffix == ".png" else []
    return bytes(cv2.imencode(suffix, np.ascontiguousarray(picture), options)[1].tobytes())
