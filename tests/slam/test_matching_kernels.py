import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from slam_scenes import (
    BASELINE_FX,
    CAMERA,
    SENSOR,
    descriptors_of,
    features_at,
    flip_bits,
    hamming_table,
    rigid,
)

from lpslam.camera import inverse_transform, transform_points
from lpslam.slam.features import Features
from lpslam.slam.kernels import matching

CELL = matching.GRID_CELL
seeds = st.integers(0, 2**32 - 1)


def keypoints_of(features: Features) -> matching.Keypoints:
    starts, order, size = matching.build_grid(features.pixels, CAMERA.width, CAMERA.height)
    return matching.Keypoints(
        features.pixels, features.u_right, features.has_depth, features.octave, features.descriptor, starts, order, size
    )


def random_features(random: np.random.Generator, count: int, spill: float = 30.0) -> Features:
    """Keypoints in and a little outside the image, some without depth, on eight levels, with alike descriptors."""
    pixels = random.uniform([-spill, -spill], [CAMERA.width + spill, CAMERA.height + spill], (count, 2))
    depths = np.where(random.random(count) < 0.7, random.uniform(0.5, 6, count), 0.0)
    descriptors = flip_bits(random, np.repeat(descriptors_of(random, 1), count, axis=0), 30)
    return features_at(pixels, depths, descriptors, random.integers(0, 8, count), random.uniform(0, 6.28, count))


# The grid ----------------------------------------------------------------------------------------------------------


@given(seeds, st.integers(0, 300), st.sampled_from([(640, 480), (33, 31), (32, 32), (1, 1), (65, 640)]))
def test_the_grid_buckets_every_keypoint_once_where_it_lies(seed: int, count: int, size: tuple[int, int]) -> None:
    width, height = size
    pixels = np.random.default_rng(seed).uniform(-40, [width + 40, height + 40], (count, 2)).astype(np.float32)
    starts, order, (columns, rows) = matching.build_grid(pixels, width, height)
    assert (columns, rows) == (-(-width // CELL), -(-height // CELL))
    assert starts[0] == 0
    assert starts[-1] == count
    assert (np.diff(starts) >= 0).all()
    assert sorted(order.tolist()) == list(range(count))
    column = np.clip(np.floor(pixels[:, 0] / CELL), 0, columns - 1)
    row = np.clip(np.floor(pixels[:, 1] / CELL), 0, rows - 1)
    bucket = np.repeat(np.arange(rows * columns), np.diff(starts))
    np.testing.assert_array_equal(bucket, (row * columns + column)[order])
    for cell in range(rows * columns):
        assert (np.diff(order[starts[cell] : starts[cell + 1]]) > 0).all()


# Windows -----------------------------------------------------------------------------------------------------------


def windows_by_definition(
    projections: np.ndarray,
    radii: np.ndarray,
    lowest: np.ndarray,
    highest: np.ndarray,
    descriptors: np.ndarray,
    keypoints: matching.Keypoints,
    taken: np.ndarray,
    max_distance: int,
    ratio: float,
) -> np.ndarray:
    """Every projection against every keypoint; the grid only decides which of equals comes first."""
    table = hamming_table(descriptors, keypoints.descriptor)
    away = np.abs(keypoints.pixels[None] - projections[:, None, :2]).max(axis=2)
    right = np.abs(keypoints.u_right[None] - projections[:, None, 2])
    allowed = (away <= radii[:, None]) & ~taken[None]
    allowed &= ~keypoints.has_depth[None] | (right <= radii[:, None])
    allowed &= (keypoints.octave[None] >= lowest[:, None]) & (keypoints.octave[None] <= highest[:, None])
    match = np.full(len(keypoints.octave), -1)
    for i in range(len(projections)):
        order = [j for j in keypoints.grid_order if allowed[i, j]]
        order.sort(key=lambda j, i=i: table[i, j])  # stable: of equals the first in the grid
        if not order or table[i, order[0]] > max_distance:
            continue
        best = order[0]
        if len(order) > 1:
            second_distance = table[i, order[1]]
            level = keypoints.octave[order[1]]
            if level == keypoints.octave[best] and table[i, best] > ratio * second_distance:
                continue
        if match[best] < 0 or table[i, best] < table[match[best], best]:
            match[best] = i
    return match


@settings(max_examples=60)
@given(
    seeds, st.integers(0, 250), st.integers(0, 120), st.sampled_from([0.7, 0.8, 1.0]), st.sampled_from([40, 60, 100])
)
def test_windows_find_what_an_exhaustive_search_finds(
    seed: int, keypoint_count: int, count: int, ratio: float, max_distance: int
) -> None:
    random = np.random.default_rng(seed)
    features = random_features(random, keypoint_count)
    keypoints = keypoints_of(features)
    projections = random.uniform([-60, -60, -60], [CAMERA.width + 60, CAMERA.height + 60, CAMERA.width], (count, 3))
    if keypoint_count and count:
        # Most lie near a keypoint, some exactly on one.
        near = random.integers(0, keypoint_count, count)
        around = np.column_stack([features.pixels[near], features.u_right[near]])
        projections = np.where(random.random((count, 1)) < 0.8, around + random.normal(0, 8, (count, 3)), projections)
    radii = random.uniform(1, 50, count).astype(np.float32)
    lowest = random.integers(-1, 7, count).astype(np.int32)
    arguments = (
        projections.astype(np.float32), radii, lowest, lowest + random.integers(0, 3, count).astype(np.int32),
        flip_bits(random, np.repeat(descriptors_of(random, 1), count, axis=0), 20) if seed % 3 else
        flip_bits(random, features.descriptor[random.integers(0, max(keypoint_count, 1), count)], 12)
        if keypoint_count else descriptors_of(random, count),
        keypoints, random.random(keypoint_count) < 0.2, max_distance, ratio,
    )  # fmt: skip
    np.testing.assert_array_equal(matching.search_windows(*arguments), windows_by_definition(*arguments))


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_a_rival_too_far_to_match_still_makes_the_best_ambiguous_in_any_order(order: list[int]) -> None:
    descriptor = np.zeros((1, 4), np.uint64)
    rivals = flip_bits(np.random.default_rng(0), np.repeat(descriptor, 2, axis=0), 90)
    rivals[1] = flip_bits(np.random.default_rng(0), descriptor, 105)[0]
    features = features_at(np.array([[100.0, 100.0], [102.0, 100.0]]), np.zeros(2), rivals[order])
    match = matching.search_windows(
        np.array([[101, 100, 0]], np.float32), np.array([5], np.float32), np.zeros(1, np.int32), np.zeros(1, np.int32),
        descriptor, keypoints_of(features), np.zeros(2, np.bool_), 100, 0.8,
    )  # fmt: skip
    np.testing.assert_array_equal(match, -1)


def test_a_known_shift_is_found_through_the_windows() -> None:
    random = np.random.default_rng(1)
    count = 300
    pixels = random.uniform([40, 40], [600, 440], (count, 2))
    descriptors = descriptors_of(random, count)
    features = features_at(pixels, np.full(count, 2.0), flip_bits(random, descriptors, 20))
    projections = np.column_stack([pixels, pixels[:, 0] - BASELINE_FX / 2.0]) + np.array([4.0, -3.0, 4.0])
    shuffle = random.permutation(count)
    match = matching.search_windows(
        projections[shuffle].astype(np.float32), np.full(count, 5, np.float32), np.full(count, -1, np.int32),
        np.full(count, 1, np.int32), descriptors[shuffle], keypoints_of(features), np.zeros(count, np.bool_), 100, 0.8,
    )  # fmt: skip
    np.testing.assert_array_equal(shuffle[match], np.arange(count))


# Projection --------------------------------------------------------------------------------------------------------


def candidates(
    positions: np.ndarray, normals: np.ndarray, ranges: np.ndarray, camera_from_world: np.ndarray, ids: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    return matching.project_candidates(
        ids.astype(np.int32), positions, normals.astype(np.float32), ranges.astype(np.float32), camera_from_world,
        SENSOR.intrinsics, SENSOR.image_size, 8, SENSOR.log_scale, 0.5,
    )  # fmt: skip


@settings(max_examples=60)
@given(seeds)
def test_candidates_are_those_in_view_in_range_and_from_a_seen_side(seed: int) -> None:
    random = np.random.default_rng(seed)
    count = 400
    camera_from_world = rigid([*random.uniform(-2, 2, 3)], [*random.uniform(-1.5, 1.5, 3)])
    positions = random.uniform(-6, 6, (count, 3))
    normals = random.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    farthest = random.uniform(0.5, 12, count)
    ranges = np.column_stack([farthest / 1.2**7, farthest]).astype(np.float32)
    ids = random.permutation(count)[:250]
    kept, projections, levels, cosines = candidates(positions, normals, ranges, camera_from_world, ids)

    in_camera = transform_points(camera_from_world, positions)
    with np.errstate(all="ignore"):
        pixels = CAMERA.project(in_camera)
    to_camera = inverse_transform(camera_from_world)[:3, 3] - positions
    distance = np.linalg.norm(to_camera, axis=1)
    cosine = (to_camera * normals.astype(np.float32)).sum(axis=1) / distance
    seen = (in_camera[:, 2] > 0.05) & (pixels >= 0).all(axis=1) & (pixels < [CAMERA.width, CAMERA.height]).all(axis=1)
    seen &= (distance >= 0.8 * ranges[:, 0]) & (distance <= 1.2 * ranges[:, 1]) & (cosine >= 0.5)
    np.testing.assert_array_equal(kept, ids[seen[ids]])
    np.testing.assert_allclose(projections[:, :2], pixels[kept], atol=1e-3)
    np.testing.assert_allclose(pixels[kept, 0] - projections[:, 2], BASELINE_FX / in_camera[kept, 2], atol=1e-3)
    np.testing.assert_allclose(cosines, cosine[kept], atol=1e-5)
    # The level at which a patch that filled a pixel at `farthest` on the finest level looks the same size from here.
    exact = np.log(ranges[kept, 1] / distance[kept]) / np.log(1.2)
    np.testing.assert_array_equal(levels, np.clip(np.ceil(exact), 0, 7))


# Brute force -------------------------------------------------------------------------------------------------------


@settings(max_examples=60)
@given(seeds, st.integers(0, 60), st.integers(0, 60), st.sampled_from([0.6, 0.75, 0.9]), st.sampled_from([30, 50, 256]))
def test_brute_force_is_the_ratio_test_with_one_owner_each(
    seed: int, count: int, frame_count: int, ratio: float, max_distance: int
) -> None:
    random = np.random.default_rng(seed)
    descriptors = descriptors_of(random, count)
    frame = descriptors_of(random, frame_count)
    if count and frame_count:
        copied = random.random(frame_count) < 0.7
        source = random.integers(0, count, frame_count)
        frame[copied] = flip_bits(random, descriptors[source], int(random.integers(0, 60)))[copied]
    table = hamming_table(frame, descriptors)
    expected = np.full(frame_count, -1)
    for j in range(frame_count):
        ranked = np.sort(table[j])
        if count and ranked[0] <= max_distance and ranked[0] < ratio * (ranked[1] if count > 1 else 257):
            expected[j] = int(table[j].argmin())
    for i in range(count):
        rivals = np.flatnonzero(expected == i)
        if len(rivals) > 1:
            owner = rivals[table[rivals, i].argmin()]
            expected[rivals[rivals != owner]] = -1
    np.testing.assert_array_equal(matching.match_brute_force(descriptors, frame, max_distance, ratio), expected)


def test_turning_together_is_kept_and_turning_alone_is_not() -> None:
    random = np.random.default_rng(2)
    count = 200
    angles = random.uniform(0, 2 * np.pi, count).astype(np.float32)
    # By two bins of twelve degrees: a turn between bins may lose the few on the other side of their border.
    turned = (angles + np.pi / 7.5 + random.normal(0, 0.01, count)) % (2 * np.pi)
    alone = random.random(count) < 0.2
    turned[alone] = (angles[alone] + random.uniform(1.5, 5.5, alone.sum())) % (2 * np.pi)
    order = random.permutation(count)
    match = np.where(random.random(count) < 0.9, order, -1).astype(np.int32)
    before = match.copy()
    matching.keep_consistent_rotations(match, angles, turned[order].astype(np.float32))
    matched = before >= 0
    np.testing.assert_array_equal(match >= 0, matched & ~alone[order])
    np.testing.assert_array_equal(match[match >= 0], before[match >= 0])


@pytest.mark.parametrize("count", [0, 1, 5])
def test_few_matches_are_no_trouble(count: int) -> None:
    match = np.arange(count, dtype=np.int32)
    matching.keep_consistent_rotations(match, np.zeros(count, np.float32), np.full(count, 6.2, np.float32))
    np.testing.assert_array_equal(match, np.arange(count))
    nothing = np.full(count, -1, np.int32)
    matching.keep_consistent_rotations(nothing, np.empty(0, np.float32), np.zeros(count, np.float32))
    np.testing.assert_array_equal(nothing, -1)


def test_twins_look_as_much_alike_and_stand_elsewhere() -> None:
    random = np.random.default_rng(4)
    descriptors = random.integers(0, 2**63, (4, 4), dtype=np.uint64)
    # The first has two copies far away, one of them blurred, the second one beside it, the third one not looked at.
    points = np.concatenate([descriptors ^ np.uint64(7), descriptors[:1] ^ np.uint64(1), descriptors[:3]])
    position = np.array(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [0, 6, 0], [0, 4, 0], [1, 0.1, 0], [2, 4, 0]], float
    )
    among = np.array([0, 1, 2, 3, 4, 5, 6], np.int32)
    found = matching.twins(descriptors, np.arange(4, dtype=np.int32), among, points, position, 0.5)
    assert found.tolist() == [5, -1, -1, -1]
