from pathlib import Path

import cv2
import numpy as np
import pytest
from recordings import raw_depth, write_seven_scenes

from lpslam.errors import UserError
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source

RED_KITCHEN = Path(__file__).parents[2] / ".." / "shared" / "data" / "redkitchen"


def test_frames_poses_and_times(tmp_path: Path) -> None:
    folder = write_seven_scenes(tmp_path / "seq-01", size=(640, 480))
    raw = raw_depth(2, 640, 480)
    raw[10:20] = 65535
    cv2.imwrite(str(folder / "frame-000002.depth.png"), raw)
    source = open_source(folder)
    frames = list(source)
    assert (source.camera.fx, source.camera.cx, source.camera.depth_scale) == (585.0, 320.0, 1000.0)
    np.testing.assert_allclose([frame.timestamp for frame in frames], np.arange(4) / 30)
    assert (frames[2].depth[10:20] == 0).all()
    np.testing.assert_allclose(frames[2].depth[20:], raw[20:] / 1000, rtol=1e-6)
    truth = read_ground_truth(folder)
    assert truth is not None
    np.testing.assert_allclose(truth.timestamps, [frame.timestamp for frame in frames])
    np.testing.assert_allclose(truth.positions[:, 0], [0, 0.1, 0.2, 0.3])


def test_intrinsics_file_is_used_and_its_faults_named(tmp_path: Path) -> None:
    folder = write_seven_scenes(tmp_path / "seq-01")
    intrinsics = folder / "camera-intrinsics.txt"
    intrinsics.write_text("60 0 30\n0 61 20\n0 0 1\n")
    camera = open_source(folder).camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (60, 61, 30, 20)
    for content, words in (("60 0 30", "nine numbers"), ("a b c", "nine numbers"), ("0 0 1 0 1 1 0 0 1", "positive")):
        intrinsics.write_text(content)
        with pytest.raises(UserError, match=words):
            open_source(folder)


def test_missing_depth_is_a_fault_and_broken_poses_are_left_out(tmp_path: Path) -> None:
    folder = write_seven_scenes(tmp_path / "seq-01")
    (folder / "camera-intrinsics.txt").write_text("60 0 31.5\n0 60 23.5\n0 0 1\n")
    (folder / "frame-000001.depth.png").unlink()
    (folder / "frame-000001.pose.txt").write_text("nan " * 16)
    (folder / "frame-000002.pose.txt").write_text("0 " * 16)
    (folder / "frame-000003.pose.txt").write_text("1 2 3")
    source = open_source(folder)
    assert [frame.index for frame in source] == [0, 2, 3]
    assert "no frame-000001.depth.png" in source.faults[0].reason
    truth = read_ground_truth(folder)
    assert truth is not None
    assert len(truth) == 1


def test_while_depth_pauses_frames_come_without_it(tmp_path: Path) -> None:
    folder = write_seven_scenes(tmp_path / "seq-01", frames=20)
    (folder / "camera-intrinsics.txt").write_text("60 0 31.5\n0 60 23.5\n0 0 1\n")
    for index in (*range(5, 14), 17):
        (folder / f"frame-{index:06d}.depth.png").unlink()
    source = open_source(folder)
    assert [frame.index for frame in source if not frame.depth.any()] == list(range(5, 14))
    assert [fault.index for fault in source.faults] == [17]


def test_unknown_places_are_told_what_was_looked_for(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="does not exist"):
        open_source(tmp_path / "none")
    (tmp_path / "file.bag").write_text("")
    with pytest.raises(UserError, match="is empty"):
        open_source(tmp_path / "file.bag")
    (tmp_path / "empty").mkdir()
    with pytest.raises(UserError, match=r"rgb.txt and depth.txt .* or frame-NNNNNN"):
        open_source(tmp_path / "empty")
    for name in ("seq-03", "seq-04"):
        write_seven_scenes(tmp_path / "scene" / name)
    with pytest.raises(UserError, match=r"did you mean .*seq-03"):
        open_source(tmp_path / "scene")


@pytest.mark.skipif(not RED_KITCHEN.is_dir(), reason="the red kitchen is not in ../shared/data")
def test_red_kitchen() -> None:
    source = open_source(RED_KITCHEN, max_frames=5)
    frames = list(source)
    assert len(frames) == 5
    assert (source.camera.fx, source.camera.width) == (585, 640)
    assert 0.5 < np.median(frames[0].depth[frames[0].depth > 0]) < 5
    truth = read_ground_truth(RED_KITCHEN)
    assert truth is not None
    assert len(truth) == 500
