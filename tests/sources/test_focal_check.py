"""A focal length that bends the room in turns is found out, in both directions; a good one never, whatever moves."""

import logging
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recordings import write_tum
from turning_pairs import CENTRE, FOCAL, HEIGHT, WIDTH, pair

from lpslam.camera import PinholeCamera
from lpslam.config import CalibrationCheckConfig, FocalCheckConfig, RegistrationCheckConfig
from lpslam.frames import RgbdFrame
from lpslam.sources.focal_check import doubts_about_focal, focal_curve
from lpslam.sources.followed_pairs import pairs_of
from lpslam.sources.open import open_source
from lpslam.sources.rigidity import MeasuringNoise, bending

DATA = Path(__file__).parents[3] / "shared" / "data"
CHECKS = FocalCheckConfig()
CAMERA = PinholeCamera(WIDTH, HEIGHT, FOCAL, FOCAL, *CENTRE)
WRONG = (0.5, 0.75, 1.35, 2.0)


def stated(ratio: float) -> PinholeCamera:
    return replace(CAMERA, fx=ratio * FOCAL, fy=ratio * FOCAL)


# Pairs -------------------------------------------------------------------------------------------------------------


def test_a_rigid_pair_without_noise_does_not_bend_and_one_of_nonsense_does() -> None:
    noise = MeasuringNoise(1.0, 0.003, 0.0035)
    rigid = [pair(0, 8.0, 0.2, noise=0.0), pair(1, 8.0, 0.2, places=40, noise=0.0)]
    assert bending(rigid, CENTRE, np.array([FOCAL]), noise).max() < 1e-6
    assert bending([pair(2, 8.0, 0.2, wrong=1.0)], CENTRE, np.array([FOCAL]), noise).min() > 4


@settings(max_examples=8)
@given(seed=st.integers(0, 10_000), shift=st.floats(0.0, 0.3), wrong=st.floats(0.0, 0.25))
def test_the_focal_length_is_found_from_turns_and_a_wrong_one_doubted(seed: int, shift: float, wrong: float) -> None:
    pairs = [pair(seed + k, 7.0, shift, wrong=wrong) for k in range(6)]
    ratios = np.array(CHECKS.ratios)
    assert focal_curve(pairs, CAMERA, ratios, CHECKS).best == pytest.approx(FOCAL, rel=0.05)
    assert doubts_about_focal(pairs, CAMERA, CHECKS) == []
    for ratio in WRONG:
        (doubt,) = doubts_about_focal(pairs, stated(ratio), CHECKS)
        assert not doubt.is_fatal
        assert "\n" not in doubt.text
        assert f"with fx {ratio * FOCAL:g} the room bends" in doubt.text
        assert "'lpslam calibrate'" in doubt.text


@settings(max_examples=8)
@given(seed=st.integers(0, 10_000), shift=st.floats(0.05, 0.4))
def test_a_pure_shift_tells_nothing_so_nothing_is_doubted(seed: int, shift: float) -> None:
    pairs = [pair(seed + k, 0.0, shift) for k in range(8)]
    for ratio in (0.5, 1.0, 2.0):
        assert doubts_about_focal(pairs, stated(ratio), CHECKS) == []


def test_a_pure_turn_is_no_cause_for_doubt_but_tells_a_wrong_focal_length() -> None:
    pairs = [pair(seed, 6.0, 0.0) for seed in range(6)]
    assert doubts_about_focal(pairs, CAMERA, CHECKS) == []
    assert doubts_about_focal(pairs, stated(2.0), CHECKS)


def test_few_pairs_do_not_judge() -> None:
    few = [pair(seed, 7.0, 0.1) for seed in range(CHECKS.min_pairs - 1)]
    assert doubts_about_focal(few, stated(2.0), CHECKS) == []
    assert doubts_about_focal([], CAMERA, CHECKS) == []


# Frames ------------------------------------------------------------------------------------------------------------


def shown(picture: Callable[[int], np.ndarray], depth: float = 2.0) -> list:
    def read(number: int) -> RgbdFrame:
        rgb = np.repeat(picture(number)[:, :, None], 3, axis=2)
        return RgbdFrame(number, number / 30, rgb, np.full(rgb.shape[:2], depth, np.float32))

    return pairs_of(read, [number / 30 for number in range(40)], CHECKS)


TEXTURE = cv2.resize(np.random.default_rng(0).integers(0, 255, (80, 160), np.uint8), (1280, 640))


def test_a_moving_picture_makes_pairs_that_moved_so_far() -> None:
    pairs = shown(lambda number: TEXTURE[:480, 4 * number : 4 * number + 640])
    assert len(pairs) == CHECKS.pairs
    moved = np.concatenate([each.other_pixels - each.pixels for each in pairs])
    assert np.percentile(np.abs(moved - [-40, 0]), 97) < 0.1


@pytest.mark.parametrize(
    "picture",
    [
        lambda number: TEXTURE[:480, :640],
        lambda number: np.zeros((480, 640), np.uint8),
        lambda number: np.full((480, 640), 255, np.uint8),
        lambda number: np.random.default_rng(number).integers(0, 255, (480, 640), np.uint8),
        lambda number: TEXTURE[:2, 4 * number : 4 * number + 2],
    ],
    ids=["still", "dark", "white", "noise", "two pixels"],
)
def test_pictures_that_tell_nothing_make_no_pairs(picture: Callable[[int], np.ndarray]) -> None:
    assert shown(picture) == []


def test_neither_depth_nor_frames_make_no_pairs() -> None:
    moving = [TEXTURE[:480, 4 * number : 4 * number + 640] for number in range(40)]
    assert shown(lambda number: moving[number], depth=0.0) == []
    assert shown(lambda number: moving[number], depth=np.nan) == []
    assert pairs_of(lambda number: None, [number / 30 for number in range(40)], CHECKS) == []
    assert pairs_of(lambda number: None, [0.0], CHECKS) == []


# Recordings --------------------------------------------------------------------------------------------------------


UNREGISTERED = CalibrationCheckConfig(registration=RegistrationCheckConfig(frames=0))


def warnings_with(folder: Path, ratio: float, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> list[str]:
    """What is said of the focal length when it is stated wrong by a ratio."""
    quiet = CalibrationCheckConfig(focal=FocalCheckConfig(pairs=0), registration=RegistrationCheckConfig(frames=0))
    camera = open_source(folder, checks=quiet).camera
    lens = f"fx: {camera.fx * ratio}\nfy: {camera.fy * ratio}\ncx: {camera.cx}\ncy: {camera.cy}\n"
    size = f"width: {camera.width}\nheight: {camera.height}\ndepth_scale: {camera.depth_scale}\n"
    (tmp_path / "stated.yaml").write_text(lens + size)
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        # How depth lies beside colour is another check, and takes most of the time.
        open_source(folder, tmp_path / "stated.yaml", checks=UNREGISTERED)
    return [message for message in caplog.messages if "the room bends" in message]


@pytest.mark.slow
def test_a_rendered_recording_is_doubted_only_with_a_wrong_focal_length(
    walk: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert warnings_with(walk, 1.0, tmp_path, caplog) == []
    for ratio in (0.5, 0.75, 1.35, 2.0):
        (line,) = warnings_with(walk, ratio, tmp_path, caplog)
        assert line.startswith("walk: with fx ")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["redkitchen", "desk_rotations", "coffee_bar"])
def test_real_recordings_are_doubted_only_with_a_wrong_focal_length(
    name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder = DATA / name
    if not folder.is_dir():
        pytest.skip(f"{name} is not in ../shared/data")
    assert warnings_with(folder, 1.0, tmp_path, caplog) == []
    for ratio in (0.5, 2.0):
        assert len(warnings_with(folder, ratio, tmp_path, caplog)) == 1


def test_the_check_can_be_left_out(tmp_path: Path) -> None:
    folder = write_tum(tmp_path / "walk")
    shutil.rmtree(folder / "rgb")
    (folder / "rgb").mkdir()
    source = open_source(folder, checks=CalibrationCheckConfig(focal=FocalCheckConfig(pairs=0)))
    assert source.frame(0) is None
    assert source.frame(99) is None
    assert source.frame(-1) is None
