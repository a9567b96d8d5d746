"""Build the lists of common words by which the embedded model spells, one a line.

They are `words.txt.xz`, `words_short.txt.xz` and `words_zh.txt.xz`.

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
SHORT, SHORT_COMMON = range(2, SHORTEST), 10.0**-3.7  # commoner shorter words, which tell where a space is one
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
    write("words_short.txt.xz", short())
    write("words_zh.txt.xz", chinese())


def short() -> list[str]:
    """The commonest of the words that are too short to be spelt by."""
    counted = [(bare(word), share) for each in COMMONEST for word, share in get_frequency_dict(each, "large").items()]
    common = {word for word, share in counted if share >= SHORT_COMMON}
    return sorted(word for word in common if len(word) in SHORT and word.isascii() and word.isalpha())


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
