"""The carried fonts: complete, licensed, small."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageDraw, ImageFont

import lpslam.assets
from lpslam.assets import font_names, font_path
from lpslam.simulation.lettering import CHINESE_FONTS, LATIN_FONTS, is_chinese, paint_board
from lpslam.simulation.lexicon import EVERYTHING, characters

FONTS = Path(lpslam.assets.__file__).parent / "fonts"


def ink(font: ImageFont.FreeTypeFont, letter: str) -> np.ndarray:
    image = Image.new("L", (60, 60))
    ImageDraw.Draw(image).text((8, 8), letter, font=font, fill=255)
    return np.asarray(image)


@pytest.mark.parametrize("name", font_names())
def test_fonts_draw_what_signs_say(name: str) -> None:
    font = ImageFont.truetype(str(font_path(name)), 36)
    missing = ink(font, "\U0010fffd")
    wanted = [letter for letter in characters() if letter != " "]
    if name.startswith("latin"):
        wanted = [letter for letter in wanted if letter.isascii()]
    absent = [letter for letter in wanted if not ink(font, letter).any() or np.array_equal(ink(font, letter), missing)]
    assert not absent


def test_the_map_font_covers_the_languages_of_maps() -> None:
    font = ImageFont.truetype(str(font_path("map")), 36)
    missing = ink(font, "\U0010fffd")
    sample = "Aézßñ一龍臺灣龟鑫厕饕あんアンー。、（）！"
    assert not [letter for letter in sample if np.array_equal(ink(font, letter), missing)]


def test_every_font_is_used_small_and_licensed() -> None:
    used = {name for fonts in (LATIN_FONTS, CHINESE_FONTS) for style in fonts.values() for name in style}
    assert used <= set(font_names())
    sizes = [path.stat().st_size for path in FONTS.iterdir() if path.is_file()]
    assert max(sizes) <= 2 * 1024**2
    assert sum(sizes) <= 4 * 1024**2
    licences = [path.read_text(encoding="utf-8") for path in (FONTS / "licences").iterdir()]
    assert len(licences) >= 15
    assert all("OFL" in text or "Apache" in text or "Open Font" in text for text in licences)
    with pytest.raises(KeyError, match="no font"):
        font_path("comic-sans")


@pytest.mark.parametrize("index", range(0, len(EVERYTHING), 9))
def test_boards_hold_their_words(index: int) -> None:
    rng = np.random.default_rng(index)
    lines = EVERYTHING[index].lines("mixed")
    board = paint_board(rng, lines, EVERYTHING[index].kind, "shop", 0.3, 2.0, 150.0)
    assert [line.text for line in board.lines] == list(lines)
    assert board.width <= 2.0 + 1e-6
    height, width = board.image.shape[:2]
    assert (width / board.width, height / board.height) == pytest.approx((150.0, 150.0), rel=0.03)
    for line in board.lines:
        assert 0 <= line.left < line.right <= board.width + 0.02
        assert 0 <= line.top < line.bottom <= board.height + 0.02
        assert line.right - line.left > 0.5 * line.letter_height
        box = board.image[int(line.top * 150) : int(line.bottom * 150), int(line.left * 150) : int(line.right * 150)]
        assert np.ptp(box.astype(float).mean(axis=2)) > 60  # letters stand out from their ground
        assert is_chinese(line.text) == any(ord(letter) > 0x2E80 for letter in line.text)
