"""Depth in a small picture without lens distortion: where its pixels lie in a camera's, and what is read there."""

import numpy as np
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
        self._is_seen = ((pixels >= 0) & (pixels < [camera.width, camera.height])).all(axis=3)
        self._at = np.clip(pixels[..., 1], 0, camera.height - 1), np.clip(pixels[..., 0], 0, camera.width - 1)

    def read(self, depth: NDArray[np.float32], farthest: float = np.inf) -> NDArray[np.float32]:
        """(h, w) the median of the readings about each pixel, 0 where most are missing.

        Args:
            depth: (height, width) metres.
            farthest: metres from which a reading is none.
        """
        readings = depth[self._at]
        readings = np.sort(np.where(self._is_seen & (readings > 0) & (readings < farthest), readings, 0.0), axis=0)
        valid = np.count_nonzero(readings, axis=0)
        middle = np.take_along_axis(readings, (len(readings) - (valid + 1) // 2)[None].clip(max=8), axis=0)[0]
        return np.where(valid > len(readings) // 2, middle, 0.0).astype(np.float32)
