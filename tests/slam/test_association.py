"""Which keypoints see which map points, on made-up maps whose every answer is known."""

from dataclasses import dataclass

import numpy as np
import pytest
from slam_scenes import (
    CAMERA,
    SENSOR,
    add_view,
    descriptors_of,
    features_at,
    flip_bits,
    points_ahead,
    pose_error,
    rigid,
    view_of,
)

from lpslam.camera import transform_points
from lpslam.config import TrackingConfig
from lpslam.slam.association import Associator, View
from lpslam.slam.features import Features
from lpslam.slam.kernels import graph
from lpslam.slam.map import SlamMap

COUNT = 300
CONFIG = TrackingConfig()


@dataclass(frozen=True)
class Scene:
    """A map of points that keyframe 0, at the origin, sees at rows 0 to n-1 as points 0 to n-1."""

    map: SlamMap
    points: np.ndarray
    descriptors: np.ndarray
    associator: Associator

    def view(self, camera_from_world: np.ndarray, random: np.random.Generator, order: np.ndarray) -> Features:
        """The points in another order, as a camera elsewhere sees them, with noise and flipped bits."""
        in_camera = transform_points(camera_from_world, self.points[order])
        pixels = CAMERA.project(in_camera) + random.normal(0, 0.4, (len(order), 2))
        depths = in_camera[:, 2] * (1 + random.normal(0, 0.004, len(order)))
        octaves = self.map.features(0).octave[order]
        return features_at(pixels, depths, flip_bits(random, self.descriptors[order], 10), octaves)


def scene(random: np.random.Generator, confirmed: int = 0) -> Scene:
    """The scene; the first `confirmed` points are seen by a second keyframe as well."""
    points, descriptors = points_ahead(random, COUNT), descriptors_of(random, COUNT)
    slam_map = SlamMap(COUNT, SENSOR.scales)
    add_view(slam_map, np.eye(4), view_of(np.eye(4), points, descriptors), -1)
    slam_map.add_points(0, np.arange(COUNT, dtype=np.int32), points)
    if confirmed:
        beside = rigid([0.1, 0, 0], [0, 0, 0])
        second = add_view(slam_map, beside, view_of(beside, points[:confirmed], descriptors[:confirmed]), 0)
        slot = int(slam_map.columns.keyframe_slot[second])
        graph.link_all(slam_map.columns, np.arange(confirmed, dtype=np.int32), slot)
    graph.refresh_points(slam_map.columns, np.arange(COUNT, dtype=np.int32), SENSOR.scales)
    return Scene(slam_map, points, descriptors, Associator(slam_map, SENSOR, CONFIG))


def moved_camera(random: np.random.Generator) -> np.ndarray:
    return rigid(random.uniform(-0.15, 0.15, 3).tolist(), random.uniform(-0.05, 0.05, 3).tolist())


# Poses -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_the_pose_is_found_among_wrong_matches_and_they_are_named(seed: int) -> None:
    random = np.random.default_rng(seed)
    world, truth, order = scene(random), moved_camera(random), random.permutation(COUNT)
    features = world.view(truth, random, order)
    points = order.astype(np.int32)
    wrong = random.choice(COUNT, COUNT // 5, replace=False)
    points[wrong] = np.roll(points[wrong], 1)
    estimate = world.associator.optimise_on_map(features, np.eye(4), points)
    assert estimate is not None
    metres, radians = pose_error(estimate.camera_from_world, truth)
    assert metres < 0.005
    assert radians < 0.002
    assert set(np.flatnonzero(estimate.points >= 0).tolist()).isdisjoint(wrong.tolist())
    assert estimate.matches == estimate.inliers > 0.7 * COUNT
    np.testing.assert_array_equal(estimate.points[estimate.points >= 0], order[estimate.points >= 0])
    assert estimate.agreement == pytest.approx(estimate.inliers / COUNT)


def test_too_few_matches_are_no_pose() -> None:
    random = np.random.default_rng(5)
    world, truth, order = scene(random), moved_camera(random), np.arange(COUNT)
    features = world.view(truth, random, order)
    points = np.full(COUNT, -1, np.int32)
    points[: CONFIG.min_pose_inliers - 1] = order[: CONFIG.min_pose_inliers - 1]
    assert world.associator.optimise_on_map(features, np.eye(4), points) is None
    assert world.associator.optimise_on_map(features, np.eye(4), np.full(COUNT, -1, np.int32)) is None


def test_matches_of_chance_are_no_pose() -> None:
    random = np.random.default_rng(6)
    world, truth = scene(random), moved_camera(random)
    features = world.view(truth, random, np.arange(COUNT))
    points = random.permutation(COUNT).astype(np.int32)
    estimate = world.associator.optimise_on_map(features, np.eye(4), points)
    assert estimate is None or estimate.matches < CONFIG.min_inliers


@pytest.mark.parametrize("seed", range(3))
def test_what_was_confirmed_decides_against_a_majority_that_moves(seed: int) -> None:
    """Two thirds of the view went half a metre aside: people, seen once; the room was seen by two keyframes."""
    random = np.random.default_rng(seed)
    confirmed = COUNT // 3
    world, truth = scene(random, confirmed), moved_camera(random)
    room, people = np.arange(confirmed), np.arange(confirmed, COUNT)
    still = world.view(truth, random, room)
    walking = world.view(truth @ rigid([0.5, 0.0, 0.2], [0, 0, 0]), random, people)
    features = Features(*(np.concatenate(columns) for columns in zip(still, walking, strict=True)))
    estimate = world.associator.optimise_on_map(features, truth, np.arange(COUNT, dtype=np.int32))
    assert estimate is not None
    assert pose_error(estimate.camera_from_world, truth)[0] < 0.01
    assert (estimate.points[room] >= 0).mean() > 0.85
    assert (estimate.points[people] >= 0).mean() < 0.05
    # The same where the first guess already stands with the people.
    astray = world.associator.optimise_on_map(
        features, truth @ rigid([0.5, 0, 0.2], [0, 0, 0]), np.arange(COUNT, dtype=np.int32)
    )
    assert astray is not None
    assert pose_error(astray.camera_from_world, truth)[0] < 0.01


@pytest.mark.parametrize("seed", range(3))
def test_someone_near_who_steps_aside_does_not_take_the_camera_along(seed: int) -> None:
    """What stands still is far and in one corner of the view: a step with a turn all but explains both."""
    random = np.random.default_rng([7, seed])
    room = random.uniform([-2.5, -0.8, 5.5], [-1.0, 0.4, 6.0], (120, 3))
    person = random.uniform([0.6, -0.8, 2.3], [1.1, 0.8, 2.5], (120, 3))
    points, descriptors = np.concatenate([room, person]), descriptors_of(random, 240)
    slam_map = SlamMap(240, SENSOR.scales)
    add_view(slam_map, np.eye(4), view_of(np.eye(4), points, descriptors), -1)
    slam_map.add_points(0, np.arange(240, dtype=np.int32), points)
    second = add_view(slam_map, np.eye(4), view_of(np.eye(4), room, descriptors[:120]), 0)
    graph.link_all(slam_map.columns, np.arange(120, dtype=np.int32), int(slam_map.columns.keyframe_slot[second]))
    graph.refresh_points(slam_map.columns, np.arange(240, dtype=np.int32), SENSOR.scales)
    now = np.concatenate([room, person + np.array([0.15, 0.0, 0.0])])
    features = features_at(
        CAMERA.project(now) + random.normal(0.0, 0.4, (240, 2)), now[:, 2] * (1 + random.normal(0, 0.03, 240)),
        descriptors, np.zeros(240, np.uint8),
    )  # fmt: skip
    estimate = Associator(slam_map, SENSOR, CONFIG).optimise_on_map(features, np.eye(4), np.arange(240, dtype=np.int32))
    assert estimate is not None
    assert pose_error(estimate.camera_from_world, np.eye(4))[0] < 0.04
    assert (estimate.points[:120] >= 0).mean() > 0.85
    assert (estimate.points[120:] >= 0).mean() < 0.3


def test_keypoints_that_are_not_in_the_map_hold_a_pose_but_are_no_matches() -> None:
    random = np.random.default_rng(8)
    world, truth = scene(random), moved_camera(random)
    features = world.view(truth, random, np.arange(COUNT))
    ids = np.where(np.arange(COUNT) < 40, np.arange(COUNT), -1).astype(np.int32)
    match = np.arange(COUNT, dtype=np.int32)
    estimate = world.associator.optimise(features, np.eye(4), match, world.points, ids)
    assert estimate is not None
    assert pose_error(estimate.camera_from_world, truth)[0] < 0.005
    assert estimate.matches <= 40 < estimate.inliers


# Matches -----------------------------------------------------------------------------------------------------------


def test_descriptors_are_matched_wherever_they_are_in_the_image() -> None:
    random = np.random.default_rng(9)
    world, order = scene(random), random.permutation(COUNT)
    features = world.view(rigid([0.4, -0.2, 0.1], [0.1, 0.3, 0.0]), random, order)
    matched = world.associator.match_descriptors(View.of(features, SENSOR), 0)
    assert (matched >= 0).mean() > 0.95
    np.testing.assert_array_equal(matched[matched >= 0], order[matched >= 0])


def test_a_keyframe_that_is_gone_or_saw_nothing_matches_nothing() -> None:
    random = np.random.default_rng(10)
    world = scene(random, confirmed=100)
    features = world.view(np.eye(4), random, np.arange(COUNT))
    without_points = add_view(world.map, np.eye(4), features, 0)
    world.map.remove_keyframe(1)
    for keyframe in (1, without_points):
        matched = world.associator.match_descriptors(View.of(features, SENSOR), keyframe)
        np.testing.assert_array_equal(matched, np.full(COUNT, -1))


def test_predicted_points_are_those_in_view_at_their_pixels() -> None:
    random = np.random.default_rng(11)
    world = scene(random)
    camera = rigid([0.1, 0, 0.1], [0, 0.25, 0])
    predicted = world.associator.predict(np.arange(COUNT, dtype=np.int32), camera)
    pixels = CAMERA.project(transform_points(camera, world.points))
    inside = ((pixels >= 0) & (pixels < [CAMERA.width, CAMERA.height])).all(axis=1)
    assert 50 < inside.sum() < COUNT
    assert set(predicted.points.tolist()) <= set(np.flatnonzero(inside).tolist())
    assert len(predicted.points) > 0.95 * inside.sum()
    np.testing.assert_allclose(predicted.projections[:, :2], pixels[predicted.points], atol=0.01)
    behind = world.associator.predict(np.arange(COUNT, dtype=np.int32), rigid([0, 0, 0], [0, np.pi, 0]))
    assert len(behind.points) == 0


def test_predicted_points_are_matched_near_their_projection_only() -> None:
    random = np.random.default_rng(12)
    world, order, everything = scene(random), random.permutation(COUNT), np.arange(COUNT, dtype=np.int32)
    view = View.of(world.view(np.eye(4), random, order), SENSOR)
    predicted = world.associator.predict(everything, np.eye(4))
    matched = world.associator.match_predicted(view, predicted, np.zeros(COUNT, np.bool_))
    assert (matched >= 0).mean() > 0.9
    np.testing.assert_array_equal(matched[matched >= 0], order[matched >= 0])
    taken = np.arange(COUNT) % 2 == 0
    half = world.associator.match_predicted(view, predicted, taken)
    assert (half[taken] == -1).all()
    assert (half[~taken] >= 0).mean() > 0.9
    # Ten pixels off is outside the narrow windows and inside those that are widened.
    turned = world.associator.predict(everything, rigid([0, 0, 0], [0, 10 / CAMERA.fx, 0]))
    assert (world.associator.match_predicted(view, turned, np.zeros(COUNT, np.bool_)) >= 0).mean() < 0.1
    wide = world.associator.match_predicted(view, turned, np.zeros(COUNT, np.bool_), widening=5.0)
    assert (wide >= 0).mean() > 0.5
    np.testing.assert_array_equal(wide[wide >= 0], order[wide >= 0])


def test_nothing_predicted_matches_nothing() -> None:
    random = np.random.default_rng(13)
    world = scene(random)
    view = View.of(world.view(np.eye(4), random, np.arange(COUNT)), SENSOR)
    predicted = world.associator.predict(np.empty(0, np.int32), np.eye(4))
    matched = world.associator.match_predicted(view, predicted, np.zeros(COUNT, np.bool_))
    np.testing.assert_array_equal(matched, np.full(COUNT, -1))


# Neighbourhood -----------------------------------------------------------------------------------------------------


def chain(shared: list[int]) -> tuple[SlamMap, Associator]:
    """Keyframes in a row; number i + 1 sees the last `shared[i]` new points of number i, and 60 new ones."""
    random = np.random.default_rng(14)
    slam_map = SlamMap(200, SENSOR.scales)
    before = np.empty(0, np.int32)
    for number, common in enumerate([0, *shared]):
        positions = points_ahead(random, 60 + common)
        add_view(slam_map, np.eye(4), view_of(np.eye(4), positions, descriptors_of(random, 60 + common)), number - 1)
        held = np.full(60 + common, -1, np.int32)
        held[:common] = before[len(before) - common :]
        graph.link_all(slam_map.columns, held, int(slam_map.columns.keyframe_slot[number]))
        first = slam_map.add_points(number, np.arange(common, 60 + common, dtype=np.int32), positions[common:])
        before = np.arange(first, first + 60, dtype=np.int32)
    return slam_map, Associator(slam_map, SENSOR, CONFIG)


def test_around_are_those_that_share_most_and_then_their_neighbours() -> None:
    slam_map, associator = chain([30, 20, 10, 5])
    seen = np.append(slam_map.columns.point[2, :80], -1).astype(np.int32)
    # Keyframe 2 itself with 80 points, then 1 with 20 and 3 with 10; then those next to them: 0 with 30 and 4 with 5.
    assert associator.around(seen, 10).tolist() == [2, 1, 3, 0, 4]
    assert associator.around(seen, 3).tolist() == [2, 1, 3]
    assert associator.around(seen, 4).tolist() == [2, 1, 3, 0]


def test_around_nothing_is_nobody() -> None:
    _, associator = chain([30])
    assert associator.around(np.full(5, -1, np.int32), 10).tolist() == []
