"""What a lost frame's depth is asked for, and when a sign in its picture counts."""

from dataclasses import replace

import numpy as np
import pytest

from lpslam.camera import PinholeCamera
from lpslam.config import FittingConfig
from lpslam.slam.advice import Anchor
from lpslam.slam.places.fitting import Fitted, Fitting
from lpslam.slam.tracking.refinding import FrameDepth

CAMERA = PinholeCamera(160, 120, 130.0, 130.0, 79.5, 59.5)
WALL = np.full((120, 160), 3.0, np.float32)
CORNERS = np.array([[-0.4, -0.1, 3.0], [0.4, -0.1, 3.0], [0.4, 0.1, 3.0], [-0.4, 0.1, 3.0]])
POINTS = np.column_stack([*np.random.default_rng(0).uniform(-1, 1, (2, 200)), np.full(200, 3.0)])


def asked(anchor: Anchor | None, pose: np.ndarray | None, timestamp: float = 7.0) -> Fitted | None:
    config = FittingConfig(fresh_seconds=0.5)
    return FrameDepth(Fitting(CAMERA, config), WALL, timestamp, config.fresh_seconds).fit(anchor, pose, POINTS)


@pytest.mark.parametrize(("seen_at", "counts"), [(6.9, True), (6.4, False), (-np.inf, False)])
def test_a_sign_counts_while_it_is_where_it_was_seen(seen_at: float, counts: bool) -> None:
    anchor = Anchor(CORNERS[None], CORNERS[None] / np.linalg.norm(CORNERS, axis=1)[:, None], seen_at)
    assert (asked(anchor, None) is not None) == counts
    # Nor is the pose that such a sign once told.
    assert (asked(anchor, np.eye(4)) is not None) == counts


def test_a_pose_of_the_frame_before_counts_without_a_sign() -> None:
    assert asked(None, np.eye(4)) is not None
    assert asked(None, None) is None
    moved = replace(Anchor(CORNERS[None], CORNERS[None], 7.0), corners=CORNERS[None] + [0.0, 0.0, 2.0])
    assert asked(moved, None) is None, "of the map's wall, two metres before it, something would be seen"
