"""From rendered frames to landmarks, trajectory files and scores."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from command_line import Command
from in_chromium import chromium, shown, until
from lpslam import pipeline
from lpslam.evaluation.report import evaluate_recording
from lpslam.mapfile.export import export_map
from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.building import write_page
from lpslam.poses import StampedPoses
from lpslam.sources.ground_truth import read_ground_truth

pytestmark = pytest.mark.slow

FRAMES = 120  # of the recording `walk`
EVO = Path(sys.executable).with_name("evo_ape")


def test_a_walk_past_shops_becomes_a_map_of_their_names(world: LanguageMap, walk: Path) -> None:
    scores = evaluate_recording(world, walk)
    assert scores.frames == scores.frames_mapped == scores.frames_tracked == scores.ate.count == FRAMES
    assert scores.ate.rmse < 0.02
    assert scores.ate.rmse < 0.005 * scores.path_length
    truth = read_ground_truth(walk)
    assert truth is not None
    assert scores.path_length == pytest.approx(truth.path_length, abs=0.1)
    marks = scores.landmarks
    assert marks is not None
    assert marks.readable_signs >= 5
    assert marks.recall is not None
    assert marks.recall >= 0.8
    assert marks.precision is not None
    assert marks.precision >= 0.8
    assert marks.median_position_error is not None
    assert marks.median_position_error < 0.12


def test_the_map_frame_begins_at_the_first_camera_and_looks_along_x(world: LanguageMap) -> None:
    first = world.frame_poses().world_from_camera[0]
    np.testing.assert_allclose(first[:3, 3], 0, atol=0.05)
    # Levelling may turn it by the camera's own tilt, no further.
    assert first[0, 2] > 0.9
    assert first[2, 1] < -0.9


def test_half_a_map_is_scored_over_the_half_that_was_walked(world: LanguageMap, walk: Path) -> None:
    whole = evaluate_recording(world, walk)
    arrays = {name: column[: FRAMES // 2] for name, column in world.trajectory.to_arrays().items()}
    world.trajectory = type(world.trajectory).from_arrays(arrays)
    half = evaluate_recording(world, walk)
    assert (half.frames, half.frames_mapped, half.frames_tracked) == (FRAMES, FRAMES // 2, FRAMES // 2)
    assert half.share_tracked == 0.5
    assert 0.3 < half.path_length / whole.path_length < 0.7


def test_exported_trajectories_are_the_maps_in_tum_format(world: LanguageMap, walk: Path, tmp_path: Path) -> None:
    export_map(world, tmp_path)
    for name, poses in (("trajectory", world.frame_poses()), ("keyframes", world.keyframe_poses())):
        written = StampedPoses.from_tum_file(tmp_path / f"{name}.txt")
        np.testing.assert_allclose(written.timestamps, poses.timestamps, atol=1e-6)
        np.testing.assert_allclose(written.world_from_camera, poses.world_from_camera, atol=2e-6)
    # Optical frames: the camera looks along its z axis, to the horizon, and its y axis points down.
    axes = world.frame_poses().world_from_camera[:, :3, :3]
    assert (np.abs(axes[:, 2, 2]) < 0.5).all()
    assert (axes[:, 2, 1] < -0.8).all()
    listed = json.loads((tmp_path / "landmarks.json").read_text(encoding="utf-8"))["landmarks"]
    assert [mark["id"] for mark in listed] == [mark.id for mark in world.landmarks()]
    promised = {"id", "name", "variants", "position", "normal", "spread", "observations", "judgements"}
    for mark in listed:
        assert promised <= mark.keys()
        assert np.linalg.norm(mark["normal"]) == pytest.approx(1.0, abs=1e-3)
        assert sum(mark["variants"].values()) >= mark["observations"]


@pytest.mark.skipif(not EVO.exists(), reason="evo is not installed")
def test_eval_agrees_with_evo(lpslam: Command, walked: Path, walk: Path, tmp_path: Path) -> None:
    lpslam("export", walked, tmp_path / "out")
    scores = lpslam("eval", walked, walk, "--json").json
    words = [EVO, "tum", walk / "groundtruth.txt", tmp_path / "out" / "trajectory.txt", "--align"]
    environment = {**os.environ, "HOME": str(tmp_path), "MPLCONFIGDIR": str(tmp_path)}
    report = subprocess.run(words, capture_output=True, text=True, check=True, env=environment).stdout
    figures = {name: float(value) for name, value in re.findall(r"^\s*(\w+)\s+([\d.]+)\s*$", report, re.MULTILINE)}
    for name in ("rmse", "mean", "median", "max"):
        assert scores[f"ate_{name}_m"] == pytest.approx(figures[name], abs=5e-6), name


def test_the_nearest_of_two_equal_signs_is_the_goal(world: LanguageMap) -> None:
    answer = pipeline.ask(world, "Where is the washroom?", position=np.array([100.0, 0.0, 0.0]))
    assert answer.landmark is not None
    assert answer.distance == pytest.approx(np.linalg.norm(answer.landmark.position - [100.0, 0.0, 0.0]))
    assert answer.choice.landmark == answer.landmark.id


def test_the_demo_writes_everything_it_promises(lpslam: Command, tmp_path: Path) -> None:
    report = lpslam("demo", "-o", tmp_path / "demo", "--frames", 24, "--seed", 7, "--json").json
    assert report["map"]["frames_tracked"] == report["scores"]["frames"] == 24
    assert report["scores"]["ate_rmse_m"] < 0.02
    assert len({answer["question"] for answer in report["answers"]}) == 3
    assert json.loads((tmp_path / "demo" / "report.json").read_text(encoding="utf-8")) == report
    for name in ("map.png", "memory.png", "trajectory.png", "map.lpmap", "page.html"):
        assert (tmp_path / "demo" / name).stat().st_size > 10_000
    text = (tmp_path / "demo" / "report.md").read_text(encoding="utf-8")
    for answer in report["answers"]:
        assert answer["question"] in text
    assert all(f"({name}.png)" in text for name in ("map", "memory", "trajectory"))
    assert LanguageMap.load(tmp_path / "demo" / "map.lpmap").text.question == "Is this a shop?"


def test_the_page_of_a_map_opens_from_the_file_system_and_finds_a_name(world: LanguageMap, tmp_path: Path) -> None:
    marks = [mark for mark in world.landmarks() if len(mark.name) > 2]
    with chromium() as browser, shown(browser, write_page(world, tmp_path / "page.html").as_uri()) as page:
        assert page.locator("#signs button").count() == len(world.landmarks())
        for mark in marks[:2]:
            page.fill("#question", mark.name)
            page.press("#question", "Enter")
            until(page, f"lpslamPage.chosen() === {mark.id}")
            assert page.locator("#card h2").inner_text() == mark.name
