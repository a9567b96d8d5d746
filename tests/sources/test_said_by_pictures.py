"""What the files of pictures say of themselves: chunks of PNG, EXIF's orientation; and sizes by rows and columns."""

import io
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image, PngImagePlugin
from tests.sources.test_depth_encodings import COUNT, HEIGHT, LENS, WIDTH, colour, is_right, room, write

from lpslam.errors import UserError
from lpslam.sources.calibration import read_calibration
from lpslam.sources.open import open_source


def millimetres(index: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint16]]:
    return np.asarray(np.round(room(index) * 4000), np.uint16)


def say(path: Path, **said: str) -> None:
    info = PngImagePlugin.PngInfo()
    for key, text in said.items():
        info.add_text(key, text)
    with Image.open(path) as image:
        image.load()
        image.save(path, pnginfo=info)


def test_a_calibration_units_and_times_in_chunks_of_png(tmp_path: Path) -> None:
    write(tmp_path, millimetres)
    (tmp_path / "camera.json").unlink()
    for index in range(COUNT):
        say(tmp_path / "rgb" / f"{index:04d}.png", camera=json.dumps(LENS), timestamp=f"{1.7e9 + index / 7:.6f}")
        say(tmp_path / "depth" / f"{index:04d}.png", depth_scale="4000")
    assert is_right(tmp_path)
    assert open_source(tmp_path).timestamps == pytest.approx([1.7e9 + index / 7 for index in range(COUNT)])


def test_chunks_that_make_no_sense_change_nothing(tmp_path: Path) -> None:
    write(tmp_path, millimetres, README="Depth has 4000 units per metre.")
    say(tmp_path / "rgb" / "0000.png", camera="{" * 5000, timestamp="nan", Title="fx: here")
    assert is_right(tmp_path)
    (tmp_path / "camera.json").unlink()
    with pytest.raises(UserError, match="has no calibration"):
        open_source(tmp_path)


def test_pictures_are_read_as_they_are_stored_whatever_exif_says(tmp_path: Path) -> None:
    write(tmp_path, millimetres, README="Depth has 4000 units per metre.")
    for index in range(COUNT):
        path = tmp_path / "rgb" / f"{index:04d}.png"
        exif = Image.Exif()
        exif[0x0112] = 6
        data = io.BytesIO()
        Image.fromarray(colour(index)[..., ::-1]).save(data, "JPEG", exif=exif, quality=95)
        path.with_suffix(".jpg").write_bytes(data.getvalue())
        path.unlink()
    frames = list(open_source(tmp_path))
    assert len(frames) == COUNT
    assert np.abs(frames[0].rgb[..., ::-1].astype(int) - colour(0)).mean() < 8
    assert cv2.imread(str(tmp_path / "rgb" / "0000.jpg")).shape[:2] == (WIDTH, HEIGHT)


def test_a_camera_as_matlab_prints_it(tmp_path: Path) -> None:
    (tmp_path / "cameraParams.txt").write_text(
        "cam = \n\n  cameraIntrinsics with properties:\n\n             FocalLength: [266.3000 265.9000]\n"
        "          PrincipalPoint: [160.2000 122.4000]\n               ImageSize: [240 320]\n"
        "        RadialDistortion: [0.1120 -0.2050 0.0750]\n    TangentialDistortion: [0.0011 -7.0000e-04]\n"
        "                    Skew: 0\n"
    )
    camera = read_calibration(tmp_path / "cameraParams.txt", (320, 240)).camera
    assert (camera.width, camera.height, camera.fx) == (320, 240, 266.3)
    assert camera.distortion == (0.112, -0.205, 0.0011, -0.0007, 0.075)


@pytest.mark.parametrize("key", ["dist_coeff", "lens_distortion", "distortion_parameters"])
def test_distortion_by_other_names(tmp_path: Path, key: str) -> None:
    terms = [0.1, -0.2, 0.001, -0.001, 0.05]
    value: object = {"model": "opencv", "values": terms} if key == "lens_distortion" else [terms]
    (tmp_path / "camera.json").write_text(json.dumps({**LENS, key: value}))
    assert read_calibration(tmp_path / "camera.json").camera.distortion == tuple(terms)
