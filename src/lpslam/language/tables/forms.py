"""Traditional and simplified forms of Chinese characters."""

from functools import lru_cache

from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.words import Folder


@lru_cache(maxsize=1)
def load_folder() -> Folder:
    """Read the tables of characters (once a process)."""
    han = read_table("lexicon/han.json")
    return Folder(han["traditional"], han["simplified"], han["lookalikes"], han["both"])


def is_traditional_only(letter: str) -> bool:
    """Whether a character is written so in traditional texts and otherwise in simplified ones."""
    return load_folder().is_traditional(letter)


def is_simplified_only(letter: str) -> bool:
    """Whether a character is written so in simplified texts and otherwise in traditional ones."""
    return load_folder().traditional(letter) != letter


def are_forms(simplified: str, traditional: str) -> bool:
    """Whether two characters are one, simplified and traditional."""
    return simplified != traditional and load_folder().fold(traditional) == simplified
