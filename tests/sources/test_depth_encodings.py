"""Raw numbers that are no depth: read as they are stated, refused where the pictures tell another encoding."""

import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.config import EncodingCheckConfig
from lpslam.errors import UserError
from lpslam.sources.depths.check import flag_bits, looks_inverse
from lpslam.sources.depths.encoding import DepthEncoding
from lpslam.sources.depths.stated import stated_encoding
from lpslam.sources.open import open_source

COUNT, WIDTH, HEIGHT = 8, 160, 120
LENS = {"fx": 140.0, "fy": 140.0, "cx": 79.5, "cy": 59.5, "width": WIDTH, "height": HEIGHT}


def room(index: int) -> NDArray[np.float64]:
    """Metres of a floor and of a wall that is seen along it."""
    across, down = np.meshgrid((np.arange(WIDTH) - 79.5) / 140, (np.arange(HEIGHT) - 59.5) / 140)
    floor = 1.2 / np.maximum(down + 0.15, 1e-3)
    wall = 1.5 / np.maximum(across + 0.25, 1e-3)
    return np.minimum(np.minimum(floor, wall), 6.0 + 0.1 * index)


def colour(index: int) -> NDArray[np.uint8]:
    noise = np.random.default_rng(index).integers(0, 255, (HEIGHT, WIDTH, 3), np.uint8)
    return np.asarray(cv2.GaussianBlur(noise, (9, 9), 3), np.uint8)


def write(folder: Path, raw: Callable[[int], NDArray[np.generic]], name: str = "depth", **said: str) -> Path:
    """A folder whose depth is what `raw` gives, and texts by their names."""
    for kind in ("rgb", name):
        (folder / kind).mkdir()
    for index in range(COUNT):
        cv2.imwrite(str(folder / "rgb" / f"{index:04d}.png"), colour(index))
        cv2.imwrite(str(folder / name / f"{index:04d}.png"), raw(index))
    (folder / "camera.json").write_text(json.dumps(LENS))
    for file, text in said.items():
        (folder / f"{file}.txt").write_text(text)
    return folder


def is_right(folder: Path, tolerance: float = 0.01) -> bool:
    frames = list(open_source(folder))
    errors = [np.abs(frame.depth - room(index))[frame.depth > 0] / 5 for index, frame in enumerate(frames)]
    return len(frames) == COUNT and max(float(np.median(error)) for error in errors) < tolerance


def flagged(index: int, bits: int = 13) -> NDArray[np.uint16]:
    """Millimetres below, and confidence that changes from place to place above."""
    noise = np.random.default_rng(index).integers(0, 255, (HEIGHT // 8, WIDTH // 8), np.uint8)
    confidence = cv2.resize(noise, (WIDTH, HEIGHT), interpolation=cv2.INTER_NEAREST).astype(np.uint16)
    return (np.round(room(index) * (600 if bits == 12 else 1000)).astype(np.uint16)) | (confidence % 4 << bits)


def inverse(index: int) -> NDArray[np.uint16]:
    return np.asarray(np.round(16384 / room(index)), np.uint16)


def packed(index: int) -> NDArray[np.uint8]:
    """Millimetres, the high byte in red and the low one in green, as OpenCV orders channels."""
    raw = np.round(room(index) * 1000).astype(np.uint16)
    return np.dstack([np.zeros_like(raw), raw & 255, raw >> 8]).astype(np.uint8)


def test_flags_in_upper_bits_are_left_out_where_a_text_says_so(tmp_path: Path) -> None:
    assert is_right(write(tmp_path, flagged, README="Depth in mm: the lower 13 bits; above them the confidence."))


@pytest.mark.parametrize("bits", [12, 13])
def test_flags_in_upper_bits_are_told_by_the_steps_between_neighbours(tmp_path: Path, bits: int) -> None:
    folder = write(tmp_path, lambda index: flagged(index, bits), README="Depth in mm")
    with pytest.raises(UserError, match=f"the upper {16 - bits} bits of its depth are none"):
        open_source(folder)


def test_inverse_depth_is_read_as_it_is_stated(tmp_path: Path) -> None:
    assert is_right(write(tmp_path, inverse, "invdepth", README="inverse_depth_scale: 16384"))


def test_inverse_depth_of_no_stated_unit_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="called inverse depth, and nothing states"):
        open_source(write(tmp_path, inverse, "invdepth"))


def test_inverse_depth_that_nothing_says_is_told_by_its_planes(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="planes are planes in its depth only if that is inverse"):
        open_source(write(tmp_path, inverse, README="One metre is 5000 units of depth."))


def test_depth_that_is_stated_to_be_inverse_and_is_not_is_refused(tmp_path: Path) -> None:
    def raw(index: int) -> NDArray[np.uint16]:
        return np.asarray(np.round(room(index) * 1000), np.uint16)

    with pytest.raises(UserError, match="stated to be inverse, and its planes are none"):
        open_source(write(tmp_path, raw, README="inverse_depth_scale: 4000"))


def test_two_bytes_in_channels_are_read_where_a_text_says_how(tmp_path: Path) -> None:
    assert is_right(write(tmp_path, packed, README="depth in mm = R * 256 + G; B is 0"))


def test_channels_that_nothing_explains_are_refused_with_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="eight bits"):
        open_source(write(tmp_path, packed))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("mask with 0x1FFF", DepthEncoding(kept_bits=13)),
        ("depth_mm = red * 256 + green", DepthEncoding(weights=(256.0, 1.0, 0.0))),
        ("d = R + G*256 + B*256^2", DepthEncoding(weights=(1.0, 256.0, 65536.0))),
        ("1000 * (R + G * 256) / 65535", DepthEncoding(weights=(1.0, 256.0, 0.0))),
        (
            "normalized = (R + G * 256 + B * 256 * 256) / (256 * 256 * 256 - 1); metres = 1000 * normalized",
            DepthEncoding(weights=(1.0, 256.0, 65536.0), scale=16777.215),
        ),
        ("inverse depth: value / 8192 = inverse depth in 1/m", DepthEncoding(numerator=8192.0)),
        ("grey = 0.3 * R + 0.6 * G + 0.1 * B", None),
        ("R + G + B", None),
        ("depth in mm", None),
    ],
)
def test_what_texts_state(tmp_path: Path, text: str, expected: DepthEncoding | None) -> None:
    (tmp_path / "README").write_text(text)
    assert stated_encoding([tmp_path / "README"], "depth/0000.png") == expected


@pytest.mark.parametrize("scale", [256.0, 1.0])
@pytest.mark.parametrize("baseline", ["baseline=95", "baseline: 0.095 m", "baseline_mm: 95"])
def test_disparity_is_read_with_a_stated_baseline(tmp_path: Path, scale: float, baseline: str) -> None:
    def raw(index: int) -> NDArray[np.uint16]:
        return np.asarray(np.round(140 * 0.095 / room(index) * scale), np.uint16)

    said = f"{baseline}\ndisparity = value / {scale:g}\n"
    assert is_right(write(tmp_path, raw, "disparity", calib=said), 0.05 if scale == 1 else 0.01)


@pytest.mark.parametrize("said", ["", "baseline: 5", "baseline: 0.1\n", "baseline: 0.1\nbaseline: 0.2"])
def test_disparity_is_not_guessed(tmp_path: Path, said: str) -> None:
    with pytest.raises(UserError, match="disparity"):
        open_source(write(tmp_path, inverse, "disparity", calib=said))


def test_planes_tell_depth_from_its_inverse_in_noise() -> None:
    config, noise = EncodingCheckConfig(), np.random.default_rng(2)
    depths = [np.asarray(room(index) * noise.normal(1, 0.002, (HEIGHT, WIDTH)), np.float32) for index in range(COUNT)]
    assert not looks_inverse(depths, config)
    assert looks_inverse([np.asarray(1 / depth, np.float32) for depth in depths], config)
    assert flag_bits([depth * 1000 for depth in depths], config) is None
    assert flag_bits([depth * 10000 for depth in depths], config) is None
