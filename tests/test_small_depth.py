"""A small picture of depth: the median of the readings about each of its pixels."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from lpslam.camera import PinholeCamera
from lpslam.small_depth import SmallDepth

CAMERA = PinholeCamera(64, 48, 52.0, 52.0, 31.5, 23.5)
SHRINK = 4
FARTHEST = 5.0


def by_definition(depth: np.ndarray) -> np.ndarray:
    """The same, pixel by pixel."""
    small = np.zeros((CAMERA.height // SHRINK, CAMERA.width // SHRINK), np.float32)
    for v, u in np.ndindex(*small.shape):
        middle = (np.array([v, u]) + 0.5) * SHRINK - 0.5
        readings = []
        for down in (-1, 0, 1):
            for across in (-1, 0, 1):
                row, column = np.rint(middle + np.array([down, across]) * SHRINK / 3).astype(int)
                if 0 <= row < CAMERA.height and 0 <= column < CAMERA.width:
                    reading = depth[row, column]
                    readings += [reading] if 0 < reading < FARTHEST else []
        small[v, u] = sorted(readings)[len(readings) // 2] if len(readings) > 4 else 0.0
    return small


@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1.0), st.floats(0.0, 0.3))
@settings(max_examples=30, deadline=None)
def test_it_is_the_median_of_nine_readings_where_most_are_there(seed: int, missing: float, broken: float) -> None:
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.5, 6.0, (CAMERA.height, CAMERA.width)).astype(np.float32)
    depth[rng.random(depth.shape) < missing] = 0.0
    depth[rng.random(depth.shape) < broken] = np.nan
    small = SmallDepth(CAMERA, CAMERA.width // SHRINK).read(depth, FARTHEST)
    np.testing.assert_array_equal(small, by_definition(depth))
