"""RealSense cameras through the maker's library, on its software device."""

import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from software_camera import COLOUR_LENS, DEPTH_LENS, HEIGHT, SHIFT, WIDTH, Feeding, SoftwareCamera, rs

from command_line import Command
from lpslam.errors import MissingExtraError, UserError
from lpslam.frames import RgbdFrame
from lpslam.mapfile.language_map import LanguageMap
from lpslam.sources.live import realsense
from lpslam.sources.live.opening import is_camera, open_camera
from lpslam.sources.open import open_source
from lpslam.sources.writing.mcap_recording import McapSink
from lpslam.views.run_progress import RunProgress


def plugged_in(monkeypatch: pytest.MonkeyPatch, *cameras: SoftwareCamera) -> None:
    monkeypatch.setattr(realsense, "connected", lambda: [camera.device for camera in cameras])


def scene(number: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A slanted wall with a box before it, and a stripe without depth; raw units of a millimetre."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    raw = (1200 + 1.5 * u + 0.8 * v).astype(np.uint16)
    raw[60:140, 100:180] = 700
    raw[200:210] = 0
    rgb = np.random.default_rng(number).integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    return rgb, raw


def test_a_camera_gives_what_was_fed(monkeypatch: pytest.MonkeyPatch) -> None:
    camera = SoftwareCamera()
    plugged_in(monkeypatch, camera)
    source = open_camera("realsense:", max_frames=5, backlog=30)
    assert source.name == "Software D400 0042"
    assert (source.camera.fx, source.camera.cy) == (COLOUR_LENS[0], COLOUR_LENS[3])
    assert source.camera.fps == 30
    with Feeding(camera, scene):
        frames = list(source)
    assert len(frames) == 5
    for frame in frames:
        number = round(frame.timestamp * 30)
        assert frame.timestamp == pytest.approx(number / 30, abs=1e-6)
        np.testing.assert_array_equal(frame.rgb, scene(number)[0])


def test_registration_agrees_with_the_makers(monkeypatch: pytest.MonkeyPatch) -> None:
    """`rs.align` splats the same rectangles; it rounds their corners, so that edges differ by a pixel."""
    camera = SoftwareCamera()
    plugged_in(monkeypatch, camera)
    driver = realsense.RealsenseDriver()
    driver.start()
    sets = []
    for number in range(4):
        camera.feed(number, 33.3 * number, *scene(number))
        is_there, frames = driver._syncer.try_wait_for_frames(500)
        if is_there and frames.size() == 2:
            sets.append(frames)
    driver.stop()
    assert sets
    frames = sets[-1]
    raw = np.array(frames.get_depth_frame().get_data())
    ours = driver.registered(raw)
    aligned = rs.align(rs.stream.color).process(frames).get_depth_frame()
    theirs = np.array(aligned.get_data()).astype(np.float32) / 1000
    assert ours.shape == theirs.shape == (HEIGHT, WIDTH)
    both = (ours > 0) & (theirs > 0)
    assert both.mean() > 0.8
    assert ((ours > 0) != (theirs > 0)).mean() < 0.02
    # They keep the depth camera's distance, we the colour camera's, as its pixels' depth must be.
    points = lifted(raw / 1000.0)
    moved = points @ camera.rotation.T + SHIFT
    assert np.abs(moved[..., 2] - raw / 1000.0).max() < 0.05
    apart = np.abs(ours - theirs)[both]
    assert np.median(apart) < 0.02
    assert np.percentile(apart, 97) < 0.05
    expected = splatted(moved, raw > 0)
    seen = (expected > 0) & (ours > 0)
    assert np.percentile(np.abs(expected - ours)[seen], 97) < 0.01


def lifted(depth: np.ndarray) -> np.ndarray:
    fx, fy, cx, cy = DEPTH_LENS
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    return np.stack([(u - cx) / fx * depth, (v - cy) / fy * depth, depth], axis=-1)


def splatted(points: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Middles alone, the nearest last."""
    fx, fy, cx, cy = COLOUR_LENS
    x, y, z = points[held].T
    order = np.argsort(-z)
    u, v = np.rint(fx * x / z + cx).astype(int)[order], np.rint(fy * y / z + cy).astype(int)[order]
    inside = (u >= 0) & (u < WIDTH) & (v >= 0) & (v < HEIGHT)
    depth = np.zeros((HEIGHT, WIDTH))
    depth[v[inside], u[inside]] = z[order][inside]
    return depth


def test_addresses(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert is_camera("realsense:")
    assert is_camera(Path("realsense:0042"))
    assert not is_camera("webcam:")
    assert not is_camera(tmp_path)
    plugged_in(monkeypatch)
    with pytest.raises(UserError, match="no RealSense camera is connected; see 'lsusb'"):
        open_camera("realsense:")
    plugged_in(monkeypatch, SoftwareCamera())
    with pytest.raises(UserError, match="no RealSense camera 7 is connected, but 0042"):
        open_camera("realsense:7")
    assert open_camera("realsense:0042").name == "Software D400 0042"
    with pytest.raises(UserError, match="is a camera, which is calibrated by its maker"):
        open_source("realsense:", camera_file=tmp_path)


def test_a_camera_that_is_in_use_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    plugged_in(monkeypatch, SoftwareCamera())
    source, other = open_camera("realsense:", max_frames=1), realsense.RealsenseDriver()
    other.start()
    with pytest.raises(UserError, match=r"cannot be opened .* does another program use it"):
        list(source)
    other.stop()


def test_a_library_that_is_missing_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    import builtins

    real = builtins.__import__

    def without(name: str, *rest: object) -> object:
        if name == "pyrealsense2":
            raise error
        return real(name, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", without)
    error: Exception = ModuleNotFoundError("No module named 'pyrealsense2'")
    with pytest.raises(MissingExtraError, match=r"lp-slam\[realsense\]"):
        realsense.library()
    error = ImportError("libusb-1.0.so.0: cannot open shared object file")
    with pytest.raises(UserError, match="apt install libusb"):
        realsense.library()


def of_clip(clip: Path) -> tuple[SoftwareCamera, Callable[[int], tuple[np.ndarray, np.ndarray]]]:
    source = open_source(clip)
    frames, lens = list(source), source.camera
    matrix = (lens.fx, lens.fy, lens.cx, lens.cy)
    camera = SoftwareCamera(matrix, matrix, (lens.width, lens.height), is_apart=False)

    def picture(number: int) -> tuple[np.ndarray, np.ndarray]:
        # There and back, so that it moves on however long it is waited for.
        row = number % (2 * len(frames) - 2)
        frame = frames[min(row, 2 * len(frames) - 2 - row)]
        return frame.rgb, np.rint(frame.depth * 1000).astype(np.uint16)

    return camera, picture


@pytest.mark.slow
def test_a_camera_is_recorded_and_mapped(
    lpslam: Command, clip: Callable[[int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    camera, picture = of_clip(clip(20))
    plugged_in(monkeypatch, camera)
    bag, output = tmp_path / "walk.mcap", tmp_path / "map.lpmap"
    with Feeding(camera, picture):
        assert lpslam("record", "realsense:", bag, "--max-frames", 12).code == 0
    frames = list(open_source(bag))
    assert len(frames) == 12
    for frame in frames:
        rgb, raw = picture(round(frame.timestamp * 30))
        np.testing.assert_array_equal(frame.rgb, rgb)
        np.testing.assert_allclose(frame.depth, raw / 1000, atol=1e-6)
    camera, picture = of_clip(tmp_path / "clip")
    plugged_in(monkeypatch, camera)
    cv2.setNumThreads(1)
    with Feeding(camera, picture):
        done = lpslam("run", "realsense:", "-o", output, "--no-text", "--max-frames", 20, "--json")
    assert done.json["frames"] == 20
    assert LanguageMap.load(output).trajectory.tracked_count == 20
    assert lpslam("record", tmp_path, bag).code == 2


@pytest.mark.slow
def test_ctrl_c_is_the_end_of_a_camera(
    lpslam: Command, clip: Callable[[int], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    camera, picture = of_clip(clip(20))
    plugged_in(monkeypatch, camera)
    show = RunProgress.update

    def press(self: RunProgress, state: Any) -> None:
        show(self, state)
        if state.frames == 8:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(RunProgress, "update", press)
    output, poses = tmp_path / "map.lpmap", tmp_path / "poses.txt"
    with Feeding(camera, picture):
        done = lpslam("run", "realsense:", "-o", output, "--no-text", "--json")
    assert done.code == 0
    assert done.json["frames_tracked"] >= 8
    assert "interrupted" not in done.err
    assert LanguageMap.load(output).trajectory.tracked_count == done.json["frames_tracked"]
    camera, picture = of_clip(tmp_path / "clip")
    plugged_in(monkeypatch, camera)
    with Feeding(camera, picture):
        done = lpslam("run", "realsense:", "--localize", output, "--trajectory", poses, "--no-text", "--json")
    assert done.code == 0
    assert done.json["frames_localised"] >= 8
    camera, picture = of_clip(tmp_path / "clip")
    plugged_in(monkeypatch, camera)

    def press_while_recording(sink: McapSink, frame: RgbdFrame) -> None:
        add(sink, frame)
        if frame.index == 5:
            signal.raise_signal(signal.SIGINT)

    add = McapSink.add
    monkeypatch.setattr(McapSink, "add", press_while_recording)
    with Feeding(camera, picture):
        assert lpslam("record", "realsense:", tmp_path / "walk.mcap").code == 0
    assert len(list(open_source(tmp_path / "walk.mcap"))) >= 6
