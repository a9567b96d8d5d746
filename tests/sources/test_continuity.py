"""One recording is one walk: clocks that were set on the way, and two recordings in one folder."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.sources.calibration import calibration_of
from lpslam.sources.open import SourceOptions, open_source

COUNT, WIDTH, HEIGHT = 10, 64, 48
LENS = {"fx": 70, "fy": 71, "cx": 31, "cy": 24, "width": WIDTH, "height": HEIGHT, "depth_scale": 1000}
TIMES = 100.0 + np.arange(COUNT) / 10


def walk(index: int, seed: int = 1) -> NDArray[np.uint8]:
    """A picture of a camera that goes along a wall."""
    wall = np.random.default_rng(seed).integers(0, 255, (HEIGHT, 4 * WIDTH, 3), np.uint8)
    return np.asarray(cv2.GaussianBlur(wall, (21, 21), 7)[:, 3 * index : 3 * index + WIDTH], np.uint8)


def put(folder: Path, name: str, picture: NDArray[np.uint8], suffix: str = ".png") -> None:
    for kind in ("rgb", "depth"):
        (folder / kind).mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / "rgb" / f"{name}{suffix}"), picture)
    ramp = np.linspace(1000, 5000, picture.shape[1])[None, :] + np.arange(picture.shape[0])[:, None]
    cv2.imwrite(str(folder / "depth" / f"{name}.png"), ramp.astype(np.uint16))
    (folder / "camera.json").write_text(json.dumps(LENS))


def tum(folder: Path, times: NDArray[np.float64], shown: list[int], names: list[str]) -> Path:
    for index, name in zip(shown, names, strict=True):
        put(folder, name, walk(index))
    for kind in ("rgb", "depth"):
        lines = (f"{time:.6f} {kind}/{name}.png" for time, name in zip(times, names, strict=True))
        (folder / f"{kind}.txt").write_text("\n".join(lines))
    return folder


def set_back() -> NDArray[np.float64]:
    """Times whose second half lies before the first as a whole."""
    return np.where(np.arange(COUNT) < COUNT // 2, TIMES, TIMES - 3.0)


def test_a_clock_that_is_set_far_back_is_told_by_the_numbers_of_the_pictures(tmp_path: Path) -> None:
    names = [f"{index:04d}" for index in range(COUNT)]
    with pytest.raises(UserError, match=r"goes back by 2\.9 between entries 5 and 6, and the pictures go on"):
        open_source(tum(tmp_path, set_back(), list(range(COUNT)), names))


def test_a_clock_that_is_set_far_back_is_told_by_the_pictures_where_names_are_times(tmp_path: Path) -> None:
    names = [f"{time:.6f}" for time in set_back()]
    with pytest.raises(UserError, match="goes back"):
        open_source(tum(tmp_path, set_back(), list(range(COUNT)), names))


def test_halves_that_are_listed_in_another_order_are_sorted_by_what_the_pictures_tell(tmp_path: Path) -> None:
    times = np.roll(TIMES, COUNT // 2)
    shown = np.roll(np.arange(COUNT), COUNT // 2).tolist()
    source = open_source(tum(tmp_path, times, shown, [f"{time:.6f}" for time in times]))
    frames = list(source)
    assert [frame.timestamp for frame in frames] == pytest.approx(TIMES.tolist())
    assert all(np.array_equal(frame.rgb[..., ::-1], walk(index)) for index, frame in enumerate(frames))


@pytest.mark.parametrize("is_set_back", [True, False])
def test_a_table_of_times_that_do_not_rise(tmp_path: Path, is_set_back: bool) -> None:
    rows = list(range(COUNT))
    for index in rows:
        put(tmp_path, f"{index:04d}", walk(index))
    times = set_back() if is_set_back else TIMES
    listed = rows if is_set_back else np.random.default_rng(5).permutation(rows).tolist()
    lines = [f"{times[index]:.3f},{index:04d}.png" for index in listed]
    (tmp_path / "frames.csv").write_text("\n".join(["time_s,file", *lines]))
    if is_set_back:
        with pytest.raises(UserError, match="goes back"):
            open_source(tmp_path)
    else:
        assert [frame.timestamp for frame in open_source(tmp_path)] == pytest.approx(TIMES.tolist())


def test_pictures_of_two_sizes_are_two_recordings(tmp_path: Path) -> None:
    for index in range(COUNT):
        put(tmp_path, f"{100 + index / 10:.3f}", walk(index))
        larger = cv2.resize(walk(index), (WIDTH, HEIGHT + 16))
        put(tmp_path, f"{1.7e9 + index / 10:.3f}", np.asarray(larger, np.uint8), ".jpg")
    with pytest.raises(UserError, match="are of two sizes, 64×48 and 64×64"):
        open_source(tmp_path)


def test_one_picture_of_another_size_is_a_fault_of_its_frame(tmp_path: Path) -> None:
    for index in range(COUNT):
        put(tmp_path, f"{100 + index / 10:.3f}", walk(index))
    put(tmp_path, "100.500", np.zeros((HEIGHT + 16, WIDTH, 3), np.uint8))
    source = open_source(tmp_path)
    assert len(list(source)) == COUNT - 1
    assert [fault.index for fault in source.faults] == [5]


def test_two_recordings_of_one_size_are_told_by_the_time_between_them(tmp_path: Path) -> None:
    for index in range(COUNT):
        put(tmp_path, f"{4215 + index / 10:.6f}", walk(index))
        put(tmp_path, f"{1.7e9 + index / 10:.6f}", walk(index, seed=2), ".jpg")
    with pytest.raises(UserError, match="between its frames 10 and 11, and they show two places"):
        open_source(tmp_path)
    assert len(open_source(tmp_path, options=SourceOptions(end=1.0))) == COUNT


def test_a_clock_that_was_set_ahead_is_one_walk(tmp_path: Path) -> None:
    for index in range(2 * COUNT):
        begin = 4215 if index < COUNT else 1_700_000_000
        put(tmp_path, f"{begin + index / 10:.6f}", walk(index))
    assert len(open_source(tmp_path)) == 2 * COUNT


def test_one_series_may_be_of_two_formats(tmp_path: Path) -> None:
    for index in range(COUNT):
        put(tmp_path, f"{100 + index / 10:.3f}", walk(index), ".jpg" if index < 4 else ".png")
    assert len(list(open_source(tmp_path))) == COUNT


@pytest.mark.parametrize(
    "lens",
    [
        {"camera_type": "ds", "intrinsics": {"fx": 119.3, "fy": 119.2, "cx": 31, "cy": 24, "xi": -0.2, "alpha": 0.57}},
        {"camera_type": "kb4", "intrinsics": {"fx": 119.3, "fy": 119.2, "cx": 31, "cy": 24, "k1": 0.01}},
        {"fx": 119.3, "fy": 119.2, "cx": 31, "cy": 24, "xi": 0.4},
        {"projection_type": "equirectangular", "fx": 119.3, "fy": 119.2, "cx": 31, "cy": 24},
        {"lens_model": "OPENCV_FISHEYE", "fx": 119.3, "fy": 119.2, "cx": 31, "cy": 24},
    ],
)
def test_a_projection_that_is_no_pinhole_is_refused_without_terms_of_distortion(lens: dict[str, object]) -> None:
    with pytest.raises(UserError, match="no pinhole"):
        calibration_of(lens, Path("calibration.json"), (WIDTH, HEIGHT))


@pytest.mark.parametrize("kind", ["pinhole", "Azure Kinect", "perspective", "plumb_bob", "pinhole-radtan8"])
def test_a_pinhole_of_any_name_is_read(kind: str) -> None:
    lens = {"camera_model": kind, "fx": 70, "fy": 71, "cx": 31, "cy": 24, "xi": 0.0}
    assert calibration_of(lens, Path("calibration.json"), (WIDTH, HEIGHT)).camera.fx == 70.0
