import numpy as np

from lpslam.frames import RgbdFrame
from lpslam.text.reading.packing import PackedFrame


def test_a_packed_frame_takes_a_quarter_and_keeps_its_depth_and_its_colours() -> None:
    rng = np.random.default_rng(3)
    depth = np.round(2.0 + np.linspace(0.0, 1.0, 320)[None] + rng.normal(0.0, 0.003, (240, 320)), 3).astype(np.float32)
    depth[:20], depth[20, 0] = 0.0, np.nan
    # Strokes two pixels wide that differ from their ground in colour, hardly in brightness.
    rgb = np.tile(np.array([150, 60, 40], np.uint8), (240, 320, 1))
    rgb[100:140, 100:200:4] = rgb[100:140, 101:200:4] = 104, 84, 30
    frame = RgbdFrame(7, 1.25, rgb, depth)
    packed = PackedFrame.of(frame)
    back = packed.unpacked()
    assert packed.nbytes < (rgb.nbytes + depth.nbytes) / 4
    assert (back.index, back.timestamp) == (7, 1.25)
    assert back.depth.dtype == np.float32
    np.testing.assert_array_equal(back.depth, depth)
    assert np.abs(back.rgb.astype(int) - rgb).max() <= 24
    assert np.abs(back.rgb.astype(int) - rgb).mean() <= 1.5


def test_depth_that_is_a_window_of_a_larger_image_is_packed_as_it_looks() -> None:
    large = np.arange(48, dtype=np.float32).reshape(6, 8)
    frame = RgbdFrame(0, 0.0, np.zeros((3, 4, 3), np.uint8), large[::2, ::2])
    np.testing.assert_array_equal(PackedFrame.of(frame).unpacked().depth, large[::2, ::2])
