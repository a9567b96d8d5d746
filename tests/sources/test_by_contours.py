"""Depth that lies beside colour is found by the contours of things; registered depth is left alone."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from displaced_views import HEIGHT, WIDTH, boxes_before_a_wall

from lpslam.config import CalibrationCheckConfig, RegistrationCheckConfig
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.sources.calibration import read_calibration
from lpslam.sources.open import open_source, open_uncalibrated
from lpslam.sources.registering.by_contours import find_displacement, looks_displaced
from lpslam.sources.registering.contours import contours_of
from lpslam.sources.registering.displacement import DepthDisplacement
from lpslam.sources.registering.registration import DepthRegistration

DATA = Path(__file__).parents[3] / "shared" / "data"
# Fewer pixels tell it in these plain views as well, sooner.
CONFIG = RegistrationCheckConfig(contour_pixels=300)
REGISTERED = DepthDisplacement.between((WIDTH, HEIGHT), (WIDTH, HEIGHT))
KINECT = DepthDisplacement(0.9, (2.0, -3.0), (-9.0, 2.0))
SMALLER = (WIDTH // 2, HEIGHT // 2)


def views(displacement: DepthDisplacement, depth_size: tuple[int, int] = (WIDTH, HEIGHT)) -> list[RgbdFrame]:
    return [boxes_before_a_wall(seed, displacement, depth_size) for seed in range(8)]


@pytest.mark.parametrize(
    ("displacement", "size"),
    [
        (KINECT, (WIDTH, HEIGHT)),
        (DepthDisplacement(1.25, (-6.0, 4.0), (5.0, 0.0)), (WIDTH, HEIGHT)),
        (DepthDisplacement(0.65, (0.0, 0.0), (6.0, -2.0)), (WIDTH, HEIGHT)),
        (DepthDisplacement(1.7, (3.0, 0.0), (-4.0, 1.0)), SMALLER),
    ],
)
def test_a_depth_camera_beside_the_colour_camera_is_found(
    displacement: DepthDisplacement, size: tuple[int, int]
) -> None:
    frames = views(displacement, size)
    assert looks_displaced(frames, CONFIG)
    found = find_displacement(frames, CONFIG)
    assert found is not None
    assert found.is_displaced
    corners = np.array([[0.1, 0.1], [0.9, 0.1], [0.5, 0.5], [0.1, 0.9], [0.9, 0.9]]) * size
    for z in (1.2, 2.0, 2.8):
        depths = np.full(len(corners), z)
        here, right = (
            each.moved(corners, depths, size, (WIDTH, HEIGHT)) for each in (found.displacement, displacement)
        )
        # A pixel of the reduced picture, and half of one where boxes were put on whole pixels.
        assert np.linalg.norm(here - right, axis=1).max() < 2.0


@pytest.mark.parametrize("pixels", [0.0, 1.5])
def test_registered_depth_is_left_alone_also_with_a_small_error(pixels: float) -> None:
    frames = views(DepthDisplacement(1.0, (pixels, -pixels), (0.0, 0.0)))
    assert not looks_displaced(frames, CONFIG)
    found = find_displacement(frames, CONFIG)
    assert found is not None
    assert not found.is_displaced


def test_smaller_registered_depth_is_only_smaller() -> None:
    found = find_displacement(views(DepthDisplacement.between(SMALLER, (WIDTH, HEIGHT)), SMALLER), CONFIG)
    assert found is not None
    assert not found.is_displaced
    assert found.displacement.scale == pytest.approx(2.0, rel=0.01)


def test_bare_walls_and_pictures_that_have_nothing_to_do_with_depth_tell_nothing() -> None:
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    wall = RgbdFrame(0, 0.0, noise, np.full((HEIGHT, WIDTH), 2.0, np.float32))
    assert find_displacement([wall] * 8, CONFIG) is None
    others = [RgbdFrame(k, k / 30, noise, boxes_before_a_wall(k, REGISTERED).depth) for k in range(8)]
    found = find_displacement(others, CONFIG)
    assert found is None or not found.is_displaced


def test_contours_lie_where_things_end_and_depth_that_is_no_number_is_none() -> None:
    depth = np.full((HEIGHT, WIDTH), 4.0, np.float32)
    depth[100:140, 50:120] = 1.5
    depth[:, 200:] = np.nan
    depth[0, 0] = np.inf
    contours = contours_of(depth, CONFIG)
    assert set(contours.depths) == {1.5}
    beside = contours.pixels[contours.axis == 0]
    assert set(beside[:, 0]) == {49.5, 119.5}
    assert set(contours.pixels[contours.axis == 1][:, 1]) == {99.5, 139.5}
    assert not len(contours_of(np.zeros((HEIGHT, WIDTH), np.float32), CONFIG).depths)


@pytest.mark.parametrize("size", [(1, 1), (2, 2), (640, 1), (1, 640), (5, 700), (4000, 10), (64, 48)])
@pytest.mark.parametrize("depth_size", [(1, 1), (1, 3), (640, 1), (3, 300), (20, 4000), (64, 48)])
def test_images_of_any_shape_and_any_readings_tell_something_or_nothing(
    size: tuple[int, int], depth_size: tuple[int, int]
) -> None:
    rng = np.random.default_rng(1)
    config = RegistrationCheckConfig(min_view_pixels=1, min_views=2, contour_pixels=100)
    frames = []
    for k in range(3):
        depth = np.where(rng.random((depth_size[1] // 5 + 1, depth_size[0] // 5 + 1)) < 0.5, 1.0, 3.0)
        depth = np.repeat(np.repeat(depth, 5, 0), 5, 1)[: depth_size[1], : depth_size[0]].astype(np.float32)
        depth[rng.random(depth.shape) < 0.05] = rng.choice([np.nan, np.inf, -1.0, 0.0])
        frames.append(RgbdFrame(k, k / 30, rng.integers(0, 255, (size[1], size[0], 3), dtype=np.uint8), depth))
    found = find_displacement(frames, config)
    assert found is None or np.isfinite(found.displacement.numbers).all()
    looks_displaced(frames, config)


def test_what_is_found_registers_depth() -> None:
    frame = boxes_before_a_wall(3, KINECT)
    right = boxes_before_a_wall(3, REGISTERED).depth
    registered = DepthRegistration(KINECT.rig((WIDTH, HEIGHT), (WIDTH, HEIGHT)))(frame.depth)
    inside = np.s_[30:-30, 30:-30]
    assert (np.abs(registered[inside] - right[inside]) < 0.01).mean() > 0.95
    assert (np.abs(frame.depth[inside] - right[inside]) < 0.01).mean() < 0.9


def written(folder: Path, displacement: DepthDisplacement, size: tuple[int, int] = (WIDTH, HEIGHT)) -> Path:
    for kind in ("rgb", "depth"):
        (folder / kind).mkdir(parents=True)
    lines = []
    for frame in views(displacement, size):
        cv2.imwrite(str(folder / f"rgb/{frame.index}.png"), frame.rgb)
        cv2.imwrite(str(folder / f"depth/{frame.index}.png"), (frame.depth * 1000).astype(np.uint16))
        lines.append(f"{frame.timestamp:.4f} KIND/{frame.index}.png")
    for kind in ("rgb", "depth"):
        (folder / f"{kind}.txt").write_text("\n".join(lines).replace("KIND", kind))
    (folder / "camera.yaml").write_text("fx: 260\nfy: 260\ncx: 159.5\ncy: 119.5\ndepth_scale: 1000\n")
    return folder


STATED = "depth_displacement: {scale: 0.9, shift: [2, -3], parallax: [-9, 2]}\n"


def test_opening_says_that_depth_is_not_registered_unless_the_calibration_says_how_it_lies(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder = written(tmp_path / "kinect", KINECT)
    open_source(folder)
    assert "depth is not registered to colour" in caplog.text
    assert "lpslam calibrate" in caplog.text
    caplog.clear()
    unchecked = CalibrationCheckConfig(registration=RegistrationCheckConfig(frames=0))
    open_source(folder, checks=unchecked)
    with (folder / "camera.yaml").open("a") as calibration:
        calibration.write(STATED)
    source = open_source(folder)
    assert "registered" not in caplog.text
    right = boxes_before_a_wall(5, REGISTERED).depth[30:-30, 30:-30]
    frame = source.frame(5)
    assert frame is not None
    assert (np.abs(frame.depth[30:-30, 30:-30] - right) < 0.01).mean() > 0.95


def test_depth_of_another_size_is_opened_once_it_is_said_how_it_lies(tmp_path: Path) -> None:
    folder = written(tmp_path / "small", DepthDisplacement(1.8, (2.0, -3.0), (-9.0, 2.0)), SMALLER)
    with pytest.raises(UserError, match="run 'lpslam calibrate'"):
        open_source(folder)
    frame = open_uncalibrated(folder).frame(0)
    assert frame is not None
    assert frame.depth.shape == SMALLER[::-1]
    with (folder / "camera.yaml").open("a") as calibration:
        calibration.write(STATED.replace("0.9", "1.8"))
    frame = open_source(folder).frame(0)
    assert frame is not None
    assert frame.depth.shape == (HEIGHT, WIDTH)
    assert (frame.depth > 0).mean() > 0.7


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        ("depth_displacement: 3", "must have scale, shift and parallax"),
        ("depth_displacement: {scale: 0.9}", "needs a shift and a parallax of two numbers"),
        ("depth_displacement: {scale: .nan, shift: [0, 0], parallax: [0, 0]}", "takes depth out of the picture"),
        ("depth_displacement: {scale: 1, shift: [0, .inf], parallax: [0, 0]}", "takes depth out of the picture"),
        ("depth_displacement: {scale: 1e-9, shift: [0, 0], parallax: [0, 0]}", "takes depth out of the picture"),
        ("depth_displacement: {scale: one, shift: [0, 0], parallax: [0, 0]}", "scale of depth_displacement is 'one'"),
    ],
)
def test_a_displacement_that_is_none_is_refused_in_one_line(tmp_path: Path, stated: str, words: str) -> None:
    path = tmp_path / "camera.yaml"
    path.write_text(f"fx: 260\nfy: 260\ncx: 159.5\ncy: 119.5\nwidth: 320\nheight: 240\n{stated}\n")
    with pytest.raises(UserError, match=words):
        read_calibration(path)


@pytest.mark.skipif(not (DATA / "redkitchen").is_dir(), reason="redkitchen is not in ../shared/data")
def test_the_red_kitchens_depth_is_a_kinects_own(caplog: pytest.LogCaptureFixture) -> None:
    source = open_source(DATA / "redkitchen")
    assert "depth is not registered to colour" in caplog.text
    frames = [source.frame(row) for row in range(0, 500, 50)]
    found = find_displacement([frame for frame in frames if frame is not None], CONFIG)
    assert found is not None
    # A Kinect's colour camera has a focal length of about 525 pixels, its depth camera of 585, 2.5 cm beside it.
    assert found.displacement.scale == pytest.approx(525 / 585, rel=0.01)
    assert found.displacement.parallax[0] / 525 == pytest.approx(-0.025, abs=0.01)


@pytest.mark.skipif(not (DATA / "coffee_bar").is_dir(), reason="recordings are not in ../shared/data")
@pytest.mark.parametrize("name", ["coffee_bar", "desk_rotations"])
def test_registered_recordings_are_not_doubted(name: str, caplog: pytest.LogCaptureFixture) -> None:
    open_source(DATA / name)
    assert "not registered" not in caplog.text
