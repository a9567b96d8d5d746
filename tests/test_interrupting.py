"""Ctrl-C while a run goes on, in a process of its own."""

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from lpslam.mapfile.language_map import LanguageMap

pytestmark = pytest.mark.slow

# The run presses its own keys, so that the tests know when, by calling what answers the signal: two signals may fall
# together before the interpreter looks at them.
SCRIPT = """
import signal
from lpslam import cli
from lpslam.views.run_progress import RunProgress
# A shell that starts the tests in the background lets them ignore the key.
signal.signal(signal.SIGINT, signal.default_int_handler)
show = RunProgress.update
def show_and_press(self, progress):
    show(self, progress)
    if progress.frames == 5:
        for _ in range(PRESSES):
            signal.getsignal(signal.SIGINT)(signal.SIGINT, None)
RunProgress.update = show_and_press
cli.main()
"""


def pressed(presses: int, recording: Path, output: Path, *more: str) -> subprocess.CompletedProcess[str]:
    script = SCRIPT.replace("PRESSES", str(presses))
    words = [sys.executable, "-c", script, "run", str(recording), "-o", str(output), "--json", *more]
    return subprocess.run(words, capture_output=True, text=True, timeout=180, check=False)


def test_ctrl_c_saves_the_map_so_far(clip: Callable[[int], Path], tmp_path: Path) -> None:
    # With a reader, see below.
    done = pressed(1, clip(8), tmp_path / "map.lpmap", "--no-text")
    assert done.returncode == 130
    assert json.loads(done.stdout)["frames"] == 5
    assert f"interrupted; the map so far is in {tmp_path / 'map.partial.lpmap'}" in done.stderr
    assert not (tmp_path / "map.lpmap").exists(), "a whole map is not replaced by a part"
    assert "Traceback" not in done.stderr
    world = LanguageMap.load(tmp_path / "map.partial.lpmap")
    assert world.trajectory.tracked_count == 5


def test_a_second_ctrl_c_ends_at_once(clip: Callable[[int], Path], tmp_path: Path) -> None:
    done = pressed(2, clip(8), tmp_path / "map.lpmap")
    assert done.returncode == 130
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    assert "terminate" not in done.stderr, "the reading engine is not torn down at work"
    assert not list(tmp_path.glob("*map.lpmap*"))


PREPARING = """
import os, signal, time
import lpslam.slam.warm_up
from lpslam import cli
signal.signal(signal.SIGINT, signal.default_int_handler)
def warm_up(say):
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(60)
lpslam.slam.warm_up.warm_up = warm_up
cli.main()
"""


def test_ctrl_c_while_kernels_are_compiled_waits_for_none(clip: Callable[[int], Path], tmp_path: Path) -> None:
    words = [sys.executable, "-c", PREPARING, "run", str(clip(2)), "-o", str(tmp_path / "map.lpmap")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=50, check=False)
    assert done.returncode == 130
    assert done.stderr.strip().splitlines()[-1] == "lpslam: interrupted"
    assert not list(tmp_path.glob("*map.lpmap*"))


SLOW_READER = """
import signal, sys, time
import numpy as np
from lpslam import cli
from lpslam.text.reading.spotting import PaddleSpotter
from lpslam.views.run_progress import RunProgress
signal.signal(signal.SIGINT, signal.default_int_handler)
def detect(self, rgb):
    time.sleep(1.0)
    return np.zeros((0, 4, 2)), np.zeros(0)
PaddleSpotter.detect = detect
show = RunProgress.update
def show_and_press(self, progress):
    show(self, progress)
    if progress.frames == 20:
        print("pressed at", time.monotonic(), file=sys.stderr)
        signal.getsignal(signal.SIGINT)(signal.SIGINT, None)
RunProgress.update = show_and_press
cli.main()
"""


def test_ctrl_c_does_not_wait_for_a_reader_that_is_behind(clip: Callable[[int], Path], tmp_path: Path) -> None:
    """A dozen frames wait to be read by then, each of which takes a second."""
    (tmp_path / "config.yaml").write_text("text: {reading: {queue_size: 16}}\n")
    words = [sys.executable, "-c", SLOW_READER, "run", str(clip(40)), "-o", str(tmp_path / "map.lpmap")]
    words += ["--config", str(tmp_path / "config.yaml")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=180, check=False)
    ended = time.monotonic()
    assert done.returncode == 130
    assert LanguageMap.load(tmp_path / "map.partial.lpmap").trajectory.tracked_count == 20
    assert "not read for lack of time" in done.stderr
    assert ended - float(done.stderr.split("pressed at")[1].split()[0]) < 4.0
