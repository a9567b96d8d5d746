"""Build the table of how characters are read in Japanese, one a line: `wishes/readings_ja.txt`.

    apt-get download unicode-data && dpkg-deb -x unicode-data_*.deb FOLDER
    python tools/build_readings.py FOLDER/usr/share/unicode

Source: Unihan of the Unicode Character Database (Unicode-3.0): readings of the characters of everyday use and of names.
"""

import bz2
import re
import sys
from collections.abc import Iterator
from pathlib import Path

TABLE = Path(__file__).parents[1] / "src" / "lpslam" / "language" / "data" / "wishes" / "readings_ja.txt"
IN_USE = ("kJoyoKanji", "kJinmeiyoKanji")
READ = ("kJapaneseOn", "kJapaneseKun")
STEMS = ((r"(?<=[AEOU])I", ""), (r"(?<=[EI])RU", ""), ("TSU", "CHI"), ("SU", "SHI"), ("(?<=[KGNBMRAO])U", "I"))
"""How the reading of an adjective or verb ends, and how it does within a name: hiroi, hiro; miru, mi; matsu, machi."""

JOINED = re.compile("^(.+)TSU$")
"""What stays of a reading of Chinese origin before the next: getsu, gekkou."""


def rows(path: Path) -> Iterator[tuple[str, str, str]]:
    """The character, property and value of each row of a file of Unihan."""
    for line in bz2.decompress(path.read_bytes()).decode().splitlines():
        if line.startswith("U+"):
            code, name, value = line.split("\t")
            yield chr(int(code[2:], 16)), name, value


def forms(reading: str) -> tuple[str, ...]:
    """A reading in Japanese, and as it is within a name."""
    stems = (
        re.sub(f"{end}$", stem, reading) for end, stem in STEMS if len(reading) > 3 and re.search(f"{end}$", reading)
    )
    return (reading, next(stems, reading))


def main() -> None:
    """Write the table."""
    folder = Path(sys.argv[1])
    in_use = {letter for letter, name, _ in rows(folder / "Unihan_OtherMappings.txt.bz2") if name in IN_USE}
    read: dict[str, dict[str, None]] = {}
    for letter, name, value in rows(folder / "Unihan_Readings.txt.bz2"):
        if letter in in_use and name in READ:
            read.setdefault(letter, {}).update(
                (form.lower(), None)
                for each in value.split()
                for form in (forms(each) if name == "kJapaneseKun" else (each, *JOINED.findall(each)))
                if form.isascii()
            )
    TABLE.write_text("".join(f"{letter} {' '.join(said)}\n" for letter, said in sorted(read.items())), encoding="utf-8")


if __name__ == "__main__":
    main()
