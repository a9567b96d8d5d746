"""Small images of keyframes: what they keep, and what of a file is refused."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from rooms import CAMERA, FLOOR, depth_of, looking

from lpslam.ground.scans import Scans

RGB = np.zeros((CAMERA.height, CAMERA.width, 3), np.uint8)


def scans(count: int = 2) -> Scans:
    taken = Scans(CAMERA, 80)
    for keyframe in range(count):
        taken.take(3 * keyframe, RGB + keyframe, depth_of([FLOOR], looking((0.0, 0.0), 0.5 * keyframe)))
    return taken


def test_the_points_of_a_scan_lie_where_its_readings_do() -> None:
    taken, pose = scans(1), looking((0.0, 0.0), 0.0)
    points = taken.points(0)
    seen = points[np.isfinite(points).all(axis=2)]
    heights = (seen @ pose[:3, :3].T + pose[:3, 3])[:, 2]
    assert len(seen) > 1500
    assert np.abs(heights).max() < 0.06
    assert np.abs(np.median(heights)) < 0.01


def test_holes_and_what_is_no_number_have_no_depth() -> None:
    depth = depth_of([FLOOR], looking((0.0, 0.0), 0.0))
    depth[:, :100], depth[:, 100:120], depth[:, 120:140] = 0.0, np.nan, 1e9
    taken = Scans(CAMERA, 80)
    taken.take(0, RGB, depth)
    assert not taken.depth(0)[:, :35].any()
    assert taken.depth(0)[50:, 36:].all()


def test_what_is_written_is_read_and_a_copy_does_not_grow() -> None:
    taken = scans()
    copied = taken.copy()
    again = Scans.from_arrays(CAMERA, taken.to_arrays(), 96)
    assert again.keyframes == taken.keyframes == [0, 3]
    assert np.array_equal(again.depth(3), taken.depth(3))
    assert np.array_equal(again.colour(3), taken.colour(3))
    assert np.array_equal(again.intrinsics, taken.intrinsics)
    taken.take(9, RGB, np.ones((CAMERA.height, CAMERA.width), np.float32))
    assert copied.keyframes == [0, 3]
    assert taken.to_arrays([9])["keyframe"].tolist() == [9]
    assert len(Scans.from_arrays(CAMERA, {}, 96)) == 0


def test_scans_of_keyframes_that_are_gone_are_forgotten_on_the_way() -> None:
    taken, depth = Scans(CAMERA, 80), np.ones((CAMERA.height, CAMERA.width), np.float32)
    for keyframe in range(600):
        taken.take(keyframe, RGB, depth)
        taken.drop(lambda each, latest=keyframe: each % 10 != 0 and each < latest - 3)
        assert len(taken) <= 200
    assert set(range(0, 600, 10)) <= set(taken.keyframes)
    assert set(taken.to_arrays()["keyframe"].tolist()) == set(taken.keyframes)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda a: a | {"depth": a["depth"][:1]},
        lambda a: a | {"depth": a["depth"].astype(np.float32)},
        lambda a: a | {"depth": a["depth"][:, :, :1]},
        lambda a: a | {"depth": np.zeros((2, 5, 100000), np.uint16)},
        lambda a: a | {"colour": a["colour"][..., :2]},
        lambda a: a | {"colour": a["colour"].astype(np.int64)},
        lambda a: a | {"keyframe": np.array([4, 4], np.int32)},
        lambda a: a | {"keyframe": np.array([[1], [2]], np.int32)},
        lambda a: {"keyframe": a["keyframe"]},
    ],
)
def test_arrays_that_do_not_belong_together_are_refused(spoil: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    with pytest.raises((ValueError, KeyError)):
        Scans.from_arrays(CAMERA, spoil(scans().to_arrays()), 96)
