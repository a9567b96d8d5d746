"""Round logos beside a name are no letters; round letters are."""

from importlib.resources import files

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lpslam.text.reading.emblems import without_emblems

LATIN = sorted(each.name for each in (files("lpslam") / "assets" / "fonts").iterdir() if each.name.startswith("latin"))
FONTS = [each for each in LATIN if "script" not in each]
SCRIPTS = [each for each in LATIN if "script" in each]


def line_of(text: str, font: str, emblem: str = "", *, bright: bool = True, blur: float = 0.0) -> NDArray[np.uint8]:
    """A line of 48 pixels with a word, and an emblem before it, 1.2 times as high as the capitals."""
    typeface = ImageFont.truetype(str(files("lpslam") / "assets" / "fonts" / font), 120)
    left, top, right, bottom = typeface.getbbox(text)
    logo = round(1.2 * (bottom - top)) if emblem else 0
    height = round(1.35 * (bottom - top))
    picture = Image.new("L", (round(right - left + 1.4 * logo + 40), height), 30 if bright else 220)
    ink, ground = (230, 30) if bright else (20, 220)
    draw = ImageDraw.Draw(picture)
    draw.text((round(1.3 * logo) + 20 - left, (height - bottom + top) // 2 - top), text, font=typeface, fill=ink)
    x, y, r = 15 + logo / 2, height / 2, logo / 2
    if emblem == "square with a hole":
        draw.rectangle((x - r, y - r, x + r, y + r), fill=ink)
        draw.ellipse((x - 0.7 * r, y - 0.7 * r, x + 0.7 * r, y + 0.7 * r), fill=ground)
    elif emblem:
        draw.ellipse((x - r, y - r, x + r, y + r), fill=ink)
    if emblem == "disc with a peak":
        draw.polygon(
            [(x - 0.75 * r, y + 0.45 * r), (x - 0.1 * r, y - 0.6 * r), (x + 0.75 * r, y + 0.45 * r)], fill=ground
        )
    grey = np.asarray(picture.resize((round(picture.width * 48 / height), 48), Image.Resampling.LANCZOS))
    if blur:
        grey = cv2.GaussianBlur(grey, (0, 0), blur)
    return np.repeat(np.asarray(grey, np.uint8)[:, :, None], 3, axis=2)


@pytest.mark.parametrize("bright", [True, False])
@pytest.mark.parametrize("font", FONTS)
@pytest.mark.parametrize("text", ["OLIVE", "OGAO", "Q-PARK", "Ocean", "BIG O", "H2O", "Zoo", "OOO", "OXO", "0800"])
def test_round_letters_stay(text: str, font: str, bright: bool) -> None:
    assert without_emblems(line_of(text, font, bright=bright), text) == text
    assert without_emblems(line_of(text, font, bright=bright, blur=1.5), text) == text


@pytest.mark.parametrize("text", ["Orla's Candles", "Oak & Iron", "Oslo", "Old Mill"])
def test_a_capital_with_a_flourish_before_small_letters_stays(text: str) -> None:
    """It is taller than most of what follows, and its hole has another shape than its outline."""
    for font in SCRIPTS:
        assert without_emblems(line_of(text, font), text) == text
        assert without_emblems(line_of(text, font, blur=1.0), text) == text


@pytest.mark.parametrize("emblem", ["disc", "disc with a peak", "square with a hole"])
@pytest.mark.parametrize("font", ["latin-sans-bold.ttf", "latin-serif-bold.ttf", "latin-narrow-bold.otf"])
@pytest.mark.parametrize("bright", [True, False])
def test_a_logo_before_a_name_goes(emblem: str, font: str, bright: bool) -> None:
    assert without_emblems(line_of("GAP", font, emblem, bright=bright), "OGAP") == "GAP"
    assert without_emblems(line_of("GAP", font, emblem, bright=bright, blur=1.0), "OGAP") == "GAP"


def test_what_begins_with_another_letter_is_not_looked_at() -> None:
    assert without_emblems(line_of("GAP", "latin-sans-bold.ttf", "disc"), "GAP") == "GAP"


@pytest.mark.parametrize("shape", [(48, 8), (48, 320), (1, 1)])
def test_a_line_without_anything_is_left_alone(shape: tuple[int, int]) -> None:
    assert without_emblems(np.full((*shape, 3), 128, np.uint8), "OPEN") == "OPEN"
