"""How soon after a keyframe the next one may come."""

from typing import Any, cast

import numpy as np
import pytest

from lpslam.config import Config
from lpslam.slam.features import Features
from lpslam.slam.tracking.keyframes import Keyframes

CONFIG = Config().slam.keyframes
COUNT = 100


def without_depth() -> Features:
    nothing = np.zeros(COUNT, np.float32)
    return Features(
        np.zeros((COUNT, 2), np.float32),
        nothing,
        nothing,
        np.zeros(COUNT, np.bool_),
        np.zeros(COUNT, np.uint8),
        nothing,
        np.zeros((COUNT, 4), np.uint64),
    )


@pytest.mark.parametrize(("rate", "frames"), [(10.0, 1), (15.0, 1), (20.0, 2), (30.0, 3), (60.0, 6)])
def test_the_next_comes_with_the_frame_nearest_to_the_least_interval(rate: float, frames: int) -> None:
    keyframes = Keyframes(cast(Any, None), cast(Any, None), cast(Any, None), CONFIG)
    keyframes._last_time = 0.0
    matched = np.ones(COUNT, np.bool_)
    assert not keyframes.wants(0.0, without_depth(), matched, frame_interval=1 / rate)
    # Fewer than are wanted, and not so few that it is urgent.
    matched[int(COUNT * (CONFIG.tracked_share + CONFIG.urgent_share) / 2) :] = False
    wanted = [keyframes.wants(frame / rate, without_depth(), matched, frame_interval=1 / rate) for frame in range(1, 8)]
    assert wanted.index(True) + 1 == frames
