"""What the SLAM benchmark counts is what it says."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lpslam.camera import PinholeCamera
from lpslam.frames import RgbdFrame
from lpslam.poses import StampedPoses

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(autouse=True)
def _beside_the_benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def turned(degrees: float, x: float = 0.0) -> np.ndarray:
    pose = np.eye(4)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    pose[:2, :2] = [[c, -s], [s, c]]
    pose[0, 3] = x
    return pose


def around(rounds: float, frames: int) -> StampedPoses:
    """A walk on a circle of 5 m, looking along it."""
    angles = np.linspace(0, 2 * np.pi * rounds, frames)
    poses = np.tile(np.eye(4), (frames, 1, 1))
    poses[:, :3, 2] = np.column_stack([-np.sin(angles), np.cos(angles), np.zeros(frames)])
    poses[:, :3, 1] = [0, 0, -1]
    poses[:, :3, 0] = np.cross(poses[:, :3, 1], poses[:, :3, 2])
    poses[:, :3, 3] = 5 * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(frames)])
    return StampedPoses(np.arange(frames) / 30.0, poses)


def test_pose_error_is_of_the_relative_pose() -> None:
    from slam_scores import pose_error

    metres, degrees = pose_error(turned(30.0, x=1.0), turned(26.0, x=1.25))
    assert metres == pytest.approx(0.25)
    assert degrees == pytest.approx(4.0)


def test_a_second_round_goes_on_where_the_first_ended() -> None:
    from slam_scale import where_it_was_before

    truth = around(1.1, 1100)
    assert where_it_was_before(truth) == pytest.approx(100, abs=2)


def test_the_mapped_part_is_reached_again_a_metre_before_its_start() -> None:
    from slam_recovery import _first_back

    truth = around(1.1, 1100)
    reached = _first_back(truth, until=500 / 30, since=600 / 30)
    # A metre on a circle of 5 m is 0.2 of 2 pi.
    assert reached * 30 == pytest.approx(1000 * (1 - 0.2 / (2 * np.pi)), abs=3)


def test_the_gap_is_blank_and_nothing_of_the_part_between_is_shown() -> None:
    from slam_recovery import BLANK, _with_a_gap

    frames = [RgbdFrame(i, i / 30, np.full((4, 4, 3), 9, np.uint8), np.ones((4, 4), np.float32)) for i in range(100)]
    shown = list(_with_a_gap(frames, 50, 80))  # type: ignore[arg-type]
    blank = [frame for frame in shown if not frame.rgb.any()]
    assert len(blank) == BLANK
    assert [frame.index for frame in shown] == [*range(50 + BLANK), *range(80, 100)]
    assert np.all(np.diff([frame.timestamp for frame in shown]) > 0)


@pytest.mark.parametrize(("metres", "is_mapped"), [(3.0, True), (1.0, False)])
def test_what_a_keyframe_sees_a_wall_before_is_not_mapped_by_it(metres: float, is_mapped: bool) -> None:
    """The camera stands where the keyframe stood and sees a wall at 3 m; the keyframe saw one so many metres away."""
    from worlds_carried import MappedViews, reach_of

    camera = PinholeCamera(width=320, height=240, fx=280.0, fy=280.0, cx=160.0, cy=120.0)
    reach = reach_of(np.full((240, 320), metres, np.float32))
    views = MappedViews(np.eye(4)[None], reach[None], camera)
    frame = RgbdFrame(0, 0.0, np.zeros((240, 320, 3), np.uint8), np.full((240, 320), 3.0, np.float32))
    assert views.show(frame, np.eye(4)) == is_mapped


def test_holes_and_thin_things_hide_nothing() -> None:
    from worlds_carried import is_hidden, reach_of

    depth = np.full((240, 320), 3.0, np.float32)
    depth[:, 100:108] = 1.0
    depth[:80] = 0.0
    reach = reach_of(depth)
    assert reach.shape == (30, 40)
    assert not is_hidden(np.full(reach.shape, 3.0), reach).any()


def test_holding_frames_keeps_them_as_they_are() -> None:
    from slam_live import _Held

    class Two:
        name, camera, faults = "two", PinholeCamera(4, 4, 4.0, 4.0, 2.0, 2.0), []

        def __len__(self) -> int:
            return 2

        def __iter__(self):  # type: ignore[no-untyped-def]
            for i in range(2):
                yield RgbdFrame(i, i / 30, np.zeros((4, 4, 3), np.uint8), np.ones((4, 4), np.float32))

    held = _Held(Two())
    assert [frame.index for frame in held] == [frame.index for frame in held] == [0, 1]


@pytest.mark.slow
def test_accuracy_of_a_short_walk(clip: Callable[[int], Path], tmp_path: Path) -> None:
    walk = clip(14).rename(tmp_path / "walk")
    command = [sys.executable, BENCHMARKS / "slam.py", "accuracy", walk, "--runs", "2", "--out", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    first, second = (json.loads(line) for line in (tmp_path / "results.jsonl").read_text().splitlines())
    assert (first["tracked"], second["tracked"]) == (first["frames"], second["frames"]) == (14, 13)
    assert max(first["ate_rmse_m"], second["ate_rmse_m"]) < 0.01
    assert first["wrong_loops"] == first["loops"] == 0
    assert (tmp_path / "walk-run-1.png").stat().st_size > 10_000
    assert "| walk | 100.0% of 14 |" in done.stdout
