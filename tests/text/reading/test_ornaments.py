import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lpslam.assets import font_names, font_path
from lpslam.text.reading.ornaments import is_pattern, pattern_likenesses, repetition
from lpslam.text.reading.patterns import Likeness

INK, GROUND = (30, 40, 60), (210, 200, 190)


def are_ornaments(rgb: NDArray[np.uint8], boxes: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.array([each is Likeness.IS for each in pattern_likenesses(rgb, boxes)], np.bool_)


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


def test_blurred_stems_at_even_distances_are_none() -> None:
    for font in font_names("latin"):
        image, box = written("GRAND STREET", font, 24)
        for blur in (1.5, 3.0):
            blurred = np.asarray(cv2.GaussianBlur(image, (0, 0), blur), np.uint8)
            assert are_ornaments(blurred, box[None]).tolist() == [False], font


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


def walked_past(picture: NDArray[np.uint8], box: NDArray[np.float64], yaw: float) -> tuple[NDArray[np.uint8], ...]:
    """A flat (480, 640, 3) wall and a box on it, seen at so many degrees."""
    cosine, sine = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
    flat = np.array([[0, 0], [640, 0], [640, 480], [0, 480]], np.float32)
    depth = 700.0 + (flat[:, 0] - 320) * sine
    seen = (flat - (320, 240)) * (cosine, 1.0) * 525.0 / depth[:, None] + (320, 240)
    warp = cv2.getPerspectiveTransform(flat, seen.astype(np.float32))
    corners = cv2.perspectiveTransform(box[None].astype(np.float64), warp)[0]
    image = cv2.warpPerspective(picture, warp, (640, 480), borderValue=GROUND)
    return np.asarray(image, np.uint8), corners


def meander(size: int = 28) -> NDArray[np.uint8]:
    image = np.full((480, 640, 3), GROUND, np.uint8)
    key = np.array([[0, 1], [0, 0], [0.8, 0], [0.8, 0.7], [0.4, 0.7], [0.4, 0.35], [0.4, 1], [1, 1]])
    for left in range(0, 640, size):
        cv2.polylines(image, [np.int32(key * size * (1.0, 0.9) + (left, 200))], False, INK, 3, cv2.LINE_AA)
    return image


@pytest.mark.parametrize("yaw", [-50.0, -25.0, 0.0, 25.0, 50.0])
def test_a_meander_is_an_ornament_in_passing_whole_and_in_pieces(yaw: float) -> None:
    for left, right in ((60, 580), (200, 300), (300, 370)):
        box = np.array([[left, 196], [right, 196], [right, 230], [left, 230]], float)
        image, seen = walked_past(meander(), box, yaw)
        assert are_ornaments(image, seen[None]).tolist() == [True], (left, right)


@pytest.mark.parametrize("text", ["AAA", "1111", "OOO", "八八八", "MOM'S", "MISSISSIPPI", "0000"])
@pytest.mark.parametrize("yaw", [-45.0, 0.0, 45.0])
def test_equal_letters_seen_aslant_are_none(text: str, yaw: float) -> None:
    for font in font_names("chinese" if "八" in text else "latin"):
        picture, box = written(text, font)
        image, seen = walked_past(picture, box, yaw)
        assert are_ornaments(image, seen[None]).tolist() == [False], font
