"""Build the lists of common words by which the embedded model spells: `words.txt.xz`, `words_zh.txt.xz`, one a line.

    pip install wordfreq==3.1.1 opencc-python-reimplemented==0.1.7
    python tools/build_words.py

Source: wordfreq (Robyn Speer), whose data are under CC BY-SA 4.0; the lists are under the same licence, beside them.
Traditional forms of Chinese words are OpenCC's (Apache 2.0).
"""

import lzma
import unicodedata
from pathlib import Path

from opencc import OpenCC
from wordfreq import get_frequency_dict, top_n_list

from lpslam.language.tables.knowledge import load_knowledge
from lpslam.language.tables.spelling import is_ideograph

DATA = Path(__file__).parents[1] / "src" / "lpslam" / "language" / "data"
COMMONEST = {"en": 20_000, "es": 6_000, "de": 6_000, "fr": 6_000}
SHORTEST = 4  # letters; shorter words are near to too much else
CHINESE, CHINESE_LETTERS = 50_000, range(2, 5)  # commonest words of so many ideographs


def bare(word: str) -> str:
    """A word without case and accents, as readings are compared."""
    letters = unicodedata.normalize("NFKD", word.casefold())
    return "".join(letter for letter in letters if not unicodedata.combining(letter))


def main() -> None:
    """Write the list."""
    words = {bare(word) for language, count in COMMONEST.items() for word in top_n_list(language, count)}
    kept = sorted(word for word in words if len(word) >= SHORTEST and word.isascii() and word.isalpha())
    write("words.txt.xz", kept)
    write("words_zh.txt.xz", chinese())


def chinese() -> list[str]:
    """Chinese words as keys are written: simplified, and traditional in characters that are not simplified there."""
    counted = get_frequency_dict("zh", "large")
    words = [word for word in counted if len(word) in CHINESE_LETTERS and all(map(is_ideograph, word))]
    commonest = sorted(words, key=lambda word: (-counted[word], word))[:CHINESE]
    fold, traditional = load_knowledge().folder.key, OpenCC("s2t").convert
    return sorted({fold(form) for word in commonest for form in (word, traditional(word))})


def write(name: str, words: list[str]) -> None:
    """Write a list, one word a line."""
    path = DATA / name
    path.write_bytes(lzma.compress("\n".join(words).encode(), preset=9 | lzma.PRESET_EXTREME))
    print(f"{path}: {len(words)} words, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
