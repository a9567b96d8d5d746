"""The frames that a calibration looks at: calm ones, each some way from the last."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import CalibratingConfig, FeatureConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.features import FeatureExtractor, Features
from lpslam.sources.followed_pairs import corners_of, followed, small_picture

Read = Callable[[int], RgbdFrame | None]

_CORNERS = 80
"""Followed to see how far the picture moved: their median needs no more."""

_FEWEST = 10
"""Corners that must be found again for that; with fewer, so much moved that nothing is told."""

_FIELD_ROUNDS, _FIELD_PIXELS = 4, 2.0
"""Of fitting a field of motion, each trusting those corners less that missed the last one by more than two pixels."""

_RUN = 10
"""Views that follow one another where not all can be used: each needs neighbours that see the same."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A chosen frame.

    Attributes:
        timestamp: seconds.
        features: its keypoints, at raw pixels.
        drag: (n, 2) pixels a second by which a rolling shutter would displace them; see `lens.project`.
    """

    timestamp: float
    features: Features
    drag: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Travel:
    """How the picture went on, frame by frame; n frames that can be used.

    Attributes:
        frames: (n,) their numbers in the recording.
        travelled: (n,) pixels that the picture has moved since the first one, all its motions added up.
        pace: (n,) pixels that it moves from frame to frame around each: blurred, and bent by a shutter that rolls.
    """

    frames: NDArray[np.int64]
    travelled: NDArray[np.float64]
    pace: NDArray[np.float64]


def travel_of(read: Read, count: int, config: CalibratingConfig, on_progress: Callable[[int, int], None]) -> Travel:
    """Look through a recording of `count` frames; of a long one, at stretches spread over it."""
    stretches = 1 if count <= config.frames_read else config.stretches
    length = min(count, config.frames_read // stretches)
    starts = np.linspace(0, count - length, stretches).astype(int)
    numbers = np.unique((starts[:, None] + np.arange(length)).ravel())
    rows: list[tuple[int, float]] = []
    before, travelled, last = None, 0.0, -1
    for done, number in enumerate(numbers, start=1):
        frame = read(int(number))
        on_progress(done, len(numbers))
        if frame is None:
            continue
        small = small_picture(frame)
        if before is not None:
            is_next = number - last <= config.gap_frames
            travelled += _motion(before, small, config.far_apart) if is_next else config.far_apart
        rows.append((int(number), travelled))
        before, last = small, int(number)
    table = np.array(rows, np.float64).reshape(-1, 2)
    steps = np.diff(table[:, 1], prepend=np.inf, append=np.inf)
    pace = np.minimum(np.maximum(steps[:-1], steps[1:]), config.far_apart)
    return Travel(table[:, 0].astype(np.int64), table[:, 1], pace)


def _motion(before: NDArray[np.uint8], picture: NDArray[np.uint8], at_most: float) -> float:
    """Median motion of the corners of a picture of half the size, in pixels of the whole one."""
    corners = corners_of(before, _CORNERS)
    if len(corners) < _FEWEST:
        return 0.0
    ends, is_found = followed(before, picture, corners)
    if is_found.sum() < _FEWEST:
        return at_most
    return min(float(2.0 * np.median(np.linalg.norm((ends - corners)[is_found, 0], axis=1))), at_most)


def chosen(travel: Travel, config: CalibratingConfig) -> NDArray[np.int64]:
    """Numbers of the frames to use: of every step that the picture moved, the calmest.

    A long way has longer steps, until neighbours would hardly overlap; then runs of steps are used, spread over it.
    """
    if not len(travel.frames):
        return np.empty(0, np.int64)
    step = float(np.clip(travel.travelled[-1] / config.views, config.near_apart, config.far_apart))
    bins = (travel.travelled / step).astype(np.int64)
    used = np.unique(bins)
    if len(used) > config.views:
        runs = max(config.views // _RUN, 1)
        starts = np.linspace(0, len(used) - _RUN, runs).astype(int)
        used = used[np.unique((starts[:, None] + np.arange(_RUN)).ravel())]
    order = np.lexsort((travel.pace, bins))
    bests = order[np.unique(bins[order], return_index=True)[1]]
    return travel.frames[np.sort(bests[np.isin(bins[bests], used)])]


def views_of(read: Read, frames: NDArray[np.int64], camera: PinholeCamera, config: CalibratingConfig) -> list[View]:
    """The keypoints of chosen frames, at raw pixels: of the camera only the size of its images is used."""
    plain = PinholeCamera(camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy)
    extractor = FeatureExtractor(plain, FeatureConfig(count=config.keypoints))
    views = []
    for number in frames:
        frame = read(int(number))
        if frame is None:
            continue
        features = extractor.extract(frame)
        neighbour = read(int(number) + 1) or read(max(int(number) - 1, 0))
        velocity = np.zeros((features.rows, 2)) if neighbour is None else _velocity(frame, neighbour, features.pixels)
        below = (features.pixels[:, 1:].astype(np.float64) + 0.5) / camera.height - 0.5
        views.append(View(frame.timestamp, features, below * velocity))
    return views


def _velocity(frame: RgbdFrame, neighbour: RgbdFrame, pixels: NDArray[np.float32]) -> NDArray[np.float64]:
    """How fast the picture moves at pixels (n, 2), pixels a second, (n, 2): an affine field through its corners."""
    seconds = neighbour.timestamp - frame.timestamp
    small = small_picture(frame)
    corners = corners_of(small, _CORNERS)
    field = np.zeros((3, 2))
    if len(corners) >= _FEWEST and seconds != 0:
        ends, is_found = followed(small, small_picture(neighbour), corners)
        places, moved = 2.0 * corners[is_found, 0], 2.0 * (ends - corners)[is_found, 0]
        weights = np.ones(len(places))
        for _ in range(_FIELD_ROUNDS if len(places) >= _FEWEST else 0):
            at = np.column_stack([places, np.ones(len(places))]) * weights[:, None]
            field, *_ = np.linalg.lstsq(at, moved * weights[:, None])
            off = np.linalg.norm(moved - np.column_stack([places, np.ones(len(places))]) @ field, axis=1)
            weights = 1.0 / (1.0 + (off / _FIELD_PIXELS) ** 2)
        field = field / seconds
    return np.asarray(np.column_stack([pixels, np.ones(len(pixels))]) @ field)
