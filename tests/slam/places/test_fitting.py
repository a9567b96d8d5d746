"""The pose of a view by its depth and one sign, whatever it looks like."""

from dataclasses import replace

import numpy as np
import pytest
from slam_scenes import pose_error, rigid

from lpslam.camera import PinholeCamera, inverse_transform
from lpslam.config import FittingConfig
from lpslam.slam.advice import Anchor
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.places.fitting import Fitting

CAMERA = PinholeCamera(320, 240, 260.0, 260.0, 159.5, 119.5)
ROOM = np.array([[-3.0, -1.5, -2.0], [3.0, 1.2, 4.0]])
PILLAR = np.array([[0.6, -1.5, 1.8], [1.1, 1.2, 2.3]])
"""Boxes by two corners; y is down, the camera looks along z."""

SIGN = np.array([[-0.9, -0.6, 4.0], [-0.1, -0.6, 4.0], [-0.1, -0.4, 4.0], [-0.9, -0.4, 4.0]])
VIEW = rigid([0.3, 0.1, 0.4], [0.05, -0.15, 0.03])
"""Camera from world."""


def depth_from(camera_from_world: np.ndarray, room: np.ndarray = ROOM, noise: float = 0.002) -> np.ndarray:
    """What a sensor measures there: noise in metres a square metre."""
    rows, columns = np.mgrid[: CAMERA.height, : CAMERA.width]
    rays = np.stack([(columns - CAMERA.cx) / CAMERA.fx, (rows - CAMERA.cy) / CAMERA.fy, np.ones(rows.shape)], axis=2)
    world_from_camera = inverse_transform(camera_from_world)
    ways, centre = rays @ world_from_camera[:3, :3].T, world_from_camera[:3, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        to_walls, to_pillar = (np.sort((box[:, None, None] - centre) / ways, axis=0) for box in (room, PILLAR))
    enters, leaves = to_pillar[0].max(axis=2), to_pillar[1].min(axis=2)
    depth = np.where((enters < leaves) & (enters > 0), enters, to_walls[1].min(axis=2))
    measured: np.ndarray = depth + np.random.default_rng(0).normal(0, noise, depth.shape) * depth**2
    return measured.astype(np.float32)


def mapped_points(room: np.ndarray = ROOM) -> np.ndarray:
    """Points on the walls and the pillar, known to 2 cm."""
    random, points = np.random.default_rng(1), []
    for box, count in ((room, 2500), (PILLAR, 200)):
        inside = random.uniform(box[0], box[1], (count, 3))
        axis, side = random.integers(0, 3, count), random.integers(0, 2, count)
        inside[np.arange(count), axis] = box[side, axis]
        points.append(inside)
    together: np.ndarray = np.concatenate(points)
    return together + random.normal(0, 0.02, together.shape)


def sign_seen(camera_from_world: np.ndarray, pixels: float = 0.0) -> Anchor:
    """The sign, its corners read with an error of some pixels."""
    local = SIGN @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]
    directions = local / local[:, 2:]
    directions[:, :2] += np.random.default_rng(2).normal(0, pixels / CAMERA.fx, (4, 2))
    return Anchor(SIGN[None], (directions / np.linalg.norm(directions, axis=1, keepdims=True))[None])


@pytest.mark.parametrize("pixels", [0.0, 1.5])
@pytest.mark.parametrize("view", [VIEW, rigid([-0.5, -0.6, 1.0], [-0.2, 0.2, -0.05])])
def test_one_sign_and_the_depth_tell_the_pose(view: np.ndarray, pixels: float) -> None:
    fitting = Fitting(CAMERA, FittingConfig())
    fitted = fitting.by_signs(fitting.surfaces(depth_from(view)), sign_seen(view, pixels), mapped_points())
    assert fitted is not None
    metres, radians = pose_error(fitted.camera_from_world, view)
    assert metres < 0.02
    assert np.degrees(radians) < 0.4
    assert fitted.agreement > 0.95


def test_a_pose_nearby_is_mended_without_a_sign() -> None:
    fitting = Fitting(CAMERA, FittingConfig())
    surfaces, points = fitting.surfaces(depth_from(VIEW)), mapped_points()
    for off in ([0.2, -0.1, 0.15, 0.05, -0.08, 0.03], [-0.15, 0.1, 0.2, -0.05, 0.06, 0.08]):
        fitted = fitting.near(surfaces, exponential(np.array(off)) @ VIEW, points)
        assert fitted is not None
        metres, radians = pose_error(fitted.camera_from_world, VIEW)
        assert metres < 0.02
        assert np.degrees(radians) < 0.4


def test_a_room_of_another_shape_contradicts() -> None:
    """The same sign hangs there as well, and a wall of the map stands in the middle of what is seen."""
    fitting, other = Fitting(CAMERA, FittingConfig()), np.array([[-3.0, -1.5, -2.0], [0.2, 1.2, 4.0]])
    assert fitting.by_signs(fitting.surfaces(depth_from(VIEW)), sign_seen(VIEW), mapped_points(other)) is None


def test_without_depth_on_the_sign_or_points_around_nothing_is_told() -> None:
    fitting, depth = Fitting(CAMERA, FittingConfig()), depth_from(VIEW)
    anchor, points = sign_seen(VIEW), mapped_points()
    column, row = anchor.pixels(np.array([CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy]))[0].mean(axis=0).astype(int)
    glass = depth.copy()
    glass[row - 30 : row + 30, column - 50 : column + 50] = 0.0
    assert fitting.by_signs(fitting.surfaces(depth), anchor, points) is not None
    assert fitting.by_signs(fitting.surfaces(glass), anchor, points) is None
    assert fitting.by_signs(fitting.surfaces(np.zeros_like(depth)), anchor, points) is None
    assert fitting.by_signs(fitting.surfaces(depth), anchor, points[:20]) is None
    assert fitting.near(fitting.surfaces(depth), VIEW, np.empty((0, 3))) is None


def test_a_sign_without_a_size_is_no_pose() -> None:
    """As of a map that was edited."""
    fitting, anchor = Fitting(CAMERA, FittingConfig()), sign_seen(VIEW)
    flat = replace(anchor, corners=np.repeat(anchor.corners[:, :1], 4, axis=1))
    assert fitting.by_signs(fitting.surfaces(depth_from(VIEW)), flat, mapped_points()) is None
