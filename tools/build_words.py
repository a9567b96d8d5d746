"""Build the list of common words by which the embedded model spells: `words.txt.xz`, one word a line.

    pip install wordfreq==3.1.1
    python tools/build_words.py

Source: wordfreq (Robyn Speer), whose data are under CC BY-SA 4.0; the list is under the same licence, beside it.
"""

import lzma
import unicodedata
from pathlib import Path

from wordfreq import top_n_list

DATA = Path(__file__).parents[1] / "src" / "lpslam" / "language" / "data"
COMMONEST = {"en": 20_000, "es": 6_000, "de": 6_000, "fr": 6_000}
SHORTEST = 4  # letters; shorter words are near to too much else


def bare(word: str) -> str:
    """A word without case and accents, as readings are compared."""
    letters = unicodedata.normalize("NFKD", word.casefold())
    return "".join(letter for letter in letters if not unicodedata.combining(letter))


def main() -> None:
    """Write the list."""
    words = {bare(word) for language, count in COMMONEST.items() for word in top_n_list(language, count)}
    kept = sorted(word for word in words if len(word) >= SHORTEST and word.isascii() and word.isalpha())
    path = DATA / "words.txt.xz"
    path.write_bytes(lzma.compress("\n".join(kept).encode(), preset=9 | lzma.PRESET_EXTREME))
    print(f"{path}: {len(kept)} words, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
