"""Boxes that hold several columns or lines, drawn and read."""

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lpslam.assets import font_path
from lpslam.config import SpottingConfig
from lpslam.text.reading.blocks import around, parts_of, read_in_parts, stacks_of
from lpslam.text.reading.spotting import PaddleSpotter, accepted_texts

CONFIG = SpottingConfig()
Rgb = NDArray[np.uint8]


def block(
    words: list[str], size: int, gap: float, lead: float, down: bool, font: str
) -> tuple[Rgb, NDArray[np.float64]]:
    """Words in columns from the right, or in lines, on a red board; and the box around all of them."""
    face = ImageFont.truetype(str(font_path(font)), size)
    board = Image.new("RGB", (640, 480), (150, 30, 28))
    draw = ImageDraw.Draw(board)
    left, top = 120, 60
    pitch, step = size * (1 + gap), size * (1 + lead)
    if down:
        wide, tall = pitch * (len(words) - 1) + size, step * max(map(len, words))
        for column, word in enumerate(words):
            for row, letter in enumerate(word):
                draw.text(
                    (left + wide - size - column * pitch, top + row * step), letter, font=face, fill=(250, 236, 200)
                )
    else:
        wide, tall = max(draw.textlength(word, font=face) for word in words), pitch * len(words)
        for row, word in enumerate(words):
            draw.text((left, top + row * pitch), word, font=face, fill=(250, 236, 200))
    margin = 0.2 * size
    x0, y0, x1, y1 = left - margin, top - margin / 2, left + wide + margin, top + tall + margin
    return np.asarray(board), np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


@pytest.fixture(scope="module")
def spotter() -> PaddleSpotter:
    return PaddleSpotter(CONFIG)


@pytest.mark.parametrize(
    ("words", "size", "gap"),
    [
        (["咖啡豆", "牛肉面"], 44, 0.3),
        (["酒楼茶", "牛肉面", "鲜花店"], 40, 0.35),
        (["珍珠奶茶", "柠檬红茶"], 36, 0.25),
    ],
)
@pytest.mark.parametrize("font", ["chinese-kai-bold", "chinese-hei-bold"])
def test_columns_in_one_box_are_read_one_by_one_from_the_right(
    words: list[str], size: int, gap: float, font: str, spotter: PaddleSpotter
) -> None:
    image, box = block(words, size, gap, 0.05, True, font)
    whole = accepted_texts(box[None], spotter.recognise(image, box[None]), CONFIG)[0]
    assert whole is None or whole.text not in words
    read = read_in_parts(image, box, None, spotter, CONFIG)
    assert [each.text for each in read] == words
    middles = [each.box[:, 0].mean() for each in read]
    assert middles == sorted(middles, reverse=True)


def test_lines_in_one_box_are_read_from_the_top(spotter: PaddleSpotter) -> None:
    image, box = block(["FRESH BREAD", "GOOD COFFEE"], 40, 0.35, 0.0, False, "latin-sans-bold")
    assert [each.text for each in read_in_parts(image, box, None, spotter, CONFIG)] == ["FRESH BREAD", "GOOD COFFEE"]


def test_columns_that_are_found_as_lines_are_read_as_columns(spotter: PaddleSpotter) -> None:
    words = ["咖啡豆", "牛肉面", "鲜花店"]
    image, box = block(words, 40, 0.35, 0.05, True, "chinese-hei-bold")
    across = [np.add(box, [[0, y0], [0, y0], [0, y1], [0, y1]]) for y0, y1 in ((0, -84), (42, -42), (84, 0))]
    read = accepted_texts(np.array(across), spotter.recognise(image, np.array(across)), CONFIG)
    lines = [each for each in read if each is not None]
    assert [each.text for each in lines] == ["鲜牛咖", "花肉啡", "店面豆"]
    (stack,) = stacks_of(lines[::-1])
    assert stack == [2, 1, 0]
    assert [each.text for each in read_in_parts(image, around(lines), None, spotter, CONFIG)] == words


def test_lines_of_a_text_are_no_columns(spotter: PaddleSpotter) -> None:
    image, box = block(["牛肉面", "咖啡豆"], 40, 0.3, 0.0, False, "chinese-hei-bold")
    across = np.array([np.add(box, [[0, y0], [0, y0], [0, y1], [0, y1]]) for y0, y1 in ((0, -52), (52, 0))])
    lines = [each for each in accepted_texts(across, spotter.recognise(image, across), CONFIG) if each is not None]
    assert [each.text for each in lines] == ["牛肉面", "咖啡豆"]
    assert stacks_of(lines) == []


def test_a_line_that_reads_well_is_left_whole(spotter: PaddleSpotter) -> None:
    image, box = block(["茶行"], 60, 0.3, 0.0, False, "chinese-hei-bold")
    whole = accepted_texts(box[None], spotter.recognise(image, box[None]), CONFIG)[0]
    assert whole is not None
    assert whole.text == "茶行"
    assert read_in_parts(image, box, whole, spotter, CONFIG) == []


def test_latin_letters_are_no_columns(spotter: PaddleSpotter) -> None:
    image, box = block(["IHI"], 90, 0.3, 0.0, False, "latin-sans-bold")
    assert read_in_parts(image, box, None, spotter, CONFIG) == []


def test_plain_ground_has_no_parts() -> None:
    box = np.array([[10.0, 10.0], [90.0, 10.0], [90.0, 70.0], [10.0, 70.0]])
    assert parts_of(np.full((100, 120, 3), 90, np.uint8), box) == []
