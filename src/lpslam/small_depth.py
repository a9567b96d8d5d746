"""Depth in a small picture without lens distortion: where its pixels lie in a camera's, and what is read there."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera


class SmallDepth:
    """Reads a camera's depth images as small ones without lens distortion.

    Args:
        camera: of the images.
        width: pixels across the small ones.

    Attributes:
        size: width and height of the small images.
        shrink: (2,) raw pixels to one of them, across and down.
        intrinsics: (fx, fy, cx, cy) of them.
        raw: (h · w, 2) raw pixels at which their pixels lie, row by row.
    """

    def __init__(self, camera: PinholeCamera, width: int) -> None:
        self.size = (width, max(round(width * camera.height / camera.width), 2))
        self.shrink = shrink = np.array([camera.width / self.size[0], camera.height / self.size[1]])
        focal, centre = np.array([camera.fx, camera.fy]), np.array([camera.cx, camera.cy])
        self.intrinsics: NDArray[np.float64] = np.concatenate([focal / shrink, (centre + 0.5) / shrink - 0.5])
        rows, columns = np.mgrid[: self.size[1], : self.size[0]]
        self.raw = camera.distort((np.column_stack([columns.ravel(), rows.ravel()]) + 0.5) * shrink - 0.5)
        # Nine readings a pixel, of which the median has few holes and a third of the noise.
        across, down = np.meshgrid(*(np.array([-1, 0, 1]) * step / 3 for step in shrink))
        around = np.column_stack([across.ravel(), down.ravel()])[:, None]
        pixels = np.rint(self.raw + around).astype(np.int64).reshape(len(around), *self.size[::-1], 2)
        is_seen = ((pixels >= 0) & (pixels < [camera.width, camera.height])).all(axis=3)
        at = np.where(is_seen, pixels[..., 1] * camera.width + pixels[..., 0], -1)
        self._at = np.ascontiguousarray(at.transpose(1, 0, 2), np.int32)

    def read(self, depth: NDArray[np.float32], farthest: float = np.inf) -> NDArray[np.float32]:
        """(h, w) the median of the readings about each pixel, 0 where most are missing.

        Args:
            depth: (height, width) metres.
            farthest: metres from which a reading is none.
        """
        small = np.empty(self.size[::-1], np.float32)
        _read(np.ascontiguousarray(depth, np.float32).ravel(), self._at, farthest, small)
        return small


_EXCHANGES = np.array(
    [
        (0, 3), (1, 7), (2, 5), (4, 8), (0, 7), (2, 4), (3, 8), (5, 6), (0, 2), (1, 3), (4, 5), (7, 8), (1, 4),
        (3, 6), (5, 7), (0, 1), (2, 4), (3, 5), (6, 8), (2, 3), (4, 5), (6, 7), (1, 2), (3, 4), (5, 6),
    ]
)  # fmt: skip
"""Pairs that are put into order, one after the other, to sort nine numbers: the same for all, so a row goes at once."""


@njit(cache=True, nogil=True)
def _read(depth: NDArray[np.float32], at: NDArray[np.int32], farthest: float, small: NDArray[np.float32]) -> None:
    """Write the median of nine readings about each small pixel, the upper of two; 0 where most are missing.

    Args:
        depth: (n,) metres, row by row.
        at: (h, 9, w) which readings; -1 for none.
        farthest: metres from which a reading is none.
        small: (h, w) overwritten.
    """
    height, around, width = at.shape
    readings, valid = np.empty((around, width), np.float32), np.empty(width, np.int64)
    none = np.float32(0.0)
    for row in range(height):
        valid[:] = 0
        for k in range(around):
            line, these = readings[k], at[row, k]
            for column in range(width):
                place = these[column]
                reading = depth[max(place, 0)]
                is_one = (place >= 0) & (reading > none) & (reading < farthest)
                line[column] = reading if is_one else none
                valid[column] += is_one
        for i, j in _EXCHANGES:
            low, high = readings[i], readings[j]
            for column in range(width):
                a, b = low[column], high[column]
                low[column], high[column] = min(a, b), max(a, b)
        for column in range(width):
            count = valid[column]
            small[row, column] = readings[around - (count + 1) // 2, column] if count > around // 2 else none
