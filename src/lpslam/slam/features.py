"""ORB features spread over the image, each with a virtual right coordinate from depth (ORB-SLAM2, III-A)."""

from functools import lru_cache
from importlib.resources import files
from typing import NamedTuple, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import FeatureConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.kernels import image as kernels

_STEERING_BINS = 60


class Features(NamedTuple):
    """The keypoints of one image, by columns; n rows.

    Attributes:
        pixels: (n, 2) float32, undistorted u, v at full resolution.
        u_right: (n,) float32, u − b·fx / depth; meaningless where `has_depth` is False.
        depth: (n,) float32 metres; 0 where `has_depth` is False.
        has_depth: (n,) bool.
        octave: (n,) uint8, pyramid level.
        angle: (n,) float32, radians.
        descriptor: (n, 4) uint64, 256 bits.
    """

    pixels: NDArray[np.float32]
    u_right: NDArray[np.float32]
    depth: NDArray[np.float32]
    has_depth: NDArray[np.bool_]
    octave: NDArray[np.uint8]
    angle: NDArray[np.float32]
    descriptor: NDArray[np.uint64]

    @property
    def rows(self) -> int:
        """Number of keypoints."""
        return len(self.octave)


class FeatureExtractor:
    """Detects and describes the keypoints of RGB-D images of one camera."""

    def __init__(self, camera: PinholeCamera, config: FeatureConfig) -> None:
        self.camera = camera
        self.config = config
        self.scales = config.scale_factor ** np.arange(config.levels)
        self._sizes = [(max(round(camera.width / s), 1), max(round(camera.height / s), 1)) for s in self.scales]
        self._quotas = _level_quotas(config)
        self._steered = [_steered_offsets(width) for width, _ in self._sizes]

    @property
    def capacity(self) -> int:
        """The most keypoints that a frame can have."""
        return int(self._quotas.sum())

    def extract(self, frame: RgbdFrame, gray: NDArray[np.uint8] | None = None) -> Features:
        """Keypoints of a frame, coarse levels last; `gray` are its grey values (h, w) where they are known."""
        corners, octaves, angles, descriptors = [], [], [], []
        level_image = gray_of(frame.rgb) if gray is None else gray
        for level, size in enumerate(self._sizes):
            if level > 0:
                level_image = as_gray(cv2.resize(level_image, size, interpolation=cv2.INTER_LINEAR))
            corner = self._detect(level_image, int(self._quotas[level]))
            if not len(corner):
                continue
            angle = kernels.orientations(level_image, corner)
            descriptor = np.empty((len(corner), 4), np.uint64)
            blurred = as_gray(cv2.blur(level_image, (5, 5)))
            kernels.describe(blurred, corner, angle, self._steered[level], descriptor)
            # Each level was rounded to whole pixels: scale by its true size, corner to corner of the pixel grid.
            scale = np.array([self.camera.width / size[0], self.camera.height / size[1]], np.float32)
            corners.append((corner.astype(np.float32) + 0.5) * scale - 0.5)
            octaves.append(np.full(len(corner), level, np.uint8))
            angles.append(angle)
            descriptors.append(descriptor)
        if not corners:
            return _no_features()
        return self._with_depth(
            np.concatenate(corners),
            frame.depth,
            np.concatenate(octaves),
            np.concatenate(angles),
            np.concatenate(descriptors),
        )

    def _detect(self, image: NDArray[np.uint8], quota: int) -> NDArray[np.int32]:
        high, low = self.config.fast_threshold, self.config.fast_threshold_in_empty_cell
        return kernels.detect_corners(
            image,
            as_gray(cv2.add(image, high)),  # type: ignore[call-overload]
            as_gray(cv2.subtract(image, high)),  # type: ignore[call-overload]
            as_gray(cv2.add(image, low)),  # type: ignore[call-overload]
            as_gray(cv2.subtract(image, low)),  # type: ignore[call-overload]
            high,
            low,
            self.config.cell_pixels,
            quota,
        )

    def moved(
        self, features: Features, rows: NDArray[np.int64], raw: NDArray[np.float32], depth: NDArray[np.float32]
    ) -> Features:
        """Some keypoints (rows) of an earlier image, seen at raw pixels (n, 2) of another one with its depth."""
        return self._with_depth(raw, depth, features.octave[rows], features.angle[rows], features.descriptor[rows])

    def _with_depth(
        self,
        raw: NDArray[np.float32],
        depth_image: NDArray[np.float32],
        octave: NDArray[np.uint8],
        angle: NDArray[np.float32],
        descriptor: NDArray[np.uint64],
    ) -> Features:
        config = self.config
        depth = kernels.sample_depth(
            depth_image, raw, config.depth_edge_radius, config.depth_edge_tolerance, config.min_depth, config.max_depth
        )
        has_depth = depth > 0
        pixels = self.camera.undistort(raw.astype(np.float64)).astype(np.float32) if self.camera.is_distorted else raw
        disparity = np.zeros(len(depth), np.float32)
        np.divide(self.camera.fx * config.virtual_baseline, depth, out=disparity, where=has_depth, casting="unsafe")
        return Features(pixels, pixels[:, 0] - disparity, depth, has_depth, octave, angle, descriptor)


def _no_features() -> Features:
    column = np.empty(0, np.float32)
    return Features(
        np.empty((0, 2), np.float32),
        column,
        column,
        np.empty(0, np.bool_),
        np.empty(0, np.uint8),
        column,
        np.empty((0, 4), np.uint64),
    )


def gray_of(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """(h, w) grey values of an RGB image (h, w, 3)."""
    return as_gray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY))


def as_gray(image: object) -> NDArray[np.uint8]:
    """Narrow what OpenCV returns to the array type that it is."""
    return cast("NDArray[np.uint8]", image)


def _level_quotas(config: FeatureConfig) -> NDArray[np.int64]:
    """How many keypoints each level may have: falling by the scale factor, since a level's area falls by its square."""
    share = config.scale_factor ** -np.arange(config.levels, dtype=float)
    quotas: NDArray[np.int64] = np.round(config.count * share / share.sum()).astype(np.int64)
    return quotas


@lru_cache(maxsize=1)
def _test_pairs() -> NDArray[np.float64]:
    """The 256 test pairs, (512, 2) x, y in pixels from the corner; `tools/train_vocabulary.py` learned them.

    Learned as ORB's are (Rublee et al. 2011, 4.3). Random pairs depend on each other: at the distance that lets four of
    five true matches pass, they let five to seven times as many wrong ones pass.
    """
    with (files("lpslam.slam") / "assets" / "test_pairs.npy").open("rb") as stream:
        return np.asarray(np.load(stream), np.float64)


@lru_cache(maxsize=32)
def _steered_offsets(width: int) -> NDArray[np.int64]:
    """Offsets into a flattened image of the given width of every test point, for each steering direction."""
    angles = np.arange(_STEERING_BINS) * (2 * np.pi / _STEERING_BINS)
    x, y = _test_pairs().T
    columns = np.rint(np.cos(angles)[:, None] * x - np.sin(angles)[:, None] * y)
    rows = np.rint(np.sin(angles)[:, None] * x + np.cos(angles)[:, None] * y)
    return np.ascontiguousarray((rows * width + columns).astype(np.int64))
