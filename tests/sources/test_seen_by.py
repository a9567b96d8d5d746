"""Frames as another camera would have taken them."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.frames import FrameFault, RgbdFrame
from lpslam.sources.seen_by import SeenBy

OURS = PinholeCamera(320, 240, 280.0, 282.0, 158.0, 121.0, (0.08, -0.12, 0.001, -0.002, 0.03), 1000.0, 15.0)


class Wall:
    """Frames of a wall that leans, painted in stripes, by rays and with any camera: what a resampled one must show."""

    name = "wall"

    def __init__(self, camera: PinholeCamera) -> None:
        self.camera, self.faults = camera, list[FrameFault]()

    def __len__(self) -> int:
        return 1

    def __iter__(self):  # type: ignore[no-untyped-def]
        """The one frame."""
        camera = self.camera
        u, v = np.meshgrid(np.arange(camera.width, dtype=float), np.arange(camera.height, dtype=float))
        x, y, _ = camera.back_project(camera.undistort(np.column_stack([u.ravel(), v.ravel()])), np.ones(u.size)).T
        depth = (2.0 / (1.0 + 0.3 * x - 0.2 * y)).reshape(u.shape)
        waves = 127 + 60 * np.sin(9 * x) + 50 * np.cos(7 * y)
        rgb = np.repeat(waves.reshape(*u.shape, 1), 3, axis=2).astype(np.uint8)
        yield RgbdFrame(7, 3.5, rgb, depth.astype(np.float32))


def only(source: SeenBy | Wall) -> RgbdFrame:
    (frame,) = source
    return frame


@pytest.mark.parametrize(
    "theirs",
    [
        PinholeCamera(320, 240, 300.0, 300.0, 160.0, 120.0),
        PinholeCamera(200, 150, 160.0, 162.0, 99.0, 76.0),
        PinholeCamera(640, 480, 700.0, 698.0, 330.0, 236.0, (-0.2, 0.05, 0.0, 0.001, 0.0)),
    ],
)
def test_a_frame_shows_what_the_other_camera_would_have_seen(theirs: PinholeCamera) -> None:
    source = SeenBy(Wall(OURS), theirs)
    assert source.camera == replace(theirs, depth_scale=1000.0, fps=15.0)
    frame, expected = only(source), only(Wall(theirs))
    assert (frame.index, frame.timestamp) == (7, 3.5)
    assert frame.rgb.shape == expected.rgb.shape == (theirs.height, theirs.width, 3)
    seen = frame.depth > 0
    assert source.share > 0.6
    assert seen.mean() == pytest.approx(source.share)
    assert np.abs(frame.depth - expected.depth)[seen].max() < 0.01
    inner = cv2.erode(seen.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    assert np.abs(frame.rgb.astype(int) - expected.rgb)[inner].max() <= 3


def test_where_the_camera_does_not_look_there_is_no_depth_and_no_corner() -> None:
    wide = PinholeCamera(320, 240, 140.0, 141.0, 160.0, 120.0)
    source = SeenBy(Noise(OURS), wide)
    frame = only(source)
    beyond = frame.depth == 0
    assert 0.7 < beyond.mean() < 0.8
    assert source.share == pytest.approx(1 - beyond.mean())
    corners = cv2.FastFeatureDetector.create(12).detect(frame.rgb[..., 0].copy())
    rows, columns = np.rint([(corner.pt[1], corner.pt[0]) for corner in corners]).astype(int).T
    assert len(corners) > 100
    assert beyond[rows, columns].sum() <= 0.02 * len(corners)


def test_a_lens_that_folds_back_beyond_its_view_shows_nothing_there() -> None:
    """By its polynomial a ray far outside falls into the picture again."""
    barrel = replace(OURS, distortion=(-0.3, 0.0, 0.0, 0.0, 0.0))
    wide = PinholeCamera(320, 240, 60.0, 60.0, 160.0, 120.0)
    share = SeenBy(Wall(barrel), wide).share
    edge = barrel.undistort(np.array([[0.0, 121.0], [319.0, 121.0], [158.0, 0.0], [158.0, 239.0]]))
    across, down = np.ptp(edge[:, 0]) / barrel.fx * wide.fx, np.ptp(edge[:, 1]) / barrel.fy * wide.fy
    assert share < 1.4 * across * down / (320 * 240)


class Noise(Wall):
    """Frames full of corners."""

    def __iter__(self):  # type: ignore[no-untyped-def]
        """The one frame."""
        shape = (self.camera.height, self.camera.width)
        blocks: NDArray[np.uint8] = np.random.default_rng(3).integers(0, 256, (shape[0] // 6, shape[1] // 6), np.uint8)
        gray = cv2.resize(blocks, shape[::-1], interpolation=cv2.INTER_NEAREST)
        yield RgbdFrame(7, 3.5, np.repeat(gray[..., None], 3, axis=2), np.ones(shape, np.float32))
