"""Depth put into another camera's pixels."""

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.sources.registering.registration import DepthRegistration, DepthRig

DEPTH = PinholeCamera(80, 60, 60.0, 60.0, 39.5, 29.5)
COLOUR = PinholeCamera(160, 120, 120.0, 120.0, 79.5, 59.5)


def pose(x: float) -> np.ndarray:
    shift = np.eye(4)
    shift[0, 3] = x
    return shift


def test_a_wall_stays_whole_and_moves_by_its_parallax() -> None:
    depth = np.full((60, 80), 2.0, np.float32)
    registered = DepthRegistration(DepthRig(DEPTH, COLOUR, pose(0.05)))(depth)
    # 0.05 m at 2 m and a focal length of 120 pixels.
    assert (registered[:, 3:] == 2.0).all()
    assert not registered[:, :3].any()


def test_the_nearest_surface_hides_what_is_behind_and_the_hole_stays_open() -> None:
    depth = np.full((60, 80), 4.0, np.float32)
    depth[20:40, 30:50] = 1.0
    registered = DepthRegistration(DepthRig(DEPTH, DEPTH, pose(0.1)))(depth)
    # The near square moves by 6 pixels, the wall by 1.5: between them nothing was seen.
    assert (registered[20:40, 36:56] == 1.0).all()
    assert (registered[20:40, 32:36] == 0.0).all()
    assert registered[20:40, 56:].min() == 4.0


def test_nothing_comes_of_no_depth() -> None:
    depth = np.array([[np.nan, np.inf], [0.0, -1.0]], np.float32)
    camera = PinholeCamera(2, 2, 2.0, 2.0, 0.5, 0.5)
    assert not DepthRegistration(DepthRig(camera, camera, pose(0.01)))(depth).any()
