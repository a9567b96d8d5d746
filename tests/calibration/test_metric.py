import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lpslam.calibration.metric import true_scale
from lpslam.camera import inverse_transform
from lpslam.poses import StampedPoses


def path(seed: int, ratio: float, noise: float) -> tuple[np.ndarray, np.ndarray, StampedPoses]:
    """Times, poses as depth has them, and the truth in another frame with metres so many times larger."""
    rng = np.random.default_rng(seed)
    ours = np.tile(np.eye(4), (40, 1, 1))
    ours[:, :3, :3] = Rotation.random(40, rng).as_matrix()
    ours[:, :3, 3] = np.cumsum(rng.normal(0, 0.1, (40, 3)), axis=0)
    true = ours.copy()
    turn = Rotation.random(None, rng).as_matrix()
    true[:, :3, 3] = ratio * ours[:, :3, 3] @ turn.T + [3, -1, 2] + noise * rng.normal(size=(40, 3))
    times = np.arange(40) / 5
    return times, np.array([inverse_transform(each) for each in ours]), StampedPoses(times + 0.003, true)


@pytest.mark.parametrize("ratio", [0.5, 1.0, 1.03, 4.0])
def test_the_ratio_is_found_within_its_sigma(ratio: float) -> None:
    misses = []
    for seed in range(20):
        found = true_scale(*path(seed, ratio, 0.005))
        assert found is not None
        misses.append((found.ratio - ratio) / found.sigma)
    assert 0.6 < np.std(misses) < 1.5
    assert np.abs(misses).max() < 4


def test_without_common_times_there_is_none() -> None:
    times, poses, truth = path(0, 1.0, 0.0)
    assert true_scale(times + 100, poses, truth) is None
    assert true_scale(times[:3], poses[:3], truth) is None
    still = StampedPoses(truth.timestamps, np.tile(np.eye(4), (40, 1, 1)))
    found = true_scale(times, np.tile(np.eye(4), (40, 1, 1)), still)
    assert found is None
