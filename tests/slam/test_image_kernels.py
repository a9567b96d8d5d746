from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from slam_scenes import hamming_table

from lpslam.camera import PinholeCamera
from lpslam.config import FeatureConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.features import FeatureExtractor, Features
from lpslam.slam.kernels import image as kernels

BORDER = kernels.BORDER
CAMERA = PinholeCamera(width=640, height=480, fx=525.0, fy=520.0, cx=318.2, cy=243.7)
EVERYTHING = 1_000_000


def texture(seed: int, width: int = 640, height: int = 480, smooth: float = 2.0) -> np.ndarray:
    """A grey picture full of corners of several sizes."""
    random = np.random.default_rng(seed)
    picture = np.zeros((height, width))
    for sigma, strength in ((smooth, 1.0), (3 * smooth, 2.0), (8 * smooth, 4.0)):
        noise = cv2.GaussianBlur(random.normal(size=(height, width)), (0, 0), sigma)
        picture += strength * noise / noise.std()
    return np.clip(128 + 22 * picture, 0, 255).astype(np.uint8)


def detect(picture: np.ndarray, quota: int, high: int = 20, low: int | None = None, cell: int = 35) -> np.ndarray:
    low = high if low is None else low
    return kernels.detect_corners(picture, high, low, cell, quota)


def as_set(corners: np.ndarray) -> set[tuple[int, int]]:
    return {(int(x), int(y)) for x, y in corners}


def fast_corners(picture: np.ndarray, threshold: int) -> dict[tuple[int, int], int]:
    """OpenCV's FAST-9 corners before suppression inside the border, with the largest threshold that keeps them.

    OpenCV states a score only of corners that survive its suppression, so the score is found by raising the threshold.
    """
    scores: dict[tuple[int, int], int] = {}
    height, width = picture.shape
    for level in range(threshold, 255):
        detector = cv2.FastFeatureDetector.create(level, False, cv2.FAST_FEATURE_DETECTOR_TYPE_9_16)
        found = [(int(k.pt[0]), int(k.pt[1])) for k in detector.detect(picture)]
        if not found:
            break
        for x, y in found:
            if BORDER <= x < width - BORDER and BORDER <= y < height - BORDER:
                scores[x, y] = level + 1
    return scores


def local_maxima(scores: dict[tuple[int, int], int]) -> set[tuple[int, int]]:
    """Corners that no neighbour beats; of equal neighbours the one that comes last, row by row."""
    kept = set()
    for (x, y), score in scores.items():
        around = [(x + dx, y + dy) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dx, dy) != (0, 0)]
        if all((scores.get(n, 0), (n[1], n[0])) < (score, (y, x)) for n in around):
            kept.add((x, y))
    return kept


# Corners -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("threshold", [7, 20, 40])
def test_corners_are_those_of_fast_after_suppression(threshold: int) -> None:
    picture = texture(1, 200, 150, smooth=1.0)
    expected = local_maxima(fast_corners(picture, threshold))
    assert len(expected) > 20
    assert as_set(detect(picture, EVERYTHING, threshold)) == expected


def test_a_picture_that_is_nothing_but_corners_is_searched_to_its_last_row() -> None:
    picture = np.random.default_rng(0).integers(0, 256, (200, 200)).astype(np.uint8)
    corners = detect(picture, EVERYTHING, 7)
    assert corners[:, 1].min() <= BORDER + 2
    assert corners[:, 1].max() >= 200 - BORDER - 3


def test_sharp_shapes_give_the_corners_of_fast() -> None:
    picture = np.full((150, 200), 60, np.uint8)
    cv2.rectangle(picture, (40, 40), (90, 100), 200, -1)
    cv2.circle(picture, (140, 60), 4, 250, -1)
    cv2.line(picture, (120, 110), (170, 125), 0, 3)
    assert as_set(detect(picture, EVERYTHING)) == local_maxima(fast_corners(picture, 20))


def test_a_saturated_picture_keeps_its_corners() -> None:
    picture = np.where(texture(2, 200, 150, smooth=1.5) > 128, 255, 0).astype(np.uint8)
    assert as_set(detect(picture, EVERYTHING)) == local_maxima(fast_corners(picture, 20))


def test_the_threshold_falls_where_a_cell_is_empty_and_only_there() -> None:
    random = np.random.default_rng(0)
    picture = np.full((BORDER * 2 + 70, BORDER * 2 + 140), 100, np.uint8)
    for x0, contrast in ((0, 60), (70, 12)):  # the left half is rich in contrast, the right half poor
        for _ in range(12):
            x, y = random.integers(4, 62), random.integers(4, 62)
            picture[BORDER + y : BORDER + y + 4, BORDER + x0 + x : BORDER + x0 + x + 4] = 100 + contrast
    strong, weak = as_set(detect(picture, EVERYTHING, 20)), as_set(detect(picture, EVERYTHING, 7))
    both = as_set(detect(picture, EVERYTHING, 20, 7, cell=35))
    assert all(x < BORDER + 70 + 4 for x, _ in strong)
    assert strong <= both
    assert len([1 for x, _ in both if x > BORDER + 74]) >= 5
    assert {c for c in both if c[0] > BORDER + 74} == {c for c in weak if c[0] > BORDER + 74}


@pytest.mark.parametrize("size", [(38, 480), (640, 38), (39, 39), (41, 60), (1, 1)])
def test_pictures_too_small_for_a_patch_have_no_corner_near_the_edge(size: tuple[int, int]) -> None:
    width, height = size
    picture = texture(3, *size, smooth=0.7) if min(size) > 1 else np.zeros((1, 1), np.uint8)
    corners = detect(picture, 50)
    assert corners.shape[1] == 2
    if min(size) <= 2 * BORDER:
        assert len(corners) == 0
    assert ((corners >= BORDER) & (corners < [width - BORDER, height - BORDER])).all()


@settings(max_examples=30)
@given(st.integers(0, 1000), st.integers(1, 400))
def test_the_quota_is_filled_and_never_exceeded(seed: int, quota: int) -> None:
    picture = texture(seed, 240, 180, smooth=1.0)
    everything = detect(picture, EVERYTHING)
    kept = detect(picture, quota)
    assert len(kept) == min(quota, len(everything))
    assert as_set(kept) <= as_set(everything)
    assert len(as_set(kept)) == len(kept)


def test_a_quota_is_spread_over_the_picture_though_one_corner_of_it_is_richer() -> None:
    picture = texture(4, smooth=1.5)
    contrast = np.where(np.arange(640)[None] < 160, 1.0, 0.55)
    picture = (128 + (picture.astype(float) - 128) * contrast).astype(np.uint8)
    quota = 200
    kept = detect(picture, quota)
    blocks = np.histogram2d(kept[:, 0], kept[:, 1], bins=[8, 6], range=[[0, 640], [0, 480]])[0]
    strongest = sorted(fast_corners(picture, 20).items(), key=lambda item: -item[1])[:quota]
    greedy = np.histogram2d(*np.array([c for c, _ in strongest]).T, bins=[8, 6], range=[[0, 640], [0, 480]])[0]
    assert (blocks > 0).mean() == 1.0
    assert blocks.max() <= 3 * quota / blocks.size
    assert blocks.std() < 0.5 * greedy.std()


def test_the_strongest_corner_of_a_picture_survives_any_quota() -> None:
    picture = texture(5, 240, 180, smooth=1.0)
    scores = fast_corners(picture, 20)
    strongest = max(scores.values())
    for quota in (1, 5, 50):
        assert max(scores[c] for c in as_set(detect(picture, quota))) == strongest


# Direction and description -----------------------------------------------------------------------------------------


def turned(picture: np.ndarray, degrees: float) -> np.ndarray:
    """The picture turned about its centre; positive angles turn x towards y."""
    height, width = picture.shape
    centre = ((width - 1) / 2, (height - 1) / 2)
    return np.asarray(cv2.warpAffine(picture, cv2.getRotationMatrix2D(centre, -degrees, 1.0), (width, height)))


def directions(picture: np.ndarray, corners: list[tuple[int, int]]) -> np.ndarray:
    return kernels.orientations(picture, np.array(corners, np.int32).reshape(-1, 2))


def describe(picture: np.ndarray, corners: np.ndarray, angles: np.ndarray) -> np.ndarray:
    extractor = FeatureExtractor(
        PinholeCamera(picture.shape[1], picture.shape[0], 500, 500, 0, 0), FeatureConfig(levels=2)
    )
    descriptors = np.empty((len(corners), 4), np.uint64)
    blurred = np.asarray(cv2.GaussianBlur(picture, (7, 7), 2.0))
    kernels.describe(blurred, corners.astype(np.int32), angles, extractor._steered[0], descriptors)
    return descriptors


@pytest.mark.parametrize(("step", "expected"), [((1, 0), 0), ((0, 1), 90), ((-1, 0), 180), ((0, -1), 270)])
def test_the_direction_points_to_the_brighter_side(step: tuple[int, int], expected: float) -> None:
    y, x = np.mgrid[0:61, 0:61]
    ramp = (120 + 3 * (step[0] * (x - 30) + step[1] * (y - 30))).astype(np.uint8)
    angle = np.degrees(directions(ramp, [(30, 30)])[0])
    assert (angle - expected + 180) % 360 - 180 == pytest.approx(0, abs=0.01)
    assert 0 <= angle < 360


@pytest.mark.parametrize("degrees", [10, 45, 90, 137, 180, 270, 351])
def test_directions_turn_with_the_picture(degrees: float) -> None:
    changes = []
    for seed in range(40):
        picture = texture(100 + seed, 121, 121, smooth=1.5)
        before = directions(picture, [(60, 60)])[0]
        after = directions(turned(picture, degrees), [(60, 60)])[0]
        changes.append((np.degrees(after - before) - degrees + 180) % 360 - 180)
    # Resampling shifts the centroid by a little; whole quarter turns only relabel pixels.
    assert np.median(np.abs(changes)) < (0.01 if degrees % 90 == 0 else 2.0)
    assert np.percentile(np.abs(changes), 90) < 6.0


@pytest.mark.parametrize("degrees", [0, 12, 30, 75, 90, 160, 245, 333])
def test_descriptors_survive_turning_the_picture(degrees: float) -> None:
    patches = [texture(200 + seed, 121, 121, smooth=1.0) for seed in range(40)]
    corner = np.array([[60, 60]])
    before, after = [], []
    for patch in patches:
        for picture, into in ((patch, before), (turned(patch, degrees), after)):
            into.append(describe(picture, corner, directions(picture, [(60, 60)]))[0])
    distances = hamming_table(np.array(before), np.array(after))
    same, other = np.diag(distances), distances[~np.eye(len(patches), dtype=bool)]
    # Resampling costs some bits; the strict threshold of tracking is 50.
    assert np.percentile(same, 95) <= (0 if degrees == 0 else 35)
    assert np.median(other) > 5 * np.median(same)
    assert np.median(other) > 75
    assert (distances.argmin(axis=1) == np.arange(len(patches))).mean() >= 0.95


def test_descriptors_see_structure_and_not_brightness() -> None:
    picture = texture(7, 121, 121)
    corner = np.array([[60, 60]])
    angle = directions(picture, [(60, 60)])
    brighter = np.clip(picture.astype(int) + 20, 0, 255).astype(np.uint8)
    plain, lit = (describe(p, corner, angle) for p in (picture, brighter))
    assert hamming_table(plain, lit)[0, 0] <= 6  # only saturated pixels may differ
    bits = np.unpackbits(
        np.concatenate([describe(texture(s, 121, 121), corner, angle) for s in range(60)]).view(np.uint8)
    )
    assert 0.4 < bits.mean() < 0.6  # half the comparisons go each way, else bits are wasted


# Depth -------------------------------------------------------------------------------------------------------------


def sample(
    depth: np.ndarray, pixels: list[tuple[float, float]], radius: int = 2, tolerance: float = 0.03
) -> np.ndarray:
    return kernels.sample_depth(depth, np.array(pixels, np.float32).reshape(-1, 2), radius, tolerance, 0.3, 8.0)


def test_depth_is_the_reading_at_the_nearest_pixel_and_never_a_mixture() -> None:
    depth = (2.0 + 0.001 * np.arange(40)[None] + 0.0005 * np.arange(30)[:, None]).astype(np.float32)
    pixels = [(10.0, 10.0), (10.4, 9.6), (10.6, 9.4), (0.0, 0.0), (39.2, 29.2)]
    rounded = [(10, 10), (10, 10), (11, 9), (0, 0), (39, 29)]
    np.testing.assert_array_equal(sample(depth, pixels), [depth[y, x] for x, y in rounded])


def test_depth_outside_the_picture_or_the_sensors_range_is_none() -> None:
    depth = np.full((30, 40), 2.0, np.float32)
    np.testing.assert_array_equal(sample(depth, [(-3, 5), (5, -3), (40.6, 5), (5, 30.6)]), 0)
    for reading in (0.0, 0.29, 8.1, -1.0, np.nan, np.inf, -np.inf):
        depth[:] = reading
        np.testing.assert_array_equal(sample(depth, [(20, 15)]), 0)


@pytest.mark.parametrize("hole", [0.0, np.nan, np.inf, 20.0])
def test_holes_around_a_reading_leave_it_be_and_a_hole_has_no_depth(hole: float) -> None:
    random = np.random.default_rng(0)
    depth = np.where(random.random((30, 40)) < 0.4, hole, 2.0).astype(np.float32)
    pixels = [(x, y) for y in range(30) for x in range(40)]
    expected = [2.0 if depth[y, x] == 2.0 else 0.0 for x, y in pixels]
    np.testing.assert_array_equal(sample(depth, pixels), np.array(expected, np.float32))


def test_at_an_edge_only_the_side_in_the_minority_loses_its_depth() -> None:
    depth = np.full((30, 40), 3.0, np.float32)
    depth[:, :20] = 1.5
    row = sample(depth, [(x, 15) for x in range(40)])
    np.testing.assert_array_equal(row, depth[15])  # a straight edge: every pixel is with the majority
    depth[:] = 3.0
    depth[14:16, 10] = 1.5  # a thin wire
    depth[10:20, 20:30] = 1.5  # a board
    assert sample(depth, [(10, 14), (10, 15)]).tolist() == [0, 0]
    assert sample(depth, [(25, 15), (21, 15)]).tolist() == [1.5, 1.5]
    assert sample(depth, [(20, 10)]).tolist() == [0]  # the board's corner: nine of twenty-five agree
    assert sample(depth, [(19, 9)]).tolist() == [3.0]


@pytest.mark.parametrize(("step", "kept"), [(0.029, True), (0.031, False)])
def test_the_tolerance_is_a_share_of_the_depth(step: float, kept: bool) -> None:
    for metres in (0.5, 2.0, 5.0):
        depth = np.full((11, 11), metres, np.float32)
        depth[5, 5] = metres / (1 + step)  # the centre is nearer than its neighbours by `step` of its own depth
        depth[3, 3] = metres * 1.5  # the spread is wide, so that the median is asked
        assert (sample(depth, [(5, 5)])[0] > 0) == kept


# The extractor -----------------------------------------------------------------------------------------------------


def extract(rgb: np.ndarray, depth: np.ndarray, camera: PinholeCamera = CAMERA, **options: float) -> Features:
    return FeatureExtractor(camera, FeatureConfig(**options)).extract(RgbdFrame(0, 0.0, rgb, depth))


def test_features_carry_a_right_coordinate_by_the_virtual_baseline() -> None:
    rgb = np.repeat(texture(8)[:, :, None], 3, axis=2)
    depth = np.full((480, 640), 2.0, np.float32)
    depth[:, 320:] = 0
    features = extract(rgb, depth, virtual_baseline=0.08)
    assert 950 <= features.rows <= FeatureExtractor(CAMERA, FeatureConfig()).capacity <= 1005
    left = features.pixels[:, 0] < 319
    assert features.has_depth[left].all()
    assert not features.has_depth[features.pixels[:, 0] > 320.5].any()
    np.testing.assert_array_equal(features.depth[~features.has_depth], 0)
    disparity = features.pixels[left, 0] - features.u_right[left]
    np.testing.assert_allclose(disparity, 525.0 * 0.08 / 2.0, atol=1e-4)
    assert np.all(np.diff(features.octave.astype(int)) >= 0)
    counts = np.bincount(features.octave, minlength=8)
    assert len(counts) == 8
    assert np.all(counts > 0)
    assert np.all(np.diff(counts) <= 0)


@pytest.mark.parametrize("octave", range(8))
def test_a_corner_keeps_its_place_on_every_level_of_the_pyramid(octave: int) -> None:
    """Soft dots of a level's size are found at their true, fractional place."""
    scale = 1.2**octave
    random = np.random.default_rng(octave)
    grid = np.stack(np.meshgrid(np.arange(90, 560, 58), np.arange(90, 400, 50)), axis=-1).reshape(-1, 2)
    dots = grid + random.uniform(-0.5 * scale, 0.5 * scale, grid.shape)
    y, x = np.arange(480)[:, None], np.arange(640)[:, None]
    columns = np.exp(-((x - dots[:, 0]) ** 2) / (2 * (1.5 * scale) ** 2))
    rows = np.exp(-((y - dots[:, 1]) ** 2) / (2 * (1.5 * scale) ** 2))
    picture = 60.5 + 180 * rows @ columns.T
    rgb = np.repeat(picture.astype(np.uint8)[:, :, None], 3, axis=2)
    features = extract(rgb, np.zeros((480, 640), np.float32), count=2000)
    offsets = features.pixels[features.octave == octave][:, None] - dots[None]
    nearest = offsets[np.arange(len(offsets)), np.linalg.norm(offsets, axis=2).argmin(axis=1)] / scale
    nearest = nearest[np.linalg.norm(nearest, axis=1) < 2]
    assert len(nearest) >= 0.9 * len(dots)
    np.testing.assert_allclose(nearest.mean(axis=0), 0, atol=0.03)
    # Far less than rounding to a pixel of the level would leave, σ = 1/√12.
    assert nearest.std(axis=0).max() < 0.1


def test_pixels_are_undistorted_and_depth_is_read_where_the_corner_was_seen() -> None:
    distorted = PinholeCamera(640, 480, 525.0, 520.0, 318.2, 243.7, (0.25, -0.9, -0.005, 0.003, 1.1))
    rgb = np.repeat(texture(9)[:, :, None], 3, axis=2)
    x, y = np.meshgrid(np.arange(640), np.arange(480))
    depth = (1.0 + 0.002 * x + 0.003 * y).astype(np.float32)
    plain, undistorted = extract(rgb, depth), extract(rgb, depth, distorted)
    np.testing.assert_allclose(undistorted.pixels, distorted.undistort(plain.pixels.astype(np.float64)), atol=1e-3)
    assert np.abs(undistorted.pixels - plain.pixels).max() > 2
    np.testing.assert_array_equal(undistorted.depth, plain.depth)
    np.testing.assert_array_equal(undistorted.descriptor, plain.descriptor)


@pytest.mark.parametrize("size", [(640, 480), (64, 48), (16, 12), (3, 2), (1, 1)])
def test_a_blank_or_tiny_picture_has_no_features_and_is_no_error(size: tuple[int, int]) -> None:
    width, height = size
    camera = PinholeCamera(width, height, 500.0, 500.0, width / 2, height / 2)
    features = extract(np.full((height, width, 3), 90, np.uint8), np.ones((height, width), np.float32), camera)
    assert features.rows == 0
    assert features.pixels.shape == (0, 2)
    assert features.descriptor.shape == (0, 4)


def test_extraction_is_the_same_to_the_bit_each_time() -> None:
    rgb = np.repeat(texture(10)[:, :, None], 3, axis=2)
    depth = np.full((480, 640), 2.0, np.float32)
    for first, second in zip(extract(rgb, depth), extract(rgb, depth), strict=True):
        np.testing.assert_array_equal(first, second)


def test_keypoints_found_in_two_threads_are_the_same() -> None:
    random = np.random.default_rng(3)
    rgb = cv2.resize(random.integers(0, 255, (60, 80, 3), np.uint8), (640, 480), interpolation=cv2.INTER_CUBIC)
    frame = RgbdFrame(0, 0.0, rgb, np.full((480, 640), 2.0, np.float32))
    alone = FeatureExtractor(CAMERA, FeatureConfig()).extract(frame)
    with ThreadPoolExecutor(1) as beside:
        together = FeatureExtractor(CAMERA, FeatureConfig(), beside).extract(frame)
    assert alone.rows > 500
    for one, other in zip(alone, together, strict=True):
        np.testing.assert_array_equal(one, other)
