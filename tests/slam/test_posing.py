"""The pose on which most of what a view sees agrees: random few, judged by all."""

from dataclasses import dataclass

import numpy as np
import pytest
from slam_scenes import CAMERA, SENSOR, add_view, descriptors_of, features_at, points_ahead, pose_error, rigid, view_of

from lpslam.camera import transform_points
from lpslam.config import TrackingConfig
from lpslam.slam.features import Features
from lpslam.slam.kernels import graph
from lpslam.slam.kernels.hypotheses import PointSights, best_hypothesis, truncated_cost
from lpslam.slam.kernels.rays import NO_RAYS
from lpslam.slam.kernels.reprojection import CHI2_DEPTH, CHI2_PIXEL
from lpslam.slam.map import SlamMap
from lpslam.slam.posing import Posing, Sights

DRAWS = np.random.default_rng(1).random((300, 6))


@dataclass(frozen=True)
class Seen:
    """A map of points that two keyframes saw, and a view of some of them that stand elsewhere now."""

    map: SlamMap
    features: Features
    sights: Sights


def seen(points: np.ndarray, now: np.ndarray, camera_from_world: np.ndarray, random: np.random.Generator) -> Seen:
    """Points (n, 3) that stood there when the map was made, and stand at `now` (n, 3) in the view."""
    count = len(points)
    descriptors, slam_map = descriptors_of(random, count), SlamMap(count, SENSOR.scales)
    add_view(slam_map, np.eye(4), view_of(np.eye(4), points, descriptors), -1)
    slam_map.add_points(0, np.arange(count, dtype=np.int32), points)
    beside = rigid([0.1, 0, 0], [0, 0, 0])
    second = add_view(slam_map, beside, view_of(beside, points, descriptors), 0)
    ids = np.arange(count, dtype=np.int32)
    graph.link_all(slam_map.columns, ids, int(slam_map.columns.keyframe_slot[second]))
    graph.refresh_points(slam_map.columns, ids, SENSOR.scales)
    in_camera = transform_points(camera_from_world, now)
    pixels = CAMERA.project(in_camera) + random.normal(0, 0.4, (count, 2))
    depths = in_camera[:, 2] * (1 + random.normal(0, 0.004, count))
    features = features_at(pixels, depths, descriptors, np.zeros(count, np.uint8))
    return Seen(slam_map, features, Sights(np.arange(count), points, np.zeros(count), ids))


@pytest.mark.parametrize("seed", range(4))
def test_a_crowd_of_keypoints_on_one_who_walks_is_one_witness(seed: int) -> None:
    """Three of four keypoints are on two coats that go their own ways; both keyframes saw everyone stand."""
    random = np.random.default_rng([31, seed])
    room = random.uniform([-2.0, -1.2, 2.5], [2.0, 1.2, 5.0], (60, 3))
    coats = [random.uniform([x, -0.5, 2.0], [x + 0.4, 0.4, 2.2], (90, 3)) for x in (-0.8, 0.5)]
    steps = [np.array([0.12, 0.0, 0.0]), np.array([0.02, 0.0, 0.15])]
    points = np.concatenate([room, *coats])
    now = np.concatenate([room, *(coat + step for coat, step in zip(coats, steps, strict=True))])
    truth = rigid([0.05, 0.0, -0.04], [0.0, 0.02, 0.0])
    world = seen(points, now, truth, random)
    found, agreeing = Posing(world.map, SENSOR, TrackingConfig()).find(world.features, np.eye(4), world.sights)
    assert pose_error(found, truth)[0] < 0.015
    assert (agreeing < 60).mean() > 0.9


@pytest.mark.parametrize("seed", range(3))
def test_where_all_stands_still_it_is_the_least_squares_of_all(seed: int) -> None:
    random = np.random.default_rng([32, seed])
    points, truth = points_ahead(random, 200), rigid([0.05, 0.02, -0.04], [0.01, 0.02, 0.0])
    world = seen(points, points, truth, random)
    found, agreeing = Posing(world.map, SENSOR, TrackingConfig()).find(world.features, np.eye(4), world.sights)
    assert pose_error(found, truth)[0] < 0.003
    assert len(agreeing) > 180


def sights_at(points: np.ndarray, camera_from_world: np.ndarray, random: np.random.Generator) -> PointSights:
    in_camera = transform_points(camera_from_world, points)
    pixels = (CAMERA.project(in_camera) + random.normal(0, 0.4, (len(points), 2))).astype(np.float32)
    disparity = (SENSOR.intrinsics[4] / in_camera[:, 2]).astype(np.float32)
    ones = np.ones(len(points), np.float32)
    return PointSights(points, pixels, disparity, np.ones(len(points), np.bool_), ones, ones)


@pytest.mark.parametrize("wrong", [0.3, 0.6])
def test_a_pose_is_found_among_many_wrong_pairs(wrong: float) -> None:
    random = np.random.default_rng(33)
    points, truth = points_ahead(random, 150), rigid([0.3, -0.1, 0.2], [0.05, 0.1, -0.05])
    near, count = sights_at(points, truth, random), int(150 * wrong)
    near.pixels[:count] = random.permutation(near.pixels[:count]) + random.uniform(20, 60, (count, 2))
    weight = np.ones(150)
    found, cost = best_hypothesis(np.eye(4), near, NO_RAYS, weight, SENSOR.intrinsics, DRAWS)
    assert pose_error(found, truth)[0] < 0.03
    assert cost <= truncated_cost(np.eye(4), near, NO_RAYS, weight, SENSOR.intrinsics, np.inf)
    assert cost == pytest.approx(truncated_cost(found, near, NO_RAYS, weight, SENSOR.intrinsics, np.inf))


def test_no_sight_costs_more_than_an_outlier_does() -> None:
    random = np.random.default_rng(34)
    near = sights_at(points_ahead(random, 50), np.eye(4), random)
    away = rigid([0, 0, -100.0], [0, 0, 0])
    most = 50 * (CHI2_PIXEL + CHI2_DEPTH)
    assert truncated_cost(away, near, NO_RAYS, np.ones(50), SENSOR.intrinsics, np.inf) == pytest.approx(most)
    assert truncated_cost(away, near, NO_RAYS, np.ones(50), SENSOR.intrinsics, 30.0) <= 30.0 + CHI2_PIXEL + CHI2_DEPTH
