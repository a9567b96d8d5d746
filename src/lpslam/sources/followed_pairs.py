"""Pairs of views of a recording, a moment apart, with places followed from one to the other by optical flow."""

from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import FocalCheckConfig
from lpslam.frames import RgbdFrame
from lpslam.sources.rigidity import ViewPair

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

_HALF = 0.5  # of the size: flow reaches twice as far, for a quarter of the work
_QUALITY, _APART = 0.01, 8.0  # corners: share of the best one's contrast, and pixels of the small picture between two
_WINDOW, _LEVELS = (15, 15), 3  # the patch that is followed, and how often it is halved: up to 60 pixels of the picture
_UNTIL = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 15, 0.03)
_RETURN = 0.5  # pixels of the small picture by which a corner that is followed there and back may miss its place


def pairs_of(
    read: Callable[[int], RgbdFrame | None], times: Sequence[float], config: FocalCheckConfig
) -> list[ViewPair]:
    """Pairs spread over a recording; where too little is followed, its frames are taken nearer to each other.

    Args:
        read: gives the frame of a number; None where it cannot be used.
        times: of all frames, seconds, rising.
        config: how many pairs, how far apart, and what makes one.
    """
    pairs: list[ViewPair] = []
    count = len(times)
    if count < 2 or not config.pairs:
        return pairs
    apart = max(1, round(config.apart_s / max(float(np.median(np.diff(times))), 1e-3)))
    for start in np.unique(np.linspace(0, max(count - 1 - apart, 0), config.pairs).astype(int)):
        first = read(int(start))
        if first is None:
            continue
        small = small_picture(first)
        corners = corners_of(small, config.corners)
        if len(corners) < config.min_places:
            continue
        for gap in (apart, apart // 3):
            end = min(int(start) + gap, count - 1)
            other = read(end) if end > start else None
            pair = None if other is None else _pair(first, small, corners, other, config)
            if pair is not None:
                pairs.append(pair)
                break
    return pairs


def _pair(
    first: RgbdFrame, small: Picture, corners: NDArray[np.float32], other: RgbdFrame, config: FocalCheckConfig
) -> ViewPair | None:
    """What was followed and has depth at both ends; None if it is too little, or hardly moved."""
    other_small = small_picture(other)
    ends, ok = followed(small, other_small, corners)
    pixels, other_pixels = (_full_size(each[ok, 0]) for each in (corners, ends))
    depth, other_depth = _depths(first.depth, pixels, config), _depths(other.depth, other_pixels, config)
    both = (depth > 0) & (other_depth > 0)
    if both.sum() < config.min_places:
        return None
    moved = np.linalg.norm(pixels[both] - other_pixels[both], axis=1)
    if np.median(moved) < config.min_motion:
        return None
    return ViewPair(pixels[both], depth[both], other_pixels[both], other_depth[both])


def corners_of(picture: Picture, count: int) -> NDArray[np.float32]:
    """Up to so many corners that can be followed, (n, 1, 2) u, v; none in a blank picture."""
    found = cv2.goodFeaturesToTrack(picture, count, _QUALITY, _APART)
    return np.empty((0, 1, 2), np.float32) if found is None else np.asarray(found, np.float32)


def small_picture(frame: RgbdFrame) -> Picture:
    """Grey values at half the size."""
    gray = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY)
    return np.asarray(cv2.resize(gray, None, fx=_HALF, fy=_HALF, interpolation=cv2.INTER_AREA), np.uint8)


def followed(
    start: Picture, end: Picture, corners: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Where corners (n, 1, 2) of one picture are in another, and which of them come back when followed back (n,)."""
    ends, found = _flow(start, end, corners)
    back, found_back = _flow(end, start, ends)
    missed = np.linalg.norm((back - corners)[:, 0], axis=1)
    return ends, (found[:, 0] > 0) & (found_back[:, 0] > 0) & (missed < _RETURN)


def _flow(start: Picture, end: Picture, corners: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    ends, found, _ = cv2.calcOpticalFlowPyrLK(
        start, end, corners, corners.copy(), winSize=_WINDOW, maxLevel=_LEVELS, criteria=_UNTIL
    )
    return np.asarray(ends, np.float32), np.asarray(found, np.uint8)


def _full_size(small_pixels: NDArray[np.float32]) -> Array:
    """Pixels of the full picture; pixel centres are at whole numbers in both."""
    return (small_pixels.astype(np.float64) + 0.5) / _HALF - 0.5


def _depths(depth: NDArray[np.float32], pixels: Array, config: FocalCheckConfig) -> Array:
    """Depth at pixels (n,), metres; 0 at edges, out of reach, or where there is none."""
    height, width = depth.shape
    if min(height, width) < 3:
        return np.zeros(len(pixels))
    u = np.clip(np.rint(pixels[:, 0]).astype(int), 1, width - 2)
    v = np.clip(np.rint(pixels[:, 1]).astype(int), 1, height - 2)
    around = np.stack([depth[v + y, u + x] for y in (-1, 0, 1) for x in (-1, 0, 1)])
    least, most = config.depth_reach
    z = depth[v, u].astype(np.float64)
    with np.errstate(invalid="ignore"):
        is_sound = (around.min(axis=0) > least) & (around.max(axis=0) < most)
        is_sound &= np.ptp(around, axis=0) < config.depth_edge * z
    return np.where(is_sound, z, 0.0)
