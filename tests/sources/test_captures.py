"""Captures of phones and data sets, written here as their descriptions say: colour, depth in metres, camera, times."""

import json
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from lpslam.errors import UserError
from lpslam.sources.captures import azure, folders, record3d, replica, scannet, stray
from lpslam.sources.open import FORMATS

WIDTH, HEIGHT, FRAMES = 64, 48, 4
FOCAL = 60.0
SENS_SIZES = 4 + 8 + len(b"sensor") + 4 * 64 + 8
"""Where a `.sens` states the sizes of its images."""


def colour(number: int, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    """A picture that JPEG keeps: broad stripes, brighter with every frame; red, green, blue."""
    across = np.linspace(0, 150, width)[None, :, None]
    return np.broadcast_to(across + 20 * number + np.array([0.0, 10.0, 30.0]), (height, width, 3)).astype(np.uint8)


def metres(number: int, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    depth = np.linspace(0.5, 3.0, width)[None, :] + 0.1 * number + np.zeros((height, 1))
    depth[: height // 4, : width // 4] = 0.0
    return np.round(depth, 3).astype(np.float32)


def jpeg(picture: np.ndarray) -> bytes:
    return bytes(cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 98])[1])


def write_scannet(path: Path) -> Path:
    matrix, same = np.eye(4, dtype="<f4"), np.eye(4, dtype="<f4")
    matrix[0, 0] = matrix[1, 1] = FOCAL
    matrix[0, 2], matrix[1, 2] = (WIDTH - 1) / 2, (HEIGHT - 1) / 2
    data = struct.pack("<IQ", 4, 6) + b"sensor" + b"".join(each.tobytes() for each in (matrix, same, matrix, same))
    data += struct.pack("<ii4IfQ", 2, 1, WIDTH, HEIGHT, WIDTH, HEIGHT, 1000.0, FRAMES)
    for number in range(FRAMES):
        picture = jpeg(colour(number))
        packed = zlib.compress(np.round(1000 * metres(number)).astype("<u2").tobytes())
        taken = 1_000_000 + 33_333 * number
        data += np.eye(4, dtype="<f4").tobytes() + struct.pack("<4Q", taken, taken, len(picture), len(packed))
        data += picture + packed
    path.write_bytes(data)
    return path


def write_pairs(folder: Path, colours: str = "color", name: str = "{:05d}") -> Path:
    for room in (colours, "depth"):
        (folder / room).mkdir(parents=True)
    for number in range(FRAMES):
        (folder / colours / f"{name.format(number)}.jpg").write_bytes(jpeg(colour(number)))
        millimetres = np.round(1000 * metres(number)).astype(np.uint16)
        cv2.imwrite(str(folder / "depth" / f"{name.format(number)}.png"), millimetres)
    matrix = [FOCAL, 0, 0, 0, FOCAL, 0, (WIDTH - 1) / 2, (HEIGHT - 1) / 2, 1]
    (folder / "camera_intrinsic.json").write_text(
        json.dumps({"width": WIDTH, "height": HEIGHT, "intrinsic_matrix": matrix})
    )
    return folder


def write_replica(scene: Path) -> Path:
    (scene / "results").mkdir(parents=True)
    for number in range(FRAMES):
        (scene / "results" / f"frame{number:06d}.jpg").write_bytes(jpeg(colour(number)))
        scaled = np.round(6553.5 * metres(number)).astype(np.uint16)
        cv2.imwrite(str(scene / "results" / f"depth{number:06d}.png"), scaled)
    camera = {"w": WIDTH, "h": HEIGHT, "fx": FOCAL, "fy": FOCAL, "cx": 31.5, "cy": 23.5, "scale": 6553.5}
    (scene.parent / "cam_params.json").write_text(json.dumps({"camera": camera}))
    return scene


def write_stray(folder: Path) -> Path:
    """Colour is four times as large as depth."""
    (folder / "depth").mkdir(parents=True)
    (folder / "confidence").mkdir()
    size = 4 * WIDTH, 4 * HEIGHT
    video = cv2.VideoWriter(str(folder / "rgb.mp4"), cv2.VideoWriter.fourcc(*"mp4v"), 30, size)
    assert video.isOpened()
    for number in range(FRAMES):
        video.write(np.ascontiguousarray(colour(number, *size)[..., ::-1]))
        millimetres = np.round(1000 * metres(number)).astype(np.uint16)
        cv2.imwrite(str(folder / "depth" / f"{number:06d}.png"), millimetres)
        sure = np.full((HEIGHT, WIDTH), 2, np.uint8)
        sure[-1] = 0
        cv2.imwrite(str(folder / "confidence" / f"{number:06d}.png"), sure)
    video.release()
    rows = [[4 * FOCAL, 0, 2 * WIDTH], [0, 4 * FOCAL, 2 * HEIGHT], [0, 0, 1]]
    (folder / "camera_matrix.csv").write_text("\n".join(",".join(map(str, row)) for row in rows))
    lines = [f"{100 + number / 60},{number:06d},0,0,0,0,0,0,1" for number in range(FRAMES)]
    (folder / "odometry.csv").write_text("\n".join(["timestamp,frame,x,y,z,qx,qy,qz,qw", *lines]))
    return folder


def write_record3d(path: Path) -> Path:
    lzfse = pytest.importorskip("lzfse")
    size = 4 * WIDTH, 4 * HEIGHT
    with zipfile.ZipFile(path, "w") as archive:
        matrix = [4 * FOCAL, 0, 0, 0, 4 * FOCAL, 0, 2.0 * WIDTH, 2.0 * HEIGHT, 1]
        tree = {"K": matrix, "w": size[0], "h": size[1], "dw": WIDTH, "dh": HEIGHT, "fps": 60}
        tree["frameTimestamps"] = [5 + number / 60 for number in range(FRAMES)]
        archive.writestr("metadata", json.dumps(tree))
        for number in range(FRAMES):
            depth = metres(number)
            depth[depth == 0] = np.nan
            archive.writestr(f"rgbd/{number}.jpg", jpeg(colour(number, *size)))
            archive.writestr(f"rgbd/{number}.depth", lzfse.compress(depth.astype("<f4").tobytes()))
    return path


def write_azure(path: Path) -> Path:
    """As k4arecorder does; the calibration is in parts of a larger image, of which the depth's mode cuts the edge."""
    av = pytest.importorskip("av")
    from fractions import Fraction

    def camera(place: str, size: tuple[int, int], focal: float) -> dict[str, object]:
        width, height = size
        parts = [0.5, 0.5, focal / width, focal / height, *[0.0] * 8, 0.0, 0.0]
        kind = "CALIBRATION_LensDistortionModelBrownConrady"
        return {
            "Location": f"CALIBRATION_CameraLocation{place}",
            "Intrinsics": {"ModelType": kind, "ModelParameterCount": 14, "ModelParameters": parts},
            "Rt": {"Rotation": np.eye(3).ravel().tolist(), "Translation": [0.0, 0.0, 0.0]},
        }

    size = 4 * WIDTH, 4 * HEIGHT
    cameras = [camera("D0", (WIDTH, HEIGHT), FOCAL), camera("PV0", size, 4 * FOCAL)]
    tree = json.dumps({"CalibrationInformation": {"Cameras": cameras}}).encode() + b"\0"
    with av.open(str(path), "w", options={"allow_raw_vfw": "1"}) as file:
        file.add_attachment("calibration.json", "application/octet-stream", tree)
        tracks = file.add_stream("mjpeg", rate=30), file.add_stream("rawvideo", rate=30)
        for track, title, form, each in zip(
            tracks, ("COLOR", "DEPTH"), ("yuvj420p", "gray16be"), (size, (WIDTH, HEIGHT)), strict=True
        ):
            track.width, track.height = each
            track.pix_fmt = form
            track.metadata["title"] = title
        for number in range(FRAMES):
            raw = np.rint(metres(number) * 1000).astype(">u2").tobytes()
            for track, data, late in zip(tracks, (jpeg(colour(number, *size)), raw), (0, 3), strict=True):
                packet = av.Packet(data)
                packet.stream, packet.time_base = track, Fraction(1, 1000)
                packet.pts = packet.dts = round(1000 * number / 30) + late
                file.mux(packet)
    return path


LAYOUTS = {
    "Azure Kinect": (lambda place: write_azure(place / "walk.mkv"), azure, 4, 1 / 30),
    "ScanNet": (lambda place: write_scannet(place / "scene.sens"), scannet, 1, 1 / 30),
    "Redwood, Open3D": (lambda place: write_pairs(place / "scene"), folders, 1, 1 / 30),
    "folders": (lambda place: write_pairs(place / "scene", "pictures", "frame-{:03d}"), folders, 1, 1 / 30),
    "Replica": (lambda place: write_replica(place / "office0"), replica, 1, 1 / 30),
    "Stray Scanner": (lambda place: write_stray(place / "scan"), stray, 4, 1 / 60),
    "Record3D": (lambda place: write_record3d(place / "walk.r3d"), record3d, 4, 1 / 60),
}


@pytest.mark.parametrize("name", list(LAYOUTS))
def test_a_capture_gives_what_was_written(tmp_path: Path, name: str) -> None:
    write, room, larger, step = LAYOUTS[name]
    place = write(tmp_path)
    assert next(layout.name for layout in FORMATS if layout.is_at(place)) == name
    source = room.open_capture(place, None, None, nominal=False)
    frames = list(source)
    assert not source.faults
    assert len(frames) == FRAMES
    camera = source.camera
    assert (camera.width, camera.height) == (larger * WIDTH, larger * HEIGHT)
    assert (camera.fx, camera.fy) == (larger * FOCAL, larger * FOCAL)
    np.testing.assert_allclose(np.diff(source.timestamps), step, atol=7e-4)
    for number, frame in enumerate(frames):
        wanted = colour(number, larger * WIDTH, larger * HEIGHT)
        assert np.abs(frame.rgb.astype(int) - wanted).mean() < 6, "colours are red, green, blue"
        depth = frame.depth[larger // 2 :: larger, larger // 2 :: larger]
        expected = metres(number)
        if name == "Stray Scanner":
            expected[-1] = 0.0  # its least confidence
        np.testing.assert_allclose(depth, expected, atol=2e-3)


@pytest.mark.parametrize("name", list(LAYOUTS))
def test_a_part_of_a_capture_is_that_part(tmp_path: Path, name: str) -> None:
    write, room, _, step = LAYOUTS[name]
    source = room.open_capture(write(tmp_path), None, None, nominal=False)
    frames = list(source.part(0.9 * step, 2.1 * step, None))
    assert len(frames) == 2
    np.testing.assert_array_equal(frames[0].rgb, list(source)[1].rgb)


def test_a_zip_with_a_password_is_one_clear_line(tmp_path: Path) -> None:
    place = write_record3d(tmp_path / "walk.r3d")
    data = bytearray(place.read_bytes())
    for signature, offset in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        begin = data.find(signature)
        while begin >= 0:
            data[begin + offset] |= 1
            begin = data.find(signature, begin + 1)
    place.write_bytes(data)
    with pytest.raises(UserError, match="is protected by a password"):
        record3d.open_capture(place, None, None, nominal=False)


@pytest.mark.parametrize("share", np.linspace(0.0, 0.98, 20).tolist())
@pytest.mark.parametrize("name", ["ScanNet", "Record3D", "Azure Kinect"])
def test_a_file_that_is_cut_off_is_one_clear_line_or_what_is_left(tmp_path: Path, name: str, share: float) -> None:
    write, room, larger, _ = LAYOUTS[name]
    place = write(tmp_path)
    data = place.read_bytes()
    place.write_bytes(data[: round(share * len(data))])
    try:
        source = room.open_capture(place, None, None, nominal=False)
        frames = list(source)
    except UserError as error:
        assert "\n" not in str(error)  # noqa: PT017
        return
    assert 1 <= len(frames) <= FRAMES
    np.testing.assert_allclose(frames[0].depth[larger // 2 :: larger, larger // 2 :: larger], metres(0), atol=2e-3)


def spoil_matrix(place: Path) -> None:
    (place / "camera_matrix.csv").write_text("a,b\nc")


def spoil_video(place: Path) -> None:
    (place / "rgb.mp4").write_bytes(b"no video")


def spoil_intrinsics(place: Path) -> None:
    (place / "camera_intrinsic.json").write_text('{"width": 64, "intrinsic_matrix": [1, 2]}')


def spoil_numbers(place: Path) -> None:
    for path in list((place / "depth").iterdir()):
        path.rename(path.with_name(f"{1000 + int(path.stem)}.png"))


def spoil_params(place: Path) -> None:
    (place.parent / "cam_params.json").write_text("[" * 5000)


@pytest.mark.parametrize(
    ("name", "spoil"),
    [
        ("Stray Scanner", spoil_matrix),
        ("Stray Scanner", spoil_video),
        ("Redwood, Open3D", spoil_intrinsics),
        ("Redwood, Open3D", spoil_numbers),
        ("Replica", spoil_params),
    ],
)
def test_what_a_capture_lacks_is_one_clear_line(tmp_path: Path, name: str, spoil: Callable[[Path], None]) -> None:
    write, room, *_ = LAYOUTS[name]
    place = write(tmp_path)
    spoil(place)
    with pytest.raises(UserError) as caught:
        room.open_capture(place, None, None, nominal=False)
    assert "\n" not in str(caught.value)


def restate(**changes: object) -> Callable[[Path], None]:
    """Other values in Record3D's metadata."""

    def spoil(place: Path) -> None:
        with zipfile.ZipFile(place) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
        members["metadata"] = json.dumps(json.loads(members["metadata"]) | changes).encode()
        with zipfile.ZipFile(place, "w") as archive:
            for name, data in members.items():
                archive.writestr(name, data)

    return spoil


def overwrite(offset: int, layout: str, *values: float) -> Callable[[Path], None]:
    """Other values in the header of a `.sens`."""

    def spoil(place: Path) -> None:
        data = bytearray(place.read_bytes())
        struct.pack_into(layout, data, offset, *values)
        place.write_bytes(data)

    return spoil


def spoil_width(place: Path) -> None:
    for path in (place / "camera_intrinsic.json", place.parent / "cam_params.json"):
        if path.is_file():
            tree = json.loads(path.read_text())
            tree.get("camera", tree).update({"w": 1e999, "width": 1e999})
            path.write_text(json.dumps(tree))


@pytest.mark.parametrize(
    ("name", "spoil"),
    [
        ("Record3D", restate(frameTimestamps=[None] * FRAMES)),
        ("Record3D", restate(dh="many")),
        ("Record3D", restate(dw=None)),
        ("Record3D", restate(w=10**9, h=10**9)),
        ("ScanNet", overwrite(4, "<Q", 2**63)),
        ("ScanNet", overwrite(SENS_SIZES, "<2I", 2**31, 2**31)),
        ("ScanNet", overwrite(SENS_SIZES + 8, "<2I", 2**31, 2**31)),
        ("Redwood, Open3D", spoil_width),
        ("Replica", spoil_width),
    ],
)
def test_hostile_values_are_one_clear_line(tmp_path: Path, name: str, spoil: Callable[[Path], None]) -> None:
    write, room, *_ = LAYOUTS[name]
    place = write(tmp_path)
    spoil(place)
    with pytest.raises(UserError) as caught:
        list(room.open_capture(place, None, None, nominal=False))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("times", [[float("nan")] * FRAMES, [5.0] * FRAMES, [4.0, 3.0, 2.0, 1.0], [1.0]])
@pytest.mark.parametrize("name", ["Record3D", "Stray Scanner"])
def test_times_that_do_not_rise_are_replaced_and_that_is_said(tmp_path: Path, name: str, times: list[float]) -> None:
    write, room, *_ = LAYOUTS[name]
    place = write(tmp_path)
    if name == "Record3D":
        restate(frameTimestamps=times)(place)
    else:
        (place / "odometry.csv").write_text("\n".join(["timestamp", *map(str, times)]))
    source = room.open_capture(place, None, None, nominal=False)
    rate = 60 if name == "Record3D" else 30
    np.testing.assert_allclose(source.timestamps, np.arange(FRAMES) / rate)
    assert source.notes == (f"its frames carry no times: {rate} a second are taken",)


def test_a_depth_image_that_is_damaged_is_one_fault(tmp_path: Path) -> None:
    place = write_pairs(tmp_path / "scene")
    path = place / "depth" / "00002.png"
    path.write_bytes(path.read_bytes()[:60])
    source = folders.open_capture(place, None, None, nominal=False)
    assert len(list(source)) == FRAMES - 1
    assert [fault.index for fault in source.faults] == [2]


def test_the_modes_of_an_azure_kinect_cut_and_bin_one_image() -> None:
    """Numbers of a camera as its maker's viewer shows them: pixels of 720p and of the narrow view of depth."""
    numbers = [0.5, 0.52, 0.49, 0.49, 0.5, -2.6, 1.5, 0.38, -2.4, 1.4, 0.0, 0.0, -0.0002, 0.0005]
    camera = {"Intrinsics": {"ModelParameters": numbers}}
    colour = azure._lens(camera, (1280, 720), is_depth=False)
    assert colour.k[2] == 0.5 * 1280 - 0.5
    assert colour.k[5] == pytest.approx(0.52 * 960 - 120 - 0.5)
    assert (colour.k[0], colour.k[4]) == (0.49 * 1280, 0.49 * 960)
    assert colour.d == [0.5, -2.6, 0.0005, -0.0002, 1.5, 0.38, -2.4, 1.4]
    narrow = azure._lens(camera, (640, 576), is_depth=True)
    assert (narrow.k[2], narrow.k[0]) == (0.5 * 1024 - 192 - 0.5, 0.49 * 1024)


def test_a_recording_with_its_own_calibration_takes_no_other(tmp_path: Path) -> None:
    layout = next(each for each in FORMATS if each.name == "ScanNet")
    with pytest.raises(UserError, match="has its own calibration"):
        layout.open(write_scannet(tmp_path / "scene.sens"), tmp_path / "camera.yaml", None, nominal=False)
