"""Folders of pictures as people lay them: what they hold tells which is which, and what belongs together."""

import json
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from lpslam.config import PairingConfig
from lpslam.errors import UserError
from lpslam.sources.calibration import read_calibration
from lpslam.sources.captures import stated
from lpslam.sources.image_pairs import ImagePairSource
from lpslam.sources.open import SourceOptions, open_source

FRAMES, STEP, START = 6, 0.125, 1_700_000_000.0
TIMES = START + STEP * np.arange(FRAMES)
CAMERA = "{fx: 60, fy: 60, cx: 31.5, cy: 23.5, width: 64, height: 48, depth_scale: 1000}"


def colour(number: int) -> np.ndarray:
    picture = np.full((48, 64, 3), 10 * number, np.uint8)
    picture[:, :32] = 200
    return picture


def millimetres(number: int) -> np.ndarray:
    return np.linspace(1000 + 100 * number, 4000, 48 * 64).reshape(48, 64).astype(np.uint16)


def write(
    folder: Path,
    colour_name: Callable[[int], str],
    depth_name: Callable[[int], str],
    camera: str = "my_camera.yaml",
    depths: range = range(FRAMES),
) -> None:
    for number in range(FRAMES):
        path = folder / colour_name(number)
        path.parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(path), colour(number))
    for number in depths:
        path = folder / depth_name(number)
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".npy":
            np.save(path, millimetres(number).astype(np.float32) / 1000)
        elif path.suffix == ".npz":
            np.savez(path, range_m=millimetres(number).astype(np.float64) / 1000)
        else:
            cv2.imwrite(str(path), millimetres(number))
    (folder / camera).write_text(CAMERA)


def is_what_was_written(folder: Path, times: np.ndarray = TIMES) -> None:
    source = open_source(folder)
    frames = list(source)
    assert len(frames) == FRAMES
    assert not source.faults
    np.testing.assert_allclose(np.array([frame.timestamp for frame in frames]), times, atol=1e-6)
    for number, frame in enumerate(frames):
        assert abs(int(frame.rgb[40, 60, 0]) - 10 * number) < 4
        np.testing.assert_allclose(frame.depth, millimetres(number) / 1000, atol=1e-3)
    assert (source.camera.fx, source.camera.cy) == (60.0, 23.5)


NUMBERED = (lambda number: f"camera_front/{number:04d}.jpg", lambda number: f"range/{number:04d}.png")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("pairs.csv", lambda n: f"{TIMES[n]},camera_front/{n:04d}.jpg,range/{n:04d}.png"),
        ("assoc.txt", lambda n: f"{TIMES[n]} camera_front/{n:04d}.jpg {TIMES[n] + 0.004} range/{n:04d}.png"),
        ("list.tsv", lambda n: f"{n}\t{round(TIMES[n] * 1e9)}\t.\\camera_front\\{n:04d}.JPG\t.\\range\\{n:04d}.PNG"),
        ("when.csv", lambda n: f'"{n:04d}.jpg";"{TIMES[n] * 1e3}"'),
        (
            "log.jsonl",
            lambda n: json.dumps({"t": {"secs": 1_700_000_000, "nsecs": round(STEP * n * 1e9)}, "rgb": f"{n:04d}.jpg"}),
        ),
        ("stamps.txt", lambda n: f"{TIMES[n]}"),
        ("stamps.csv", lambda n: f"{n}, {round(TIMES[n] * 1e6)}"),
        ("utc.csv", lambda n: f"2023-11-14T22:13:20.{round(1000 * STEP * n):03d}+00:00,camera_front/{n:04d}.jpg"),
    ],
)
def test_times_stand_in_a_list(tmp_path: Path, name: str, text: Callable[[int], str]) -> None:
    write(tmp_path, *NUMBERED)
    (tmp_path / name).write_text(
        "# made by hand\r\n" + "\r\n".join(text(n) for n in range(FRAMES)), encoding="utf-8-sig"
    )
    is_what_was_written(tmp_path)


def test_columns_are_known_by_their_names(tmp_path: Path) -> None:
    write(tmp_path, *NUMBERED)
    rows = [f"{n + 1},{500 + n},{TIMES[n]},camera_front/{n:04d}.jpg,range/{n:04d}.png" for n in range(FRAMES)]
    (tmp_path / "frames.csv").write_text("\n".join(["row,exposure,timestamp,front,depth", *rows]))
    is_what_was_written(tmp_path)


def test_a_tree_of_json_lists_frames(tmp_path: Path) -> None:
    write(tmp_path, *NUMBERED)
    frames = [
        {"time": TIMES[n], "files": {"rgb": f"camera_front/{n:04d}.jpg", "d": f"range/{n:04d}.png"}}
        for n in range(FRAMES)
    ]
    (tmp_path / "index.json").write_text(json.dumps({"version": 2, "frames": frames}))
    is_what_was_written(tmp_path)


@pytest.mark.parametrize(
    "stem",
    [
        lambda n: f"{round(TIMES[n] * 1e9)}",
        lambda n: f"front-{round(TIMES[n] * 1e6)}",
        lambda n: f"{TIMES[n]:.6f}",
        lambda n: f"cam_{round(TIMES[n] * 1e3)}.000",
    ],
)
@pytest.mark.parametrize("suffix", ["png", "npy"])
def test_names_are_times(tmp_path: Path, stem: Callable[[int], str], suffix: str) -> None:
    write(tmp_path, lambda n: f"pics/{stem(n)}.png", lambda n: f"far/{stem(n)}.{suffix}")
    is_what_was_written(tmp_path)


def test_pictures_with_times_of_their_own_are_paired_as_configured(tmp_path: Path) -> None:
    write(tmp_path, lambda n: f"pics/{TIMES[n]:.6f}.png", lambda n: f"far/{TIMES[n] + 0.01:.6f}.png")
    is_what_was_written(tmp_path)
    strict = SourceOptions(pairing=PairingConfig(tolerance_s=0.001, slow_tolerance_s=0.001))
    with pytest.raises(UserError, match="nothing says which depth picture"):
        open_source(tmp_path, options=strict)


def test_both_kinds_lie_in_one_folder(tmp_path: Path) -> None:
    write(tmp_path, lambda n: f"left_{n}.png", lambda n: f"depthmap_{n:06d}.npz")
    is_what_was_written(tmp_path, np.arange(FRAMES) / 30)


def test_what_is_no_view_is_left_out(tmp_path: Path) -> None:
    write(tmp_path, *NUMBERED)
    for number in range(2 * FRAMES):
        for name in ("confidence", "masks"):
            (tmp_path / name).mkdir(exist_ok=True)
            cv2.imwrite(str(tmp_path / name / f"{number:04d}.png"), np.zeros((48, 64), np.uint16))
    is_what_was_written(tmp_path, np.arange(FRAMES) / 30)


def test_of_many_texts_of_one_kind_one_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, *NUMBERED)
    (tmp_path / "labels").mkdir()
    for number in range(200):
        (tmp_path / "labels" / f"{number:04d}.txt").write_text("3 0.5 0.5 0.1 0.1\n7 0.2 0.3 0.1 0.1\n")
    read: list[Path] = []
    monkeypatch.setattr(
        stated, "read_calibration", lambda path, **how: read.append(path) or read_calibration(path, **how)
    )
    is_what_was_written(tmp_path, np.arange(FRAMES) / 30)
    assert len(read) < 5


def test_a_missing_depth_picture_is_one_fault(tmp_path: Path) -> None:
    write(tmp_path, *NUMBERED, depths=range(0, FRAMES, 2))
    source = open_source(tmp_path)
    assert len(list(source)) == FRAMES // 2
    assert [fault.index for fault in source.faults] == [1, 3, 5]


def test_pictures_that_nothing_pairs_are_refused(tmp_path: Path) -> None:
    write(tmp_path, lambda n: f"a/{n}.jpg", lambda n: f"b/{n + 500}.png")
    with pytest.raises(UserError, match="nothing says which depth picture belongs to which colour picture"):
        open_source(tmp_path)


@pytest.mark.parametrize("layout", ["rgb.txt", ""])
def test_two_calibrations_that_contradict_are_refused(tmp_path: Path, layout: str) -> None:
    write(tmp_path, lambda n: f"rgb/{n}.jpg", lambda n: f"depth/{n}.png", "camera.yaml")
    if layout:
        for kind, suffix in (("rgb", "jpg"), ("depth", "png")):
            lines = [f"{TIMES[n]} {kind}/{n}.{suffix}" for n in range(FRAMES)]
            (tmp_path / f"{kind}.txt").write_text("\n".join(lines))
    (tmp_path / "intrinsics.json").write_text(json.dumps({"fx": 70, "fy": 70, "cx": 31.5, "cy": 23.5}))
    with pytest.raises(UserError, match="contradict each other"):
        open_source(tmp_path)
    assert open_source(tmp_path, tmp_path / "camera.yaml").camera.fx == 60.0


def test_a_calibration_that_cannot_be_read_is_said(tmp_path: Path) -> None:
    write(tmp_path, lambda n: f"color/{n}.jpg", lambda n: f"depth/{n}.png")
    (tmp_path / "my_camera.yaml").write_text("{fx: wide, fy: 60, cx: 31.5, cy: 23.5}")
    with pytest.raises(UserError, match="my_camera"):
        open_source(tmp_path)


def test_an_archive_of_another_kind_is_refused(tmp_path: Path) -> None:
    (tmp_path / "walk.zip").write_bytes(b"PK\x03\x04")
    with pytest.raises(UserError, match="is neither a zip nor a tar"):
        open_source(tmp_path / "walk.zip")


@pytest.mark.parametrize(
    "damage", [b"", b"\x93NUMPY\x01\x00\xff\xff{'descr': '|O', 'shape': (9,)}", b"\x93NUMPY" + b"\xff" * 40]
)
def test_hostile_arrays_are_faults(tmp_path: Path, damage: bytes) -> None:
    write(tmp_path, lambda n: f"pics/{n}.png", lambda n: f"far/{n}.npy")
    (tmp_path / "far" / "3.npy").write_bytes(damage)
    source = open_source(tmp_path)
    assert isinstance(source, ImagePairSource)
    assert len(list(source)) == FRAMES - 1
    assert [fault.index for fault in source.faults] == [3]


@pytest.mark.parametrize("text", ["[" * 10_000, "{}", '{"a": [1, 2]}', "\x00\x01\x02", "a,b\n" * 9, '"' * 999])
@pytest.mark.parametrize("name", ["odd.json", "odd.csv", "odd.txt", "odd.jsonl"])
def test_a_list_that_makes_no_sense_changes_nothing(tmp_path: Path, name: str, text: str) -> None:
    write(tmp_path, *NUMBERED)
    (tmp_path / name).write_text(text)
    is_what_was_written(tmp_path, np.arange(FRAMES) / 30)


def test_times_of_no_clock_are_one_line(tmp_path: Path) -> None:
    write(tmp_path, *NUMBERED)
    (tmp_path / "times.txt").write_text("".join(f"{number + 1}e307\n" for number in range(FRAMES)))
    with pytest.raises(UserError, match="of no clock"):
        open_source(tmp_path)


def test_numbers_of_another_kind_count_nothing(tmp_path: Path) -> None:
    write(tmp_path, *NUMBERED)
    lines = [f"{number} {time}\n" for number, time in zip("⁰¹²³⁴⁵", TIMES, strict=True)]
    (tmp_path / "times.txt").write_text("".join(lines))
    is_what_was_written(tmp_path)


@pytest.mark.parametrize("table", ["1.5," * 100_000, "7 7\n" * 150_000], ids=["wide", "long"])
def test_a_table_of_something_else_takes_no_time(tmp_path: Path, table: str) -> None:
    write(tmp_path, *NUMBERED)
    (tmp_path / "odd.csv").write_text(f"{table}\n" * (9 if "," in table else 1))
    begun = time.process_time()
    assert open_source(tmp_path).timestamps == pytest.approx(np.arange(FRAMES) / 30)
    assert time.process_time() - begun < 2.0
