"""Worlds by their seeds: the same seed gives the same world, and a set shows every value of every factor."""

from collections import Counter

import numpy as np
import pytest

from lpslam.errors import UserError
from lpslam.simulation.worlds.factors import FACTORS, SETS, STRATIFIED, World, draw_world, seeds_of


def test_a_seed_is_a_world() -> None:
    assert draw_world(1007) == draw_world(1007)
    assert draw_world(1007) != draw_world(1008)
    assert World.from_json(draw_world(1007).as_json()) == draw_world(1007)


@pytest.mark.parametrize("which", list(SETS))
@pytest.mark.parametrize("count", [12, STRATIFIED])
def test_every_value_comes_about_equally_often(which: str, count: int) -> None:
    worlds = [draw_world(seed) for seed in seeds_of(which, count)]
    for name, values in FACTORS.items():
        counts, wanted = Counter(world.factors()[name] for world in worlds), Counter(values)
        for value, weight in wanted.items():
            due = count * weight / len(values)
            assert due - weight <= counts[value] <= due + weight, (name, value)


def test_factors_do_not_go_together() -> None:
    worlds = [draw_world(seed) for which in SETS for seed in seeds_of(which)]
    pairs = Counter((world.depth, world.light) for world in worlds)
    assert len(pairs) > 0.8 * len(set(FACTORS["depth"])) * len(set(FACTORS["light"]))


def test_sets_share_no_world_and_extras_are_drawn_freely() -> None:
    dev, test = ([draw_world(seed).factors() for seed in seeds_of(which)] for which in SETS)
    assert dev != test
    extras = Counter(draw_world(1000 + STRATIFIED + i).depth for i in range(200))
    assert set(extras) == set(FACTORS["depth"])


def test_numbers_keep_to_their_ranges() -> None:
    for seed in range(1000, 1100):
        world = draw_world(seed)
        assert 60 <= world.field_of_view <= 90
        assert world.readout == 0.0 or 0.008 <= world.readout <= 0.030
        assert 0.003 <= world.shutter_time <= min(0.033, 1 / world.fps)
        assert abs(world.focal_error) <= 0.01
        assert np.hypot(*world.misregistration) <= 3.0
        assert abs(world.depth_delay) <= 0.025
        assert abs(world.depth_scale_error) <= 0.02
        assert world.frames <= 600


def test_a_given_factor_leaves_all_others_as_they_were() -> None:
    plain, changed = draw_world(1003).factors(), draw_world(1003, depth="tof").factors()
    assert changed["depth"] == "tof"
    assert {**plain, "depth": "tof"} == changed
    assert draw_world(1003, readout=0.02).readout == 0.02


def test_what_is_not_known_is_refused() -> None:
    with pytest.raises(UserError, match="no factor is called weather"):
        draw_world(1, weather="rain")
    with pytest.raises(UserError, match="depth is 'sonar'"):
        draw_world(1, depth="sonar")
