"""Texts whose names are unsure are drawn from all their views and read again."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import SecondLookConfig, TextConfig
from lpslam.text.again.averaging import canvas_of
from lpslam.text.again.crops import Crop, CropStore, cut_out
from lpslam.text.again.looking import look_again
from lpslam.text.placing.places import places_of_class
from lpslam.text.reading.legibility import SeenSize
from lpslam.text.remembering.memory import TextClass
from lpslam.text.remembering.naming import name_class
from lpslam.text.text_map import TextMap
from lpslam.text.types import Placement, Recognition, TextObservation

CAMERA = PinholeCamera(width=320, height=240, fx=300.0, fy=300.0, cx=159.5, cy=119.5)
PLACEMENT = Placement((0.0, 0.0, 2.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 0.6, 0.12, 0.01)


def poses(keyframe: int) -> NDArray[np.float64]:
    """A camera that moves sideways by pieces of a pixel."""
    pose = np.eye(4)
    pose[0, 3] = 0.004 * keyframe
    return pose


def view(keyframe: int, noise: float = 40.0, before: str = "") -> NDArray[np.uint8]:
    """A wall with a line on it, 2 m away, perhaps with letters before it, and noise of its own."""
    image = np.full((960, 1280, 3), 90, np.uint8)
    shift = -4.0 * 300.0 * 0.004 * keyframe / 2.0
    (ahead, _), _ = cv2.getTextSize(before, cv2.FONT_HERSHEY_SIMPLEX, 3.0, 8)
    at = round(480 + shift) - ahead, 510
    cv2.putText(image, f"{before}HELLO", at, cv2.FONT_HERSHEY_SIMPLEX, 3.0, (230, 230, 230), 8)
    small = np.asarray(cv2.resize(image, (320, 240), interpolation=cv2.INTER_AREA), np.float64)
    noisy = small + np.random.default_rng(keyframe).normal(0.0, noise, small.shape)
    return np.asarray(np.clip(noisy, 0, 255), np.uint8)


def crop(keyframe: int, rgb: NDArray[np.uint8] | None = None, height: float = 20.0) -> Crop:
    box = np.array([[112.0, 108.0], [208.0, 108.0], [208.0, 132.0], [112.0, 132.0]])
    left, top, pixels = cut_out(view(keyframe) if rgb is None else rgb, box, 20.0)
    return Crop(float(keyframe), keyframe, np.eye(4), left, top, pixels, SeenSize(height, 1.0))


def text_map(readings: list[str], before: str = "") -> TextMap:
    """A map in which one text was read in so many ways, each time from the next keyframe."""
    made = TextMap(TextConfig())
    for row, text in enumerate(readings):
        made.memory.forget(float(row))
        text_class = made.memory.sight(text, 0.7, float(row))
        seen = TextObservation(row, float(row), row, text, 0.7, PLACEMENT, 20.0, right=0.2)
        text_class.observations.append(seen)
        made.crops.keep(text_class.id, crop(row, view(row, before=before)), made.is_unsure)
    return made


class Reader:
    """Reads one text in every box, and finds none by itself."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.pictures: list[NDArray[np.uint8]] = []

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        self.pictures.append(rgb)
        return np.zeros((0, 4, 2)), np.zeros(0)

    def recognise(self, rgb: NDArray[np.uint8], boxes: NDArray[np.float64]) -> list[Recognition]:
        return [Recognition(self.text, 0.99, (), 0.3)] * len(boxes)


def by_readings(text_class: TextClass) -> None:
    """Named without a model."""
    name_class(text_class, None, TextConfig())


def test_the_mean_of_many_views_has_less_noise_than_the_best_of_them() -> None:
    made = text_map(["HELLO"] * 9)
    (place,) = places_of_class(made.long_term[0], poses, made.config.instances, made.config.memory)
    crops = made.crops.by_class[0]
    one = canvas_of(place, crops[:1], poses, CAMERA, made.config.again)
    many = canvas_of(place, crops, poses, CAMERA, made.config.again)
    clean = canvas_of(place, [crop(0, view(0, noise=0.0))], poses, CAMERA, made.config.again)
    assert one is not None
    assert many is not None
    assert clean is not None
    assert many.views >= 7
    inside = np.s_[30:60, 40:-40]

    def error(canvas: Any) -> float:
        return float(np.std(canvas.rgb[inside].astype(float) - clean.rgb[inside]))

    assert error(many) < 0.6 * error(one)


def test_what_a_second_look_reads_becomes_the_name() -> None:
    made = text_map(["HELLD", "HFLLO", "NELLO", "HELLU", "HELIO"])
    looked = look_again(made, poses, CAMERA, Reader("HELLO"), by_readings)
    assert (looked.texts, looked.readings) == (1, 1)
    assert made.long_term[0].name == "HELLO"
    assert len(made.crops) == 0


@pytest.mark.parametrize("read", ["3HELLO", "HELLO M", "3 HELLO M"])
def test_what_no_reading_had_before_or_behind_a_text_is_its_neighbours(read: str) -> None:
    made = text_map(["HELLO", "HELLO", "HELLO", "HELLO", "HELL0"])
    look_again(made, poses, CAMERA, Reader(read), by_readings)
    assert made.long_term[0].name == "HELLO"
    assert read not in made.long_term[0].variants


def test_an_end_that_readings_had_in_part_is_the_text_s_own() -> None:
    made = text_map(["HELLO", "HELLO", "HELLO", "HELLO 2", "HELLO Z"])
    look_again(made, poses, CAMERA, Reader("HELLO 21"), by_readings)
    assert "HELLO 21" in made.long_term[0].variants


def test_a_reading_unlike_all_others_joins_nothing() -> None:
    made = text_map(["HELLD", "HFLLO", "NELLO", "HELLU", "HELIO"])
    before = dict(made.long_term[0].variants)
    assert look_again(made, poses, CAMERA, Reader("QUARTZ"), by_readings).readings == 0
    assert made.long_term[0].variants == before


def test_a_piece_of_what_was_read_says_nothing_of_the_ends() -> None:
    made = text_map(["HELLO", "HFLLO", "HELLO", "HELLO", "HELLD"])
    looked = look_again(made, poses, CAMERA, Reader("HELL"), by_readings)
    assert (looked.texts, looked.readings) == (1, 0)
    assert made.long_term[0].name == "HELLO"


class FindsOne(Reader):
    """Finds one box, from so many pixels of the drawing's left on, and reads nothing in the known one."""

    def __init__(self, text: str, left: float) -> None:
        super().__init__(text)
        self.left = left

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        height, width = rgb.shape[:2]
        right, top, bottom = width - 0.2 * width, 0.36 * height, 0.64 * height
        box = np.array([[self.left, top], [right, top], [right, bottom], [self.left, bottom]])
        return box[None], np.ones(1)

    def recognise(self, rgb: NDArray[np.uint8], boxes: NDArray[np.float64]) -> list[Recognition]:
        return [Recognition("", 0.0), *super().recognise(rgb, boxes[1:])]


@pytest.mark.parametrize(("before", "left", "counts"), [("WWWW", 0.0, False), ("", 40.0, True)])
def test_what_the_border_of_the_drawing_cuts_off_is_no_reading(before: str, left: float, counts: bool) -> None:
    made = text_map(["HELLO", "MY HELLO", "HELLO", "HFLLO", "HELLD"], before)
    look_again(made, poses, CAMERA, FindsOne("Y HELLO", left), by_readings)
    assert ("Y HELLO" in made.long_term[0].variants) == counts


def test_no_more_is_searched_than_allowed_and_the_rest_keeps_its_crops() -> None:
    made = text_map(["HELLD", "HFLLO", "NELLO", "HELLU", "HELIO"])
    reader = Reader("HELLO")
    assert look_again(made, poses, CAMERA, reader, by_readings, pixels=10.0).pixels == 0
    assert not reader.pictures
    assert len(made.crops) == 5


def test_a_text_of_a_sub_map_without_a_place_is_left_alone() -> None:
    made = text_map(["HELLD", "HFLLO", "NELLO", "HELLU", "HELIO"])
    assert look_again(made, lambda keyframe: None, CAMERA, Reader("HELLO"), by_readings).texts == 0


def test_crops_come_back_as_they_were_kept() -> None:
    store = text_map(["HELLD", "HFLLO"]).crops
    again = CropStore.from_arrays(store.to_arrays(), store.config)
    assert again.by_class.keys() == store.by_class.keys()
    for kept, back in zip(store.by_class[0], again.by_class[0], strict=True):
        np.testing.assert_array_equal(kept.rgb, back.rgb)
        np.testing.assert_array_equal(kept.keyframe_from_camera, back.keyframe_from_camera)
        assert (kept.timestamp, kept.keyframe, kept.left, kept.top, kept.seen) == (
            *(back.timestamp, back.keyframe, back.left, back.top),
            back.seen,
        )
    assert len(CropStore.from_arrays(CropStore(store.config).to_arrays(), store.config)) == 0


@pytest.mark.parametrize(("column", "value"), [(5, 0.0), (6, 1e9), (6, np.nan), (5, 3.0)])
def test_crops_that_lie_about_their_size_are_refused(column: int, value: float) -> None:
    arrays = text_map(["HELLD", "HFLLO"]).crops.to_arrays()
    arrays["rows"][0, column] = value  # type: ignore[index]
    with pytest.raises(ValueError, match="crops"):
        CropStore.from_arrays(arrays, SecondLookConfig())


def test_few_crops_of_a_class_are_kept_and_those_seen_largest() -> None:
    store = CropStore(SecondLookConfig(crops=2))
    for row, height in enumerate([10.0, 30.0, 20.0, 12.0]):
        store.keep(0, crop(row, height=height), lambda key: True)
    assert sorted(each.seen.height for each in store.by_class[0]) == [20.0, 30.0]


def test_room_is_made_by_what_nobody_wants() -> None:
    size = crop(0).rgb.nbytes
    store = CropStore(SecondLookConfig(all_bytes=3 * size))
    for key in range(3):
        store.keep(key, crop(key), lambda key: True)
    store.keep(3, crop(3), lambda key: key != 1)
    assert sorted(store.by_class) == [0, 2, 3]


def test_crops_travel_with_the_map(tmp_path: Path) -> None:
    from lpslam.mapfile.language_map import LanguageMap
    from lpslam.slam.features import Features
    from lpslam.slam.map import SlamMap
    from lpslam.slam.trajectory import Trajectory

    made = text_map(["HELLD", "HFLLO"])
    slam_map, nothing = SlamMap(1, np.ones(1)), np.zeros(1, np.float32)
    seen = Features(
        pixels=np.zeros((1, 2), np.float32),
        u_right=nothing,
        depth=nothing,
        has_depth=np.zeros(1, np.bool_),
        octave=np.zeros(1, np.uint8),
        angle=nothing,
        descriptor=np.zeros((1, 4), np.uint64),
    )
    for number in range(2):
        slam_map.add_keyframe(np.eye(4), seen, nothing, float(number), number, number - 1)
    LanguageMap(CAMERA, slam_map, Trajectory(), made).save(tmp_path / "a.lpmap")
    assert len(LanguageMap.load(tmp_path / "a.lpmap").text.crops) == 2
