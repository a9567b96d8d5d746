"""What can be read on a walk: views of signs, duplicates, similar names, signs with two sides."""

import csv
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from lpslam.camera import inverse_transform, transform_points
from lpslam.config import SimulationConfig
from lpslam.simulation.lettering import is_chinese
from lpslam.simulation.lexicon import EVERYTHING, SIMILAR
from lpslam.simulation.mall import build_mall
from lpslam.simulation.signs import Sign
from lpslam.simulation.source import MallSource
from lpslam.simulation.visibility import SignViews, views_of
from lpslam.simulation.walk import stroll
from lpslam.simulation.writer import write_sequence

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def twins() -> tuple[Sign, ...]:
    """Signs of a mall that was asked for duplicates and similar names."""
    options = SimulationConfig(duplicate_distances=(3.0, 3.0, 15.0, 15.0), similar_names=True, loop_length=34.0)
    return build_mall(303, options).signs


def test_readable_means_near_frontal_sharp_whole_and_uncovered(mall: MallSource) -> None:
    poses, scene, camera = mall.ground_truth.world_from_camera, mall._mall.scene, mall.camera
    assert sum(sign.readable_frames >= 10 for sign in mall.signs) >= 5
    sign = max(mall.signs, key=lambda each: each.readable_frames)
    views = mall.sign_views[sign.id]
    seen = np.flatnonzero(views.readable())
    assert len(seen) == sign.readable_frames == sign.lines[0].readable_frames
    assert sign.readable_from == pytest.approx(seen[0] / 30)

    def look(pose: np.ndarray, end: np.ndarray | None = None, sign: Sign = sign, scene=scene) -> SignViews:  # type: ignore[no-untyped-def]
        still, last = pose[None], (pose if end is None else end)[None]
        return views_of(sign, scene, camera, still, still, last)

    pose = poses[seen[0]]
    plain = look(pose)
    assert plain.readable()[0]
    # Against the definitions, one by one.
    way = pose[:3, 3] - sign.corners.mean(axis=0)
    assert plain.distance[0] == pytest.approx(np.linalg.norm(way))
    assert np.cos(plain.angle[0]) == pytest.approx(way @ sign.normal / np.linalg.norm(way))
    ends = camera.project(transform_points(inverse_transform(pose), sign.lines[0].corners))
    box = sign.lines[0].corners
    drawn = np.linalg.norm(ends[[0, 1]] - ends[[3, 2]], axis=1).mean()
    letters = drawn * sign.letter_height / np.linalg.norm(box[0] - box[3])
    assert plain.letter_pixels[0] == pytest.approx(letters, rel=0.1)

    turned = pose.copy()
    turned[:3, :3] = pose[:3, :3] @ np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    assert not look(turned).readable()[0]
    assert look(turned).seen_share[0] == 0.0
    shaken = pose.copy()
    shaken[:3, 3] += 0.2 * pose[:3, 0]
    assert look(pose, shaken).blur_pixels[0] > 3.0
    assert not look(pose, shaken).readable()[0]
    tiny = replace(sign, lines=(replace(sign.lines[0], letter_height=sign.letter_height / 20), *sign.lines[1:]))
    assert not look(pose, sign=tiny).readable()[0]
    # A board between the eye and the sign: the scene's first face, moved there, first over all of it, then over half.
    origin, edge_u, edge_v, normal = (each.copy() for each in (scene.origin, scene.edge_u, scene.edge_v, scene.normal))
    middle = (pose[:3, 3] + sign.corners.mean(axis=0)) / 2
    edge_u[0], edge_v[0], normal[0] = pose[:3, 0] * 1.0, pose[:3, 1] * 1.0, -pose[:3, 2]
    for aside, share in ((0.0, 0.0), (0.5, 0.5)):
        origin[0] = middle - edge_u[0] * (0.5 - aside) - edge_v[0] / 2
        covered = replace(scene, origin=origin, edge_u=edge_u, edge_v=edge_v, normal=normal)
        view = look(pose, scene=covered)
        assert view.seen_share[0] == pytest.approx(share, abs=0.25)
        assert not view.readable()[0]


def test_the_second_line_is_read_from_nearer(mall: MallSource) -> None:
    boards = [sign for sign in mall.signs if len(sign.lines) == 2]
    assert boards
    for sign in boards:
        first, second = (mall.sign_views[sign.id].readable(line) for line in (0, 1))
        if is_chinese(sign.lines[1].text) or not is_chinese(sign.lines[0].text):
            assert not (second & ~first).any()
        assert sign.lines[1].readable_frames == second.sum()
        # The lines stand one over the other, inside the ink of all.
        assert sign.lines[0].centre[2] > sign.lines[1].centre[2]
        assert sign.height > sum(line.as_json()["height"] for line in sign.lines)


def test_duplicates_hang_at_the_distances_asked_for_and_look_the_same(twins: tuple[Sign, ...]) -> None:
    pairs = [(a, b) for a, b in combinations(twins, 2) if a.text == b.text]
    assert any(a.kind != "facility" for a, _ in pairs)
    apart = sorted(float(np.linalg.norm(a.centre - b.centre)) for a, b in pairs)
    assert len(pairs) == 4
    assert all(1.8 < distance < 4.5 for distance in apart[:2])
    assert all(10.5 < distance < 19.5 for distance in apart[2:])
    for a, b in pairs:
        assert [line.text for line in a.lines] == [line.text for line in b.lines]
        assert a.kind == b.kind
        # Shop fronts have the same fonts: letters are as wide for their height, but for what rounding to pixels does.
        first, second = (each.lines[0].as_json() for each in (a, b))
        if a.kind != "facility":
            ratio = second["width"] / second["letter_height"]
            assert first["width"] / first["letter_height"] == pytest.approx(ratio, rel=0.05)


def test_similar_names_are_shown_when_asked_for(twins: tuple[Sign, ...], mall: MallSource) -> None:
    names = {text for wording in SIMILAR for text in (wording.english, wording.chinese) if text}
    shown = names & {sign.text for sign in twins}
    assert {"GAP", "GAO"} <= shown
    assert len(shown) >= 6
    only_similar = names - {text for wording in EVERYTHING for text in (wording.english, wording.chinese)}
    assert not only_similar & {sign.text for sign in mall.signs}


def test_who_comes_back_sees_the_other_side() -> None:
    options = SimulationConfig(loop_length=24.0, projecting_share=1.0, way="there-and-back")
    source = MallSource(306, options=options)
    poses = source.ground_truth.world_from_camera
    two_sided = [sign for sign in source._mall.signs if sign.double_sided]
    # Every third frame, a tenth of a second after the one before; signs until there are enough.
    frames = range(0, len(source), 3)
    opened, closed = (np.array(each) for each in zip(*map(source._shutter, frames), strict=True))
    both = 0
    for sign in two_sided:
        is_front = (poses[::3, :3, 3] - sign.centre) @ sign.normal > 0
        readable = views_of(sign, source.scene, source.camera, poses[::3], opened, closed).readable()
        both += bool((readable & is_front).sum() >= 4 and (readable & ~is_front).sum() >= 4)
        if both == 3:
            break
    assert both == 3
    few = build_mall(306, SimulationConfig(loop_length=24.0, projecting_share=0.0))
    assert sum(sign.double_sided for sign in few.signs) <= 4 < len(two_sided)
    # The way back is the way there, on the other side of the corridor's middle, in the other direction.
    positions = poses[:, :2, 3]
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1) * 30
    assert 0.85 < steps.mean() < 1.2
    assert steps.max() < 1.6
    ahead = np.diff(positions, axis=0) / np.linalg.norm(np.diff(positions, axis=0), axis=1, keepdims=True)
    met = [
        ((np.linalg.norm(positions[:-1] - place, axis=1) < 1.5) & (ahead @ way < -0.7)).any()
        for place, way in zip(positions[:-1:30], ahead[::30], strict=True)
    ]
    assert np.mean(met) > 0.9
    for low, high in source._mall.layout.blocks:
        assert not np.any(np.all((positions > low - 0.3) & (positions < high + 0.3), axis=1))
    walk = stroll(306, source._mall.layout, source._mall.signs, options, None)
    turns = np.array([walk.pose(i / 30)[:3, 2] for i in range(walk.frames)])
    rates = np.degrees(np.arccos(np.clip((turns[1:] * turns[:-1]).sum(axis=1), -1, 1))) * 30
    assert rates.max() <= 46.0


def test_the_folder_says_how_each_frame_shows_each_sign(mall: MallSource, tmp_path: Path) -> None:
    short = MallSource(3, frames=60, options=mall._options)
    few = MallSource(3, frames=1, options=mall._options)
    few.__dict__["sign_views"], few.__dict__["signs"] = short.sign_views, short.signs
    write_sequence(few, tmp_path)
    with (tmp_path / "readability.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert rows
    assert {int(row["frame"]) for row in rows} == {0}
    for row in rows:
        views = short.sign_views[int(row["sign"])]
        assert float(row["letter_pixels"]) == pytest.approx(views.letter_pixels[0], abs=0.06)
        assert float(row["angle_degrees"]) == pytest.approx(np.degrees(views.angle[0]), abs=0.06)
        assert 0.0 < float(row["seen_share"]) <= 1.0
        assert bool(int(row["readable"])) == views.readable()[0]
