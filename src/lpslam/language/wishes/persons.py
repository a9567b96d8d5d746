"""People whose names are asked for in another script than their boards are painted in: 田辺 and Yuki Tanabe."""

import json
import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib.resources import files

from anyascii import anyascii

from lpslam.language.tables.words import is_unspaced

_SOUNDS = str.maketrans("vbplgckqzjxd", "fffrkkkksss" + "t", "aeiouhwy")
_SKELETON = 3  # consonants of a name that is compared by them
_LONGEST = 3  # characters of a surname


def consonants(latin: str) -> str:
    """The consonants of a name, those that scripts do not tell apart as one, doubled ones once."""
    kept = latin.translate(_SOUNDS)
    return "".join(ch for at, ch in enumerate(kept) if not at or kept[at - 1] != ch)


@lru_cache(maxsize=1)
def _surnames() -> Mapping[str, tuple[str, ...]]:
    """How surnames of Chinese characters and Hangul are written in Latin letters, where it is not as they are read."""
    tree: Mapping[str, Mapping[str, str]] = json.loads(
        (files("lpslam.language") / "data" / "wishes" / "surnames.json").read_text(encoding="utf-8")
    )
    return {name: tuple(joined.split("|")) for names in tree.values() for name, joined in names.items()}


def _letters(text: str) -> list[str]:
    return [word for word in re.split(r"[^a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", anyascii(text)).casefold()) if word]


def spellings(name: str) -> list[tuple[str, ...]]:
    """Return how a person's name may be written in Latin letters, word by word, the surname first."""
    bare = re.sub(r"[\s・·]+", "", name)
    found = [tuple(_letters(name))]
    for size in range(min(_LONGEST, len(bare)), 0, -1):
        for surname in _surnames().get(bare[:size], ()):
            found.append((surname, *_letters(bare[size:])))
    return [words for words in found if words]


def is_called(asked: str, words: Sequence[str], runs: Sequence[str]) -> bool:
    """Whether a board's Latin words, or its runs of other scripts, are a person's name that is asked for in the other."""
    if is_unspaced(asked):
        return any(_is_spelled(spelled, words) for spelled in spellings(asked))
    named = [word for word in _letters(asked) if len(word) > 1]
    heads = (run[:size] for run in runs for size in range(1, 1 + min(_LONGEST, len(run))))
    return bool(named) and any(named[-1] in _surnames().get(head, ()) for head in heads)


def _is_spelled(spelled: Sequence[str], words: Sequence[str]) -> bool:
    """Whether words hold a name: its surname as it is written, or all its consonants in a row."""
    if spelled[0] in words and (len(spelled) == 1 or any(_alike(spelled[1:], words, at) for at in range(len(words)))):
        return True
    return any(_alike(spelled, words, at) for at in range(len(words)))


def _alike(spelled: Sequence[str], words: Sequence[str], start: int) -> bool:
    sought, said = consonants("".join(spelled)), ""
    for word in words[start:]:
        said = consonants(said + consonants(word))
        if said == sought and (len(sought) >= _SKELETON or "".join(spelled) == word):
            return True
        if len(said) >= len(sought):
            return False
    return False
