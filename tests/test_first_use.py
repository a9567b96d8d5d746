"""What somebody meets who tries the program for the first time, and makes the mistakes that one makes."""

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from command_line import Command
from lpslam import cli_runs
from lpslam.errors import UserError
from lpslam.mapfile import export
from lpslam.mapfile.language_map import LanguageMap
from lpslam.sources.calibration import read_calibration
from lpslam.views import run_progress

LENS = "{fx: 500, fy: 500, cx: 320, cy: 240, width: 640, height: 480"


def test_a_map_is_replaced_only_by_force(lpslam: Command, clip: Callable[[int], Path], tmp_path: Path) -> None:
    words = ("run", clip(4), "-o", tmp_path / "map.lpmap", "--no-text", "--json")
    assert lpslam(*words).json["frames"] == 4
    before = (tmp_path / "map.lpmap").read_bytes()
    assert "give --force to replace it" in lpslam(*words).complaint
    assert (tmp_path / "map.lpmap").read_bytes() == before
    assert lpslam(*words, "--force").code == 0


def test_a_run_survives_a_full_disk(world: LanguageMap, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    save = LanguageMap.save
    full = tmp_path / "full" / "map.lpmap"

    def saved(self: LanguageMap, path: Path) -> None:
        if path == full:
            raise UserError("no space left")
        save(self, path)

    monkeypatch.setattr(LanguageMap, "save", saved)
    with pytest.raises(UserError, match="nothing is lost: the map is in ") as told:
        cli_runs.keep(world, full)
    assert len(LanguageMap.load(str(told.value).split("the map is in ")[1]).trajectory) == len(world.trajectory)


def test_distilling_says_what_it_found_though_the_disk_is_full(
    lpslam: Command, walked: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(self: LanguageMap, path: Path) -> None:
        raise UserError("no space left")

    monkeypatch.setattr(LanguageMap, "save", refused)
    done = lpslam("distill", walked, "--json")
    assert done.code == 2
    assert "no space left" in done.err
    assert done.json["landmarks"]


def test_an_export_is_whole_or_leaves_what_was_there(
    world: LanguageMap, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    export.export_map(world, folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}

    def full(path: Path, points: object) -> None:
        path.write_bytes(b"ply")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(export, "write_ply", full)
    with pytest.raises(UserError, match="No space left"):
        export.export_map(world, folder)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_exported_landmarks_say_what_their_numbers_are(world: LanguageMap, tmp_path: Path) -> None:
    export.export_map(world, tmp_path)
    listed = json.loads((tmp_path / "landmarks.json").read_text())
    assert (listed["version"], listed["units"]["position"]) == (1, "m")
    assert "z up" in listed["frame"]


def test_scoring_against_another_recording_is_refused(
    lpslam: Command, walked: Path, clip: Callable[[int], Path]
) -> None:
    assert "it was made of walk; give that one" in lpslam("eval", walked, clip(20)).complaint


def test_localising_that_finds_nothing_says_so(
    lpslam: Command, walked: Path, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    recording = clip(3)
    for picture in (recording / "rgb").iterdir():
        _blacken(picture)
    done = lpslam("run", recording, "--localize", walked, "--trajectory", tmp_path / "poses.txt", "--no-text")
    assert done.code == 2
    assert "none of 3 frames is found" in done.err
    assert not (tmp_path / "poses.txt").exists()


def _blacken(picture: Path) -> None:
    import cv2

    cv2.imwrite(str(picture), np.zeros((480, 640, 3), np.uint8))


def test_a_summary_lists_the_words(lpslam: Command, walked: Path, world: LanguageMap) -> None:
    assert set(lpslam("info", walked, "--json").json["words"]) == {mark.name for mark in world.landmarks()}


@pytest.mark.parametrize(("said", "scale"), [("depthscale: 5000", 5000.0), ("depth_scale: 5000", 5000.0)])
def test_a_depth_scale_is_understood_however_it_is_spelt(tmp_path: Path, said: str, scale: float) -> None:
    (tmp_path / "camera.yaml").write_text(f"{LENS}, {said}}}\n")
    assert read_calibration(tmp_path / "camera.yaml").camera.depth_scale == scale


def test_a_mistyped_key_is_told(tmp_path: Path) -> None:
    (tmp_path / "camera.yaml").write_text(f"{LENS}, depth_scale: 1000, distorsion: [0.1, 0, 0, 0, 0]}}\n")
    assert any("distorsion" in note for note in read_calibration(tmp_path / "camera.yaml").notes)


def test_a_fisheye_is_refused(tmp_path: Path) -> None:
    (tmp_path / "camera.yaml").write_text(f"{LENS}, fisheye: true}}\n")
    with pytest.raises(UserError, match="rectify the images"):
        read_calibration(tmp_path / "camera.yaml")


def test_the_module_is_the_command() -> None:
    done = subprocess.run([sys.executable, "-m", "lpslam", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("lpslam ")


def test_asking_without_an_input_is_one_line(walked: Path) -> None:
    words = f"{sys.executable} -m lpslam ask {walked} <&-"
    done = subprocess.run(words, shell=True, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "no standard input" in done.stderr


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
def test_a_full_output_is_one_line(walked: Path) -> None:
    words = f"{sys.executable} -m lpslam info {walked} > /dev/full"
    done = subprocess.run(words, shell=True, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1


def test_ctrl_c_while_it_loads_is_no_traceback() -> None:
    script = """
import sys
class Pressed:
    def find_spec(self, name, path=None, target=None):
        if name == "typer":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Pressed())
from lpslam.__main__ import main
main()
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "lpslam: interrupted\n")


def test_a_pipe_gets_a_line_now_and_then(
    lpslam: Command, clip: Callable[[int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_progress, "_LINE_EVERY", 0.0)
    done = lpslam("run", clip(4), "-o", tmp_path / "map.lpmap", "--no-text", "--json")
    assert done.err.count(" of 4 frames") == 4


def test_a_simulation_is_not_mixed_with_another(lpslam: Command, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert "is not empty" in lpslam("simulate", tmp_path, "--frames", 1).complaint
