"""People who walk by: how much of what a camera sees they may hide."""

import numpy as np
import pytest

from lpslam.camera import PinholeCamera
from lpslam.simulation.worlds.factors import draw_world
from lpslam.simulation.worlds.places.place import Walker
from lpslam.simulation.worlds.source import WorldSource
from lpslam.simulation.worlds.walking import MOST_COVERED, thinned

CAMERA = PinholeCamera(320, 240, 260.0, 260.0, 159.5, 119.5)
TIMES = np.arange(0.0, 6.0, 0.5)


def passing(metres: float, aside: float = 0.0, speed: float = 1e-9) -> Walker:
    """Someone who crosses the view of a camera at the origin that looks along x, so many metres off."""
    start, end = np.array([metres, aside]), np.array([metres, aside + 4.0])
    return Walker(0, 0, start, end, speed, 0.0, np.empty(0), np.empty(0))


def views(count: int, height: float = 1.5) -> np.ndarray:
    """(n, 4, 4) of a camera that stands and looks along x."""
    pose = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, height], [0, 0, 0, 1]])
    return np.tile(pose, (count, 1, 1))


def left(*walkers: Walker) -> list[int]:
    kept = thinned(walkers, CAMERA, views(len(TIMES)), TIMES)
    return [number for number, walker in enumerate(walkers) if any(walker is each for each in kept)]


def test_nobody_is_left_out_where_all_is_well() -> None:
    assert left(passing(4.0), passing(3.0, 1.0), passing(5.0, -2.0, 1.0)) == [0, 1, 2]
    assert left() == []


def test_whoever_stands_before_the_lens_goes_and_the_others_stay() -> None:
    assert left(passing(4.0), passing(0.6), passing(5.0, -1.0)) == [0, 2]


def test_one_view_that_is_hidden_is_enough() -> None:
    hurried = passing(0.8, -3.0, 1.3)
    assert thinned((hurried,), CAMERA, views(1), np.array([0.0])) == (hurried,)
    assert left(passing(4.0), hurried) == [0]


def test_of_a_crowd_that_hides_too_much_together_those_in_front_go_first() -> None:
    crowd = [passing(2.1, aside) for aside in (-1.0, -0.4, 0.2, 0.8)] + [passing(1.2, 0.0)]
    kept = left(*crowd)
    assert 4 not in kept
    assert kept
    assert len(kept) == len(left(*[crowd[k] for k in kept])), "what is left is well"


def test_someone_behind_the_camera_hides_nothing() -> None:
    assert left(passing(-0.6), passing(-3.0)) == [0, 1]


@pytest.mark.parametrize("seed", [23])
def test_people_of_a_world_hide_two_fifths_of_a_view_at_most(seed: int) -> None:
    source = WorldSource(
        draw_world(seed, place="people", motion="handheld", light="normal", size="320x240", rate="10", seconds=6.0)
    )
    stage, lens = source._stage, source._lens
    rows = [row for walker in stage.walkers for row in range(walker.first, walker.last)]
    assert rows
    for time in np.arange(0.0, 6.0, 0.5):
        pose = source.trajectory.poses(np.array([time]))[0]
        view, _ = stage.view(lens.canvas, pose, time, with_colour=False)
        assert np.isin(view.face, rows).mean() <= MOST_COVERED
