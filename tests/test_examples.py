"""The examples do what they say, on a rendered recording."""

import queue
import runpy
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import lpslam
from lpslam.sources.open import open_source

EXAMPLES = Path(__file__).parent.parent / "examples"
FRAMES = 12


def example(name: str) -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


def started(name: str, monkeypatch: pytest.MonkeyPatch, *words: object) -> None:
    monkeypatch.setattr(sys, "argv", [name, *map(str, words)])
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.py")), ids=lambda file: file.stem)
def test_an_example_is_short(file: Path) -> None:
    assert len(file.read_text().splitlines()) <= 40


def test_a_queue_of_frames(walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = open_source(walk, max_frames=FRAMES)
    frames: queue.Queue[Any] = queue.Queue()
    for frame in source:
        frames.put((frame.rgb, frame.depth, frame.timestamp))
    frames.put(None)
    example("queue_of_frames")["map_frames"](source.camera, frames, str(tmp_path / "map.lpmap"))
    assert capsys.readouterr().out.count("tracking:") == FRAMES
    assert lpslam.LanguageMap.load(tmp_path / "map.lpmap").trajectory.tracked_count == FRAMES


def test_a_recording(clip: Callable[[int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started("map_a_recording", monkeypatch, clip(FRAMES), tmp_path / "map.lpmap")
    assert lpslam.LanguageMap.load(tmp_path / "map.lpmap").trajectory.tracked_count == FRAMES


class _Camera:
    """What the example uses of pyrealsense2, giving a recording's frames and then Ctrl-C."""

    def __init__(self, recording: Path) -> None:
        self._source = open_source(recording, max_frames=FRAMES)
        self._frames = iter(self._source)
        self.stopped = False
        self.stream = SimpleNamespace(color=0, depth=1)
        self.format = SimpleNamespace(rgb8=0, z16=1)

    def pipeline(self) -> "_Camera":
        return self

    def config(self) -> SimpleNamespace:
        return SimpleNamespace(enable_stream=lambda *what: None)

    def align(self, stream: int) -> SimpleNamespace:
        return SimpleNamespace(process=lambda frames: frames)

    def start(self, settings: object) -> SimpleNamespace:
        lens = self._source.camera
        seen = SimpleNamespace(
            width=lens.width, height=lens.height, fx=lens.fx, fy=lens.fy, ppx=lens.cx, ppy=lens.cy, coeffs=[0.0] * 5
        )
        sensor = SimpleNamespace(get_depth_scale=lambda: 0.001)
        return SimpleNamespace(
            get_device=lambda: SimpleNamespace(first_depth_sensor=lambda: sensor),
            get_stream=lambda kind: SimpleNamespace(
                as_video_stream_profile=lambda: SimpleNamespace(get_intrinsics=lambda: seen)
            ),
        )

    def wait_for_frames(self) -> SimpleNamespace:
        frame = next(self._frames, None)
        if frame is None:
            raise KeyboardInterrupt
        return SimpleNamespace(
            get_color_frame=lambda: SimpleNamespace(get_data=lambda: frame.rgb),
            get_depth_frame=lambda: SimpleNamespace(get_data=lambda: (frame.depth * 1000.0).astype(np.uint16)),
            get_timestamp=lambda: 1000.0 * frame.timestamp,
        )

    def stop(self) -> None:
        self.stopped = True


def test_a_live_realsense(walk: Path, tmp_path: Path) -> None:
    camera = _Camera(walk)
    example("live_realsense")["map_realsense"](camera, str(tmp_path / "map.lpmap"))
    assert camera.stopped
    assert lpslam.LanguageMap.load(tmp_path / "map.lpmap").trajectory.tracked_count == FRAMES


def test_localising(walked: Path, clip: Callable[[int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started("localise", monkeypatch, walked, clip(FRAMES), tmp_path / "poses.txt")
    poses = [line for line in (tmp_path / "poses.txt").read_text().splitlines() if not line.startswith("#")]
    assert len(poses) == FRAMES


def test_an_own_language_model(
    walked: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    name = lpslam.LanguageMap.load(walked).landmarks()[0].name
    started("own_language_model", monkeypatch, walked, f"Where is {name}?")
    assert name in capsys.readouterr().out


def test_an_own_reader(clip: Callable[[int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started("own_text_reader", monkeypatch, clip(FRAMES), tmp_path / "map.lpmap")
    statistics = lpslam.LanguageMap.load(tmp_path / "map.lpmap").statistics["reading"]
    assert statistics["frames_read"]
    assert not statistics["reader_errors"]
