import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import FeatureConfig
from lpslam.frames import RgbdFrame
from lpslam.simulation.source import MallSource
from lpslam.slam import features
from lpslam.slam.kernels import image


def test_every_test_point_stays_within_the_border_when_turned() -> None:
    pairs = features._test_pairs()
    assert pairs.shape == (512, 2)
    assert np.hypot(*pairs.T).max() <= image.BORDER - 3.5
    assert not (pairs[::2] == pairs[1::2]).all(axis=1).any()
    assert len(np.unique(pairs.reshape(256, 4), axis=0)) == 256


def described(rgb: NDArray[np.uint8]) -> features.Features:
    camera = PinholeCamera(width=640, height=480, fx=560.0, fy=560.0, cx=320.0, cy=240.0)
    extractor = features.FeatureExtractor(camera, FeatureConfig())
    return extractor.extract(RgbdFrame(0, 0.0, rgb, np.zeros((480, 640), np.float32)))


def test_other_corners_look_different_and_the_same_ones_alike_after_a_turn() -> None:
    picture = MallSource(950).frame(100).rgb
    turn = cv2.getRotationMatrix2D((320, 240), 25, 1.0)
    one, other = described(picture), described(np.asarray(cv2.warpAffine(picture, turn, (640, 480)), np.uint8))
    bits = np.bitwise_count(one.descriptor[:, None] ^ other.descriptor[None]).sum(axis=2)
    moved = one.pixels @ turn[:, :2].T + turn[:, 2]
    apart = np.linalg.norm(moved[:, None] - other.pixels[None], axis=2)
    same_level = one.octave[:, None] == other.octave[None]
    same = bits[(apart < 1.5) & same_level]
    different = bits[(apart > 20) & same_level]
    assert len(same) > 200
    assert np.mean(same <= 50) > 0.7
    assert np.mean(different <= 50) < 0.01  # of random pairs, 0.05
    assert 110 < np.median(different) < 132  # of 256 independent bits, 128
