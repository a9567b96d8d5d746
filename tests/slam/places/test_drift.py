import numpy as np
import pytest
from slam_scenes import SENSOR, add_view, descriptors_of, points_ahead, rigid, view_of

from lpslam.camera import inverse_transform
from lpslam.config import LoopConfig
from lpslam.slam.map import SlamMap
from lpslam.slam.places.drift import Drift
from lpslam.slam.places.located import Expected, Located
from lpslam.slam.places.parts import Parts
from lpslam.slam.state import Beginning

HOME, AWAY = range(6), range(6, 9)  # keyframes a metre apart, in two sub-maps; the second begins half a metre on


def at(metres: float) -> np.ndarray:
    return inverse_transform(rigid([metres, 0.0, 0.0], [0, 0, 0]))


def two_submaps() -> SlamMap:
    random, slam_map = np.random.default_rng(0), SlamMap(20, SENSOR.scales)
    for keyframe in (*HOME, *AWAY):
        is_root = keyframe in (HOME[0], AWAY[0])
        metres = float(keyframe - (AWAY[0] if keyframe in AWAY else 0))
        points = points_ahead(random, 20)
        view = view_of(np.eye(4), points, descriptors_of(random, 20))
        add_view(slam_map, at(metres), view, -1 if is_root else keyframe - 1)
    return slam_map


def located(candidate: int, metres: float, *, is_told: bool = False) -> Located:
    none, parts = np.zeros(0, np.int32), Parts(np.zeros(48, np.intp), np.zeros(48, np.intp))
    expected = Expected(none, np.zeros((0, 2), np.float32), none)
    return Located(candidate, at(metres), none, 100, expected, parts, 1.0, 1.0, is_told)


@pytest.mark.parametrize(
    ("metres", "is_allowed"), [(7.5, True), (6.1, True), (8.5, True), (5.0, False), (10.0, False), (-3.0, False)]
)
def test_a_submap_begins_where_the_camera_can_have_been(metres: float, is_allowed: bool) -> None:
    slam_map = two_submaps()
    slam_map.beginnings[AWAY[0]] = Beginning(HOME[-1], np.eye(4), 1.2)
    drift = Drift(slam_map, LoopConfig())
    # The last keyframe stands two metres after the first of its sub-map, that at most 1.2 m after the last at home,
    # and the way may drift by 0.3 m and more.
    assert drift.allows(AWAY[-1], located(HOME[-1], metres)) is is_allowed
    # Seen from the other side: a keyframe at home, located where the other sub-map has it.
    assert drift.allows(HOME[-1], located(AWAY[-1], 5.0 - (metres - 2.0))) is is_allowed


def test_signs_and_cameras_that_were_blind_may_be_anywhere() -> None:
    slam_map = two_submaps()
    assert Drift(slam_map, LoopConfig()).allows(AWAY[-1], located(HOME[0], -30.0))
    slam_map.beginnings[AWAY[0]] = Beginning(HOME[-1], np.eye(4), 1.2)
    assert not Drift(slam_map, LoopConfig()).allows(AWAY[-1], located(HOME[0], -30.0))
    assert Drift(slam_map, LoopConfig()).allows(AWAY[-1], located(HOME[0], -30.0, is_told=True))


def test_within_a_map_the_way_since_bounds_a_correction() -> None:
    drift = Drift(two_submaps(), LoopConfig())
    assert drift.allows(HOME[-1], located(HOME[0], 5.4))
    assert not drift.allows(HOME[-1], located(HOME[0], 5.6))
