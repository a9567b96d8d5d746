import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lpslam.assets import font_names, font_path
from lpslam.text.reading.ornaments import are_ornaments, is_pattern, repetition

INK, GROUND = (30, 40, 60), (210, 200, 190)


def written(text: str, font: str, size: int = 40) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    wall = Image.new("RGB", (640, 480), GROUND)
    pen, letters = ImageDraw.Draw(wall), ImageFont.truetype(str(font_path(font)), size)
    left, top, right, bottom = pen.multiline_textbbox((40, 60), text, font=letters)
    pen.multiline_text((40, 60), text, font=letters, fill=INK)
    box = np.array([[left, top], [right, top], [right, bottom], [left, bottom]], float)
    return np.asarray(wall, np.uint8), box + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 0.15 * size


def band(kind: str, count: int, size: int = 36) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    image = np.full((480, 640, 3), GROUND, np.uint8)
    for number in range(count):
        x, y = 60 + number * size, 200
        if kind == "arches":
            cv2.ellipse(image, (x, y + size), (size // 2, size), 0, 180, 360, INK, 4, cv2.LINE_AA)
        elif kind == "zigzag":
            cv2.polylines(image, [np.int32([[x, y], [x + size // 2, y + size], [x + size, y]])], False, INK, 4)
        elif kind == "circles and crosses":
            cv2.circle(image, (x, y + size // 2), size // 2 - 4, INK, 4, cv2.LINE_AA)
            cv2.drawMarker(image, (x + size // 2, y + size // 2), INK, cv2.MARKER_CROSS, 10, 3)
        else:
            cv2.line(image, (x, y), (x, y + size), INK, 5)
    box = np.array([[60, 200], [60 + count * size, 200], [60 + count * size, 200 + size], [60, 200 + size]], float)
    return image, box + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (24.0, 6.0)


@pytest.mark.parametrize("kind", ["arches", "zigzag", "circles and crosses", "railing"])
@pytest.mark.parametrize("count", [6, 9, 14])
def test_a_band_of_equal_motifs_is_an_ornament(kind: str, count: int) -> None:
    image, box = band(kind, count)
    assert are_ornaments(image, box[None]).tolist() == [True]


@pytest.mark.parametrize("text", ["COFFEE", "OOO", "101", "88", "00", "WWW", "0000", "1000", "BANANA", "XOXO", "III"])
def test_texts_of_equal_letters_are_none(text: str) -> None:
    for font in font_names("latin"):
        image, box = written(text, font)
        assert are_ornaments(image, box[None]).tolist() == [False], font


def test_letters_spaced_out_evenly_and_blurred_are_none() -> None:
    for font in font_names("latin"):
        image, box = written("C O F F E E", font, 20)
        blurred = cv2.GaussianBlur(image, (0, 0), 1.2)
        assert are_ornaments(np.asarray(blurred, np.uint8), box[None]).tolist() == [False], font


@pytest.mark.parametrize("text", ["一二三", "三三", "王王", "出口", "出\n口", "洗\n手\n间"])
def test_chinese_is_none_across_or_downwards(text: str) -> None:
    for font in font_names("chinese"):
        image, box = written(text, font)
        assert are_ornaments(image, box[None]).tolist() == [False], font


def test_nothing_is_no_pattern() -> None:
    assert are_ornaments(np.zeros((48, 64, 3), np.uint8), np.zeros((0, 4, 2))).shape == (0,)
    assert repetition(np.full((16, 64), 90.0)) == (1.0, 0.0)
    assert not is_pattern(np.zeros((16, 2)))


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(5, 20), st.integers(6, 20))
def test_any_motif_repeated_is_a_pattern_and_noise_is_none(seed: int, count: int, period: int) -> None:
    random = np.random.default_rng(seed)
    motif = cv2.GaussianBlur(random.uniform(0, 255, (16, period)), (0, 0), 1.0)
    motif[:, 0] = 0.0
    strip = np.tile(motif, count)
    periods, correlation = repetition(strip)
    assert periods == pytest.approx(count, abs=1.0)
    assert correlation > 0.95
    assert not is_pattern(cv2.GaussianBlur(random.uniform(0, 255, (16, period * count)), (0, 0), 1.0))
