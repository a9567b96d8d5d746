"""What somebody meets who tries the program for the first time, and makes the mistakes that one makes."""

import errno
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command_line import Command
from lpslam import cli_runs
from lpslam.config import Config
from lpslam.config.section import Section
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
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises(UserError, match="nothing is lost: the map is in ") as told:
        cli_runs.keep(world, full)
    assert len(LanguageMap.load(str(told.value).split("the map is in ")[1]).trajectory) == len(world.trajectory)


def test_distilling_says_what_it_found_though_the_disk_is_full(
    lpslam: Command, walked: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor can it be kept elsewhere: no empty folder is left where that was tried."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))

    def refused(self: LanguageMap, path: Path) -> None:
        raise UserError("no space left")

    monkeypatch.setattr(LanguageMap, "save", refused)
    done = lpslam("distill", walked, "--json")
    assert done.code == 2
    assert "no space left" in done.err
    assert done.json["landmarks"]
    assert not list(tmp_path.glob("lpslam-*"))


def test_an_export_is_whole_or_leaves_what_was_there(
    world: LanguageMap, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    export.export_map(world, folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}

    def full(path: Path, *what: object) -> None:
        path.write_bytes(b"ply")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(export, "write_ply", full)
    with pytest.raises(UserError, match="No space left"):
        export.export_map(world, folder)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_an_export_that_finds_no_room_names_the_place_that_was_asked_for_and_leaves_no_folder(
    world: LanguageMap, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"

    def full(path: Path, *what: object) -> None:
        raise UserError(f"{path} cannot be written (No space left on device)")

    monkeypatch.setattr(export, "write_ply", full)
    with pytest.raises(UserError, match=rf"^{folder}/cloud\.ply cannot be written"):
        export.export_map(world, folder)
    assert not folder.exists()


def test_exported_landmarks_say_what_their_numbers_are(world: LanguageMap, tmp_path: Path) -> None:
    export.export_map(world, tmp_path)
    listed = json.loads((tmp_path / "landmarks.json").read_text())
    assert (listed["version"], listed["units"]["position"]) == (1, "m")
    assert "z up" in listed["frame"]


def test_scoring_against_another_recording_is_refused(
    lpslam: Command, walked: Path, clip: Callable[[int], Path]
) -> None:
    assert "it was made of walk; give that one" in lpslam("eval", walked, clip(20)).complaint


def test_scoring_against_another_name_is_said(lpslam: Command, walked: Path, walk: Path, tmp_path: Path) -> None:
    shutil.copytree(walk, tmp_path / "other", copy_function=os.link)
    done = lpslam("eval", walked, tmp_path / "other")
    assert done.code == 0
    assert "the map was made of walk and is scored against other" in done.err
    assert not lpslam("eval", walked, walk).err


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


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
@pytest.mark.parametrize("where", ["2>/dev/full", "2>&-", ">&- 2>&-"])
def test_a_mistake_is_exit_code_2_though_nobody_listens(tmp_path: Path, where: str) -> None:
    words = f"{sys.executable} -m lpslam info {tmp_path / 'nowhere.lpmap'} {where}"
    done = subprocess.run(words, shell=True, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "")


def test_closed_streams_do_not_stop_a_command(walked: Path, tmp_path: Path) -> None:
    words = f"{sys.executable} -m lpslam export {walked} {tmp_path / 'out'} <&- >&- 2>&-"
    assert subprocess.run(words, shell=True, check=False).returncode == 0
    assert json.loads((tmp_path / "out" / "landmarks.json").read_text())["landmarks"]


@pytest.fixture
def full_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of its own that has 64 kB."""
    folder = tmp_path / "small"
    folder.mkdir()
    mounted = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)]
    if shutil.which("mount") is None or subprocess.run(mounted, capture_output=True, check=False).returncode:
        pytest.skip("a small file system cannot be mounted here")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_a_disk_that_fills_loses_nothing_and_keeps_no_part(
    lpslam: Command, clip: Callable[[int], Path], walked: Path, full_disk: Path
) -> None:
    recording = clip(4)
    done = lpslam("run", recording, "-o", full_disk / "map.lpmap", "--no-text")
    assert done.code == 2
    assert "No space left" in done.err
    rescued = Path(done.err.split("the map is in ")[1].strip())
    assert LanguageMap.load(rescued).trajectory.tracked_count == 4
    shutil.rmtree(rescued.parent)
    for words in (
        ("export", walked, full_disk / "out"),
        ("convert", recording, full_disk / "bag.mcap"),
        ("convert", recording, full_disk / "copy"),
        ("draw", walked, full_disk / "map.png"),
    ):
        assert "No space left" in lpslam(*words).complaint
    assert not [path for path in full_disk.rglob("*") if path.is_file()]


PRESSED = """
import os, signal, sys, threading, time
from lpslam import __main__
signal.signal(signal.SIGINT, signal.default_int_handler)
def press():
    for delay in DELAYS:
        time.sleep(delay)
        os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=press, daemon=True).start()
__main__.main()
"""


KILL = "os.getpid(), signal.SIGTERM"


@pytest.mark.parametrize("delays", [[0.05], [0.2], [0.4], [0.6], [0.3, 0.05], [0.5, 0.01]])
def test_ctrl_c_at_any_moment_is_one_line(delays: list[float], walked: Path) -> None:
    """Compiled modules that are broken off while they are loaded fail with errors of their own."""
    words = [sys.executable, "-c", PRESSED.replace("DELAYS", repr(delays)), "ask", str(walked)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        told = process.stderr.read()
        assert (process.wait(30), told) == (130, "lpslam: interrupted\n")


PRESSED_AT_THE_END = """
import os, signal, sys
from lpslam import interruption
signal.signal(signal.SIGINT, signal.default_int_handler)
class Terminal:
    def write(self, text):
        os.write(2, text.encode())
        os.kill(os.getpid(), signal.SIGINT)
    def flush(self):
        pass
sys.stderr = Terminal()
interruption.watch()
interruption.end()
"""


def test_ctrl_c_while_the_last_line_is_said_does_not_say_it_again() -> None:
    done = subprocess.run([sys.executable, "-c", PRESSED_AT_THE_END], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "lpslam: interrupted\n")


@pytest.mark.parametrize("moment", ["time.sleep(0.3)", "while len(os.listdir(FOLDER)) < 2: time.sleep(0.001)"])
def test_a_polite_kill_is_as_ctrl_c(moment: str, clip: Callable[[int], Path], tmp_path: Path) -> None:
    """By default it would end the process at once, and leave the part of a recording that nobody finds.

    It comes while the program is loaded, and once that part is there.
    """
    moment = moment.replace("FOLDER", repr(str(tmp_path)))
    script = PRESSED.replace("DELAYS", "[0]").replace("time.sleep(delay)", moment)
    words = [sys.executable, "-c", script.replace("os.getpid(), signal.SIGINT", KILL)]
    words += ["convert", str(clip(12)), str(tmp_path / "copy.mcap")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (130, "lpslam: interrupted\n")
    assert [path.name for path in tmp_path.iterdir()] == ["clip"], "no part of it is left"


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


def test_converting_in_a_pipe_says_how_far_it_is(
    lpslam: Command, clip: Callable[[int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_progress, "_LINE_EVERY", 0.0)
    assert "writing, 3 of 4 frames" in lpslam("convert", clip(4), tmp_path / "copy").err


def test_every_section_of_the_configuration_says_units_and_reasons(lpslam: Command) -> None:
    said = lpslam("config").out
    assert "  # metres; structured-light and stereo sensors are blind below\n    min_depth: 0.3" in said
    bare = [
        name
        for name, below in _walked_through(Config())
        if all("#" not in line for line in said.split(f"{name}:\n")[1].splitlines()[: 3 * len(below)])
    ]
    assert not bare


def _walked_through(section: Section) -> Iterator[tuple[str, dict[str, Any]]]:
    for name, value in section:
        if isinstance(value, Section):
            yield name, value.model_dump()
            yield from _walked_through(value)


def test_a_simulation_is_not_mixed_with_another(lpslam: Command, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert "is not empty" in lpslam("simulate", tmp_path, "--frames", 1).complaint


ENDING = """
import os, signal, sys, time
from lpslam import interruption
signal.signal(signal.SIGINT, signal.default_int_handler)  # who starts the tests in the background ignores it
interruption.watch()
class Held:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGNAL)
        time.sleep(0.01)
try:
    Held()
    time.sleep(5)
    print("went on")
except KeyboardInterrupt:
    interruption.end()
"""


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_key_that_falls_into_the_end_of_an_object_is_heard(name: str) -> None:
    words = [sys.executable, "-c", ENDING.replace("SIGNAL", name)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "lpslam: interrupted\n")
