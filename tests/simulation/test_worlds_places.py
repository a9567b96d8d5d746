"""Worlds as recordings: places, motions, what is blind, what is written."""

import json
from pathlib import Path

import numpy as np
import pytest

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.evaluation.signs import read_signs
from lpslam.simulation.scene import SceneBuilder
from lpslam.simulation.worlds.factors import FACTORS, draw_world
from lpslam.simulation.worlds.glazing import GLASS, MIRROR, glaze, glazings_of
from lpslam.simulation.worlds.motions import STEP, move
from lpslam.simulation.worlds.places.building import build_place
from lpslam.simulation.worlds.places.place import Pane
from lpslam.simulation.worlds.raster import view_of
from lpslam.simulation.worlds.source import WorldSource
from lpslam.simulation.worlds.writing import read_world, write_world
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source

PLACES = sorted(set(FACTORS["place"]))
SMALL = {"size": "320x240", "rate": "10", "seconds": 6.0}


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
def test_no_camera_is_ever_inside_of_anything(place: str) -> None:
    seed = 3 + PLACES.index(place)
    built = build_place(place, seed, "normal")
    for motion in sorted(set(FACTORS["motion"])):
        for visit in (0, 1):
            path = move(motion, seed, visit, built.route, built.solids, 12.0)
            assert built.solids.clearance(path.positions[::12]).min() > 0.05, (motion, visit)


@pytest.mark.parametrize("motion", sorted(set(FACTORS["motion"])))
def test_motions_are_smooth(motion: str) -> None:
    built = build_place("corridor", 5, "normal")
    path = move(motion, 5, 0, built.route, built.solids, 12.0)
    speed = np.diff(path.positions, axis=0) / STEP
    rate = np.diff(np.unwrap(path.angles[:, 0])) / STEP
    assert np.linalg.norm(speed, axis=1).max() < 3.0
    assert np.abs(rate).max() < np.radians(320)
    assert np.abs(np.diff(speed, axis=0)).max() / STEP < 60.0  # metres per square second, of a heavy step
    if motion == "robot":
        assert np.ptp(path.positions[:, 2]) < 0.01
    if motion == "rotation":
        assert np.ptp(np.unwrap(path.angles[:, 0])) > np.pi
        assert np.linalg.norm(np.ptp(path.positions, axis=0)) < 1.0
    if motion == "set-down":
        slow = np.linalg.norm(speed, axis=1) < 1e-4
        assert slow.sum() * STEP > 1.5


def test_the_camera_is_blind_in_the_bag_and_in_the_dark() -> None:
    bag = WorldSource(draw_world(3, motion="bag", place="corridor", **SMALL))
    assert 0.1 < bag.blind.mean() < 0.8
    dark = WorldSource(draw_world(3, motion="handheld", place="lights-off", light="normal", **SMALL))
    for source in (bag, dark):
        index = int(np.flatnonzero(source.blind)[len(np.flatnonzero(source.blind)) // 2])
        assert source.frame(index).rgb.mean() < 15
        seeing = int(np.flatnonzero(~source.blind)[0])
        assert source.frame(seeing).rgb.mean() > 30
    index = int(np.flatnonzero(bag.blind)[len(np.flatnonzero(bag.blind)) // 2])
    assert not bag.frame(index).depth.any()
    assert not WorldSource(draw_world(3, motion="handheld", place="corridor", **SMALL)).blind.any()


def test_frames_depend_on_the_world_alone() -> None:
    world = draw_world(7, place="corridor", compression="jpeg", **SMALL)
    first, second = WorldSource(world), WorldSource(world)
    a, b = first.frame(20), second.frame(20)
    assert np.array_equal(a.rgb, b.rgb)
    assert np.array_equal(a.depth, b.depth)
    assert not np.array_equal(a.rgb, first.frame(20, noise=1).rgb)
    again = WorldSource(world, visit=1)
    assert np.array_equal(again.place.scene.origin, first.place.scene.origin)
    assert not np.allclose(again.ground_truth.world_from_camera, first.ground_truth.world_from_camera)


@pytest.mark.parametrize("depth", sorted(set(FACTORS["depth"])))
def test_depth_and_colour_belong_together(depth: str) -> None:
    """Points of one frame, taken through the true poses, have the depth that another frame says."""
    world = draw_world(
        11, depth=depth, place="living", motion="handheld", light="normal", delay="none", registration="exact",
        depth_scale_error=0.0, lens="mild", calibration="right", depth_noise=0.0, **SMALL,
    )  # fmt: skip
    source = WorldSource(world)
    camera, truth = source.true_camera, source.ground_truth.world_from_camera
    errors = []
    for index in (5, 30):
        first, second = source.frame(index).depth, source.frame(index + 2).depth
        v, u = np.nonzero(first[::5, ::5])
        pixels = np.column_stack([u, v]) * 5.0
        points = camera.back_project(camera.undistort(pixels), first[::5, ::5][v, u].astype(float))
        seen = transform_points(inverse_transform(truth[index + 2]) @ truth[index], points)
        spots = camera.distort(camera.project(seen)).round().astype(int)
        inside = (spots >= 2).all(axis=1) & (spots < [camera.width - 2, camera.height - 2]).all(axis=1)
        there = second[spots[inside, 1], spots[inside, 0]]
        errors.append((there - seen[inside, 2])[there > 0] / seen[inside, 2][there > 0])
    error = np.concatenate(errors)
    assert len(error) > 500
    assert np.median(np.abs(error)) < 0.012


@pytest.mark.slow
def test_a_written_world_is_a_recording(tmp_path: Path) -> None:
    brief = {**SMALL, "seconds": 1.5}
    world = draw_world(13, place="living", compression="jpeg", delay="stamped", calibration="wrong", **brief)
    source = WorldSource(world)
    write_world(source, tmp_path)
    opened, truth = open_source(tmp_path), read_ground_truth(tmp_path)
    assert truth is not None
    assert len(opened) == len(source) == len(truth)
    assert opened.camera.fx == pytest.approx(source.true_camera.fx * (1 + world.focal_error))
    frames = {frame.index: frame for frame in opened}
    drawn = source.frame(10)
    assert np.array_equal(frames[10].rgb, drawn.rgb)
    assert np.array_equal(frames[10].depth, drawn.depth)
    again, tree = read_world(tmp_path)
    assert again == world
    assert tree["blind"] == [int(i) for i in np.flatnonzero(source.blind)]
    assert len(read_signs(tmp_path) or []) == len(source.signs) > 0
    stated = (tmp_path / "depth.txt").read_text().splitlines()[12]
    assert float(stated.split()[0]) == pytest.approx(source.timestamps[11] + world.depth_delay, abs=1e-5)


def test_a_hidden_delay_is_not_stated() -> None:
    hidden = WorldSource(draw_world(13, place="corridor", delay="hidden", **SMALL))
    assert hidden.world.depth_delay != 0.0
    assert np.array_equal(hidden.depth_timestamps, hidden.timestamps)


def test_a_mirror_shows_what_is_before_it_and_glass_what_is_behind() -> None:
    builder = SceneBuilder()
    red, blue = builder.add_colour((200, 0, 0)), builder.add_colour((0, 0, 200))
    up = np.array([0.0, 0.0, 1.0])
    # A blue wall at x = 4 that faces the camera at the origin, and a red one behind the camera at x = -1.
    builder.add_face(np.array([4.0, 3.0, 3.0]), np.array([0.0, -6.0, 0.0]), -6 * up, blue)
    builder.add_face(np.array([-1.0, -3.0, 3.0]), np.array([0.0, 6.0, 0.0]), -6 * up, red)
    scene = builder.build()
    camera = PinholeCamera(160, 120, 120.0, 120.0, 79.5, 59.5)
    pose = np.eye(4)
    pose[:3, :3] = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
    for is_mirror in (True, False):
        pane = Pane(np.array([2.0, 0.5, 0.5]), np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, -1.0]), is_mirror)
        view = view_of(scene, camera, pose)
        marks = glaze(view, camera, pose, glazings_of(scene, (pane,)))
        assert marks[60, 80] == (MIRROR if is_mirror else GLASS)
        assert marks[5, 5] == 0
        # Two metres to the mirror, and three from it to the red wall.
        assert view.depth[60, 80] == pytest.approx(5.0 if is_mirror else 4.0, abs=1e-3)
        red_and_blue = view.colour[60, 80, [0, 2]]
        assert (red_and_blue[0] > 150) == is_mirror
        assert (red_and_blue[1] > 150) == (not is_mirror)


def test_people_cover_what_is_behind_them_and_walk_on() -> None:
    source = WorldSource(draw_world(17, place="people", motion="handheld", light="normal", **SMALL))
    stage, lens = source._stage, source._lens
    rows = [row for walker in source.place.walkers for row in range(walker.first, walker.last)]
    shares = []
    for time in np.arange(0.0, 6.0, 1.0):
        view, _ = stage.view(lens.canvas, source.trajectory.poses(np.array([time]))[0], time, with_colour=False)
        shares.append(float(np.isin(view.face, rows).mean()))
    assert 0.01 < max(shares) < 0.55
    assert np.ptp(shares) > 0.01


def test_facts_of_a_world_are_plain_json(tmp_path: Path) -> None:
    world = draw_world(19, place="corridor", seconds=0.4, size="320x240", rate="10")
    write_world(WorldSource(world), tmp_path)
    tree = json.loads((tmp_path / "world.json").read_text())
    assert tree["world"]["seed"] == 19
    assert tree["path_metres"] >= 0
