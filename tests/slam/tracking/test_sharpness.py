"""How sharp and bright frames are."""

import numpy as np

from lpslam.frames import RgbdFrame
from lpslam.slam.tracking.sharpness import UsualSharpness


def frame(rgb: np.ndarray) -> RgbdFrame:
    return RgbdFrame(0, 0.0, rgb.astype(np.uint8), np.zeros(rgb.shape[:2], np.float32))


def test_a_dark_frame_is_called_dark_and_a_blurred_one_blurred() -> None:
    texture = np.random.default_rng(0).integers(60, 250, (120, 160, 3))
    usual = UsualSharpness()
    usual.begin(frame(texture))
    assert usual.fault(frame(texture * 0.4)).startswith("dark or blurred (sharpness 1")
    assert usual.fault(frame(np.full_like(texture, texture.mean()))).startswith("blurred (sharpness 0%")
