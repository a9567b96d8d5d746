"""Points from two views: geometry, matching along epipolar lines, and what they are worth where depth ends early."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rendered_walk import FRAMES, RenderedWalk
from slam_scenes import (
    CAMERA,
    SENSOR,
    add_view,
    check_graph,
    descriptors_of,
    features_at,
    flip_bits,
    hamming_table,
    observations_of,
    points_ahead,
    rigid,
)

from lpslam.camera import transform_points
from lpslam.config import FarPointConfig, MappingConfig, SlamConfig, TrackingConfig
from lpslam.evaluation.trajectory import AteResult, absolute_trajectory_error
from lpslam.frames import RgbdFrame
from lpslam.poses import StampedPoses
from lpslam.slam.features import Features
from lpslam.slam.kernels import graph
from lpslam.slam.kernels.triangulation import Rays, match_epipolar
from lpslam.slam.map import SlamMap
from lpslam.slam.mapping.triangulation import Triangulator, intersect_rays
from lpslam.slam.system import RgbdSlam

seeds = st.integers(0, 2**32 - 1)
SIDEWAYS = rigid([-0.5, 0.05, 0.1], [0.02, -0.06, 0.03])
"""camera from world of a second camera, half a metre to the right of a first one that stands in the origin."""


# Rays --------------------------------------------------------------------------------------------------------------


@given(seeds)
def test_rays_meet_at_the_point_that_they_were_drawn_to(seed: int) -> None:
    random = np.random.default_rng(seed)
    points = points_ahead(random, 50)
    centres = random.uniform(-1, 1, (50, 3))
    away = np.linalg.norm(np.cross(points, centres), axis=1) > 0.05
    points, centres = points[away], centres[away]
    first, second = random.uniform(0.3, 3, (2, len(points), 1))
    meeting = intersect_rays(points / first, (points - centres) / second, centres)
    np.testing.assert_allclose(meeting.points, points, atol=1e-8)
    np.testing.assert_allclose(meeting.first, first[:, 0], rtol=1e-6)
    np.testing.assert_allclose(meeting.second, second[:, 0], rtol=1e-6)
    to_points, to_centres = points, points - centres
    cosines = (to_points * to_centres).sum(axis=1) / np.linalg.norm(to_points, axis=1)
    cosines /= np.linalg.norm(to_centres, axis=1)
    np.testing.assert_allclose(meeting.sine**2 + cosines**2, 1, atol=1e-9)


def test_skew_rays_meet_halfway_between_them() -> None:
    meeting = intersect_rays(np.array([[0.0, 0.0, 1.0]]), np.array([[-1.0, 0.0, 1.0]]), np.array([[2.0, 0.1, 0.0]]))
    np.testing.assert_allclose(meeting.points, [[0, 0.05, 2]], atol=1e-12)
    np.testing.assert_allclose([meeting.first, meeting.second], [[2], [2]])


def test_rays_that_part_meet_behind_the_camera_and_parallel_ones_nowhere() -> None:
    forward, outward = np.array([[0.0, 0.0, 1.0]]), np.array([[0.2, 0.0, 1.0]])
    beside = np.array([[0.5, 0.0, 0.0]])
    parting = intersect_rays(forward, outward, beside)
    assert parting.first[0] < 0
    parallel = intersect_rays(forward, forward, beside)
    assert parallel.sine[0] == 0
    assert not np.isfinite(parallel.points).all()


# Epipolar lines ----------------------------------------------------------------------------------------------------


def matched_by_definition(
    own: Rays, other: Rays, other_from_own: np.ndarray, gates: np.ndarray, max_distance: int, ratio: float
) -> np.ndarray:
    """All pairs: the distance from the line by the fundamental matrix, and the half-plane by the plane's normals."""
    rotation, shift = other_from_own[:3, :3], other_from_own[:3, 3]
    to_pixel = np.array([[CAMERA.fx, 0, CAMERA.cx], [0, CAMERA.fy, CAMERA.cy], [0, 0, 1]])
    turned = own.direction @ rotation.T
    normals = np.cross(shift, turned)
    lines = normals @ np.linalg.inv(to_pixel)
    off = (other.direction @ to_pixel.T) @ lines.T / np.hypot(lines[:, 0], lines[:, 1])
    same_side = np.cross(shift, other.direction) @ normals.T > 0
    close = same_side & (off**2 <= gates[other.octave][:, None] + gates[own.octave])
    table = hamming_table(other.descriptor, own.descriptor)
    match = np.full(len(off), -1)
    for j in range(len(off)):
        near = np.flatnonzero(close[j])
        distances = np.sort(table[j, near])
        if not len(near) or distances[0] > max_distance:
            continue
        best = near[table[j, near].argmin()]
        rivals = np.delete(near, table[j, near].argmin())
        if len(rivals):
            rival = rivals[table[j, rivals].argmin()]
            if own.octave[rival] == own.octave[best] and distances[0] > ratio * distances[1]:
                continue
        owner = np.flatnonzero(match == best)
        if len(owner) and table[owner[0], best] <= table[j, best]:
            continue
        match[owner] = -1
        match[j] = best
    return match


MOTIONS = {
    "sideways": rigid([-0.5, 0.05, 0.1], [0.02, -0.06, 0.03]),
    "up": rigid([0.0, 0.4, 0.0], [0.1, 0.0, 0.0]),
    "forward": rigid([0.01, 0.02, -0.6], [0.0, 0.05, 0.02]),
    "backward": rigid([0.0, -0.05, 0.6], [0.1, 0.0, 0.5]),
}


@settings(max_examples=40)
@given(seeds, st.sampled_from(sorted(MOTIONS)), st.integers(0, 150), st.sampled_from([20, 50]))
def test_matches_are_those_of_the_definition(seed: int, motion: str, count: int, max_distance: int) -> None:
    random = np.random.default_rng(seed)
    other_from_own = MOTIONS[motion]
    points = points_ahead(random, count, 1.0, 4.0)
    common = descriptors_of(random, 1)
    descriptors = flip_bits(random, np.repeat(common, count, axis=0), 20)
    views = []
    for pose, bits in ((np.eye(4), 0), (other_from_own, 12)):
        in_camera = transform_points(pose, points)
        in_camera[:, 2] = np.abs(in_camera[:, 2]) + 0.1
        pixels = CAMERA.project(in_camera) + random.normal(0, 2, (count, 2))
        rays = CAMERA.back_project(pixels, np.ones(count))
        octaves = random.integers(0, 2, count).astype(np.uint8)
        views.append(Rays(rays, octaves, flip_bits(random, descriptors, bits)))
    gates = np.full(8, 20.0)
    arguments = (*views, other_from_own)
    expected = matched_by_definition(*arguments, gates, max_distance, 0.8)
    found = match_epipolar(*arguments, (CAMERA.fx, CAMERA.fy), gates, max_distance, 0.8)
    # Which of equally near candidates is met first is open.
    table = hamming_table(views[1].descriptor, views[0].descriptor)
    differing = np.flatnonzero(found != expected)
    assert len(differing) <= 0.02 * count + 1, f"{len(differing)} of {count} differ"
    assert (table[found >= 0, found[found >= 0]] <= max_distance).all()
    assert len(set(found[found >= 0].tolist())) == np.count_nonzero(found >= 0)


def test_views_from_the_same_place_match_nothing() -> None:
    random = np.random.default_rng(1)
    rays = Rays(points_ahead(random, 20), np.zeros(20, np.uint8), descriptors_of(random, 20))
    found = match_epipolar(rays, rays, rigid([0, 0, 0], [0, 0.2, 0]), (500.0, 500.0), np.full(8, 4.0), 50, 0.8)
    np.testing.assert_array_equal(found, -1)


# Points in the map -------------------------------------------------------------------------------------------------


class Pair:
    """Two keyframes, covisible by near points with depth, that also see far points without."""

    def __init__(self, seed: int, second_from_world: np.ndarray = SIDEWAYS, far: tuple[float, float] = (3, 6)) -> None:
        self.random = np.random.default_rng(seed)
        self.second_from_world = second_from_world
        near = points_ahead(self.random, 60, 1, 2.5)
        beyond = points_ahead(self.random, 400, *far)
        seen = CAMERA.project(transform_points(second_from_world, beyond))
        inside = ((seen > 5) & (seen < [CAMERA.width - 5, CAMERA.height - 5])).all(axis=1)
        self.far = beyond[inside][:120]
        self.near_count = len(near)
        self.points = np.concatenate([near, self.far])
        self.descriptors = descriptors_of(self.random, len(self.points))
        self.views = [self.view(np.eye(4)), self.view(second_from_world)]

    def view(self, camera_from_world: np.ndarray) -> Features:
        in_camera = transform_points(camera_from_world, self.points)
        depths = np.where(np.arange(len(self.points)) < self.near_count, in_camera[:, 2], 0)
        return features_at(CAMERA.project(in_camera), depths, flip_bits(self.random, self.descriptors, 5))

    def triangulate(self, config: MappingConfig | None = None) -> tuple[SlamMap, np.ndarray]:
        slam_map = SlamMap(len(self.points), SENSOR.scales)
        add_view(slam_map, np.eye(4), self.views[0], -1)
        add_view(slam_map, self.second_from_world, self.views[1], 0)
        rows = np.arange(self.near_count, dtype=np.int32)
        slam_map.add_points(0, rows, self.points[rows])
        shared = np.full(len(self.points), -1, np.int32)
        shared[rows] = rows
        graph.link_all(slam_map.columns, shared, 1)
        made = Triangulator(slam_map, SENSOR, config or MappingConfig()).process(1)
        check_graph(slam_map)
        return slam_map, made

    def errors(self, slam_map: SlamMap, made: np.ndarray) -> np.ndarray:
        """Metres between new points and the truth; each must be seen by the two keypoints of one true point."""
        m = slam_map.columns
        features = []
        for point in made.tolist():
            seen = list(observations_of(m, point))
            assert sorted(slot for slot, _ in seen) == [0, 1]
            assert len({feature for _, feature in seen}) == 1, f"point {point} was matched wrongly"
            features.append(seen[0][1])
        return np.asarray(np.linalg.norm(m.position[made] - self.points[features], axis=1))


@given(seeds)
def test_what_two_keyframes_see_without_depth_becomes_points_where_they_stand(seed: int) -> None:
    pair = Pair(seed)
    slam_map, made = pair.triangulate()
    assert len(made) > 0.9 * len(pair.far)
    assert pair.errors(slam_map, made).max() < 1e-3
    m = slam_map.columns
    assert (m.observations[made] == 2).all()
    assert (m.first_keyframe[made] == 1).all()
    np.testing.assert_allclose(np.linalg.norm(m.normal[made], axis=1), 1, rtol=1e-5)


@pytest.mark.parametrize("ahead", [0.6, -0.6])
def test_walking_towards_things_makes_points_of_those_aside(ahead: float) -> None:
    pair = Pair(14, second_from_world=rigid([0.0, 0.0, -ahead], [0.01, -0.01, 0.05]))
    slam_map, made = pair.triangulate()
    assert len(made) > 0.5 * len(pair.far)
    assert pair.errors(slam_map, made).max() < 1e-2


def test_noise_of_half_a_pixel_moves_points_by_no_more_than_the_rays_allow() -> None:
    pair = Pair(4)
    for view in pair.views:
        view.pixels[:] += pair.random.normal(0, 0.5, view.pixels.shape)
    slam_map, made = pair.triangulate()
    assert len(made) > 0.75 * len(pair.far)
    errors = pair.errors(slam_map, made)
    depths = np.linalg.norm(slam_map.columns.position[made], axis=1)
    # Half a pixel in both views over 0.5 m of baseline: z² σ √2 / (f b).
    expected = depths**2 * 0.5 * np.sqrt(2) / (525 * 0.5)
    assert 0.4 < np.sqrt(np.mean((errors / expected) ** 2)) < 1.6


def test_points_too_far_for_the_baseline_are_not_made() -> None:
    pair = Pair(5, far=(40, 60))
    assert len(pair.triangulate()[1]) == 0
    # Half a degree of parallax is enough for whoever believes it.
    assert len(pair.triangulate(MappingConfig(max_depth_uncertainty=1.0))[1]) > 0.8 * len(pair.far)


def test_a_camera_that_turned_on_the_spot_makes_no_points() -> None:
    pair = Pair(6, second_from_world=rigid([0.01, 0.0, 0.0], [0.0, 0.15, 0.0]))
    assert len(pair.triangulate()[1]) == 0


def test_none_are_made_where_the_configuration_says_so() -> None:
    assert len(Pair(7).triangulate(MappingConfig(triangulated_neighbours=0))[1]) == 0


def test_a_far_reading_serves_where_the_rays_are_nearly_parallel() -> None:
    pair = Pair(8, second_from_world=rigid([-0.1, 0.0, 0.0], [0.0, 0.0, 0.0]), far=(5, 7))
    assert len(pair.triangulate()[1]) == 0
    read = pair.points[:, 2].astype(np.float32)
    disparity = (SENSOR.intrinsics[4] / read).astype(np.float32)
    first = pair.views[0]
    pair.views[0] = first._replace(
        depth=read, has_depth=np.ones(len(read), np.bool_), u_right=first.pixels[:, 0] - disparity
    )
    slam_map, made = pair.triangulate()
    assert len(made) > 0.9 * len(pair.far)
    assert pair.errors(slam_map, made).max() < 1e-3


def test_a_reading_that_contradicts_the_rays_refuses_the_point() -> None:
    pair = Pair(9)
    first = pair.views[0]
    wrong = np.where(first.has_depth, first.depth, 0.7 * pair.points[:, 2]).astype(np.float32)
    disparity = (SENSOR.intrinsics[4] / wrong).astype(np.float32)
    pair.views[0] = first._replace(
        depth=wrong, has_depth=np.ones(len(wrong), np.bool_), u_right=first.pixels[:, 0] - disparity
    )
    assert len(pair.triangulate()[1]) < 0.05 * len(pair.far)


def test_keypoints_of_other_sizes_are_not_the_same_thing() -> None:
    pair = Pair(10)
    pair.views[0].octave[:] = 6
    assert len(pair.triangulate()[1]) == 0
    assert len(pair.triangulate(MappingConfig(scale_tolerance=5.0))[1]) > 0.5 * len(pair.far)


def test_alike_keypoints_of_different_things_seldom_become_points() -> None:
    """Every far keypoint looks like another thing's: only those that lie near the epipolar line by chance pass."""
    pair = Pair(11)
    shuffled = np.arange(len(pair.points))
    shuffled[pair.near_count :] = pair.near_count + pair.random.permutation(len(pair.far))
    second = pair.views[1]
    pair.views[1] = second._replace(descriptor=np.ascontiguousarray(second.descriptor[shuffled]))
    _, made = pair.triangulate()
    assert len(made) < 0.05 * len(pair.far)


def test_keypoints_that_turned_another_way_are_refused() -> None:
    pair = Pair(12)
    turned = pair.near_count + np.arange(0, len(pair.far), 4)
    pair.views[1].angle[turned] += np.linspace(0.7, 5.5, len(turned), dtype=np.float32)
    slam_map, made = pair.triangulate()
    features = {feature for point in made.tolist() for _, feature in observations_of(slam_map.columns, point)}
    assert len(features & set(turned.tolist())) < 0.15 * len(turned)
    assert len(made) > 0.6 * len(pair.far)


def test_points_of_a_world_that_was_corrected_meanwhile_are_thrown_away(monkeypatch: pytest.MonkeyPatch) -> None:
    solve = Triangulator._intersect

    def solve_while_a_loop_is_closed(self: Triangulator, *arguments: object) -> object:
        self._map.version += 1
        return solve(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(Triangulator, "_intersect", solve_while_a_loop_is_closed)
    slam_map, made = Pair(13).triangulate()
    assert len(made) == 0
    assert len(slam_map.living_points()) == 60


# What they are worth -----------------------------------------------------------------------------------------------


WALK = FRAMES


class Walk:
    """A rendered walk, seen with less depth."""

    def __init__(self, rendered: RenderedWalk) -> None:
        self.camera, self.frames, self.truth = rendered.camera, rendered.frames, rendered.truth

    def seen_to(self, reach: float, after: int) -> list[RgbdFrame]:
        """The frames without any depth beyond `reach` metres from some frame on."""
        return [
            frame
            if frame.index < after
            else replace(frame, depth=np.where(frame.depth < reach, frame.depth, 0).astype(np.float32))
            for frame in self.frames
        ]

    def track(self, frames: list[RgbdFrame], neighbours: int, far_points: int = 0) -> tuple[int, AteResult]:
        """How many frames are tracked with so many neighbours searched for new points, and how well.

        Nothing carries the camera where the map does not hold it.
        """
        config = SlamConfig(
            mapping=MappingConfig(triangulated_neighbours=neighbours),
            far_points=FarPointConfig(most=far_points),
            tracking=TrackingConfig(coast_seconds=0.0),
        )
        slam = RgbdSlam(self.camera, config)
        tracked = [slam.process(frame).is_tracked for frame in frames]
        slam.finish()
        check_graph(slam.map)
        estimate = StampedPoses(*slam.trajectory.world_from_camera(slam.map))
        return sum(tracked), absolute_trajectory_error(self.truth, estimate)


@pytest.fixture(scope="module")
def walk(rendered_walk: RenderedWalk) -> Walk:
    return Walk(rendered_walk)


@pytest.mark.parametrize(("far_points", "starts"), [(0, 1), (150, 3)])
def test_a_sensor_that_sees_three_metres_is_enough(walk: Walk, far_points: int, starts: int) -> None:
    """The median of three starts where far points take part: one frame less at the start changes the error by half."""
    frames = walk.seen_to(3.0, after=1)
    errors = []
    for start in range(starts):
        tracked, error = walk.track(frames[start:], 10, far_points)
        assert tracked == WALK - start
        # One followed frame may be off: before a plain wall a step and a turn look alike.
        assert error.max < 0.05
        assert np.sort(error.errors)[-2] < 0.025
        errors.append(error.rmse)
    assert np.median(errors) < 0.01


def test_points_known_by_direction_alone_hold_the_way_as_well(walk: Walk) -> None:
    """If less well: keyframes are not searched for what both see, so that fewer of these points get a place."""
    tracked, error = walk.track(walk.seen_to(3.0, after=1), 0, 150)
    assert tracked == WALK
    assert error.rmse < 0.04


def test_a_sensor_that_sees_less_is_not_enough_without_points_beyond(walk: Walk) -> None:
    frames = walk.seen_to(2.8, after=1)
    # Flow carries some frames over, and the way is lost sooner or later.
    tracked, error = walk.track(frames, 0)
    assert tracked < WALK
    assert error.count < 0.95 * WALK


def test_when_depth_fails_for_good_the_map_goes_on_growing(walk: Walk) -> None:
    tracked, error = walk.track(walk.seen_to(0.0, after=10), 10)
    assert tracked == WALK
    assert error.rmse < 0.02
    assert error.max < 0.05


def test_where_depth_is_good_triangulation_does_no_harm(walk: Walk) -> None:
    tracked, error = walk.track(walk.frames, 10)
    assert tracked == WALK
    assert error.rmse < 0.008
    assert error.max < 0.02
