"""Frames as another camera in the same place would have taken them: for a map that another camera made."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.frames import FrameSource, PassedOn, RgbdFrame


class SeenBy(PassedOn):
    """A `FrameSource` whose frames are resampled to the pixels of another camera; poses are the same for both.

    Where the source's camera does not look there is no depth, and colour goes on as it is at the border, blurred, so
    that no corner is found there.

    Args:
        source: where the frames come from.
        camera: whose size, focal length, principal point and lens they get.
    """

    def __init__(self, source: FrameSource, camera: PinholeCamera) -> None:
        super().__init__(source)
        self._camera = replace(camera, depth_scale=source.camera.depth_scale, fps=source.camera.fps)

    @property
    def camera(self) -> PinholeCamera:
        """The calibration of the frames as they come out."""
        return self._camera

    @property
    def share(self) -> float:
        """Share of the other camera's picture that the source shows."""
        return float(self._is_seen.mean())

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield the source's frames, resampled."""
        for frame in self.source:
            yield replace(frame, rgb=self._colour(frame.rgb), depth=self._depth(frame.depth))

    @cached_property
    def _pixels(self) -> NDArray[np.float32]:
        """(h, w, 2) where the source shows what each pixel of the other camera looks at; NaN where it does not look."""
        theirs, ours = self._camera, self.source.camera
        u, v = np.meshgrid(np.arange(theirs.width, dtype=float), np.arange(theirs.height, dtype=float))
        rays = theirs.back_project(theirs.undistort(np.column_stack([u.ravel(), v.ravel()])), np.ones(u.size))
        ideal = ours.project(rays)
        pixels = ours.distort(ideal)
        # Beyond the view for which a lens was fitted its polynomial folds back into the picture.
        size = np.array([ours.width, ours.height])
        inside = np.asarray(((pixels > -0.5) & (pixels < size - 0.5)).all(axis=1))
        inside[inside] = np.linalg.norm(ours.undistort(pixels[inside]) - ideal[inside], axis=1) < _FOLDED_PIXELS
        pixels[~inside] = np.nan
        return pixels.reshape(theirs.height, theirs.width, 2).astype(np.float32)

    @cached_property
    def _is_seen(self) -> NDArray[np.bool_]:
        return np.isfinite(self._pixels[..., 0])

    @cached_property
    def _nearest(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row and column (h, w) of the source's pixel that is nearest to what each looks at."""
        import cv2

        at = np.where(self._is_seen[..., None], self._pixels, 0.0)
        _, labels = cv2.distanceTransformWithLabels(
            (~self._is_seen).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE, labelType=cv2.DIST_LABEL_PIXEL
        )
        of_label = np.zeros((labels.max() + 1, 2), np.float32)
        of_label[labels[self._is_seen]] = at[self._is_seen]
        column, row = np.rint(of_label[labels]).astype(np.intp).transpose(2, 0, 1)
        return np.clip(row, 0, self.source.camera.height - 1), np.clip(column, 0, self.source.camera.width - 1)

    def _depth(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """Metres along the axis are the same for both; between two surfaces there is none, so the nearest counts."""
        return np.where(self._is_seen, depth[self._nearest], np.float32(0.0))

    def _colour(self, rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        import cv2

        shrink = min(self._camera.fx / self.source.camera.fx, 1.0)
        # Finer than what it is resampled to, a picture would shimmer.
        small = rgb if shrink > _ALIKE else cv2.resize(rgb, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
        scale = np.array([small.shape[1] / rgb.shape[1], small.shape[0] / rgb.shape[0]], np.float32)
        at = (self._pixels + 0.5) * scale - 0.5
        across, down = np.nan_to_num(at).transpose(2, 0, 1)
        seen = cv2.remap(small, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        if self._is_seen.all():
            return np.asarray(seen, np.uint8)
        beyond = cv2.blur(np.where(self._is_seen[..., None], seen, rgb[self._nearest]), (_SMOOTH, _SMOOTH))
        return np.where(self._is_seen[..., None], seen, beyond).astype(np.uint8)


_FOLDED_PIXELS = 1.0
"""Pixels by which a lens undone must lead back to where it began."""

_ALIKE = 0.8
"""Ratio of focal lengths from which on a picture is not made smaller before it is resampled."""

_SMOOTH = 31
"""Pixels over which colour is blurred where nothing is seen: as wide as what a keypoint looks at."""
