"""Neighbouring keyframes compared as whole pictures, and how far what they tell is believed."""

import numpy as np
from corner_room import CAMERA, CORNER, shot
from slam_scenes import add_view, descriptors_of, features_at, pose_error, rigid

from lpslam.camera import inverse_transform
from lpslam.config import PictureConfig, SlamConfig
from lpslam.slam.map import SlamMap
from lpslam.slam.mapping.relative_poses import RelativePoses
from lpslam.slam.mapping.whole_pictures import WholePictures
from lpslam.slam.sensor import SensorModel

SENSOR = SensorModel.of(CAMERA, SlamConfig())
STEP = rigid([0.02, -0.01, 0.01], [0.004, 0.02, 0.0])


def compared(
    frames: int,
    *,
    off: np.ndarray | None = None,
    off_from: int = 1,
    coat_from: int = 1000,
    is_blurred: bool = False,
    **config: float,
) -> SlamMap:
    """A map of a camera that steps before a corner, whose keyframes have been compared.

    Args:
        frames: keyframes.
        off: 4×4 by which the map has each keyframe wrong beside the one before, ...
        off_from: ... from this one on.
        coat_from: the keyframe from which on somebody in a checked coat goes along with the camera.
        is_blurred: whether the keyframes may be blurred.
        config: thresholds of the comparison.
    """
    random = np.random.default_rng(1)
    slam_map = SlamMap(4, SENSOR.scales)
    pictures = WholePictures(slam_map, CAMERA, SENSOR, SlamConfig(pictures=PictureConfig(longest_gap=5.0, **config)))
    true = supposed = np.eye(4)
    for k in range(frames):
        features = features_at(np.full((4, 2), 50.0), np.ones(4, np.float32), descriptors_of(random, 4))
        keyframe = add_view(slam_map, supposed, features, k - 1)
        gray, depth = shot(CORNER, true, 12.0)
        if k >= coat_from:
            gray, depth = with_coat(gray, depth)
        strayed = depth + (depth > 0) * random.normal(0.0, 0.5 * SENSOR.depth_sigma, depth.shape)
        pictures.keep(keyframe, gray, strayed.astype(np.float32))
        if is_blurred:
            slam_map.blurred.add(keyframe)
        pictures.compare(keyframe)
        true = STEP @ true
        supposed = STEP @ supposed if off is None or k + 1 < off_from else off @ STEP @ supposed
    return slam_map


def with_coat(gray: np.ndarray, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A picture (h, w) with its depth, the middle of which a coat of strong contrasts hides."""
    height, width = gray.shape
    rows, columns = slice(height // 6, height), slice(width // 3, width * 2 // 3)
    checks = np.random.default_rng(5).integers(0, 2, (40, 40)) * 200
    coat = np.kron(checks, np.ones((16, 16)))[: height - height // 6, : width * 2 // 3 - width // 3]
    gray, depth = gray.copy(), depth.copy()
    gray[rows, columns], depth[rows, columns] = coat, 0.6
    return gray, depth


def pairs_of(slam_map: SlamMap) -> list[list[int]]:
    everyone = slam_map.living_keyframes()
    pairs: list[list[int]] = slam_map.relative_poses.among(everyone, len(everyone)).pairs.tolist()
    return pairs


def test_pictures_tell_a_step_that_the_map_has_wrong() -> None:
    off = rigid([0.004, 0.0, 0.0], [0.0, 0.001, 0.0])
    slam_map = compared(2, off=off)
    problem = slam_map.relative_poses.among(np.array([1, 0], np.int32), 1)
    np.testing.assert_array_equal(problem.pairs, [[1, 0]])
    metres, radians = pose_error(problem.a_from_b[0], inverse_transform(STEP))
    assert metres < 0.003
    assert np.degrees(radians) < 0.1


def test_pictures_that_the_map_denies_hold_where_most_pixels_agree() -> None:
    """As where blur spoils corners: the map is what is wrong."""
    slam_map = compared(6, off=rigid([0.05, 0.0, 0.02], [0.0, 0.03, 0.0]), off_from=5, most_disagreement=1.0)
    assert [4, 5] in pairs_of(slam_map)
    problem = slam_map.relative_poses.among(np.array([5, 4], np.int32), 1)
    assert pose_error(problem.a_from_b[0], inverse_transform(STEP))[0] < 0.003


def test_pictures_that_follow_somebody_who_fills_the_view_hold_nothing() -> None:
    """He goes along with the camera; pictures say that it stands, and the map says that it moves."""
    slam_map = compared(9, coat_from=6)
    assert pairs_of(slam_map) == [[k, k + 1] for k in range(5)]


def test_before_anything_is_usual_the_map_is_believed() -> None:
    slam_map = compared(2, off=rigid([0.3, 0.0, 0.0], [0.0, 0.05, 0.0]), most_disagreement=1.0)
    assert pairs_of(slam_map) == []


def test_the_way_round_three_keyframes_is_looked_at() -> None:
    relative = compared(6, judged_first=3).relative_poses
    assert relative.judged == 3
    # One scene, one sensor: pictures err by no more here than in a mall.
    assert relative.excess < 10 * RelativePoses(PictureConfig()).excess


def test_what_ways_round_do_not_show_is_configured() -> None:
    doubting, trusting = (compared(2, unseen_errors=unseen).relative_poses.excess for unseen in (30.0, 15.0))
    np.testing.assert_allclose(doubting, 2 * trusting)


def test_how_ways_round_close_decides_what_pictures_weigh() -> None:
    believed = []
    for gap in (2.0, 2000.0):
        relative = RelativePoses(PictureConfig())
        relative.add(0, 1, STEP, np.eye(6))
        for _ in range(20):
            relative.judge(gap)
        believed.append(relative.among(np.array([0, 1], np.int32), 1).information[0, 0, 0])
    np.testing.assert_allclose(believed[0], 1000.0 * believed[1])


def test_pictures_err_no_more_than_they_differ_from_the_map_in_calm_steps() -> None:
    config = PictureConfig()
    relative = RelativePoses(config)
    for _ in range(config.remembered_gaps):
        relative.judge(30.0)
    by_ways_round = relative.excess
    for _ in range(config.judged_first - 1):
        relative.differ(60.0)
    assert relative.excess == by_ways_round  # Too few to tell.
    relative.differ(60.0)
    np.testing.assert_allclose(relative.excess, by_ways_round * 60.0 / (config.unseen_errors * 30.0))
    for _ in range(config.remembered_gaps):
        relative.differ(1e5)
    assert relative.excess == by_ways_round  # The map may be what is wrong.


def test_only_calm_steps_are_compared_with_the_map() -> None:
    calm = compared(20, judged_first=3).relative_poses.excess
    blurred = compared(20, is_blurred=True, judged_first=3).relative_poses.excess
    assert calm < blurred


def test_pictures_that_hold_nothing_are_rarely_compared() -> None:
    often, rarely = (compared(12, largest_excess=limit).relative_poses for limit in (1e9, 1.0))
    rows = np.arange(12, dtype=np.int32)
    assert len(often.among(rows, 12).pairs) == 11
    assert 0 < len(rarely.among(rows, 12).pairs) <= 4


def test_pairs_outside_the_adjusted_part_are_left_out() -> None:
    relative = RelativePoses(PictureConfig())
    for k in range(5):
        relative.add(k, k + 1, STEP, np.eye(6))
    problem = relative.among(np.array([3, 2, 4, 0], np.int32), 1)
    np.testing.assert_array_equal(problem.pairs, [[1, 0], [0, 2]])
    # Between keyframes that are all held there is nothing to tell.
    assert len(relative.among(np.array([0, 3, 4], np.int32), 1).pairs) == 0
    relative.forget()
    assert len(relative.among(np.arange(6, dtype=np.int32), 6).pairs) == 0


def test_comparing_can_be_turned_off() -> None:
    assert compared(3, enabled=False).relative_poses.judged == 0
