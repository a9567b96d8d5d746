"""Images and calibrations that are made to fill the memory, never end, or break whoever reads them."""

import os
import struct
import time
import zlib
from contextlib import suppress
from pathlib import Path

import pytest

from lpslam.config import Config
from lpslam.errors import UserError
from lpslam.sources.calibration import read_calibration
from lpslam.sources.images import BadImageError, image_size, read_colour

GOOD = "fx: 60\nfy: 60\ncx: 32\ncy: 24\nwidth: 64\nheight: 48\n"
LAUGHS = "a: &a {k: 1}\n" + "".join(
    f"{b}: &{b} {{{', '.join(f'x{n}: *{a}' for n in range(9))}}}\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True)
)
HOSTILE = {
    "deep": "a: " + "[" * 20_000,
    "deep blocks": "a:\n " + "- " * 20_000,
    "deep maps": "a: " + "{b: " * 20_000,
    "copies": LAUGHS,
    "circle": "a: &a {b: *a}\n",
    "date": "fx: 2020-99-99\n",
    "digits": "fx: " + "9" * 5000,
    "hexadecimal": "fx: 0x" + "f" * 5000 + "\n",
    "time": "fx: !!timestamp x\n",
    "whole": "!!int x: y\n",
    "long": "x: 1\n" * 100_000,
    "blank": "\n" * 60_000,
    "per unit": "depth_mm_per_unit: " + "9" * 400 + "\n",
    "lens": "distortion_model: inverse brown conrady\ndistortion: [1.0e+200, 1.0, 1.0, 1.0, 1.0, 1.0]\n",
}
HOSTILE_JSON = {
    "deep": '{"a":' * 900 + "1" + "}" * 900,
    "lists": "[" * 900 + "]" * 900,
    "transform": "[" + "9" * 400 + ", 0" * 11 + "]",
    "matrix": "[" + ", ".join(["9" * 400] * 9) + "]",
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
def test_yaml_that_is_made_to_hurt_is_one_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "camera.yaml"
    path.write_text(GOOD + text)
    begun = time.process_time()
    read_calibration(_written(tmp_path / "good.yaml", GOOD), image_size=None, default_depth_scale=1000.0)
    with pytest.raises(UserError) as caught:
        Config.from_yaml(path)
    assert "\n" not in str(caught.value)
    # Which values a calibration needs is its own business; nothing else than a mistake may come of the others.
    with suppress(UserError):
        read_calibration(path, image_size=None, default_depth_scale=1000.0)
    assert time.process_time() - begun < 5.0, "a file of half a page takes no minute"


@pytest.mark.parametrize(
    "name", ["more", "color_from_depth", "K", "depth_mm_per_unit", "distortion", "a." * 5000 + "a"]
)
@pytest.mark.parametrize("value", HOSTILE_JSON.values(), ids=HOSTILE_JSON)
def test_json_that_is_made_to_hurt_is_one_line(tmp_path: Path, name: str, value: str) -> None:
    path = tmp_path / "camera.json"
    path.write_text(f'{{"{name}": {value}, "fx": 60, "fy": 60, "cx": 32, "cy": 24, "width": 64, "height": 48}}')
    with suppress(UserError):
        read_calibration(path, image_size=None, default_depth_scale=1000.0)


def test_numbers_of_azure_kinect_that_are_none_are_one_line(tmp_path: Path) -> None:
    parameters = "[" + ", ".join(["9" * 400] * 14) + "]"
    cameras = f'[{{"Location": "CALIBRATION_CameraLocationPV0", "Intrinsics": {{"ModelParameters": {parameters}}}}}]'
    path = _written(tmp_path / "camera.json", f'{{"CalibrationInformation": {{"Cameras": {cameras}}}}}')
    with pytest.raises(UserError):
        read_calibration(path, image_size=(64, 48), default_depth_scale=1000.0)


def _written(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", ["/dev/zero", "a\0b.png", "pipe", "."])
def test_what_is_listed_as_an_image_must_be_a_file(tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert image_size(tmp_path / name) is None
    with pytest.raises(BadImageError):
        read_colour(tmp_path / name)


def test_an_image_that_unpacks_to_gigabytes_is_not_unpacked(tmp_path: Path) -> None:
    def part(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = part(b"IHDR", struct.pack(">IIBBBBB", 30_000, 30_000, 16, 0, 0, 0, 0))
    bomb = tmp_path / "bomb.png"
    bomb.write_bytes(b"\x89PNG\r\n\x1a\n" + header + part(b"IDAT", zlib.compress(bytes(10_000))) + part(b"IEND", b""))
    with pytest.raises(BadImageError, match="larger than any camera"):
        read_colour(bomb)
