"""Texts of the same brightness as their ground, drawn and read."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lpslam.assets import font_path
from lpslam.config import SpottingConfig
from lpslam.text.reading.colours import in_their_colours, read_in_colours
from lpslam.text.reading.spotting import PaddleSpotter, accepted_texts

CONFIG = SpottingConfig()
BRIGHTNESS = np.array([0.299, 0.587, 0.114])
RED = np.array([170.0, 24.0, 30.0])


def painted(text: str, ink: NDArray[np.float64], seed: int) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """A red board with a text on it, as a camera with a codec sees it; and the text's box."""
    board = Image.new("RGB", (320, 120), tuple(int(value) for value in RED))
    face = ImageFont.truetype(str(font_path("chinese-brush" if not text.isascii() else "latin-serif")), 22)
    draw = ImageDraw.Draw(board)
    draw.text((60, 40), text, font=face, fill=tuple(int(value) for value in ink))
    x0, y0, x1, y1 = draw.textbbox((60, 40), text, font=face)
    seen = cv2.GaussianBlur(np.asarray(board), (0, 0), 0.8) + np.random.default_rng(seed).normal(0, 8, (120, 320, 3))
    _, packed = cv2.imencode(".jpg", np.clip(seen, 0, 255).astype(np.uint8)[..., ::-1])
    decoded = np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR)[..., ::-1], np.uint8)
    return decoded, np.array([[x0 - 5.0, y0 - 5], [x1 + 5, y0 - 5], [x1 + 5, y1 + 5], [x0 - 5, y1 + 5]])


GOLD = np.array([200.0, 150.0, 50.0]) * (RED @ BRIGHTNESS) / (np.array([200.0, 150.0, 50.0]) @ BRIGHTNESS)


@pytest.fixture(scope="module")
def spotter() -> PaddleSpotter:
    return PaddleSpotter(CONFIG)


def test_ink_of_the_grounds_brightness_is_read_by_its_colour(spotter: PaddleSpotter) -> None:
    by_colour = plainly = 0
    for seed, text in enumerate(["烘焙茶行", "照相馆", "珠宝行", "PHARMACY", "茶餐厅"] * 3):
        image, box = painted(text, GOLD, seed)
        (plain,) = accepted_texts(box[None], spotter.recognise(image, box[None]), CONFIG)
        read = read_in_colours(image, box, plain, spotter, CONFIG)
        plainly += plain is not None and plain.text == text
        by_colour += read is not None and read.text == text
        if read is not None and plain is not read:
            assert np.abs(read.box.mean(axis=0) - box.mean(axis=0)).max() < 20
    assert by_colour >= plainly + 4
    assert by_colour >= 8


def test_what_differs_in_brightness_is_not_looked_at_by_colour() -> None:
    image, box = painted("茶餐厅", np.array([250.0, 240.0, 210.0]), 0)
    assert in_their_colours(image, box) is None


def test_plain_ground_has_no_ink() -> None:
    box = np.array([[20.0, 20.0], [90.0, 20.0], [90.0, 60.0], [20.0, 60.0]])
    assert in_their_colours(np.full((80, 120, 3), 90, np.uint8), box) is None
