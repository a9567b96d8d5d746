"""What tells places of one kind from one another: the blue room, the north gate, the back door, in any language."""

import re
from collections.abc import Mapping
from functools import lru_cache

from lpslam.language.sanitise import clean_text
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.words import is_unspaced


@lru_cache(maxsize=1)
def _patterns() -> Mapping[tuple[str, str], re.Pattern[str]]:
    """Groups and what each may be, and how that is said; of a group a place has one."""
    tree: Mapping[str, Mapping[str, str]] = read_table("wishes/attributes.json")
    return {(group, value): _pattern(joined) for group, values in tree.items() for value, joined in values.items()}


def _pattern(joined: str) -> re.Pattern[str]:
    words = re.split(r"\|(?![^()]*\))", joined)
    spaced = "|".join(word for word in words if not is_unspaced(word))
    unspaced = "|".join(word for word in words if is_unspaced(word))
    # It is looked for in texts without capitals. “Haupt-” and “Süd-” begin words.
    return re.compile(rf"(?<!\w)(?:{spaced})(?!(?<=\w)[^\W_])|(?<!\w)(?:{_prefixes(words)})|{unspaced}")


def _prefixes(words: list[str]) -> str:
    return "|".join([word for word in words if word.endswith(r"(?=\w)")] or ["(?!)"])


@lru_cache(maxsize=1 << 14)
def attributes_of(text: str) -> frozenset[tuple[str, str]]:
    """Return what a board or a question says that tells a place from others of its kind: ("colour", "blue")."""
    folded = clean_text(text).casefold()
    return frozenset(value for value, pattern in _patterns().items() if pattern.search(folded))


def told_apart(asked: frozenset[tuple[str, str]], board: frozenset[tuple[str, str]]) -> int:
    """Return how much of what is asked a board says, 0 where it is silent, -1 where it says something else of it."""
    values = dict(board)
    is_another = any(group in values and (group, value) not in board for group, value in asked)
    return -1 if is_another else len(asked & board)
