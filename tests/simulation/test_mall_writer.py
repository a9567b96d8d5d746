"""The folder that `write_sequence` leaves, read back by independent means."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from lpslam.errors import UserError
from lpslam.simulation.recording import recorded
from lpslam.simulation.source import MallSource
from lpslam.simulation.writer import write_sequence


@pytest.fixture(scope="module")
def short(mall: MallSource) -> MallSource:
    return MallSource(3, frames=3, options=mall._options)


@pytest.mark.slow
def test_folder_reads_back_as_the_frames(short: MallSource, tmp_path: Path) -> None:
    steps: list[tuple[int, int]] = []
    write_sequence(short, tmp_path / "mall", lambda done, total: steps.append((done, total)))
    folder = tmp_path / "mall"
    assert steps == [(1, 3), (2, 3), (3, 3)]
    rows = {
        name: [line.split() for line in (folder / name).read_text().splitlines() if not line.startswith("#")]
        for name in ("rgb.txt", "depth.txt", "groundtruth.txt")
    }
    assert [len(each) for each in rows.values()] == [3, 3, 3]
    for index, frame in enumerate(short):
        rgb = cv2.imread(str(folder / rows["rgb.txt"][index][1]), cv2.IMREAD_COLOR)[..., ::-1]
        depth = cv2.imread(str(folder / rows["depth.txt"][index][1]), cv2.IMREAD_UNCHANGED)
        assert np.array_equal(rgb, frame.rgb)
        assert depth.dtype == np.uint16
        assert np.abs(depth / 5000.0 - frame.depth).max() <= 0.00011
        assert float(rows["rgb.txt"][index][0]) == pytest.approx(frame.timestamp, abs=1e-6)
        truth = np.array(rows["groundtruth.txt"][index], dtype=float)
        pose = short.ground_truth.world_from_camera[index]
        assert truth[1:4] == pytest.approx(pose[:3, 3], abs=1e-6)
        assert np.allclose(Rotation.from_quat(truth[4:]).as_matrix(), pose[:3, :3], atol=1e-5)
    camera = yaml.safe_load((folder / "camera.yaml").read_text())
    assert camera["fx"] == short.camera.fx
    assert camera["depth_scale"] == 5000
    assert (camera["width"], camera["height"], camera["fps"]) == (640, 480, 30)
    signs = json.loads((folder / "signs.json").read_text(encoding="utf-8"))["signs"]
    assert len(signs) == len(short.signs)
    assert {"id", "text", "aliases", "kind", "centre", "normal", "width", "height", "readable_frames"} <= set(signs[0])


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_of_a_recording_that_does_not_become_whole_no_new_folder_is_left(tmp_path: Path, error: BaseException) -> None:
    def fail(folder: Path) -> None:
        with recorded(folder, "simulation") as recording:
            recording.add("rgb", 0.0, b"picture")
            raise error

    with pytest.raises((UserError, KeyboardInterrupt)):
        fail(tmp_path / "new")
    assert not (tmp_path / "new").exists()
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("kept")
    with pytest.raises((UserError, KeyboardInterrupt)):
        fail(tmp_path / "mine")
    assert (tmp_path / "mine" / "notes.txt").read_text() == "kept"


@pytest.mark.slow
def test_a_folder_that_cannot_be_written_is_a_clear_error(short: MallSource, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(UserError, match="cannot be written"):
        write_sequence(short, tmp_path / "taken")
