"""Which part of an image is searched between two whole searches: where what is not settled was seen a moment ago."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import TextConfig
from lpslam.text.reading.boxes import Boxes, letter_heights
from lpslam.text.reading.spotting import TextSpotter
from lpslam.text.types import Placement, Shot

Window = tuple[slice, slice]
"""Rows and columns of an image."""

# Sides of a window, pixels: the network halves its input five times, and the engine prepares itself for every shape.
_STEP = 160
# Pixels, and letter heights, around a text that belong to its window: what comes into view of it, and strayed poses.
_MARGIN, _MARGIN_SHARE = 32.0, 1.0
# A box nearer than this, pixels, to an edge of the window that is none of the image may be a piece.
_RIM = 16.0
# Texts that are remembered: what half a second shows of some boards.
_CAPACITY = 64


class Windows:
    """Texts that were read too few times, and where they are in the next images."""

    def __init__(self, camera: PinholeCamera, config: TextConfig) -> None:
        self._camera = camera
        self._config = config
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
        world = transform_points(shot.world_from_keyframe @ shot.keyframe_from_camera, corners)
        self._open.append((shot.frame.timestamp, world))

    def window(self, shot: Shot, expected: Boxes) -> Window | None:
        """The part of an image where what was seen a moment ago stands, and (n, 4, 2) expected boxes; None without.

        The frame's place in the world must be known.
        """
        assert shot.world_from_keyframe is not None
        patience, seen = self._config.reading.new_text_patience, list(expected)
        camera_from_world = inverse_transform(shot.world_from_keyframe @ shot.keyframe_from_camera)
        size, is_any = np.array([self._camera.width, self._camera.height]), False
        for timestamp, corners in self._open:
            corners = transform_points(camera_from_world, corners)
            if abs(shot.frame.timestamp - timestamp) > patience or corners[:, 2].min() <= 0.0:
                continue
            box = self._camera.distort(self._camera.project(corners))
            if (box.max(axis=0) > 0.0).all() and (box.min(axis=0) < size).all():
                seen.append(box)
                is_any = True
        if not is_any:
            return None
        points = np.concatenate(seen)
        low, high = np.clip([points.min(axis=0), points.max(axis=0)], 0.0, size)
        sides = np.minimum(np.ceil((high - low) / _STEP) * _STEP, size)
        start = np.clip((low + high - sides) // 2.0, 0.0, size - sides).astype(int)
        (left, top), (right, bottom) = start.tolist(), (start + sides.astype(int)).tolist()
        return slice(top, bottom), slice(left, right)

    def share(self, window: Window) -> float:
        """Share of the image that a window is."""
        rows, columns = window
        pixels = int((rows.stop - rows.start) * (columns.stop - columns.start))
        return pixels / (self._camera.width * self._camera.height)


def boxes_within(spotter: TextSpotter, rgb: NDArray[np.uint8], window: Window | None) -> Boxes:
    """Boxes (n, 4, 2) that a spotter finds in a window of an image, but for those that the window may have cut."""
    if window is None:
        return spotter.detect(rgb)[0]
    part = rgb[window]
    boxes, _ = spotter.detect(part)
    start, size = np.array([window[1].start, window[0].start]), np.array(part.shape[1::-1])
    inner_low, inner_high = start > 0, start + size < rgb.shape[1::-1]
    cut = (boxes.min(axis=1) < _RIM) & inner_low | (boxes.max(axis=1) > size - 1 - _RIM) & inner_high
    return np.asarray(boxes[~cut.any(axis=1)] + start, np.float64)
