"""The walk and the world: size of the loop, turning, languages, duplicates, readable signs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lpslam.config import SimulationConfig
from lpslam.errors import UserError
from lpslam.simulation.layout import plan
from lpslam.simulation.lettering import is_chinese
from lpslam.simulation.mall import Mall, build_mall
from lpslam.simulation.source import MallSource
from lpslam.simulation.walk import Walk, stroll


@pytest.fixture(scope="module")
def default_mall() -> Mall:
    """A world does not depend on how fast the camera turns in it."""
    return build_mall(1, SimulationConfig())


def turn_rates(walk: Walk) -> np.ndarray:
    """Degrees a second between successive frames."""
    turns = np.array([walk.pose(i / 30)[:3, :3] for i in range(walk.frames)])
    step = np.einsum("nji,njk->nik", turns[:-1], turns[1:])
    return np.degrees(np.arccos(np.clip((np.trace(step, axis1=1, axis2=2) - 1) / 2, -1, 1))) * 30


@given(st.integers(0, 10_000), st.sampled_from(["loop", "figure-eight"]), st.floats(24.0, 200.0))
@settings(max_examples=60, deadline=None)
def test_corridors_are_wide_enough_and_walls_face_them(seed: int, shape: str, length: float) -> None:
    length = max(length, 60.0) if shape == "figure-eight" else length
    layout = plan(np.random.default_rng(seed), shape, length)
    sides = np.linalg.norm(np.roll(layout.route, -1, axis=0) - layout.route, axis=1)
    assert sides.sum() == pytest.approx(length, rel=0.02)
    assert np.all(layout.blocks[:, 1] - layout.blocks[:, 0] >= 1.79)
    for wall in layout.walls:
        assert wall.length > 1.0
        middle = (wall.start + wall.end) / 2
        # A step out of the wall is walkable: inside the outline, outside every block.
        spot = middle + 1.0 * wall.normal
        assert np.all((spot > layout.outline[0]) & (spot < layout.outline[1]))
        assert not any(np.all((spot > block[0]) & (spot < block[1])) for block in layout.blocks)


@pytest.mark.slow
@pytest.mark.parametrize("max_turn_rate", [45.0, 134.0])
def test_default_walk_is_a_closed_loop_at_walking_pace(default_mall: Mall, max_turn_rate: float) -> None:
    options, mall = SimulationConfig(max_turn_rate=max_turn_rate), default_mall
    walk = stroll(1, mall.layout, mall.signs, options, None)
    poses = np.array([walk.pose(i / 30) for i in range(walk.frames)])
    steps = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    assert walk.frames >= 900
    assert steps.sum() >= 25.0
    assert 0.85 < steps.mean() * 30 < 1.2
    assert steps.max() * 30 < 1.5
    rates = turn_rates(walk)
    assert rates.max() <= max_turn_rate
    if max_turn_rate > 100:
        assert rates.max() > 70
    assert np.all((poses[:, 2, 3] > 1.2) & (poses[:, 2, 3] < 1.6))
    assert poses[:, 2, 3].std() > 0.005
    # The end goes over the start's ground again, looking the same way.
    apart = np.linalg.norm(poses[-30:, None, :3, 3] - poses[None, :150, :3, 3], axis=2)
    assert np.median(apart.min(axis=1)) < 0.3
    views = np.einsum("ei,ei->e", poses[-30:, :3, 2], poses[apart.argmin(axis=1), :3, 2])
    assert np.median(views) > np.cos(np.radians(15))
    # The camera never walks into a wall.
    place = poses[:, :2, 3]
    assert np.all((place > mall.layout.outline[0] + 0.4) & (place < mall.layout.outline[1] - 0.4))
    for low, high in mall.layout.blocks:
        assert not np.any(np.all((place > low - 0.4) & (place < high + 0.4), axis=1))


@pytest.mark.slow
def test_options_of_the_world() -> None:
    chinese = build_mall(5, SimulationConfig(loop_length=24.0, language="chinese"))
    assert all(is_chinese(sign.text) for sign in chinese.signs)
    english = build_mall(5, SimulationConfig(loop_length=24.0, language="english", duplicates=4))
    texts = [sign.text for sign in english.signs]
    assert not any(is_chinese(text) for text in texts)
    assert 1 <= len(texts) - len(set(texts)) <= 4
    eight = build_mall(5, SimulationConfig(loop_length=60.0, layout="figure-eight"))
    assert len(eight.layout.blocks) == 2
    assert {"shop", "facility"} <= {sign.kind for sign in eight.signs}
    for world in (chinese, english, eight):
        lid = world.scene.origin[:, 2].max()
        assert all(sign.corners[:, 2].min() > 0.3 and sign.corners[:, 2].max() < lid for sign in world.signs)
    for world in (chinese, eight):
        first_lines = [sign.text for sign in world.signs]
        assert len(first_lines) == len(set(first_lines))
        assert world.scene.texels.nbytes < 250e6


def test_a_user_learns_what_is_wrong() -> None:
    with pytest.raises(UserError, match="frames is 0"):
        MallSource(0, frames=0)
    with pytest.raises(UserError, match="seed is -1"):
        MallSource(-1)
