"""Find the letters that look alike from afar: rendered small and blurred, in the fonts of the package.

    python tools/build_lookalikes.py

Every character that the names of the gazetteer are written with (and that the fonts have) is drawn in each font, shrunk
to the size at which signs are misread, and compared with every other. Pairs that agree in the mean over the fonts are
written to `language/data/lookalikes.txt`, the likest first.
"""

from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from fontTools.ttLib import TTFont
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lpslam.language.tables.knowledge import load_knowledge

ROOT = Path(__file__).parents[1] / "src" / "lpslam"
FONTS = ROOT / "assets" / "fonts"
OUT = ROOT / "language" / "data" / "lookalikes.txt"
DRAWN, SMALL = 48, 16  # pixels, of a character's cell: as drawn, and as misread
CHINESE, LATIN = ("map.ttf", 0.72), ("latin-*", 0.72)  # fonts, and the least correlation of a pair
NEIGHBOURS = 4  # a letter is taken for one of its likest ones only


def glyph(letter: str, font: ImageFont.FreeTypeFont) -> NDArray[np.float32]:
    """A letter in the middle of a small blurred cell, of zero mean and unit length; (SMALL * SMALL,)."""
    cell = Image.new("L", (DRAWN + 16, DRAWN + 16))
    left, _, right, _ = font.getbbox(letter)
    ImageDraw.Draw(cell).text(((DRAWN + 16 - left - right) / 2, 4), letter, 255, font=font)
    blurred = cv2.GaussianBlur(np.asarray(cell, np.float32), (0, 0), 0.5 * DRAWN / SMALL)
    small = cv2.resize(blurred, (SMALL, SMALL), interpolation=cv2.INTER_AREA).ravel()
    small -= small.mean()
    length = float(np.linalg.norm(small))
    return small / length if length > 0 else small


def pairs(letters: list[str], pattern: str, least: float) -> list[tuple[float, str]]:
    """Pairs that correlate, over the fonts that have both letters."""
    total = np.zeros((len(letters), len(letters)), np.float32)
    counts = np.zeros_like(total)
    for path in sorted(FONTS.glob(pattern)):
        known = set(TTFont(path).getBestCmap())
        font = ImageFont.truetype(str(path), DRAWN)
        at = np.array([index for index, letter in enumerate(letters) if ord(letter) in known])
        drawn = np.stack([glyph(letters[index], font) for index in at])
        total[np.ix_(at, at)] += drawn @ drawn.T
        counts[np.ix_(at, at)] += 1
    mean = total / np.maximum(counts, 1)
    np.fill_diagonal(mean, 0.0)
    rank = np.argsort(np.argsort(-mean, axis=1), axis=1)
    mean = np.triu(np.where((rank < NEIGHBOURS) & (rank.T < NEIGHBOURS), mean, 0.0))
    return [
        (float(mean[one, other]), letters[one] + letters[other])
        for one, other in zip(*np.nonzero(mean >= least), strict=True)
    ]


def main() -> None:
    """Write the table and print some of it."""
    used = sorted({letter for key in load_knowledge().known for letter in key})
    han = [letter for letter in used if "\u4e00" <= letter <= "\u9fff"]
    # Upper and lower case look different, and keys have none: either may be what was painted.
    latin = [*"abcdefghijklmnopqrstuvwxyz", *"ABCDEFGHIJKLMNOPQRSTUVWXYZ", *"0123456789"]
    found: dict[str, float] = {}
    for letters, (pattern, least) in ((han, CHINESE), (latin, LATIN)):
        for likeness, pair in pairs(letters, pattern, least):
            pair = "".join(sorted(pair.casefold()))
            if pair[0] != pair[1]:
                found[pair] = max(likeness, found.get(pair, 0.0))
    ranked = sorted(found, key=lambda pair: (-found[pair], pair))
    lines = [" ".join(ranked[start : start + 40]) for start in range(0, len(ranked), 40)]
    OUT.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(len(ranked), "pairs;", *ranked[:60])
    assert all(found[one] >= found[other] for one, other in pairwise(ranked))


if __name__ == "__main__":
    main()
