"""Every mistake is one clear line (what, where, remedy) and exit code 2; a bad frame is skipped and counted."""

import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from command_line import Command
from small_maps import small_map, with_floor

pytestmark = pytest.mark.slow

Clip = Callable[[int], Path]


def images(folder: Path, kind: str) -> list[Path]:
    return sorted((folder / kind).iterdir(), key=lambda path: float(path.stem))


def refused(lpslam: Command, recording: Path, *words: object) -> str:
    """The complaint of a run, which must leave no map."""
    output = recording.parent / "refused.lpmap"
    complaint = lpslam("run", recording, "-o", output, "--no-text", *words).complaint
    assert not list(recording.parent.glob("*refused.lpmap*"))
    return complaint


def test_no_recording(lpslam: Command, tmp_path: Path) -> None:
    assert "nowhere does not exist; give the folder" in refused(lpslam, tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    assert "looked for rgb.txt and depth.txt (TUM RGB-D) or" in refused(lpslam, tmp_path / "empty")
    (tmp_path / "file").touch()
    assert "is empty" in refused(lpslam, tmp_path / "file")


def test_lists_and_calibrations(lpslam: Command, clip: Clip) -> None:
    recording = clip(3)
    camera, rgb = recording / "camera.yaml", recording / "rgb.txt"
    calibration, listed = camera.read_text(), rgb.read_text()
    rgb.write_text("")
    assert "rgb.txt lists no images" in refused(lpslam, recording)
    rgb.write_text(listed)
    camera.write_text("\n".join(line for line in calibration.splitlines() if not line.startswith("fx")))
    assert "camera.yaml: fx is missing" in refused(lpslam, recording)
    camera.write_text(calibration.replace("width: 640", "width: 320").replace("height: 480", "height: 240"))
    assert "its images are 640×480, its calibration is for 320×240" in refused(lpslam, recording)
    camera.unlink()
    assert "--camera FILE" in refused(lpslam, recording)
    assert "nowhere.yaml cannot be read" in refused(lpslam, recording, "--camera", recording / "nowhere.yaml")
    other = recording.parent / "other.yaml"
    other.write_text(calibration)
    output = recording.parent / "good.lpmap"
    assert lpslam("run", recording, "-o", output, "--no-text", "--camera", other).code == 0
    assert "--camera FILE" in lpslam("eval", output, recording).complaint
    assert lpslam("eval", output, recording, "--camera", other).code == 0


def test_bad_frames_are_skipped_counted_and_shown(lpslam: Command, clip: Clip, tmp_path: Path) -> None:
    recording = clip(8)
    colours, depths = images(recording, "rgb"), images(recording, "depth")
    colours[2].write_bytes(colours[2].read_bytes()[:5000])
    depths[3].write_bytes(depths[3].read_bytes()[:5000])
    cv2.imwrite(str(colours[4]), np.zeros((48, 64, 3), np.uint8))
    depths[5].unlink()
    done = lpslam("run", recording, "-o", tmp_path / "map.lpmap", "--no-text", "--json")
    assert (done.code, done.json["frames_tracked"], done.json["frames_skipped"]) == (0, 4, 4)
    assert done.err == f"lpslam: 4 frames skipped; the first, frame 2: {colours[2].name} is truncated\n"
    assert "4 more skipped" in lpslam("info", tmp_path / "map.lpmap").out


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_depth_that_says_nothing(lpslam: Command, clip: Clip, value: float) -> None:
    recording = clip(4)
    listed = (recording / "depth.txt").read_text()
    (recording / "depth.txt").write_text(listed.replace(".png", ".tiff"))
    for path in images(recording, "depth"):
        cv2.imwrite(str(path.with_suffix(".tiff")), np.full((480, 640), value, np.float32))
        path.unlink()
    complaint = refused(lpslam, recording)
    assert complaint.startswith("clip: none of 4 frames can be tracked (waiting for a first view: 0 of ")
    assert "check the depth scale" in complaint


def test_no_frame_can_be_decoded(lpslam: Command, clip: Clip) -> None:
    recording = clip(3)
    for path in images(recording, "rgb"):
        path.write_bytes(b"")
    assert "none of its 3 frames can be used; the first: " in refused(lpslam, recording)


def test_a_recording_of_one_frame_is_a_map_but_no_trajectory(lpslam: Command, clip: Clip, tmp_path: Path) -> None:
    recording, path = clip(1), tmp_path / "one.lpmap"
    assert lpslam("run", recording, "-o", path, "--no-text", "--json").json["frames_tracked"] == 1
    assert "1 tracked frames; the trajectory error needs at least 3" in lpslam("eval", path, recording).complaint
    assert lpslam("draw", path, tmp_path / "one.png").code == 0
    assert lpslam("export", path, tmp_path / "one").code == 0


def test_frames_without_a_pose_are_said_with_their_reason(lpslam: Command, clip: Clip, tmp_path: Path) -> None:
    recording = clip(6)
    for path in images(recording, "rgb")[4:]:
        cv2.imwrite(str(path), np.full((480, 640, 3), 40, np.uint8))
    for path in images(recording, "depth")[4:]:
        cv2.imwrite(str(path), np.zeros((480, 640), np.uint16))
    done = lpslam("run", recording, "-o", tmp_path / "map.lpmap", "--no-text", "--json")
    assert done.json["frames_tracked"] == 4
    assert done.err.startswith("lpslam: 2 frames not tracked; the first, frame 4: coasting: 0 keypoints")


@pytest.mark.parametrize("has_ground", [False, True])
def test_an_export_that_cannot_be_whole_writes_nothing(lpslam: Command, tmp_path: Path, has_ground: bool) -> None:
    world = small_map(["Bakery"])
    (with_floor(world) if has_ground else world).save(tmp_path / "map.lpmap")
    done = lpslam("export", tmp_path / "map.lpmap", tmp_path / "out", "--nav2", "--route", "Where is an aeroplane?")
    assert ("nothing on the map serves" if has_ground else "nothing of the ground") in done.complaint
    assert not (tmp_path / "out").exists()


def test_places_that_cannot_be_written(lpslam: Command, walked: Path, clip: Clip, tmp_path: Path) -> None:
    recording = clip(2)
    precious = tmp_path / "thesis.txt"
    precious.write_text("all of it")
    assert "does not exist; make it first" in lpslam("run", recording, "-o", tmp_path / "no" / "m.lpmap").complaint
    assert "is a folder" in lpslam("run", recording, "-o", tmp_path).complaint
    assert "it is not overwritten" in lpslam("run", recording, "-o", precious).complaint
    assert "cannot be written" in lpslam("draw", walked, tmp_path / "no" / "map.png").complaint
    assert "no picture format" in lpslam("draw", walked, tmp_path / "map").complaint
    assert "choose another folder" in lpslam("export", walked, precious).complaint
    assert "choose another folder" in lpslam("simulate", precious, "--frames", 1).complaint
    assert "choose another folder" in lpslam("demo", "-o", precious).complaint
    (tmp_path / "demo").mkdir()
    (tmp_path / "demo" / "map.lpmap").write_text("no map")
    assert "it is not overwritten" in lpslam("demo", "-o", tmp_path / "demo").complaint, "before minutes of work"
    assert precious.read_text() == "all of it"


def damaged(walked: Path, folder: Path) -> dict[str, tuple[Path, str]]:
    """Files that are no readable map, and what is said of them."""
    content = walked.read_bytes()
    files = {name: folder / f"{name}.lpmap" for name in ("missing", "text", "cut", "flipped", "newer", "partial")}
    files["text"].write_text("no map")
    files["cut"].write_bytes(content[: len(content) // 2])
    middle = len(content) // 2
    files["flipped"].write_bytes(content[:middle] + bytes([content[middle] ^ 255]) + content[middle + 1 :])
    with (
        zipfile.ZipFile(walked) as good,
        zipfile.ZipFile(files["newer"], "w") as newer,
        zipfile.ZipFile(files["partial"], "w") as partial,
    ):
        for name in good.namelist():
            data = good.read(name)
            if name == "manifest.json":
                newer.writestr(name, json.dumps({**json.loads(data), "format_version": 99}))
            else:
                newer.writestr(name, data)
            if name != "arrays/slam.position.npy":
                partial.writestr(name, data)
    said = {
        "missing": "cannot be read (No such file",
        "text": "is not an lpslam map",
        "cut": "is not an lpslam map, or is damaged",
        "flipped": "is damaged",
        "newer": "of format version 99, this lpslam reads up to 3: update lpslam",
        "partial": "is missing",
    }
    return {name: (files[name], said[name]) for name in files}


def test_files_that_are_no_readable_map_are_said_to_be_and_left_alone(
    lpslam: Command, walked: Path, walk: Path, tmp_path: Path
) -> None:
    for path, said in damaged(walked, tmp_path).values():
        before = path.read_bytes() if path.exists() else None
        for words in (
            ["info", path],
            ["distill", path],
            ["ask", path, "pizza?"],
            ["export", path, tmp_path / "out"],
            ["draw", path, tmp_path / "map.png"],
            ["eval", path, walk],
        ):
            complaint = lpslam(*words).complaint
            assert said in complaint
            assert path.name in complaint
        assert (path.read_bytes() if path.exists() else None) == before
    assert not (tmp_path / "out").exists()


def test_questions_models_and_truths_that_are_missing(
    lpslam: Command, walked: Path, clip: Clip, tmp_path: Path
) -> None:
    assert "the question is empty" in lpslam("ask", walked, " ").complaint
    assert "the question is empty" in lpslam("distill", walked, "--judge", "").complaint
    assert "use offline, openai:MODEL" in lpslam("ask", walked, "pizza?", "--llm", "hal").complaint
    assert "does not exist" in lpslam("eval", walked, tmp_path / "nowhere").complaint
    recording = clip(2)
    (recording / "groundtruth.txt").unlink()
    assert "has no ground truth; looked for groundtruth.txt" in lpslam("eval", walked, recording).complaint
    assert "cannot be read" in lpslam("run", recording, "-o", tmp_path / "m.lpmap", "--config", "no.yaml").complaint
    unused = tmp_path / "config.yaml"
    unused.write_text("slam: {nope: 3}\n")
    assert "slam.nope" in lpslam("export", walked, tmp_path / "out", "--config", unused).complaint
    assert not (tmp_path / "out").exists()
    assert "option --layout" in lpslam("simulate", tmp_path / "s", "--layout", "spiral").complaint


def test_names_of_files_in_a_recording_cannot_steer_the_terminal(lpslam: Command, clip: Clip, tmp_path: Path) -> None:
    recording = clip(3)
    listed = (recording / "rgb.txt").read_text().splitlines()
    listed[1] = f"{listed[1].split()[0]} rgb/\x1b[2Jgone.png"
    (recording / "rgb.txt").write_text("\n".join(listed))
    done = lpslam("run", recording, "-o", tmp_path / "map.lpmap", "--no-text")
    assert "1 frame skipped" in done.err
    assert "\x1b" not in done.err


def test_a_doubtful_calibration_is_said_and_used_and_an_impossible_one_refused(
    lpslam: Command, clip: Clip, tmp_path: Path
) -> None:
    recording = clip(3)
    camera = recording / "camera.yaml"
    calibration = camera.read_text()
    camera.write_text(calibration.replace("depth_scale: 5000.0", "depth_scale: 1000.0"))
    done = lpslam("run", recording, "-o", tmp_path / "map.lpmap", "--no-text")
    first = done.err.splitlines()[0]
    assert first.startswith("lpslam: clip: at depth_scale 1000 the median depth is ")
    assert "depth_scale 5000 in the calibration would make it" in first
    camera.write_text(calibration.replace("depth_scale: 5000.0", "depth_scale: 1.0"))
    assert "clip: at depth_scale 1 the median depth is" in refused(lpslam, recording)
    for path in images(recording, "depth"):
        cv2.imwrite(str(path), np.full((212, 256), 9000, np.uint16))
    camera.write_text(calibration)
    assert "clip: its colour images are 640×480, its depth images 256×212; register" in refused(lpslam, recording)
