"""Points beyond the sensor's reach: made where nothing was read, and placed when the camera has moved."""

import numpy as np
import pytest
from slam_scenes import CAMERA, SENSOR, add_view, check_graph, descriptors_of, features_at, rigid

from lpslam.camera import transform_points
from lpslam.config import FarPointConfig
from lpslam.slam.adjusting import Adjuster
from lpslam.slam.features import Features
from lpslam.slam.kernels import graph
from lpslam.slam.map import SlamMap
from lpslam.slam.mapping.far_points import FarPoints

CONFIG = FarPointConfig()
NEAR, FAR, EDGE = slice(0, 60), slice(60, 160), slice(160, 180)
REACH = 4.0


class Hall:
    """A floor within reach, a wall eight to sixteen metres away, and keypoints at the floor's ragged edge."""

    def __init__(self, seed: int = 0) -> None:
        random = np.random.default_rng(seed)
        floor = random.uniform([40, 340], [600, 440], (60, 2))
        wall = random.uniform([120, 100], [520, 200], (100, 2))
        edge = np.column_stack([random.uniform(40, 600, 20), np.full(20, 297.0)])
        self.pixels = np.concatenate([floor, wall, edge])
        self.inverse = random.uniform(1 / 16, 1 / 8, 100)
        depths = np.concatenate([random.uniform(1.5, REACH, 60), 1 / self.inverse, np.full(20, 4.5)])
        self.points = CAMERA.back_project(self.pixels, depths)
        self.descriptors = descriptors_of(random, 180)
        self.depth = np.zeros((480, 640), np.float32)
        self.depth[300:] = 3.0
        self.map = SlamMap(200, SENSOR.scales)
        self.far_points = FarPoints(self.map, SENSOR, CONFIG)

    def features(self, camera_from_world: np.ndarray, reach: float = REACH) -> Features:
        in_camera = transform_points(camera_from_world, self.points)
        depths = np.where(in_camera[:, 2] <= reach, in_camera[:, 2], 0)
        return features_at(CAMERA.project(in_camera), depths, self.descriptors)

    def begin(self) -> np.ndarray:
        """The first keyframe, at the origin; ids of the far points of all keypoints, -1 for none."""
        features = self.features(np.eye(4))
        keyframe = add_view(self.map, np.eye(4), features, -1)
        return self.far_points.add(keyframe, self.depth, features, np.ones(180, np.bool_))

    def see(self, camera_from_world: np.ndarray, made: np.ndarray, reach: float = REACH) -> int:
        """Another keyframe that sees the far points."""
        keyframe = add_view(self.map, camera_from_world, self.features(camera_from_world, reach), 0)
        graph.link_all(self.map.columns, made, int(self.map.columns.keyframe_slot[keyframe]))
        self.far_points.measure(keyframe)
        return keyframe

    def inverse_depths(self, points: np.ndarray) -> np.ndarray:
        return 1.0 / self.map.columns.position[points, 2]


@pytest.fixture
def hall() -> Hall:
    return Hall()


def test_points_are_made_where_nothing_was_read_and_nowhere_else(hall: Hall) -> None:
    made = hall.begin()
    assert (made[NEAR] < 0).all()
    assert (made[EDGE] < 0).all()
    assert (made[FAR] >= 0).all()
    m, points = hall.map.columns, made[FAR]
    np.testing.assert_allclose(CAMERA.project(m.position[points]), hall.pixels[FAR], atol=1e-3)
    # Between the reach and infinity, by inverse depth: its middle, and the sigma of what is uniform there.
    reach = np.quantile(hall.features(np.eye(4)).depth[NEAR], CONFIG.reach_share)
    np.testing.assert_allclose(hall.inverse_depths(points), 0.5 / reach, rtol=1e-5)
    np.testing.assert_allclose(m.inverse_sigma[points], 1 / np.sqrt(12) / reach, rtol=1e-5)
    check_graph(hall.map)


def test_a_sensor_whose_reach_is_not_known_makes_none(hall: Hall) -> None:
    features = hall.features(np.eye(4), reach=0.1)
    keyframe = add_view(hall.map, np.eye(4), features, -1)
    assert (hall.far_points.add(keyframe, hall.depth, features, np.ones(180, np.bool_)) < 0).all()


def test_no_more_are_made_than_asked_for_or_needed(hall: Hall) -> None:
    features = hall.features(np.eye(4))
    keyframe = add_view(hall.map, np.eye(4), features, -1)
    few = FarPoints(hall.map, SENSOR, FarPointConfig(most=30))
    none = FarPoints(hall.map, SENSOR, FarPointConfig(in_view=60))
    is_free = np.ones(180, np.bool_)
    is_free[NEAR] = False
    assert (none.add(keyframe, hall.depth, features, is_free) < 0).all()
    assert np.count_nonzero(few.add(keyframe, hall.depth, features, is_free) >= 0) == 30


def test_a_way_aside_places_them_and_makes_them_sure(hall: Hall) -> None:
    made = hall.begin()
    before = hall.map.columns.inverse_sigma[made[FAR]].copy()
    hall.see(rigid([-0.1, 0, 0], [0, 0.02, 0]), made)
    m, points = hall.map.columns, made[FAR]
    little = m.inverse_sigma[points].copy()
    assert (little < before).all()
    hall.see(rigid([-1.5, 0.1, 0], [0.03, 0.1, 0]), made)
    assert (m.inverse_sigma[points] == 0).all()
    np.testing.assert_allclose(hall.inverse_depths(points), hall.inverse, rtol=0.03)
    check_graph(hall.map)


def test_depth_that_is_read_later_places_them_at_once(hall: Hall) -> None:
    made = hall.begin()
    hall.see(rigid([0, 0, -0.05], [0, 0, 0]), made, reach=20.0)
    points = made[FAR]
    assert (hall.map.columns.inverse_sigma[points] == 0).all()
    np.testing.assert_allclose(hall.inverse_depths(points), hall.inverse, rtol=1e-3)


def test_what_moves_is_dropped(hall: Hall) -> None:
    made = hall.begin()
    hall.points[60:80] += [0.0, 0.5, 0.0]
    hall.see(rigid([-0.5, 0, 0], [0, 0, 0]), made)
    alive = hall.map.columns.point_alive[made[FAR]]
    assert not alive[:20].any()
    assert alive[20:].all()
    check_graph(hall.map)


def test_they_go_with_the_keyframe_that_saw_them_first(hall: Hall) -> None:
    made = hall.begin()
    root = hall.map.keyframe_count - 1
    second = add_view(hall.map, rigid([-0.2, 0, 0], [0, 0, 0]), hall.features(rigid([-0.2, 0, 0], [0, 0, 0])), root)
    made = hall.far_points.add(second, hall.depth, hall.features(rigid([-0.2, 0, 0], [0, 0, 0])), made < 0)
    new = made[made >= 0]
    hall.map.remove_keyframe(second)
    hall.far_points.measure(root)
    assert not hall.map.columns.point_alive[new].any()
    check_graph(hall.map)


def test_adjustment_leaves_them_out_and_carries_them_along(hall: Hall) -> None:
    """A keyframe that is moved back to where it was takes them with it, as it saw them."""
    made = hall.begin()
    m = hall.map.columns
    near = hall.map.add_points(0, np.arange(60, dtype=np.int32), hall.points[NEAR])
    truth = rigid([-0.3, 0, 0], [0, 0.02, 0])
    features = hall.features(truth)
    moved = add_view(hall.map, rigid([0.02, 0.01, 0.02], [0.01, 0, 0]) @ truth, features, 0)
    seen = np.full(180, -1, np.int32)
    seen[NEAR] = np.arange(near, near + 60)
    seen[60:100] = made[60:100]
    graph.link_all(hall.map.columns, seen, int(hall.map.columns.keyframe_slot[moved]))
    own = hall.far_points.add(moved, hall.depth, features, seen < 0)
    own, old = own[own >= 0], made[60:100]
    m = hall.map.columns
    before, old_before = transform_points(m.camera_from_world[moved], m.position[own]), m.position[old].copy()
    Adjuster(hall.map, SENSOR).adjust(np.array([moved], np.int32), (10, 10), np.zeros(1, np.bool_))
    np.testing.assert_allclose(m.camera_from_world[moved], truth, atol=1e-3)
    np.testing.assert_allclose(transform_points(m.camera_from_world[moved], m.position[own]), before, atol=1e-9)
    np.testing.assert_array_equal(m.position[old], old_before)


def test_a_finished_map_has_none(hall: Hall) -> None:
    made = hall.begin()
    hall.see(rigid([-0.05, 0, 0], [0, 0, 0]), made)
    assert not len(hall.map.point_positions())
    assert not len(hall.map.points_seen_by(0))
    hall.far_points.forget_unsure()
    assert not hall.map.columns.point_alive[made[FAR]].any()
    check_graph(hall.map)


def test_a_point_that_stands_somewhere_gives_its_place_to_one_that_does_not(hall: Hall) -> None:
    made = hall.begin()
    m = hall.map.columns
    sure = hall.map.add_points(0, np.array([0], np.int32), np.array([[1.0, 2.0, 3.0]]))
    m = hall.map.columns
    kept = int(made[FAR][0])
    graph.merge_points(m, sure, kept)
    assert m.inverse_sigma[kept] == 0
    np.testing.assert_array_equal(m.position[kept], [1.0, 2.0, 3.0])
