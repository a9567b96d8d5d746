import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from slam_scenes import CAMERA, LOOKING_AHEAD, rotation_angle

from lpslam.camera import PinholeCamera
from lpslam.config import LevellingConfig
from lpslam.slam.mapping.levelling import floor_normal, level_rotation

CONFIG = LevellingConfig()
FIRST_UP = np.array([0.0, -1.0, 0.0])
"""Up in the optical frame of a camera that is held level."""


class Room:
    """Rectangles in a world with z up, seen as a depth image by a camera 1.4 m above the floor."""

    def __init__(self) -> None:
        self._faces: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def add(self, corner: list[float], side: list[float], other_side: list[float]) -> "Room":
        """A rectangle by a corner and two sides at right angles, metres."""
        self._faces.append((np.array(corner, float), np.array(side, float), np.array(other_side, float)))
        return self

    def floor(self, height: float = 0.0) -> "Room":
        return self.add([-20, -20, height], [40, 0, 0], [0, 40, 0])

    def walls(self, front: float = 4.0, side: float = 2.0) -> "Room":
        for y in (-side, side):
            self.add([-20, y, -1], [40, 0, 0], [0, 0, 5])
        return self.add([front, -20, -1], [0, 40, 0], [0, 0, 5])

    def depth(
        self, world_from_camera: np.ndarray, seed: int = 0, noisy: bool = True, camera: PinholeCamera = CAMERA
    ) -> np.ndarray:
        """(h, w) metres with the noise of a structured-light sensor, 0 beyond 8 m."""
        # Every fourth pixel is drawn and fills its block: levelling looks at coarser samples still.
        v, u = np.mgrid[0 : camera.height : 4, 0 : camera.width : 4]
        ray = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(u.shape)], axis=-1)
        ray = ray @ world_from_camera[:3, :3].T
        nearest = np.full(u.shape, np.inf)
        for corner, side, other_side in self._faces:
            normal = np.cross(side, other_side)
            with np.errstate(all="ignore"):
                z = (normal @ (corner - world_from_camera[:3, 3])) / (ray @ normal)
                hit = world_from_camera[:3, 3] + z[..., None] * ray - corner
                share, other = hit @ side / (side @ side), hit @ other_side / (other_side @ other_side)
                ok = (z > 0) & (share >= 0) & (share <= 1) & (other >= 0) & (other <= 1)
            nearest = np.where(ok, np.minimum(nearest, z), nearest)
        depth = np.where(nearest < 8, nearest, 0.0)
        if noisy:
            random = np.random.default_rng(seed)
            depth = depth + random.normal(size=depth.shape) * (0.0007 + 0.0022 * depth**2) * (depth > 0)
            speckle = ndimage.gaussian_filter(random.normal(size=depth.shape), 1.0)
            depth[speckle > np.quantile(speckle, 0.92)] = 0  # holes in patches, as such sensors leave them
        blocks = np.repeat(np.repeat(depth, 4, axis=0), 4, axis=1)[: camera.height, : camera.width]
        return np.ascontiguousarray(blocks, dtype=np.float32)


def held(pitch: float = 0.0, roll: float = 0.0, yaw: float = 0.0, height: float = 1.4) -> np.ndarray:
    """world_from_camera of a camera that looks down by `pitch` and leans by `roll`, degrees."""
    p, r, y = np.radians([pitch, roll, yaw])
    nod = np.array([[1, 0, 0], [0, np.cos(p), np.sin(p)], [0, -np.sin(p), np.cos(p)]])
    lean = np.array([[np.cos(r), -np.sin(r), 0], [np.sin(r), np.cos(r), 0], [0, 0, 1]])
    turn = np.array([[np.cos(y), -np.sin(y), 0], [np.sin(y), np.cos(y), 0], [0, 0, 1]])
    pose = LOOKING_AHEAD.copy()
    pose[:3, :3] = turn @ LOOKING_AHEAD[:3, :3] @ nod @ lean
    pose[2, 3] = height
    return pose


def tilt(normal: np.ndarray, world_from_camera: np.ndarray) -> float:
    """Degrees between a normal in the optical frame and the world's z axis."""
    return float(np.degrees(np.arccos(np.clip((world_from_camera[:3, :3] @ normal)[2], -1, 1))))


@pytest.mark.parametrize(("pitch", "roll"), [(10, 0), (20, 0), (30, 0), (15, 10), (15, -12), (25, 20), (5, 3)])
def test_the_floor_of_a_corridor_is_found_to_half_a_degree(pitch: float, roll: float) -> None:
    errors = []
    for seed in range(5):
        pose = held(pitch, roll, yaw=7.0 * seed)
        normal = floor_normal(Room().floor().walls().depth(pose, seed), CAMERA, FIRST_UP, CONFIG)
        assert normal is not None
        assert np.linalg.norm(normal) == pytest.approx(1.0)
        errors.append(tilt(normal, pose))
    assert max(errors) < 0.5
    # At five degrees the floor begins three metres off and is seen at a low angle.
    assert np.median(errors) < (0.25 if pitch >= 10 else 0.5)


def test_a_view_of_the_floor_alone_is_levelled_to_a_fifth_of_a_degree() -> None:
    pose = held(35, 4)
    normal = floor_normal(Room().floor().depth(pose), CAMERA, FIRST_UP, CONFIG)
    assert normal is not None
    assert tilt(normal, pose) < 0.2


@settings(max_examples=6)
@given(st.floats(8, 30), st.floats(-15, 15), st.floats(0.8, 1.8), st.integers(0, 1000))
def test_the_rotation_that_follows_puts_the_floor_level(pitch: float, roll: float, height: float, seed: int) -> None:
    pose = held(pitch, roll, height=height)
    normal = floor_normal(Room().floor().walls(front=5.0, side=2.5).depth(pose, seed), CAMERA, FIRST_UP, CONFIG)
    assert normal is not None
    up_in_start = LOOKING_AHEAD[:3, :3] @ normal
    level = level_rotation(up_in_start)[:3, :3]
    # The first camera defines the start world; the true z axis in it must now be z.
    true_up = LOOKING_AHEAD[:3, :3] @ pose[:3, :3].T @ [0.0, 0.0, 1.0]
    assert np.degrees(np.arccos(min((level @ true_up)[2], 1.0))) < 0.6
    assert rotation_angle(level) == pytest.approx(np.arccos(up_in_start[2]), abs=1e-6)


def test_a_better_idea_of_up_is_not_needed_but_a_wild_one_is_not_followed() -> None:
    pose = held(20, 5)
    depth = Room().floor().walls().depth(pose)
    known = floor_normal(depth, CAMERA, pose[:3, :3].T @ [0.0, 0.0, 1.0], CONFIG)
    scaled = floor_normal(depth, CAMERA, 5.0 * FIRST_UP, CONFIG)
    assert known is not None
    assert scaled is not None
    assert tilt(known, pose) < 0.5
    assert tilt(scaled, pose) < 0.5
    sideways = floor_normal(depth, CAMERA, np.array([1.0, 0.0, 0.0]), CONFIG)
    assert sideways is None or abs(sideways[0]) > np.cos(CONFIG.max_tilt)


NO_FLOOR = {
    "walls alone": Room().walls(),
    "a wall ahead": Room().add([2.0, -20, -20], [0, 40, 0], [0, 0, 40]),
    "a ceiling": Room().floor(2.6).walls(),
    "a rail before a void": Room().add([2.6, -9, 0.8], [0, 18, 0], [0, 0, 0.12]),
    "a wall at an angle": Room().add([3.0, -6, -20], [-4, 12, 0], [0, 0, 40]),
}


@pytest.mark.parametrize("name", NO_FLOOR)
@pytest.mark.parametrize("pitch", [0, 15])
def test_where_no_floor_is_seen_there_is_none(name: str, pitch: float) -> None:
    for seed in range(3):
        depth = NO_FLOOR[name].depth(held(pitch, 3), seed)
        assert floor_normal(depth, CAMERA, FIRST_UP, CONFIG) is None


def shelves(pitch_of_boards: float = 0.0) -> Room:
    """A rack of narrow boards at several heights before a wall: their front edges line up on slanted planes."""
    room = Room().add([2.6, -20, -20], [0, 40, 0], [0, 0, 40])
    for level in range(6):
        drop = 0.3 * np.tan(np.radians(pitch_of_boards))
        room.add([2.3, -2, 0.1 + 0.35 * level - drop], [0.3, 0, drop], [0, 4, 0])
        room.add([2.3, -2, 0.05 + 0.35 * level - drop], [0, 4, 0], [0, 0, 0.05])
    return room


@pytest.mark.parametrize("pitch", [0, 10, 20])
def test_the_edges_of_shelves_are_not_a_slanted_floor(pitch: float) -> None:
    for seed in range(3):
        pose = held(pitch, 2)
        normal = floor_normal(shelves().depth(pose, seed), CAMERA, FIRST_UP, CONFIG)
        assert normal is None or tilt(normal, pose) < 2.0


def test_a_floor_is_found_though_a_slanted_board_and_a_table_stand_on_it() -> None:
    room = Room().floor().walls()
    room.add([2.0, 0.3, 0.0], [0.5, 0, 0.9], [0, 0.8, 0])  # a board at sixty degrees
    room.add([1.6, -1.2, 0.74], [0.7, 0, 0], [0, 0.8, 0])  # a table
    for seed in range(5):
        pose = held(20, 4, yaw=3.0 * seed)
        normal = floor_normal(room.depth(pose, seed), CAMERA, FIRST_UP, CONFIG)
        assert normal is not None
        assert tilt(normal, pose) < 0.6


def test_a_table_that_hides_the_floor_is_as_level() -> None:
    pose = held(30, 5)
    normal = floor_normal(Room().floor(0.75).depth(pose), CAMERA, FIRST_UP, CONFIG)
    assert normal is not None
    assert tilt(normal, pose) < 0.2


def test_a_surface_at_the_chin_is_no_floor() -> None:
    pose = held(20)
    near = Room().floor(1.4 - 0.8 * CONFIG.min_height)
    assert floor_normal(near.depth(pose), CAMERA, FIRST_UP, CONFIG) is None


def test_the_answer_is_the_same_each_time() -> None:
    depth = Room().floor().walls().depth(held(15, 5))
    first, second = (floor_normal(depth, CAMERA, FIRST_UP, CONFIG) for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("reading", [0.0, np.nan, np.inf, -1.0])
def test_readings_that_are_none_are_left_out(reading: float) -> None:
    """Principal point on a sampled pixel: a ray straight ahead times an infinite depth is not a number."""
    camera = PinholeCamera(640, 480, 525.0, 520.0, 320.0, 240.0)
    pose = held(20, 4)
    depth = Room().floor().walls().depth(pose, camera=camera)
    depth[depth == 0] = reading
    depth[240, 320] = reading
    normal = floor_normal(depth, camera, FIRST_UP, CONFIG)
    assert normal is not None
    assert tilt(normal, pose) < 0.5
    assert floor_normal(np.full((480, 640), reading, np.float32), camera, FIRST_UP, CONFIG) is None


@pytest.mark.parametrize("size", [(1, 1), (8, 6), (64, 48), (641, 479)])
def test_pictures_of_any_size_are_no_trouble(size: tuple[int, int]) -> None:
    width, height = size
    camera = PinholeCamera(width, height, 0.82 * width, 0.82 * width, width / 2, height / 2)
    normal = floor_normal(Room().floor().depth(held(30), camera=camera), camera, FIRST_UP, CONFIG)
    assert normal is None or tilt(normal, held(30)) < 2.0
