"""Recordings as people pack and describe them: what is stated is found, and what cannot be read is said."""

import json
import shutil
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.sources.calibration import calibration_of, read_calibration
from lpslam.sources.image_pairs import ImagePairSource
from lpslam.sources.open import open_source, open_uncalibrated

COUNT, WIDTH, HEIGHT = 6, 64, 48
LENS = "{fx: 70, fy: 71, cx: 31, cy: 24, width: 64, height: 48}"
TIMES = 100.0 + np.arange(COUNT) / 10


def colour(index: int) -> NDArray[np.uint8]:
    noise = np.random.default_rng(index).integers(0, 255, (HEIGHT, WIDTH, 3), np.uint8)
    return np.asarray(cv2.GaussianBlur(noise, (9, 9), 3), np.uint8)


def metres(index: int) -> NDArray[np.float64]:
    return np.linspace(1.0, 5.0, WIDTH)[None, :] + 0.01 * np.arange(HEIGHT)[:, None] + 0.1 * index


def pictures(folder: Path, units: float = 1000.0, size: tuple[int, int] = (WIDTH, HEIGHT)) -> Path:
    """Folders rgb/ and depth/ whose names count."""
    for name in ("rgb", "depth"):
        (folder / name).mkdir(parents=True)
    for index in range(COUNT):
        cv2.imwrite(str(folder / "rgb" / f"{index:03d}.png"), colour(index))
        raw = np.round(metres(index) * units).astype(np.uint16)
        cv2.imwrite(str(folder / "depth" / f"{index:03d}.png"), cv2.resize(raw, size, interpolation=cv2.INTER_NEAREST))
    return folder


def tum(folder: Path, times: NDArray[np.float64] = TIMES) -> Path:
    pictures(folder)
    for name in ("rgb", "depth"):
        lines = (f"{time:.6f} {name}/{index:03d}.png" for index, time in enumerate(times))
        (folder / f"{name}.txt").write_text("\n".join(lines))
    (folder / "camera.yaml").write_text(LENS.replace("}", ", depth_scale: 1000}"))
    return folder


def is_right(source: object, tolerance: float = 0.02) -> bool:
    assert isinstance(source, ImagePairSource)
    frames = list(source)
    errors = [np.median(np.abs(frame.depth - metres(index))[frame.depth > 0]) for index, frame in enumerate(frames)]
    return len(frames) == COUNT and max(errors) < tolerance and not source.faults


def test_units_that_a_text_beside_the_calibration_states_hold(tmp_path: Path) -> None:
    pictures(tmp_path, 4000.0)
    (tmp_path / "camera.yaml").write_text(LENS)
    (tmp_path / "notes.txt").write_text("Depth as 16 bit PNG; depth in metres = value / 4000, 0 = no value.\n")
    assert is_right(open_source(tmp_path))


def test_a_length_of_a_raw_unit_without_its_own_unit_may_be_of_millimetres(tmp_path: Path) -> None:
    pictures(tmp_path, 2000.0)
    (tmp_path / "camera.yaml").write_text(LENS.replace("}", ", depth_scale: 0.5}"))
    assert is_right(open_source(tmp_path))


def test_the_only_recording_in_a_folder_is_opened_with_the_calibration_beside_it(tmp_path: Path) -> None:
    tum(tmp_path / "seq")
    (tmp_path / "seq" / "camera.yaml").rename(tmp_path / "lens.yaml")
    assert is_right(open_source(tmp_path))
    tum(tmp_path / "seq2")
    with pytest.raises(UserError, match="did you mean"):
        open_source(tmp_path)


@pytest.mark.parametrize("name", ["a.zip", "a.tar.gz"])
def test_an_archive_is_unpacked_and_read(tmp_path: Path, name: str) -> None:
    tum(tmp_path / "room" / "take")
    kind = "zip" if name.endswith("zip") else "gztar"
    shutil.make_archive(str(tmp_path / "a"), kind, tmp_path / "room")
    shutil.rmtree(tmp_path / "room")
    for _ in range(2):
        source = open_source(tmp_path / name)
        assert is_right(source)
        assert source.name == "take"


def test_a_recording_in_an_archive_goes_by_its_name(tmp_path: Path) -> None:
    shutil.make_archive(str(tmp_path / "Our hall.v2"), "zip", tum(tmp_path / "take"))
    assert open_source(tmp_path / "Our hall.v2.zip").name == "Our hall.v2"


def test_an_archive_in_an_archive_is_refused(tmp_path: Path) -> None:
    shutil.make_archive(str(tmp_path / "in" / "a"), "zip", tum(tmp_path / "take"))
    shutil.make_archive(str(tmp_path / "b"), "zip", tmp_path / "in")
    with pytest.raises(UserError, match="holds another archive"):
        open_source(tmp_path / "b.zip")


def test_an_archive_that_leads_out_writes_nothing_there(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("../outside.txt", "x")
    with pytest.raises(UserError, match="no plain name"):
        open_source(tmp_path / "a.zip")
    assert not (tmp_path / "outside.txt").exists()
    (tmp_path / "b.zip").write_bytes(b"PK\x03\x04" + bytes(100))
    with pytest.raises(UserError, match=r"b\.zip"):
        open_source(tmp_path / "b.zip")


def test_depth_in_fewer_pixels_of_the_same_shape_shows_the_same_view(tmp_path: Path) -> None:
    pictures(tmp_path, size=(WIDTH // 2, HEIGHT // 2))
    (tmp_path / "camera.yaml").write_text(LENS)
    assert is_right(open_source(tmp_path), 0.1)


def test_depth_of_a_camera_of_its_own_is_registered_as_stated(tmp_path: Path) -> None:
    """A wall 2 m away, seen by a depth camera that stands 0.1 m to the left and has another lens."""
    pictures(tmp_path)
    for index in range(COUNT):
        wall = np.full((40, 52), 2000, np.uint16)
        wall[:, 26:] = 4000
        cv2.imwrite(str(tmp_path / "depth" / f"{index:03d}.png"), wall)
    stated = {
        "color": {"width": 64, "height": 48, "fx": 70, "fy": 70, "cx": 31.5, "cy": 23.5},
        "depth": {"width": 52, "height": 40, "fx": 50, "fy": 50, "cx": 25.5, "cy": 19.5, "unit": "mm"},
        "T_color_depth": [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
    }
    (tmp_path / "camera.json").write_text(json.dumps(stated))
    frame = open_source(tmp_path).frame(0)
    assert frame is not None
    row = frame.depth[24]
    near = np.flatnonzero((row > 1.9) & (row < 2.1))
    # The edge's last near column 25 looks (25 - 25.5) / 50 aside at 2 m, and 0.1 m more to the left for colour.
    assert abs(near.max() - (31.5 + 70 * (-0.01 - 0.05))) <= 1.5
    del stated["T_color_depth"]
    (tmp_path / "camera.json").write_text(json.dumps(stated))
    with pytest.raises(UserError, match="register depth"):
        open_source(tmp_path)


@pytest.mark.parametrize(
    ("key", "matrix"),
    [
        ("depth_to_color", np.eye(4)),
        ("T_depth_color", np.eye(4)),
        ("d2c", np.eye(3)),
        ("color_to_depth", [[1, 2], [3, 4]]),
        ("T_color_depth", "none"),
        ("T_color_depth", {"rotation": 2 * np.eye(3), "translation": [0, 0, 0]}),
    ],
)
def test_a_transform_is_a_rigid_one_or_none(key: str, matrix: object) -> None:
    from lpslam.sources.calibrations.extrinsics import transform_between

    found = transform_between([{key.lower(): matrix}])
    assert found is None or np.allclose(found, np.eye(4))
    assert (found is not None) == (isinstance(matrix, np.ndarray) and matrix.shape == (4, 4))


def test_a_transform_the_other_way_is_turned_round_and_may_be_in_millimetres() -> None:
    from lpslam.sources.calibrations.extrinsics import transform_between

    matrix = np.eye(4)
    matrix[:3, 3] = 25.0, 0.0, 5.0
    for key, sign in (("depth_to_color", 1), ("color_to_depth", -1), ("t_depth_color", -1), ("t_color_depth", 1)):
        found = transform_between([{key: matrix.tolist()}])
        assert found is not None
        assert np.allclose(found[:3, 3], sign * np.array([0.025, 0.0, 0.005]))


def test_distance_along_the_rays_becomes_depth_along_the_axis(tmp_path: Path) -> None:
    (tmp_path / "camera.yaml").write_text(LENS)
    across = (np.arange(WIDTH)[None, :] - 31.0) / 70.0
    down = (np.arange(HEIGHT)[:, None] - 24.0) / 71.0
    for index in range(COUNT):
        cv2.imwrite(str(tmp_path / f"rgb_{index:04d}.png"), colour(index))
        distance = metres(index) * np.sqrt(1 + across**2 + down**2)
        np.save(tmp_path / f"distance_to_camera_{index:04d}.npy", distance.astype(np.float32))
    assert is_right(open_source(tmp_path), 1e-4)


def test_disparity_is_not_taken_for_depth(tmp_path: Path) -> None:
    pictures(tmp_path)
    (tmp_path / "depth").rename(tmp_path / "disparity")
    (tmp_path / "camera.yaml").write_text(LENS)
    with pytest.raises(UserError, match="called disparity, and no single baseline is stated; write depth"):
        open_source(tmp_path)


def test_disparity_in_an_array_is_not_taken_for_depth_either(tmp_path: Path) -> None:
    views = np.stack([colour(index) for index in range(COUNT)])
    disparity = np.stack([70 * 0.1 / metres(index) for index in range(COUNT)]).astype(np.float32)
    np.savez(tmp_path / "a.npz", left=views, disparity=disparity, K=np.array([[70, 0, 31], [0, 71, 24], [0, 0, 1.0]]))
    with pytest.raises(UserError, match="called disparity, and no single baseline is stated; write depth"):
        open_source(tmp_path / "a.npz")


def test_what_a_type_can_hold_at_most_is_no_depth_and_less_is_one(tmp_path: Path) -> None:
    pictures(tmp_path)
    (tmp_path / "camera.yaml").write_text(LENS.replace("}", ", depth_scale: 1000000}"))
    for index in range(COUNT):
        (tmp_path / "depth" / f"{index:03d}.png").unlink()
        micrometres = np.round(metres(index) * 1e6).astype(np.int32)
        micrometres[:3], micrometres[3:6] = np.iinfo(np.int32).max, -1
        np.save(tmp_path / "depth" / f"{index:03d}.npy", micrometres)
    source = open_source(tmp_path)
    assert is_right(source)
    frame = source.frame(0)
    assert frame is not None
    assert not frame.depth[:6].any()
    assert frame.depth[6:].all()


def test_where_it_is_to_be_found_how_depth_lies_nothing_is_said_of_it(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    pictures(tmp_path, size=(WIDTH // 2, HEIGHT // 2))
    (tmp_path / "camera.yaml").write_text(LENS)
    open_source(tmp_path)
    assert "the same view" in caplog.text
    caplog.clear()
    open_uncalibrated(tmp_path)
    assert "the same view" not in caplog.text


def test_a_folder_for_each_frame(tmp_path: Path) -> None:
    pictures(tmp_path)
    for index in range(COUNT):
        place = tmp_path / f"frame_{index + 6}"
        place.mkdir()
        (tmp_path / "rgb" / f"{index:03d}.png").rename(place / "color.png")
        (tmp_path / "depth" / f"{index:03d}.png").rename(place / "depth.png")
        (place / "meta.yaml").write_text(LENS)
    for name in ("rgb", "depth"):
        (tmp_path / name).rmdir()
    assert is_right(open_source(tmp_path))


@pytest.mark.parametrize("first", [0, 1])
def test_raw_depth_beside_depth_in_false_colours(tmp_path: Path, first: int) -> None:
    (tmp_path / "camera.yaml").write_text(LENS)
    for index in range(COUNT):
        name = f"{index + first:04d}"
        cv2.imwrite(str(tmp_path / f"hall_Infrared_{name}.png"), colour(index)[..., 0])
        cv2.imwrite(str(tmp_path / f"hall_Depth_{name}.png"), colour(index))
        np.round(metres(index) * 1000).astype("<u2").tofile(tmp_path / f"hall_Depth_{name}.raw")
    source = open_source(tmp_path)
    assert is_right(source)
    frame = source.frame(0)
    assert frame is not None
    assert np.array_equal(frame.rgb[..., 0], colour(0)[..., 0])


def test_a_clock_that_is_set_back_is_said_and_lists_in_another_order_are_sorted(tmp_path: Path) -> None:
    swapped = np.roll(TIMES, 3)
    folder = tum(tmp_path / "swapped")
    for name in ("rgb", "depth"):
        # Numbers in the names follow the times, and the list does not.
        listed = (folder / f"{name}.txt").read_text().splitlines()
        (folder / f"{name}.txt").write_text("\n".join(np.roll(listed, 3)))
    assert is_right_in_time(folder, swapped)
    lines = np.array([100.0, 100.1, 100.3, 100.2, 100.4, 100.5])
    assert is_right_in_time(tum(tmp_path / "lines", lines), lines), "a logger wrote two lines in the wrong order"
    back = np.array([100.0, 100.1, 100.2, 100.05, 100.15, 100.25])
    with pytest.raises(UserError, match=r"goes back by 0\.15 between entries 3 and 4"):
        open_source(tum(tmp_path / "back", back))


def is_right_in_time(folder: Path, times: NDArray[np.float64]) -> bool:
    found = [frame.timestamp for frame in open_source(folder)]
    return bool(np.allclose(found, np.sort(times)))


def test_depth_that_is_the_same_everywhere_tells_no_units(tmp_path: Path) -> None:
    tum(tmp_path)
    (tmp_path / "camera.yaml").write_text(LENS)
    for path in (tmp_path / "depth").iterdir():
        cv2.imwrite(str(path), np.full((HEIGHT, WIDTH), 5000, np.uint16))
    with pytest.raises(UserError, match="the same everywhere and always"):
        open_source(tmp_path)


def test_a_matrix_of_four_rows_has_no_distortion(tmp_path: Path) -> None:
    (tmp_path / "K.txt").write_text("70 0 31 0\n0 71 24 0\n0 0 1 0\n0 0 0 1\n")
    camera = read_calibration(tmp_path / "K.txt", (WIDTH, HEIGHT)).camera
    assert (camera.fx, camera.cx, camera.distortion) == (70.0, 31.0, (0.0,) * 5)


def test_a_focal_length_and_an_aperture_in_millimetres_are_pixels() -> None:
    tree = {"camera_focal_length": 18.0, "camera_aperture": [24.0, 18.0], "render_product_resolution": [640, 480]}
    camera = calibration_of(tree, Path("camera_params.json"), (640, 480)).camera
    assert (camera.fx, camera.fy) == (pytest.approx(480.0), pytest.approx(480.0))
    assert (camera.cx, camera.cy) == (319.5, 239.5)


def test_an_aperture_that_is_a_number_of_its_lens_is_no_length() -> None:
    tree = {"focal_length": 525.0, "aperture": 2.0, "cx": 319.5, "cy": 239.5, "width": 640, "height": 480}
    assert calibration_of(tree, Path("camera.json"), (640, 480)).camera.fx == 525.0


def test_a_list_of_cameras_is_read_by_their_names(tmp_path: Path) -> None:
    matrix = [[70.0, 0, 31.0], [0, 71.0, 24.0], [0, 0, 1]]
    tree = {"cameraData": [[0, {"intrinsicMatrix": matrix, "width": 64, "height": 48, "distortionCoeff": [0.1, 0.2]}]]}
    (tmp_path / "calib.json").write_text(json.dumps(tree))
    camera = read_calibration(tmp_path / "calib.json", (WIDTH, HEIGHT)).camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (70.0, 71.0, 31.0, 24.0)
    assert camera.distortion[:2] == (0.1, 0.2)


@pytest.mark.parametrize("size", [(1280, 720), (2048, 1536), (320, 240)])
def test_the_raw_calibration_of_an_azure_kinect(tmp_path: Path, size: tuple[int, int]) -> None:
    full = max(round(size[0] * 0.75), size[1])
    numbers = [0.5, 0.5, 0.6, 0.8, 0.1, -0.05, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.002, 0.001]
    cameras = [
        {"Location": f"CALIBRATION_CameraLocation{place}", "Intrinsics": {"ModelParameters": values}}
        for place, values in (("D0", [0.4] * 14), ("PV0", numbers))
    ]
    (tmp_path / "calibration.json").write_text(json.dumps({"CalibrationInformation": {"Cameras": cameras}}))
    camera = read_calibration(tmp_path / "calibration.json", size).camera
    assert camera.fx == pytest.approx(0.6 * size[0])
    assert camera.fy == pytest.approx(0.8 * full)
    assert camera.cy == pytest.approx((size[1] - 1) / 2)
    assert camera.distortion == pytest.approx((0.1, -0.05, 0.001, 0.002, 0.01))
    assert camera.depth_scale == 1000.0


def test_eight_terms_are_used_as_the_five_that_come_nearest(tmp_path: Path) -> None:
    eight = [0.3, 0.05, 0.001, 0.0005, 0.01, 0.35, 0.08, 0.02]
    stated = f"{{fx: 500, fy: 500, cx: 319.5, cy: 239.5, width: 640, height: 480, distortion: {eight}}}"
    (tmp_path / "camera.yaml").write_text(stated)
    calibration = read_calibration(tmp_path / "camera.yaml")
    matrix = np.array([[500, 0, 319.5], [0, 500, 239.5], [0, 0, 1]])
    rays = np.array([[[x, y, 1.0]] for x in (-0.5, 0.0, 0.5) for y in (-0.4, 0.3)])
    whole = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix, np.array(eight))[0]
    nearest = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix, np.array(calibration.camera.distortion))[0]
    assert np.abs(whole - nearest).max() < 0.5


@pytest.mark.parametrize(
    ("distortion", "terms"),
    [
        ({"type": "none", "parameters": {"cols": 1, "rows": 0, "data": []}}, (0.0,) * 5),
        (
            {"type": "radial-tangential", "parameters": {"cols": 1, "rows": 4, "data": [0.1, -0.2, 0.001, 0.002]}},
            (0.1, -0.2, 0.001, 0.002, 0.0),
        ),
    ],
)
def test_a_lens_as_aslams_tools_write_it(
    tmp_path: Path, distortion: dict[str, object], terms: tuple[float, ...]
) -> None:
    intrinsics = {"cols": 1, "rows": 4, "data": [70.0, 71.0, 31.0, 24.0]}
    camera = {"image_width": 64, "image_height": 48, "type": "pinhole", "intrinsics": intrinsics}
    (tmp_path / "calib.yaml").write_text(json.dumps({"cameras": [{"camera": {**camera, "distortion": distortion}}]}))
    found = read_calibration(tmp_path / "calib.yaml", (64, 48)).camera
    assert (found.fx, found.fy, found.cx, found.cy) == (70.0, 71.0, 31.0, 24.0)
    assert found.distortion == terms


def test_a_fisheye_as_aslams_tools_write_it_is_refused(tmp_path: Path) -> None:
    distortion = {"type": "equidistant", "parameters": {"cols": 1, "rows": 4, "data": [0.1, -0.2, 0.001, 0.002]}}
    intrinsics = {"cols": 1, "rows": 4, "data": [70.0, 71.0, 31.0, 24.0]}
    camera = {"image_width": 64, "image_height": 48, "type": "pinhole", "intrinsics": intrinsics}
    (tmp_path / "calib.yaml").write_text(json.dumps({"cameras": [{"camera": {**camera, "distortion": distortion}}]}))
    with pytest.raises(UserError, match="equidistant is no"):
        read_calibration(tmp_path / "calib.yaml", (64, 48))
