"""What stands at a spot of a picture, whether or not a corner was found there."""

import numpy as np
import pytest
from test_image_kernels import CAMERA, texture

from lpslam.config import FeatureConfig
from lpslam.slam.features import FeatureExtractor, smoothed
from lpslam.slam.kernels import image as kernels
from lpslam.slam.kernels.looking import NOWHERE

HERE = np.zeros((1, 2), np.int32)


@pytest.fixture(scope="module")
def extractor() -> FeatureExtractor:
    return FeatureExtractor(CAMERA, FeatureConfig())


def described(picture: np.ndarray, spots: np.ndarray, extractor: FeatureExtractor) -> np.ndarray:
    """Descriptors at pixels of the finest level."""
    corners = spots.astype(np.int32)
    descriptors = np.empty((len(corners), 4), np.uint64)
    angles = kernels.orientations(picture, corners)
    kernels.describe(smoothed(picture), corners, angles, extractor._steered[0], descriptors)
    return descriptors


def test_what_was_described_at_a_spot_is_found_there_and_not_beside_it(extractor: FeatureExtractor) -> None:
    picture, random = texture(1), np.random.default_rng(2)
    spots = random.integers(60, [580, 420], (50, 2)).astype(np.float32)
    descriptors, levels = described(picture, spots, extractor), np.zeros(50, np.int32)
    steps = np.array([(0, 0), (24, 0), (0, -24)], np.int32)
    bits = extractor.unlikeness(picture, spots, levels, descriptors, steps, 0)
    assert (bits[:, 0] == 0).all()
    assert np.median(bits[:, 1:]) > 60


@pytest.mark.parametrize(("radius", "is_found"), [(2, True), (1, False)])
def test_it_may_stand_as_far_off_as_it_is_looked_for(extractor: FeatureExtractor, radius: int, is_found: bool) -> None:
    picture, spot = texture(3), np.array([[300.0, 200.0]], np.float32)
    descriptors = described(picture, spot, extractor)
    beside = spot + np.array([[2.0, -2.0]], np.float32)
    bits = extractor.unlikeness(picture, beside, np.zeros(1, np.int32), descriptors, HERE, radius)
    assert (bits[0, 0] == 0) == is_found


def test_it_is_looked_for_on_its_level(extractor: FeatureExtractor) -> None:
    picture = texture(4)
    level = 3
    image = extractor._levels(picture)[level]
    corner = np.array([[120, 100]], np.int32)
    descriptors = np.empty((1, 4), np.uint64)
    kernels.describe(
        smoothed(image), corner, kernels.orientations(image, corner), extractor._steered[level], descriptors
    )
    scale = np.array([CAMERA.width / image.shape[1], CAMERA.height / image.shape[0]])
    pixels = ((corner + 0.5) * scale - 0.5).astype(np.float32)
    assert extractor.unlikeness(picture, pixels, np.array([level], np.int32), descriptors, HERE, 0)[0, 0] == 0


def test_beyond_the_border_there_is_nothing(extractor: FeatureExtractor) -> None:
    picture = texture(5)
    outside = np.array([[2.0, 200.0], [637.0, 200.0], [300.0, -50.0], [300.0, 1e6]], np.float32)
    bits = extractor.unlikeness(picture, outside, np.zeros(4, np.int32), np.zeros((4, 4), np.uint64), HERE, 2)
    assert (bits == NOWHERE).all()
