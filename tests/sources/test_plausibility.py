"""Calibrations that cannot be right, each found by the one line that mends it; good ones are left in peace."""

import logging
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import write_tum

from lpslam.camera import PinholeCamera
from lpslam.config import CalibrationCheckConfig, RegistrationCheckConfig
from lpslam.errors import UserError
from lpslam.sources.open import open_source
from lpslam.sources.plausibility import (
    Doubt,
    doubts_about_depth,
    doubts_about_intrinsics,
    doubts_about_timing,
    fitting_depth_scale,
)

KITCHEN = Path(__file__).parents[3] / "shared" / "data" / "redkitchen"
CHECKS = CalibrationCheckConfig()
KINECT = PinholeCamera(640, 480, 525.0, 525.0, 319.5, 239.5, depth_scale=5000.0)

# Published or typical calibrations of cameras that people use; none of them may be doubted.
GOOD = {
    "kinect": KINECT,
    "freiburg1": replace(
        KINECT, fx=517.3, fy=516.5, cx=318.6, cy=255.3, distortion=(0.2624, -0.9531, -0.0054, 0.0026, 1.1633)
    ),
    "freiburg2": replace(
        KINECT, fx=520.9, fy=521.0, cx=325.1, cy=249.7, distortion=(0.2312, -0.7849, -0.0033, -0.0001, 0.9172)
    ),
    "freiburg3": replace(KINECT, fx=535.4, fy=539.2, cx=320.1, cy=247.6),
    "7-scenes": replace(KINECT, fx=585.0, fy=585.0, cx=320.0, cy=240.0),
    "realsense wide": PinholeCamera(1280, 720, 640.0, 640.0, 645.0, 362.0),
    "azure kinect depth, wide": PinholeCamera(1024, 1024, 505.0, 505.1, 513.2, 514.9),
    "telephone": PinholeCamera(192, 256, 213.0, 213.0, 95.5, 127.5),
}


def the_doubt(camera: PinholeCamera) -> Doubt:
    (doubt,) = doubts_about_intrinsics(camera, CHECKS)
    assert "\n" not in doubt.text
    return doubt


@pytest.mark.parametrize("camera", GOOD.values(), ids=GOOD)
def test_cameras_that_people_use_are_not_doubted(camera: PinholeCamera) -> None:
    assert doubts_about_intrinsics(camera, CHECKS) == []


@pytest.mark.parametrize("focal", [4.2, 24.0, 5250.0])
def test_a_focal_length_in_millimetres_or_of_a_telescope_is_refused(focal: float) -> None:
    doubt = the_doubt(replace(KINECT, fx=focal, fy=focal))
    assert doubt.is_fatal
    assert f"fx {focal:g} sees" in doubt.text
    assert "in pixels of these images" in doubt.text


def test_an_unusual_field_of_view_is_said() -> None:
    doubt = the_doubt(replace(KINECT, fx=1050.0, fy=1050.0))
    assert not doubt.is_fatal
    assert "sees 34° across 640 pixels" in doubt.text


def test_pixels_that_are_not_square_are_said() -> None:
    doubt = the_doubt(replace(KINECT, fy=700.0))
    assert not doubt.is_fatal
    assert "fx 525 and fy 700 differ by 25%" in doubt.text


@given(cx=st.floats(-2000, 4000), cy=st.floats(-2000, 4000))
def test_the_principal_point_is_refused_outside_said_off_centre_and_accepted_near_it(cx: float, cy: float) -> None:
    doubts = doubts_about_intrinsics(replace(KINECT, cx=cx, cy=cy), CHECKS)
    offset = max(abs(cx - 319.5) / 640, abs(cy - 239.5) / 480)
    assert [doubt.is_fatal for doubt in doubts] == ([] if offset <= CHECKS.centre_offset else [offset > 0.5])


def test_a_calibration_of_another_resolution_is_recognised() -> None:
    twice = the_doubt(replace(KINECT, fx=1050.0, fy=1050.0, cx=641.0, cy=478.0))
    assert twice.is_fatal
    assert "calibrated at 1280×960: divide fx, fy, cx and cy by 2" in twice.text
    half = the_doubt(replace(KINECT, fx=262.0, fy=262.0, cx=160.0, cy=120.0))
    assert "calibrated at 320×240: divide fx, fy, cx and cy by 0.5" in half.text


@pytest.mark.parametrize("distortion", [(-0.9, 0.0, 0.0, 0.0, 0.0), (0.2, -3.0, 0.0, 0.0, 0.0)])
def test_distortion_that_folds_the_image_is_said(distortion: tuple[float, float, float, float, float]) -> None:
    assert "folds the image over" in the_doubt(replace(KINECT, distortion=distortion)).text


# Depth -------------------------------------------------------------------------------------------------------------


def room(scale: float = 1.0, median: float = 2.0) -> list[np.ndarray]:
    """Five frames of a room, a third of them without depth, whose readings are `scale` times too far."""
    frames = []
    for seed in range(5):
        depth = np.random.default_rng(seed).lognormal(np.log(median), 0.4, (48, 64)).astype(np.float32)
        depth[:16] = [0.0, np.nan, np.inf, -1.0] * 16
        frames.append(depth * np.float32(scale))
    return frames


@given(median=st.floats(0.7, 4.5))
def test_rooms_are_not_doubted(median: float) -> None:
    assert doubts_about_depth(room(median=median), KINECT, CHECKS) == []


@pytest.mark.parametrize(
    ("true_scale", "stated", "is_fatal"),
    [
        (1000.0, 5000.0, False),  # millimetres read as TUM
        (5000.0, 1000.0, False),  # TUM read as millimetres
        (1.0, 1000.0, True),  # metres read as millimetres
        (1000.0, 1.0, True),
        (10000.0, 1000.0, False),
    ],
)
def test_a_wrong_depth_scale_is_told_with_the_one_that_fits(true_scale: float, stated: float, is_fatal: bool) -> None:
    camera = replace(KINECT, depth_scale=stated)
    (doubt,) = doubts_about_depth(room(true_scale / stated), camera, CHECKS)
    assert doubt.is_fatal is is_fatal
    assert f"at depth_scale {stated:g} the median depth is" in doubt.text
    # 5000 and 10000 raw units in a metre both make a room; the more usual one is proposed.
    proposed = 5000.0 if true_scale == 10000.0 else true_scale
    assert f"depth_scale {proposed:g} in the calibration would make it" in doubt.text


def test_depth_that_no_usual_scale_explains_is_said_and_no_depth_is_not() -> None:
    (doubt,) = doubts_about_depth(room(1e-9), KINECT, CHECKS)
    assert doubt.is_fatal
    assert "state the raw units in a metre" in doubt.text
    for nothing in ([], [np.zeros((4, 4), np.float32)], [np.full((4, 4), np.nan, np.float32)]):
        assert doubts_about_depth(nothing, KINECT, CHECKS) == []


# Timing ------------------------------------------------------------------------------------------------------------

TIMES = 100 + np.arange(60) / 30


@given(seed=st.integers(0, 1000))
def test_lists_that_belong_together_are_not_doubted(seed: int) -> None:
    rng = np.random.default_rng(seed)
    depth = TIMES + rng.uniform(-0.008, 0.008, 60)
    assert doubts_about_timing(TIMES, depth, CHECKS) == []
    some = np.sort(rng.choice(60, 50, replace=False))
    assert doubts_about_timing(TIMES[some], depth, CHECKS) == []


@pytest.mark.parametrize("lag", [-0.5, -0.03, 0.025, 0.4, 3600.0])
def test_a_clock_that_is_off_is_told_by_how_much(lag: float) -> None:
    (doubt,) = doubts_about_timing(TIMES, TIMES + lag, CHECKS)
    assert f"stamped {abs(lag):.3f} s {'after' if lag > 0 else 'before'} its colour" in doubt.text


def test_depth_between_two_colour_images_is_said_unless_frames_are_few() -> None:
    (doubt,) = doubts_about_timing(TIMES, TIMES - 0.0155, CHECKS)
    assert "16 ms before colour" in doubt.text
    (doubt,) = doubts_about_timing(TIMES[3:40], TIMES + 0.014, CHECKS)
    assert "14 ms after colour" in doubt.text
    assert doubts_about_timing(TIMES[:5], TIMES[:5] + 0.5, CHECKS) == []


# Recordings --------------------------------------------------------------------------------------------------------


def test_a_doubt_is_a_warning_with_the_recordings_name_and_the_rest_is_read(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder = write_tum(tmp_path / "walk")
    calibration = (folder / "camera.yaml").read_text()
    with caplog.at_level(logging.WARNING):
        assert len(list(open_source(folder))) == 5
    assert caplog.messages == []
    (folder / "camera.yaml").write_text(calibration.replace("fy: 51.0", "fy: 80.0"))
    assert len(list(open_source(folder))) == 5
    assert [message.split(";")[0] for message in caplog.messages] == [
        "walk: fx 50 and fy 80 differ by 38%, but pixels are square in nearly every camera"
    ]


def refused(folder: Path, change: Callable[[str], str]) -> str:
    (folder / "camera.yaml").write_text(change((folder / "camera.yaml").read_text()))
    with pytest.raises(UserError) as refusal:
        open_source(folder)
    assert "\n" not in str(refusal.value)
    return str(refusal.value)


def test_what_cannot_be_is_refused_with_the_recordings_name(tmp_path: Path) -> None:
    millimetres = refused(write_tum(tmp_path / "lens"), lambda text: text.replace("fx: 50.0", "fx: 1.9"))
    assert millimetres.startswith("lens: fx 1.9 sees 173° across 64 pixels")
    metres = refused(write_tum(tmp_path / "far"), lambda text: text.replace("5000", "1"))
    assert metres.startswith("far: at depth_scale 1 the median depth is ")
    assert "depth_scale 5000" in metres


def test_thresholds_are_those_of_the_configuration(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    checks = CalibrationCheckConfig(aspect=0.01)
    assert len(open_source(write_tum(tmp_path / "walk"), checks=checks)) == 5
    assert "differ by 2%" in caplog.text


def test_colour_and_depth_of_different_size_are_told_with_both_sizes(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk")
    for path in (folder / "depth").iterdir():
        cv2.imwrite(str(path), np.full((30, 40), 5000, np.uint16))
    with pytest.raises(UserError, match="colour images are 64×48, its depth images 40×30; register depth to colour"):
        open_source(folder)


def test_lists_on_clocks_that_never_meet_are_refused_with_the_gap(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk")
    lines = (folder / "depth.txt").read_text().splitlines()[1:]
    shifted = [f"{float(line.split()[0]) + 50:.6f} {line.split()[1]}" for line in lines]
    (folder / "depth.txt").write_text("\n".join(shifted))
    with pytest.raises(UserError, match=r"they begin 50\.005 s apart"):
        open_source(folder)


def test_a_shifted_clock_whose_lists_still_overlap_is_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    folder = write_tum(tmp_path / "walk", frames=20)
    lines = (folder / "depth.txt").read_text().splitlines()[1:]
    shifted = [f"{float(line.split()[0]) + 0.1:.6f} {line.split()[1]}" for line in lines]
    (folder / "depth.txt").write_text("\n".join(shifted))
    open_source(folder, max_frames=12)
    assert "every depth image is stamped 0.105 s after its colour image" in caplog.text


@pytest.mark.skipif(not KITCHEN.is_dir(), reason="the red kitchen is not in ../shared/data")
def test_a_real_recording_is_not_doubted_and_found_out_with_a_wrong_scale(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    open_source(KITCHEN)
    # Its depth is that of a Kinect's own camera, beside the colour's: that is said, and nothing else.
    (only,) = (message for message in caplog.messages if "focal length 585" not in message)
    assert "depth is not registered to colour" in only
    calibration = tmp_path / "camera.yaml"
    text = "fx: 585\nfy: 585\ncx: 320\ncy: 240\nwidth: 640\nheight: 480\ndepth_scale: "
    unregistered = CalibrationCheckConfig(registration=RegistrationCheckConfig(frames=0))
    for scale in ("5000", "200"):
        caplog.clear()
        calibration.write_text(text + scale)
        open_source(KITCHEN, calibration, checks=unregistered)
        assert "depth_scale 1000 in the calibration would make it" in caplog.text


@pytest.mark.parametrize(
    ("true_scale", "assumed", "told"),
    [
        (5000.0, 5000.0, 5000.0),
        (1000.0, 5000.0, 1000.0),
        (1000.0, 1000.0, 1000.0),
        (5000.0, 1000.0, 5000.0),
        (1.0, 1000.0, 1.0),
    ],
)
@given(median=st.floats(1.2, 3.5))
def test_where_no_scale_is_stated_the_depth_tells_it(
    true_scale: float, assumed: float, told: float, median: float
) -> None:
    camera = replace(KINECT, depth_scale=assumed)
    assert fitting_depth_scale(room(true_scale / assumed, median), camera, CHECKS) == told


def test_without_depth_the_assumed_scale_stays() -> None:
    assert fitting_depth_scale([np.zeros((4, 4), np.float32)], KINECT, CHECKS) == KINECT.depth_scale


def test_a_recording_that_states_no_scale_is_opened_with_that_of_its_depth(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder = tmp_path / "corridor"
    for name in ("rgb", "depth"):
        (folder / name).mkdir(parents=True)
        lines = [f"{0.1 * index:.1f} {name}/{index}.png" for index in range(4)]
        (folder / f"{name}.txt").write_text("\n".join(lines))
    ramp = np.linspace(1000, 6000, 48 * 64).reshape(48, 64).astype(np.uint16)
    for index in range(4):
        cv2.imwrite(str(folder / "rgb" / f"{index}.png"), np.zeros((48, 64, 3), np.uint8))
        cv2.imwrite(str(folder / "depth" / f"{index}.png"), ramp)
    (folder / "camera.yaml").write_text("{fx: 60, fy: 60, cx: 31.5, cy: 23.5}")
    source = open_source(folder)
    assert source.camera.depth_scale == 1000.0
    assert "1000 raw units in a metre are taken" in caplog.text
    first = next(iter(source))
    assert first.depth.max() == pytest.approx(6.0)
    (folder / "camera.yaml").write_text("{fx: 60, fy: 60, cx: 31.5, cy: 23.5, depth_scale: 5000}")
    assert open_source(folder).camera.depth_scale == 5000.0
