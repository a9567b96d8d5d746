"""What the text benchmark counts is what it says."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from lpslam.camera import PinholeCamera
from lpslam.config import Config
from lpslam.evaluation.report import evaluate
from lpslam.evaluation.signs import listed_signs
from lpslam.frames import FrameFault, RgbdFrame
from lpslam.poses import StampedPoses

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
CAMERA = PinholeCamera(640, 480, 500.0, 500.0, 319.5, 239.5)
SIGN = {
    "id": 0, "text": "EXIT", "centre": [0.0, 3.0, 0.0], "normal": [0.0, -1.0, 0.0], "readable_frames": 30,
    "readable_from": 0.0, "lines": [{"text": "EXIT", "centre": [0, 3, 0], "width": 0.6, "height": 0.15}],
}  # fmt: skip


@pytest.fixture(autouse=True)
def _beside_the_benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def facts(**given: object) -> dict[str, object]:
    counted = ("expected", "found", "landmarks", "right", "exact", "facing", "facings", "pairs", "apart")
    plain: dict[str, object] = dict.fromkeys((*counted, "frames", "dropped", "searched", "boxes_read"), 0)
    return plain | {"position_m": [], "delay_s": [], "minutes": 0.0, "reader_s": 0.0, "ate_rmse_m": 0.0} | given


def test_malls_are_added_up_as_if_they_were_one() -> None:
    from text_malls import _row, _together

    many = facts(expected=30, found=30, landmarks=40, right=40, exact=38, facing=36, facings=40, pairs=3, apart=3)
    few = facts(expected=2, found=1, landmarks=4, right=2, exact=1, facing=1, facings=2, pairs=1)
    many |= {"position_m": [0.01] * 40, "minutes": 2.0, "searched": 600, "frames": 3600, "reader_s": 90.0}
    few |= {"position_m": [0.5, 0.5], "minutes": 1.0, "searched": 600, "frames": 1800, "dropped": 54}
    row = _row("all", _together([many, few]))
    # The mean of the malls' recalls would be 75 %, the median of their positions 0.255.
    assert row[1:7] == ["96.9% of 32", "95.5% of 44", "92.9% of 42", "3 of 4", "0.010", "88.1% of 42"]
    assert row[8] == "400"
    assert row[10] == "30.0"
    assert row[12] == "1.0%"
    assert _row("nothing", facts())[1:4] == ["none"] * 3


def test_the_sets_share_their_kinds_and_no_seed() -> None:
    from slam_recordings import KINDS, TEXT_KINDS, TEXT_SETS, Recording

    kinds = {which: [name.rsplit("-", 1)[0] for name in names] for which, names in TEXT_SETS.items()}
    assert kinds["dev"] == kinds["eval"]
    assert set(kinds["eval"]) == set(TEXT_KINDS)
    seeds = [name.rsplit("-", 1)[1] for names in TEXT_SETS.values() for name in names]
    assert len(seeds) == len(set(seeds))
    assert Recording.at(Path("cache/eval-chinese-305")).kind == "eval-chinese"
    assert Recording.at(Path("cache/dark-71")).kind == "dark"
    assert Recording.at(Path("cache/kitchen")).kind == "recording"
    assert KINDS["dark"].options == TEXT_KINDS["dark"]


class Wall:
    """A camera that slides along a sign for two seconds."""

    name, camera, faults = "wall", CAMERA, list[FrameFault]()

    def __len__(self) -> int:
        return 60

    def pose(self, index: int) -> np.ndarray:
        pose = np.eye(4)
        pose[:3, :3] = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
        pose[0, 3] = (index - 30) / 100
        return pose

    def __iter__(self):  # type: ignore[no-untyped-def]
        (width, _), _ = cv2.getTextSize("EXIT", cv2.FONT_HERSHEY_SIMPLEX, 1.2, 4)
        for index in range(60):
            rgb = np.full((480, 640, 3), 90, np.uint8)
            rgb[::16, :, 1] = 110
            x = round(500 * -self.pose(index)[0, 3] / 3 + 319.5)
            cv2.putText(
                rgb, "EXIT", (x - width // 2, 252), cv2.FONT_HERSHEY_SIMPLEX, 1.2, (255, 255, 255), 4, cv2.LINE_AA
            )
            yield RgbdFrame(index, index / 30, rgb, np.full((480, 640), 3.0, np.float32))


@pytest.mark.slow
def test_with_true_poses_a_sign_is_found_where_it_is_and_drawn_there(tmp_path: Path) -> None:
    from slam_recordings import Recording
    from text_malls import MeasuredSpotter
    from text_pictures import draw_signs
    from text_true_poses import map_with_true_poses

    wall, config = Wall(), Config()
    truth = StampedPoses(np.arange(60) / 30, np.array([wall.pose(i) for i in range(60)]))
    spotter = MeasuredSpotter(config.text.spotting)
    world = map_with_true_poses(wall, truth, config, spotter)
    signs = listed_signs([SIGN], "signs")
    scores = evaluate(world, truth, signs, 60)
    marks = scores.landmarks
    assert marks is not None
    assert (marks.recall, marks.precision, marks.exact_name_share, marks.facing_share) == (1.0, 1.0, 1.0, 1.0)
    assert marks.median_position_error is not None
    assert marks.median_position_error < 0.02
    assert scores.ate.rmse < 1e-6
    assert scores.median_delay is not None
    assert 0.0 < scores.median_delay < 1.0
    assert scores.reading is not None
    assert scores.reading.detections >= 5
    assert spotter.processor_seconds > 0.0

    class Folder(Recording):
        def open(self):  # type: ignore[no-untyped-def]
            return wall

        @property
        def truth(self) -> StampedPoses:
            return truth

    (tmp_path / "readability.csv").write_text(
        "frame,sign,letter_pixels,angle_degrees,distance_m,blur_pixels,seen_share,readable\n"
        "3,0,30,1,3,0,1.0,0\n30,0,25,1,3,0,1.0,1\n40,0,20,1,3,0,1.0,1\n"
    )
    draw_signs(tmp_path / "wall-signs", Folder("wall", "recording", tmp_path), world, signs, marks)
    picture = cv2.imread(str(tmp_path / "wall-signs-1.png"))
    assert picture is not None
    # Frame 30, the readable one with the largest letters: the sign is in its middle, with a green box around it.
    green = (np.abs(picture[24:504, :640].astype(int) - [80, 200, 40]).max(axis=2) < 30).nonzero()
    assert len(green[0]) > 100
    assert abs(green[1].mean() - 319.5) < 40
    assert abs(np.median(green[0]) - 239.5) < 60
