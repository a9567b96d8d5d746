import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from recordings import CAMERA_YAML, picture, raw_depth, write_tum

from lpslam.errors import UserError
from lpslam.frames import FrameSource
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source
from lpslam.sources.tum import open_tum


def test_frames_are_read_as_written(tmp_path: Path) -> None:
    source = open_source(write_tum(tmp_path / "walk"))
    assert isinstance(source, FrameSource)
    frames = list(source)
    assert [frame.index for frame in frames] == [0, 1, 2, 3, 4]
    assert source.name == "walk"
    assert (source.camera.fx, source.camera.fy, source.camera.depth_scale) == (50.0, 51.0, 5000.0)
    for i, frame in enumerate(frames):
        np.testing.assert_array_equal(frame.rgb, picture(i))
        assert frame.depth.dtype == np.float32
        np.testing.assert_allclose(frame.depth, raw_depth(i) / 5000, rtol=1e-6)
        assert frame.timestamp == pytest.approx(100 + i / 30, abs=1e-6)
    assert source.faults == []
    assert len(list(source)) == 5, "a second iteration starts from the first frame"


def test_lists_out_of_order_are_sorted_and_max_frames_takes_the_first(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk")
    lines = (folder / "rgb.txt").read_text().splitlines()
    (folder / "rgb.txt").write_text("\n".join(reversed(lines)))
    source = open_source(folder, max_frames=3)
    assert len(source) == 3
    for i, frame in enumerate(source):
        np.testing.assert_array_equal(frame.rgb, picture(i))


def test_depth_missing_for_a_frame_is_a_fault_and_each_depth_is_used_once(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk")
    lines = (folder / "depth.txt").read_text().splitlines()
    del lines[3]
    (folder / "depth.txt").write_text("\n".join(lines))
    source = open_source(folder)
    assert [frame.index for frame in source] == [0, 1, 3, 4]
    assert [(fault.index, "no depth" in fault.reason) for fault in source.faults] == [(2, True)]
    assert len(source) == 5


def test_one_frame_and_repeated_timestamps(tmp_path: Path) -> None:
    assert len(list(open_source(write_tum(tmp_path / "one", frames=1)))) == 1
    folder = write_tum(tmp_path / "twice")
    with (folder / "rgb.txt").open("a") as listing:
        listing.write("100.000000 rgb/1.png\n")
    source = open_source(folder)
    assert len(list(source)) == 5
    assert len(source.faults) == 1


def cut(path: Path, share: float) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.99])
@pytest.mark.parametrize("image", ["rgb/2.png", "depth/2.png"])
def test_truncated_images_are_faults(
    tmp_path: Path, image: str, share: float, capfd: pytest.CaptureFixture[str]
) -> None:
    folder = write_tum(tmp_path / "walk")
    cut(folder / image, share)
    source = open_source(folder)
    assert [frame.index for frame in source] == [0, 1, 3, 4]
    assert len(source.faults) == 1
    assert Path(image).name in source.faults[0].reason
    assert capfd.readouterr().err == "", "the decoder has nothing to add"


def test_a_flipped_byte_is_a_fault(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk")
    data = bytearray((folder / "depth/1.png").read_bytes())
    data[len(data) // 2] ^= 0xFF
    (folder / "depth/1.png").write_bytes(data)
    source = open_source(folder)
    assert len(list(source)) == 4
    assert "checksum" in source.faults[0].reason


def test_a_file_that_is_no_image_is_a_fault(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    folder = write_tum(tmp_path / "walk")
    (folder / "rgb/1.png").write_bytes(b"groceries: milk" * 100)
    (folder / "depth/2.png").write_bytes(b"\xff\xd8 half a jpeg")
    source = open_source(folder)
    assert [frame.index for frame in source] == [0, 3, 4]
    assert "not an image" in source.faults[0].reason
    assert "truncated" in source.faults[1].reason
    assert capfd.readouterr().err == ""


def test_a_missing_image_wrong_sizes_and_wrong_depths_are_faults(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk", frames=6)
    (folder / "rgb/0.png").unlink()
    cv2.imwrite(str(folder / "rgb/1.png"), picture(1, width=32))
    cv2.imwrite(str(folder / "depth/2.png"), raw_depth(2, height=20))
    cv2.imwrite(str(folder / "depth/3.png"), picture(3))
    cv2.imwrite(str(folder / "depth/4.png"), (raw_depth(4) // 256).astype(np.uint8))
    source = open_source(folder)
    assert [frame.index for frame in source] == [5]
    reasons = [fault.reason for fault in source.faults]
    assert len(reasons) == 5
    for reason, words in zip(reasons, ["cannot be read", "32×48", "64×20", "channel", "uint8"], strict=True):
        assert words in reason


@pytest.mark.parametrize("value", [0, 65535])
def test_a_frame_without_any_depth_is_still_a_frame(tmp_path: Path, value: int) -> None:
    folder = write_tum(tmp_path / "walk", frames=1)
    cv2.imwrite(str(folder / "depth/0.png"), np.full((48, 64), value, np.uint16))
    (frame,) = open_source(folder)
    assert np.isfinite(frame.depth).all()


def test_floating_point_depth_with_nan_everywhere_is_no_depth(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk", frames=2)
    cv2.imwrite(str(folder / "depth/0.tiff"), np.full((48, 64), np.nan, np.float32))
    listing = folder / "depth.txt"
    listing.write_text(listing.read_text().replace("depth/0.png", "depth/0.tiff"))
    frame = next(iter(open_source(folder)))
    assert (frame.depth == 0).all()


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("rgb.txt", "", "lists no images"),
        ("rgb.txt", "# only\n# comments\n", "lists no images"),
        ("depth.txt", "", "lists no images"),
        ("rgb.txt", "100.0\n", "line 1"),
        ("rgb.txt", "# c\nnoon rgb/0.png\n", "line 2"),
        ("depth.txt", "nan depth/0.png\n", "line 1"),
        ("depth.txt", "9999.0 depth/0.png\n", "same clock"),
        ("camera.yaml", "fy: 1\ncx: 1\ncy: 1\n", "fx is missing"),
        ("camera.yaml", CAMERA_YAML.replace("64", "640"), "64×48"),
    ],
)
def test_malformed_recordings_are_one_clear_line(tmp_path: Path, name: str, content: str, words: str) -> None:
    folder = write_tum(tmp_path / "walk")
    (folder / name).write_text(content)
    with pytest.raises(UserError, match=words) as caught:
        open_source(folder)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["rgb.txt", "depth.txt"])
def test_a_missing_list_is_named(tmp_path: Path, name: str) -> None:
    folder = write_tum(tmp_path / "walk")
    (folder / name).unlink()
    with pytest.raises(UserError, match=name):
        open_source(folder)


def test_no_usable_frame_at_all_is_an_error(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk")
    for path in (folder / "depth").iterdir():
        path.write_bytes(b"")
    with pytest.raises(UserError, match="none of its 5 frames"):
        list(open_source(folder))


@pytest.mark.parametrize("limit", [0, -1])
def test_a_limit_below_one_is_refused(tmp_path: Path, limit: int) -> None:
    with pytest.raises(UserError, match="at least 1"):
        open_source(write_tum(tmp_path / "walk"), max_frames=limit)


@pytest.mark.parametrize(
    ("folder_name", "fx", "distorted"),
    [("rgbd_dataset_freiburg1_xyz", 517.3, True), ("fr2_desk", 520.9, True), ("freiburg3_long_office", 535.4, False)],
)
def test_freiburg_calibrations_are_known_by_the_folders_name(
    tmp_path: Path, folder_name: str, fx: float, distorted: bool
) -> None:
    source = open_tum(write_tum(tmp_path / folder_name, camera=None))
    assert source.camera.fx == fx
    assert source.camera.is_distorted is distorted
    assert source.camera.depth_scale == 5000
    assert len(source.notes) == 1


@pytest.mark.parametrize("name", ["camera.json", "calibration.json", "camera_info.yaml", "intrinsics.json"])
def test_a_calibration_beside_the_lists_is_found_by_any_usual_name(tmp_path: Path, name: str) -> None:
    folder = write_tum(tmp_path / "walk", camera=None)
    (folder / name).write_text(json.dumps(yaml.safe_load(CAMERA_YAML)))
    assert open_source(folder).camera.fx == 50.0


def test_an_unknown_camera_is_asked_for_and_can_be_given(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk", camera=None)
    with pytest.raises(UserError, match="--camera"):
        open_source(folder)
    (tmp_path / "mine.yaml").write_text("fx: 1\nfy: 1\ncx: 1\ncy: 1\n")
    source = open_tum(folder, tmp_path / "mine.yaml")
    assert (source.camera.width, source.camera.height) == (64, 48)
    assert source.camera.depth_scale == 5000
    assert "5000" in source.notes[0]
    with pytest.raises(UserError, match="cannot be read"):
        open_source(folder, tmp_path / "none.yaml")


def test_ground_truth_is_read_where_there_is_one(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk")
    assert read_ground_truth(folder) is None
    (folder / "groundtruth.txt").write_text("# t\n100 1 2 3 0 0 0 1\n101 1 2 4 0 0 1 0\n")
    truth = read_ground_truth(folder)
    assert truth is not None
    np.testing.assert_allclose(truth.positions, [[1, 2, 3], [1, 2, 4]])
    np.testing.assert_allclose(truth.world_from_camera[1, :3, :3], np.diag([-1, -1, 1]), atol=1e-12)


def test_while_depth_pauses_the_camera_is_seen_in_colour(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk", frames=30)
    lines = (folder / "depth.txt").read_text().splitlines()
    header = len(lines) - 30
    kept = [line for row, line in enumerate(lines) if not header + 8 <= row < header + 20 and row != header + 25]
    (folder / "depth.txt").write_text("\n".join(kept))
    source = open_source(folder)
    frames = list(source)
    assert [frame.index for frame in frames if not frame.depth.any()] == list(range(8, 20))
    assert [fault.index for fault in source.faults] == [25], "one is a slip, and bridged"


def test_what_comes_before_depth_begins_is_a_fault(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk", frames=30)
    lines = (folder / "depth.txt").read_text().splitlines()
    (folder / "depth.txt").write_text("\n".join(lines[-18:]))
    source = open_source(folder)
    assert [frame.index for frame in source] == list(range(12, 30))
    assert len(source.faults) == 12


@pytest.mark.parametrize(("rate", "late", "pairs"), [(15, 0.03, 5), (5, 0.045, 5), (5, 0.08, 0), (30, 0.025, 4)])
def test_slow_cameras_may_have_depth_that_comes_later(tmp_path: Path, rate: int, late: float, pairs: int) -> None:
    folder = write_tum(tmp_path / "walk")
    for name, after in (("rgb", 0.0), ("depth", late)):
        lines = [f"{100 + i / rate + after:.6f} {name}/{i}.png" for i in range(5)]
        (folder / f"{name}.txt").write_text("\n".join(lines) + "\n")
    if not pairs:
        with pytest.raises(UserError, match=r"within 50 ms; .*pairing\.tolerance_s"):
            open_source(folder)
        return
    assert len(list(open_source(folder))) == pairs
