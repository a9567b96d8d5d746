"""Text from the world made fit to be drawn: it is untrusted, and no font has every character."""

import unicodedata
from collections.abc import Container

_REPLACEMENT = "?"


def printable(text: str, longest: int = 40) -> str:
    """Strip control, format (bidirectional, zero-width) and surrogate characters; join spaces; cut what is too long.

    Args:
        text: as read.
        longest: characters kept at most, the ellipsis included.
    """
    kept = (
        char if unicodedata.category(char)[0] != "C" else " " for char in text if unicodedata.category(char) != "Cf"
    )
    line = " ".join("".join(kept).split())
    return line if len(line) <= longest else f"{line[: longest - 3]}..."


def with_known_glyphs(text: str, known: Container[int]) -> str:
    """Replace every character whose code point the font lacks."""
    return "".join(char if ord(char) in known else _REPLACEMENT for char in text)
