"""Following keypoints from frame to frame by optical flow (Lucas-Kanade in a pyramid; Bouguet 2001).

Flow costs a fifth of finding and describing keypoints anew, and is as accurate over a few frames; what it follows are
observations of map points, so that matching with the map every few frames keeps it from drifting.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import TrackingConfig


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """Keypoints found again: which rows (m,) of those asked for, and their raw pixels (m, 2) now."""

    rows: NDArray[np.int64]
    raw: NDArray[np.float32]


def choose_followed(
    pixels: NDArray[np.float32], octave: NDArray[np.uint8], is_mapped: NDArray[np.bool_], limit: int
) -> NDArray[np.int64]:
    """Rows of at most `limit` keypoints (n, 2): those in the map first, spread over the image, fine levels first."""
    if len(pixels) <= limit:
        return np.arange(len(pixels))
    order = np.lexsort((octave, ~is_mapped))
    cell = np.floor(pixels[order] / _CELL).astype(np.int64) @ np.array([1, 1000])
    # Rank within the cell: the first of every cell is taken before the second of any.
    by_cell = np.argsort(cell, kind="stable")
    starts = np.flatnonzero(np.r_[True, np.diff(cell[by_cell]) != 0])
    lengths = np.diff(np.r_[starts, len(cell)])
    rank = np.empty(len(cell), np.int64)
    rank[by_cell] = np.arange(len(cell)) - np.repeat(starts, lengths)
    preferred = np.lexsort((rank, ~is_mapped[order]))
    chosen: NDArray[np.int64] = np.sort(order[preferred[:limit]])
    return chosen


_CELL = 32.0
"""Side in pixels of the cells over which followed keypoints are spread."""


def follow_flow(
    before: NDArray[np.uint8],
    now: NDArray[np.uint8],
    pixels: NDArray[np.float32],
    predicted: NDArray[np.float32],
    levels: int,
    camera: PinholeCamera,
    config: TrackingConfig,
) -> Flow:
    """Find keypoints of one image in the next.

    Args:
        before, now: (h, w) grey values.
        pixels: (n, 2) undistorted, in the first image.
        predicted: (n, 2) undistorted, where they are expected in the second.
        levels: pyramid levels above the image.
        camera: of both.
        config: window and precision.
    """
    height, width = now.shape
    start = camera.distort(predicted.astype(np.float64)).astype(np.float32)
    in_image = ((start >= 0) & (start < np.array([width, height]))).all(axis=1)
    asked = np.flatnonzero(in_image)
    if not len(asked):
        return Flow(asked, np.empty((0, 2), np.float32))
    raw_before = camera.distort(pixels[asked].astype(np.float64)).astype(np.float32)
    found, status, _ = cv2.calcOpticalFlowPyrLK(
        before,
        now,
        raw_before,
        start[asked].copy(),
        winSize=(config.flow_window, config.flow_window),
        maxLevel=levels,
        criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, config.flow_steps, config.flow_precision),
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    raw = found.reshape(-1, 2).astype(np.float32)
    ok = (status.reshape(-1) == 1) & ((raw >= 0) & (raw < np.array([width - 1, height - 1]))).all(axis=1)
    return Flow(asked[ok], raw[ok])
