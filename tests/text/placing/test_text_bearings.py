import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import InstanceConfig, MemoryConfig
from lpslam.text import documents
from lpslam.text.placing.bearings import placed
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.places import places_of_class
from lpslam.text.placing.views import bearing_of
from lpslam.text.remembering.memory import LongShortTermMemory, Pool, TextClass, Variant
from lpslam.text.types import Placement, TextObservation

Array = NDArray[np.float64]

CONFIG = InstanceConfig()
CAMERA = PinholeCamera(640, 480, 550.0, 550.0, 320.0, 240.0)


def looking(x: float, z: float = 0.0, turn: float = 0.0) -> Array:
    """A camera at (x, 0, z) in a world like its own frame, turned to the right by radians."""
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(turn), 0.0, np.sin(turn)], [0.0, 1.0, 0.0], [-np.sin(turn), 0.0, np.cos(turn)]]
    pose[:3, 3] = x, 0.0, z
    return pose


def sign(middle: tuple[float, float, float], turn: float = 0.0, size: tuple[float, float] = (0.6, 0.15)) -> Array:
    """Corners (4, 3) of a text that faces the cameras, turned about the upright."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * (size[0] / 2, size[1] / 2, 0.0)
    return np.asarray(corners @ looking(0.0, turn=turn)[:3, :3].T + middle, np.float64)


def seen(
    number: int,
    pose: Array,
    corners: Array,
    noise: float = 0.0,
    depth: float | None = None,
    text: str = "COFFEE",
    uncertainty: float = 0.02,
) -> TextObservation:
    """What a camera on a keyframe of its own sees of a sign; with depth, of a wall that far ahead in the world's z."""
    box = CAMERA.project(transform_points(inverse_transform(pose), corners))
    box = box + np.random.default_rng(number).normal(0.0, noise, 2)
    placement = None
    if depth is not None:
        middle = corners.mean(axis=0)
        point = pose[:3, 3] + (middle - pose[:3, 3]) * (depth - pose[2, 3]) / (middle[2] - pose[2, 3])
        local = transform_points(inverse_transform(pose), point[None])[0]
        rotation = pose[:3, :3].T
        normal, along = rotation @ np.array([0.0, 0.0, -1.0]), rotation @ np.array([1.0, 0.0, 0.0])
        placement = Placement(tuple(local), tuple(normal), tuple(along), 0.6, 0.15, uncertainty)
    bearing = bearing_of(box, CAMERA, np.eye(4))
    return TextObservation(number, number / 10, number, text, 0.95, placement, 20.0, None, bearing)


def poses_of(poses: list[Array]) -> KeyframePoses:
    return lambda keyframe: poses[keyframe]


def where(observations: list[TextObservation], poses: list[Array]) -> Array:
    return np.array(
        [transform_points(poses[each.keyframe], np.array([each.place.position]))[0] for each in observations]
    )


WALK = [looking(x) for x in np.linspace(-0.6, 0.6, 7)]


def text_class(observations: list[TextObservation]) -> TextClass:
    return TextClass(
        3, 0.0, 1.0, {"COFFEE": Variant(len(observations), 5.0)}, 3.0, Pool.LONG_TERM, 0.5, observations=observations
    )


def test_a_point_between_two_signs_does_not_outdo_the_sign_that_depth_places_too() -> None:
    """Directions to one from afar, and to the other, cross before both; in the first one's place depth was measured."""
    far, near = [looking(x) for x in np.linspace(0.0, 0.06, 7)], [looking(x, 3.0) for x in np.linspace(-0.4, 0.4, 5)]
    aside = [looking(4.0 + x, 2.0, -1.107) for x in np.linspace(0.0, 0.05, 3)]
    poses, first = [*far, *near, *aside], sign((0.0, 0.0, 6.0))
    observations = [seen(row, poses[row], first, 0.5) for row in range(7)]
    observations += [seen(row, poses[row], first, 0.5, depth=6.0) for row in range(7, 12)]
    observations += [seen(row, poses[row], sign((-2.0, 0.0, 5.0), -1.107), 0.5, text="TOFFEE") for row in range(12, 15)]
    found = [each for each in placed(observations, poses_of(poses), CONFIG) if each.text == "COFFEE"]
    assert len(found) == 12
    assert np.linalg.norm(where(found, poses) - [0.0, 0.0, 6.0], axis=1).max() < 0.2


@pytest.mark.parametrize("middle", [(0.2, -0.4, 3.0), (1.0, 0.3, 4.0), (0.0, 0.0, 2.0)])
def test_text_without_depth_is_placed_by_its_bearings(middle: tuple[float, float, float]) -> None:
    observations = [seen(number, pose, sign(middle), 0.5) for number, pose in enumerate(WALK)]
    found = placed(observations, poses_of(WALK), CONFIG)
    assert len(found) == len(observations)
    offsets = np.linalg.norm(where(found, WALK) - middle, axis=1)
    assert offsets.max() < min(0.15, 3.0 * found[0].place.uncertainty)
    assert found[0].place.width == pytest.approx(0.6, rel=0.1)
    assert found[0].place.height == pytest.approx(0.15, rel=0.15)
    (place,) = places_of_class(text_class(observations), poses_of(WALK), CONFIG, MemoryConfig())
    assert place.position == pytest.approx(middle, abs=0.15)


def test_signs_beyond_the_sensor_are_placed_when_the_way_is_long_enough() -> None:
    walk = [looking(x) for x in np.linspace(-3.0, 3.0, 13)]
    corners = sign((1.0, -2.0, 18.0), size=(4.0, 1.0))
    found = placed([seen(n, pose, corners, 0.5) for n, pose in enumerate(walk)], poses_of(walk), CONFIG)
    assert len(found) == len(walk)
    assert where(found, walk).mean(axis=0) == pytest.approx((1.0, -2.0, 18.0), abs=0.6)


def test_without_parallax_there_is_no_place() -> None:
    standing = [looking(0.01 * n) for n in range(6)]
    observations = [seen(n, pose, sign((0.2, -0.4, 3.0)), 0.5) for n, pose in enumerate(standing)]
    assert placed(observations, poses_of(standing), CONFIG) == []
    assert places_of_class(text_class(observations), poses_of(standing), CONFIG, MemoryConfig()) == []
    # Two directions of one plane meet somewhere.
    assert placed([*observations[:1], seen(5, WALK[5], sign((0.2, -0.4, 3.0)))], poses_of(WALK), CONFIG) == []


@settings(deadline=None)
@given(st.floats(-3.0, 3.0), st.floats(-5.0, 5.0))
def test_the_place_moves_with_the_keyframes(turn: float, shift: float) -> None:
    observations = [seen(n, pose, sign((0.2, -0.4, 3.0)), 0.5) for n, pose in enumerate(WALK)]
    corrected = looking(shift, 1.0, turn)
    moved = [corrected @ pose for pose in WALK]
    before = where(placed(observations, poses_of(WALK), CONFIG), WALK)
    after = where(placed(observations, poses_of(moved), CONFIG), moved)
    assert after == pytest.approx(transform_points(corrected, before), abs=1e-4)


def test_equal_texts_in_two_places_are_kept_apart() -> None:
    middles = (-0.7, 0.0, 3.0), (0.9, 0.1, 3.4)
    observations = [replace(seen(n, pose, sign(middle)), frame=n) for n, pose in enumerate(WALK) for middle in middles]
    found = placed(observations, poses_of(WALK), CONFIG)
    assert where(found, WALK)[::2] == pytest.approx(np.array([middles[0]] * len(WALK)), abs=0.05)
    assert where(found, WALK)[1::2] == pytest.approx(np.array([middles[1]] * len(WALK)), abs=0.05)
    assert len(places_of_class(text_class(observations), poses_of(WALK), CONFIG, MemoryConfig())) == 2


def test_boxes_that_agree_place_a_text_from_a_shorter_way() -> None:
    middle = (0.2, -0.4, 3.0)
    poses = [looking(x) for x in np.linspace(-0.08, 0.08, 24)]
    steady = placed([seen(n, pose, sign(middle), 0.5) for n, pose in enumerate(poses)], poses_of(poses), CONFIG)
    assert len(steady) == len(poses)
    assert np.linalg.norm(where(steady, poses) - middle, axis=1).max() < 3.0 * steady[0].place.uncertainty < 1.0
    # Few say little of how much boxes stray, and boxes that stray are as bad as they are held to be, or worse.
    assert placed([seen(n, poses[n], sign(middle), 0.5) for n in (5, 11, 18)], poses_of(poses), CONFIG) == []
    assert placed([seen(n, pose, sign(middle), 9.0) for n, pose in enumerate(poses)], poses_of(poses), CONFIG) == []


def test_depth_refines_what_bearings_say() -> None:
    middle = (0.2, -0.4, 3.0)
    poses = [looking(x) for x in np.linspace(-0.03, 0.03, 5)]
    without = [seen(n, pose, sign(middle), 1.0) for n, pose in enumerate(poses)]
    assert placed(without, poses_of(poses), CONFIG) == []
    refined = placed([*without[:-1], seen(4, poses[4], sign(middle), depth=3.0)], poses_of(poses), CONFIG)
    assert len(refined) == 5
    assert np.linalg.norm(where(refined, poses) - middle, axis=1).max() < 0.06
    assert refined[0].place.uncertainty < 0.05


def test_the_surface_around_a_sign_counts_as_little_as_it_knows() -> None:
    middle = (0.2, -0.4, 3.0)
    walk = [looking(x) for x in np.linspace(-1.0, 1.0, 9)]
    # The wall is 0.4 m behind the sign.
    observations = [seen(n, pose, sign(middle), 0.3, depth=3.4, uncertainty=0.3) for n, pose in enumerate(walk)]
    found = placed(observations, poses_of(walk), CONFIG)
    assert np.linalg.norm(where(found, walk) - middle, axis=1).max() < 0.06


def test_what_few_views_see_around_a_sign_is_nearer_than_the_sign() -> None:
    """On the way towards a sign 12 m ahead two of twenty views show a thing at 6 m beside it, the others nothing."""
    poses = [looking(0.0, 0.03 * step) for step in range(20)]
    corners = sign((1.0, -1.0, 12.0), size=(1.2, 0.35))

    def sure(depths: dict[int, float]) -> list[TextObservation]:
        views = [seen(step, pose, corners, 0.3, depths.get(step), uncertainty=0.3) for step, pose in enumerate(poses)]
        return placed(views, poses_of(poses), CONFIG)

    assert sure({}) == sure({12: 6.0, 13: 6.0}) == []
    assert len(sure(dict.fromkeys(range(5, 20), 12.0))) == 20


def test_text_on_glass_is_where_parallax_says_and_not_where_depth_was_measured() -> None:
    middle = (0.1, -0.2, 2.0)
    observations = [seen(n, pose, sign(middle), 0.3, depth=4.5) for n, pose in enumerate(WALK)]
    found = placed(observations, poses_of(WALK), CONFIG)
    assert np.linalg.norm(where(found, WALK) - middle, axis=1).max() < 0.08
    # Behind it is decided alike: a pane is measured, the sign hangs in the shop.
    observations = [seen(n, pose, sign((0.1, -0.2, 4.5)), 0.3, depth=2.0) for n, pose in enumerate(WALK)]
    found = placed(observations, poses_of(WALK), CONFIG)
    assert np.linalg.norm(where(found, WALK) - (0.1, -0.2, 4.5), axis=1).max() < 0.3


@pytest.mark.parametrize("noise", [0.0, 1.0, 2.0])
def test_true_depth_is_not_overruled(noise: float) -> None:
    observations = [seen(n, pose, sign((0.1, -0.2, 2.5)), noise, depth=2.5) for n, pose in enumerate(WALK)]
    assert placed(observations, poses_of(WALK), CONFIG) == observations


def test_a_long_text_whose_box_is_lower_at_one_end_stays_where_depth_has_it() -> None:
    walk = [looking(x, turn=0.2) for x in np.linspace(-1.0, 0.0, 10)]
    rng = np.random.default_rng(4)
    observations = []
    for number, pose in enumerate(walk):
        corners = sign((0.0, -0.6, 3.0), size=(1.4, 0.13))
        corners[0, 1] += 0.04 * (1.0 - number / 9.0)
        corners[1, 1] += 0.04 * number / 9.0
        one = seen(number, pose, corners, 0.5, 3.0)
        strayed = np.array(one.place.position) + rng.normal(0.0, 0.006, 3)
        observations.append(replace(one, placement=replace(one.place, position=tuple(strayed), uncertainty=0.018)))
    assert where(placed(observations, poses_of(walk), CONFIG), walk) == pytest.approx(where(observations, walk))


def test_what_is_carried_towards_the_camera_is_not_on_glass() -> None:
    walker = [(0.3 * n - 0.9, 0.0, 5.0 - 0.3 * n) for n in range(7)]
    observations = [seen(n, WALK[n], sign(middle), depth=middle[2]) for n, middle in enumerate(walker)]
    assert placed(observations, poses_of(WALK), CONFIG) == observations


def test_a_row_of_equal_signs_is_not_one_behind_glass() -> None:
    walk = [looking(1.0 * n) for n in range(8)]
    signs = [seen(n, pose, sign((1.5 * n, 0.0, 3.0)), depth=3.0) for n, pose in enumerate(walk)]
    twice = [replace(seen(n + 1, walk[n + 1], sign((1.5 * n, 0.0, 3.0)), depth=3.0)) for n in range(7)]
    observations = signs + twice
    assert placed(observations, poses_of(walk), CONFIG) == observations


@pytest.mark.parametrize("turn", [-0.6, 0.0, 0.6])
def test_the_facing_is_told_by_the_corners_over_a_long_way(turn: float) -> None:
    walk = [looking(x) for x in np.linspace(-2.0, 2.0, 15)]
    corners = sign((0.0, -0.3, 3.0), turn, (1.2, 0.3))
    found = placed([seen(n, pose, corners, 0.2) for n, pose in enumerate(walk)], poses_of(walk), CONFIG)
    normal = np.array(found[7].place.normal)
    truth = looking(0.0, turn=turn)[:3, :3] @ np.array([0.0, 0.0, -1.0])
    assert np.degrees(np.arccos(np.clip(normal @ truth, -1.0, 1.0))) < 12.0


def test_the_less_the_corners_tell_the_more_it_faces_the_viewers() -> None:
    turns = []
    for reach, middle in ((2.0, 3.0), (0.5, 3.0), (0.5, 4.5)):
        walk = [looking(x) for x in np.linspace(-reach, reach, 7)]
        corners = sign((0.0, 0.0, middle), 0.7, (0.1, 0.04))
        found = placed([seen(n, pose, corners) for n, pose in enumerate(walk)], poses_of(walk), CONFIG)
        turns.append(float(np.arccos(-found[3].place.normal[2])))
    assert 0.7 > turns[0] > turns[1] > turns[2]
    assert turns[2] < 0.25


def test_fragments_do_not_pull_the_place_aside() -> None:
    middle = (0.0, 0.0, 3.0)
    observations = [seen(n, pose, sign(middle)) for n, pose in enumerate(WALK)]
    # Of the last views only the end was read, and its middle is farther right.
    for n in (5, 6):
        observations[n] = seen(n, WALK[n], sign((0.15, 0.0, 3.0), size=(0.3, 0.15)), text="FEE")
    found = placed(observations, poses_of(WALK), CONFIG)
    assert np.linalg.norm(where(found, WALK)[0] - middle) < 0.08


def test_bearings_survive_the_document_and_older_ones_have_none() -> None:
    memory, restored = LongShortTermMemory(MemoryConfig()), LongShortTermMemory(MemoryConfig())
    observations = [seen(0, WALK[0], sign((0.2, -0.4, 3.0))), seen(1, WALK[1], sign((0.2, -0.4, 3.0)), depth=3.0)]
    memory.long_term[3] = text_class(observations)
    document = json.loads(json.dumps(documents.from_memory(memory)))
    documents.restore_memory(restored, document)
    assert restored.classes == memory.classes
    older = LongShortTermMemory(MemoryConfig())
    del document["classes"][0]["observations"][0]
    del document["classes"][0]["observations"][0]["bearing"]
    documents.restore_memory(older, document)
    (observation,) = older.classes[0].observations
    assert observation == replace(observations[1], bearing=None)
    assert placed([observation], poses_of(WALK), CONFIG) == [observation]
    assert asdict(observation)["bearing"] is None


def test_what_has_no_place_says_so() -> None:
    with pytest.raises(ValueError, match="not placed"):
        _ = seen(0, WALK[0], sign((0.2, -0.4, 3.0))).place


def test_equal_entries_of_one_list_are_two_places() -> None:
    upper, lower = (0.0, -0.05, 4.0), (0.0, 0.05, 4.0)
    around = {"depth": 4.4, "uncertainty": 0.3}
    observations = [
        replace(seen(2 * number + row, pose, sign(middle), 1.5, **around), keyframe=number, frame=number)
        for number, pose in enumerate(WALK)
        for row, middle in enumerate((upper, lower))
    ]
    found = where(placed(observations, poses_of(WALK), CONFIG), WALK)
    assert np.median(found[0::2], axis=0) == pytest.approx(upper, abs=0.1)
    assert np.median(found[1::2, 1] - found[0::2, 1]) == pytest.approx(0.1, abs=0.04)
    marks = places_of_class(text_class(observations), poses_of(WALK), CONFIG, MemoryConfig())
    assert len(marks) == 2
