"""The same mall walked again, and the same frames measured again."""

import numpy as np
import pytest

from lpslam.camera import PinholeCamera
from lpslam.config import SimulationConfig
from lpslam.errors import UserError
from lpslam.frames import FrameFault, RgbdFrame
from lpslam.simulation.replay import NoisyAgain
from lpslam.simulation.source import MallSource

SMALL = SimulationConfig(loop_length=26.0)


class Still:
    """One frame, as often as it is asked for."""

    def __init__(self, frame: RgbdFrame) -> None:
        self.frame = frame
        self.name, self.camera = "still", PinholeCamera(640, 480, 570.0, 570.0, 319.5, 239.5)
        self.faults: list[FrameFault] = []

    def __len__(self) -> int:
        return 1

    def __iter__(self):  # type: ignore[no-untyped-def]
        yield self.frame


@pytest.mark.usefixtures("built_anew")
def test_another_visit_is_another_walk_in_the_same_world(mall: MallSource) -> None:
    again = MallSource(3, options=SMALL, visit=1)
    assert again.camera == mall.camera
    assert [sign.text for sign in again._mall.signs] == [sign.text for sign in mall._mall.signs]
    first, second = (each.ground_truth.world_from_camera[:, :3, 3] for each in (mall, again))
    assert np.linalg.norm(first[0] - second[0]) > 0.5
    # Both follow the same corridor: every place of the one is near some place of the other.
    nearest = np.linalg.norm(first[::30, None, :2] - second[None, :, :2], axis=2).min(axis=1)
    assert nearest.max() < 0.7


def test_visits_count_from_zero() -> None:
    with pytest.raises(UserError, match="visit is -1"):
        MallSource(3, options=SMALL, visit=-1)


def test_noise_changes_the_measurement_and_nothing_else(mall: MallSource) -> None:
    plain, same, other = mall.frame(30), mall.frame(30, noise=0), mall.frame(30, noise=1)
    assert np.array_equal(plain.rgb, same.rgb)
    assert np.array_equal(plain.depth, same.depth)
    change = other.rgb.astype(float) - plain.rgb
    assert 0.5 < change.std() < 6.0
    assert abs(change.mean()) < 0.1
    both = (plain.depth > 0) & (other.depth > 0)
    z = plain.depth[both]
    scaled = (other.depth[both] - z) / (np.sqrt(2) * (0.0007 + 0.0022 * z**2))
    assert np.median(np.abs(scaled)) == pytest.approx(0.6745, rel=0.15)


def test_measuring_again_adds_the_stated_share_of_the_sensors_noise() -> None:
    z = 3.0
    depth = np.full((480, 640), z, np.float32)
    depth[:10] = 0
    frame = RgbdFrame(5, 0.2, np.full((480, 640, 3), 120, np.uint8), depth)
    source = NoisyAgain(Still(frame), seed=1, share=0.5)
    (seen,) = source
    (repeated,) = source
    assert np.array_equal(seen.rgb, repeated.rgb)
    assert np.array_equal(seen.depth, repeated.depth)
    assert not np.array_equal(seen.rgb, source.disturbed(frame, 2).rgb)
    assert (seen.index, seen.timestamp) == (5, 0.2)
    assert not seen.depth[:10].any()
    assert (seen.depth[10:] - z).std() == pytest.approx(0.5 * (0.0007 + 0.0022 * z**2), rel=0.1)
    assert 0.5 < seen.rgb.std() < 1.5
    assert seen.rgb.mean() == pytest.approx(120, abs=0.1)


def test_measuring_again_does_not_wrap_around_at_black_and_white() -> None:
    ends = np.zeros((480, 640, 3), np.uint8)
    ends[:, 320:] = 255
    frame = RgbdFrame(0, 0.0, ends, np.ones((480, 640), np.float32))
    (seen,) = NoisyAgain(Still(frame), seed=3, share=2.0)
    assert seen.rgb[:, :320].max() < 60
    assert seen.rgb[:, 320:].min() > 195
