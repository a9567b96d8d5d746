"""ORB features spread over the image, each with a virtual right coordinate from depth (ORB-SLAM2, III-A)."""

import math
from collections.abc import Sequence
from concurrent.futures import Executor
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
from lpslam.slam.kernels.looking import NOWHERE, least_distances
from lpslam.slam.kernels.settling import settle

_STEERING_BINS = 60

# Side in pixels of the squares over which a level is averaged: as many times its noise is less.
_SMOOTHED = 5

# Levels that stay when another thread takes the rest: with six pixels in five to a level, about half of all pixels.
_HERE = (0, 2)

_LevelKeypoints = tuple[NDArray[np.float32], NDArray[np.uint8], NDArray[np.float32], NDArray[np.uint64]]


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
    """Detects and describes the keypoints of RGB-D images of one camera.

    Args:
        camera: of the images.
        config: how many keypoints, on which pyramid.
        beside: takes about half of every image's work, for those who wait for the result; which does not change by it.
    """

    def __init__(self, camera: PinholeCamera, config: FeatureConfig, beside: Executor | None = None) -> None:
        self.camera = camera
        self.config = config
        self.scales = config.scale_factor ** np.arange(config.levels)
        self._sizes = [(max(round(camera.width / s), 1), max(round(camera.height / s), 1)) for s in self.scales]
        self._quotas = _level_quotas(config)
        self._steered = [_steered_offsets(width) for width, _ in self._sizes]
        self._beside = beside

    @property
    def capacity(self) -> int:
        """The most keypoints that a frame can have."""
        return int(self._quotas.sum())

    def extract(self, frame: RgbdFrame, gray: NDArray[np.uint8] | None = None) -> Features:
        """Keypoints of a frame, coarse levels last; `gray` are its grey values (h, w) where they are known."""
        images = self._levels(gray_of(frame.rgb) if gray is None else gray)
        found = [keypoints for keypoints in self._of_levels(images) if len(keypoints[0])]
        if not found:
            return no_features()
        raw, octave, angle, descriptor = (np.concatenate(column) for column in zip(*found, strict=True))
        return self._with_depth(raw, frame.depth, octave, angle, descriptor)

    def _levels(self, gray: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
        """Grey values (h, w) on every level, the finest first."""
        images = [gray]
        for size in self._sizes[1:]:
            images.append(as_gray(cv2.resize(images[-1], size, interpolation=cv2.INTER_LINEAR)))
        return images

    def unlikeness(
        self,
        gray: NDArray[np.uint8],
        pixels: NDArray[np.float32],
        octave: NDArray[np.int32],
        descriptor: NDArray[np.uint64],
        steps: NDArray[np.int32],
        radius: int,
    ) -> NDArray[np.int32]:
        """By how many bits descriptors differ from what an image shows at given pixels and a few steps beside them.

        Args:
            gray: (h, w) of the image.
            pixels: (n, 2) undistorted u, v at full resolution.
            octave: (n,) level on which each is looked at.
            descriptor: (n, 4) looked for.
            steps: (places, 2) pixels of the level.
            radius: pixels of the level around each place in which the likest counts.

        Returns:
            (n, places); more than any two descriptors differ where the place is too near to the border.
        """
        raw = self.camera.distort(pixels.astype(np.float64)) if self.camera.is_distorted else pixels
        least = np.full((len(pixels), len(steps)), NOWHERE, np.int32)
        for level, image in enumerate(self._levels(gray)):
            rows = np.flatnonzero(octave == level)
            if not len(rows):
                continue
            width, height = self._sizes[level]
            scale = np.array([width / self.camera.width, height / self.camera.height])
            spots = np.rint((raw[rows] + 0.5) * scale - 0.5).astype(np.int32)[:, None] + steps
            steered = self._steered[level]
            least[rows] = least_distances(image, smoothed(image), spots, radius, steered, descriptor[rows])
        return least

    def _of_levels(self, images: Sequence[NDArray[np.uint8]]) -> list[_LevelKeypoints]:
        """The keypoints of each level."""
        everything = range(len(images))
        if self._beside is None:
            return [self._of_level(images[level], level) for level in everything]
        here = [level for level in everything if level in _HERE]
        there = [level for level in everything if level not in _HERE]
        others = self._beside.submit(lambda: [self._of_level(images[level], level) for level in there])
        by_level = dict(zip(here, [self._of_level(images[level], level) for level in here], strict=True))
        by_level.update(zip(there, others.result(), strict=True))
        return [by_level[level] for level in everything]

    def _of_level(self, image: NDArray[np.uint8], level: int) -> _LevelKeypoints:
        """Raw pixels, octaves, angles and descriptors of the keypoints of one level (h, w)."""
        smooth = smoothed(image)
        corners, exact = self.corners(image, smooth, int(self._quotas[level]))
        angles = kernels.orientations(image, corners)
        descriptors = np.empty((len(corners), 4), np.uint64)
        kernels.describe(smooth, corners, angles, self._steered[level], descriptors)
        # Each level was rounded to whole pixels: scale by its true size, corner to corner of the pixel grid.
        width, height = self._sizes[level]
        scale = np.array([self.camera.width / width, self.camera.height / height], np.float32)
        return (exact + 0.5) * scale - 0.5, np.full(len(corners), level, np.uint8), angles, descriptors

    def corners(
        self, image: NDArray[np.uint8], smooth: NDArray[np.uint8], quota: int
    ) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Corners of a level (h, w) and of the same smoothed, at most `quota`: (n, 2) nearest pixels, and exact ones.

        They are looked for where they will be compared: one that smoothing takes away would not be found again.
        """
        config = self.config
        # What is no more than the picture's noise, of which smoothing leaves a fifth, is no corner.
        noise = math.ceil(config.noise_multiple * _noise(image) / _SMOOTHED)
        faintest = min(max(config.faintest_threshold, noise), config.fast_threshold)
        found = kernels.detect_corners(smooth, config.fast_threshold, faintest, config.cell_pixels, quota)
        if len(found) < config.sparse_share * quota:
            # In the dark contrasts are a few grey values.
            found = kernels.detect_corners(smooth, faintest, faintest, config.cell_pixels, quota)
        return settle(smooth, found, kernels.BORDER)

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


def smoothed(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A level (h, w) as corners are found in it and described."""
    return as_gray(cv2.blur(image, (_SMOOTHED, _SMOOTHED)))


def _noise(image: NDArray[np.uint8]) -> float:
    """Standard deviation of a picture's noise in grey values, at most: by second differences along every eighth row."""
    if image.shape[1] < 3:
        return 0.0
    rows = image[::8].astype(np.float32)
    bends = np.abs(rows[:, :-2] - 2.0 * rows[:, 1:-1] + rows[:, 2:])
    return float(bends.mean()) * math.sqrt(math.pi / 2.0) / math.sqrt(6.0)


def no_features() -> Features:
    """Not one keypoint."""
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
