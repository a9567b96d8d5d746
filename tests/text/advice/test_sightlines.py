"""Where a camera stands by the signs that it sees, without depth."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.camera import inverse_transform, transform_points
from lpslam.config import AdviceConfig
from lpslam.slam.kernels.geometry import exponential
from lpslam.text.advice.constellations import Seen
from lpslam.text.advice.sightlines import Sightline, corners_of, standpoints
from lpslam.text.placing.views import vector3
from lpslam.text.types import Bearing

CONFIG = AdviceConfig()


def sign(text_class: int, text: str, x: float, z: float = 0.0, width: float = 1.4, height: float = 0.25) -> Seen:
    """On a wall at y = 0 that faces -y."""
    return Seen(
        text_class, (text,), 9, 0.95, 1.0, np.array([x, 0.0, z]), np.array([0.0, -1.0, 0.0]),
        np.array([1.0, 0.0, 0.0]), width, height,
    )  # fmt: skip


SIGNS = [sign(1, "WALNUT TAILORS", 0.0), sign(2, "METRO SNEAKERS", 3.3), sign(3, "青花瓷坊", 6.6, 0.1)]


def camera_at(x: float, distance: float, yaw: float = 0.0) -> np.ndarray:
    """4×4, camera from world: upright, `distance` before the wall, turned by radians."""
    level = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0], [0, 0, 0, 1.0]])  # columns: right, down, ahead
    world_from_camera = level @ exponential(np.array([0, 0, 0, 0.02, yaw, 0.03]))
    world_from_camera[:3, 3] = (x, -distance, -0.8)
    return inverse_transform(world_from_camera)


def line(seen: Seen, pose: np.ndarray, may_be: list[Seen], noise: float = 0.0, seed: int = 0) -> Sightline:
    """How a sign is seen from a pose, its corners off by radians."""
    corners = transform_points(pose, corners_of(seen))
    corners /= corners[:, 2:]
    corners[:, :2] += np.random.default_rng(seed).normal(0, noise, (4, 2))
    return Sightline(bearing(corners), np.eye(4), may_be)


def bearing(directions: np.ndarray, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Bearing:
    first, second, third, fourth = (vector3(each / np.linalg.norm(each)) for each in directions)
    return Bearing(origin, (first, second, third, fourth))


def off(pose: np.ndarray, true: np.ndarray) -> float:
    return float(np.linalg.norm((inverse_transform(pose) - inverse_transform(true))[:3, 3]))


@given(st.floats(0, 3.3), st.floats(3, 9), st.floats(-0.3, 0.3))
def test_two_signs_tell_where_the_camera_stands(x: float, distance: float, yaw: float) -> None:
    pose = camera_at(x, distance, yaw)
    (found,) = standpoints([line(each, pose, [each]) for each in SIGNS[:2]], CONFIG)
    assert off(found.camera_from_world, pose) < 0.02
    assert found.rarity == 2.0


def test_as_exactly_as_boxes_are_drawn() -> None:
    """Signs in one row say little of how the camera is tilted, and by that of its height."""
    pose = camera_at(2.0, 6.5, 0.1)
    for seed in range(10):
        lines = [line(each, pose, [each], 1.0 / 525, seed + 10 * each.text_class) for each in SIGNS]
        (found,) = standpoints(lines, CONFIG)
        where, true = inverse_transform(found.camera_from_world)[:3, 3], inverse_transform(pose)[:3, 3]
        assert np.abs(where - true)[:2].max() < 0.3
        assert abs(where - true)[2] < 1.0
        assert found.anchor.corners.shape == found.anchor.directions.shape == (3, 4, 3)
        assert found.rarity == 3.0


def test_of_signs_that_say_the_same_those_that_fit_are_meant() -> None:
    pose = camera_at(2.0, 6.0)
    exits = [sign(4, "EXIT", x, 0.3) for x in (-20.0, 5.0, 30.0)]
    lines = [line(SIGNS[1], pose, [SIGNS[1]]), line(exits[1], pose, exits)]
    (found,) = standpoints(lines, CONFIG)
    assert off(found.camera_from_world, pose) < 0.02
    assert found.rarity == pytest.approx(4 / 3)


@pytest.mark.parametrize(
    "elsewhere",
    [sign(2, "METRO SNEAKERS", 2.4), sign(2, "METRO SNEAKERS", 3.3, 0.6), sign(2, "METRO SNEAKERS", 3.3, width=0.9)],
    ids=["nearer", "higher", "smaller"],
)
def test_signs_that_stand_otherwise_tell_nothing(elsewhere: Seen) -> None:
    pose = camera_at(2.0, 6.0)
    lines = [line(SIGNS[0], pose, [SIGNS[0]]), line(elsewhere, pose, [SIGNS[1]])]
    assert list(standpoints(lines, CONFIG)) == []


def test_one_sign_tells_nothing_nor_do_two_readings_of_one() -> None:
    pose = camera_at(2.0, 6.0)
    alone = line(SIGNS[0], pose, [SIGNS[0]])
    assert list(standpoints([], CONFIG)) == []
    assert list(standpoints([alone], CONFIG)) == []
    twin = sign(5, "WALNUT TAILOR", 3.3)
    assert list(standpoints([alone, line(twin, pose, [twin])], CONFIG)) == []


def test_signs_behind_the_camera_or_seen_from_behind_tell_nothing() -> None:
    pose = camera_at(2.0, 6.0)
    lines = [line(each, pose, [each]) for each in SIGNS[:2]]
    rays = [np.array(each.bearing.corners) for each in lines]
    behind = [Sightline(bearing(-own), np.eye(4), each.signs) for own, each in zip(rays, lines, strict=True)]
    assert list(standpoints(behind, CONFIG)) == []
    turned = [own[[1, 0, 3, 2]] for own in rays]
    mirrored = [Sightline(bearing(own), np.eye(4), each.signs) for own, each in zip(turned, lines, strict=True)]
    assert list(standpoints(mirrored, CONFIG)) == []


def test_what_one_frame_saw_another_would_have_seen_elsewhere() -> None:
    """A bearing hangs on a keyframe; the camera that saw it stood beside that, and the one that asks beside both."""
    keyframe, camera, asks = camera_at(1.0, 6.0), camera_at(1.3, 5.8, 0.1), camera_at(0.8, 6.1, -0.05)
    world_from_camera = inverse_transform(camera)
    lines = []
    for each in SIGNS[:2]:
        rays = corners_of(each) - world_from_camera[:3, 3]
        origin = vector3(transform_points(keyframe, world_from_camera[None, :3, 3])[0])
        seen = bearing(rays @ keyframe[:3, :3].T, origin)
        lines.append(Sightline(seen, asks @ inverse_transform(keyframe), [each]))
    (found,) = standpoints(lines, CONFIG)
    assert off(found.camera_from_world, asks) < 0.3
    expected = transform_points(asks, corners_of(SIGNS[0]))
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    np.testing.assert_allclose(lines[0].corners_if(SIGNS[0]), expected, atol=0.004)


@pytest.mark.parametrize(("width", "height"), [(0.0, 0.2), (1.4, 0.0), (0.0, 0.0), (1e6, 1e6)])
def test_signs_of_an_edited_map_without_a_size_tell_nothing(width: float, height: float) -> None:
    pose = camera_at(2.0, 6.0)
    names = ("WALNUT TAILORS", "METRO SNEAKERS")
    broken = [sign(at, name, 3.3 * at, width=width, height=height) for at, name in enumerate(names)]
    lines = [line(whole, pose, [each]) for whole, each in zip(SIGNS, broken, strict=False)]
    assert list(standpoints(lines, CONFIG)) == []
