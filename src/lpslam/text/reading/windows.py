"""Which part of an image is searched between two whole searches: where what is not settled was seen a moment ago."""

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import TextConfig
from lpslam.text.reading.boxes import Boxes, letter_heights
from lpslam.text.reading.spotting import TextSpotter
from lpslam.text.types import Placement, Shot

Window = tuple[slice, slice]
"""Rows and columns of an image."""

WHOLE: Window = (slice(0, None), slice(0, None))

# Sides of a window, pixels: the network halves its input five times, and the engine prepares itself for every shape.
_STEP = 160
# Pixels, and letter heights, around a text that belong to its window: what comes into view of it, and strayed poses.
_MARGIN, _MARGIN_SHARE = 32.0, 1.0
# A box nearer than this, pixels, to an edge of the window that is none of the image may be a piece.
_RIM = 16.0
# Texts that are remembered: what half a second shows of some boards.
_CAPACITY = 64


class Windows:
    """Texts that were read too few times, and where they are in the next images.

    Attributes:
        searched: images, parts of them counted as such.
    """

    def __init__(self, camera: PinholeCamera, config: TextConfig) -> None:
        self.searched = 0.0
        self._camera = camera
        self._config = config
        self._last_whole = -np.inf
        self._open: deque[tuple[float, NDArray[np.float64]]] = deque(maxlen=_CAPACITY)

    def hold(self, shot: Shot, box: NDArray[np.float64], placement: Placement | None) -> None:
        """Note a text that another reading would tell more of: its (4, 2) box; without a place it is held to be far."""
        if shot.world_from_keyframe is None:
            return
        depth = self._config.placement.max_depth
        if placement is not None:
            depth = float(np.linalg.norm(np.array(placement.position) - shot.keyframe_from_camera[:3, 3]))
        grown = box + (_MARGIN + _MARGIN_SHARE * letter_heights(box[None])) * np.sign(box - box.mean(axis=0))
        corners = self._camera.back_project(self._camera.undistort(grown), np.full(4, depth))
        world = transform_points(shot.world_from_camera, corners)
        self._open.append((shot.frame.timestamp, world))

    def next(self, shot: Shot, expected: Callable[[], Boxes]) -> Window | None:
        """What to search of an image: all of it at the set interval, and where most of it is to be searched.

        Else the part where the texts are that were noted a moment ago, and the (n, 4, 2) boxes that are expected;
        without any noted text in view nothing (None).
        """
        timestamp, share = shot.frame.timestamp, 1.0
        # Frames need not come in their order; half a millisecond of grace, since timestamps are rounded.
        is_between = abs(timestamp - self._last_whole) < self._config.reading.interval - 5e-4
        window = WHOLE
        if is_between and shot.world_from_keyframe is not None:
            around = self._around(timestamp, inverse_transform(shot.world_from_camera), expected)
            if around is None:
                return None
            sides = [side.stop - side.start for side in around]
            window, share = around, self._pixels(*sides) / self._pixels(self._camera.width, self._camera.height)
        if share > self._config.reading.window_share:
            window, share, self._last_whole = WHOLE, 1.0, timestamp
        self.searched += share
        return window

    def _pixels(self, width: int, height: int) -> float:
        """Pixels that the detector sees of an image: larger ones are shrunk first."""
        return width * height * min(1.0, self._config.spotting.detection_side / max(width, height)) ** 2

    def _around(
        self, timestamp: float, camera_from_world: NDArray[np.float64], expected: Callable[[], Boxes]
    ) -> Window | None:
        seen, size = [], np.array([self._camera.width, self._camera.height])
        for noted, corners in self._open:
            corners = transform_points(camera_from_world, corners)
            if abs(timestamp - noted) <= self._config.reading.new_text_patience and corners[:, 2].min() > 0.0:
                box = self._camera.distort(self._camera.project(corners))
                if (box.max(axis=0) > 0.0).all() and (box.min(axis=0) < size).all():
                    seen.append(box)
        if not seen:
            return None
        points = np.concatenate([*seen, *expected()])
        low, high = np.clip([points.min(axis=0), points.max(axis=0)], 0.0, size)
        sides = np.minimum(np.ceil((high - low) / _STEP) * _STEP, size).astype(int)
        left, top = np.clip((low + high - sides) // 2.0, 0.0, size - sides).astype(int).tolist()
        return slice(top, top + int(sides[1])), slice(left, left + int(sides[0]))


def boxes_within(spotter: TextSpotter, rgb: NDArray[np.uint8], window: Window) -> Boxes:
    """Boxes (n, 4, 2) that a spotter finds in a window of an image, but for those that the window may have cut."""
    part = rgb[window]
    boxes, _ = spotter.detect(part)
    start, size = np.array([window[1].start, window[0].start]), np.array(part.shape[1::-1])
    cut = (boxes.min(axis=1) < _RIM) & (start > 0)
    cut |= (boxes.max(axis=1) > size - 1 - _RIM) & (start + size < rgb.shape[1::-1])
    return np.asarray(boxes[~cut.any(axis=1)] + start, np.float64)
