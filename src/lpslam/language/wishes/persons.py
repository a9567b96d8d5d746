"""People whose names are asked for in another script than their boards are painted in: 田辺 and Yuki Tanabe."""

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache

from anyascii import anyascii
from rapidfuzz import fuzz

from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.words import is_unspaced

_SOUNDS = str.maketrans("vbplgckqzjxd", "fffrkkkksss" + "t", "aeiouhwy")
_SKELETON = 3  # consonants of a name that is compared by them
_LONGEST = 3  # characters of a surname
_LETTERS, _SURE = 0.5, 1.0  # alike among all letters: of a name of many consonants, and of one of few


@lru_cache(maxsize=1 << 14)
def consonants(latin: str) -> str:
    """The consonants of a name, those that scripts do not tell apart as one, doubled ones once."""
    kept = latin.translate(_SOUNDS)
    return "".join(ch for at, ch in enumerate(kept) if not at or kept[at - 1] != ch)


@lru_cache(maxsize=1)
def _surnames() -> Mapping[str, tuple[str, ...]]:
    """How surnames of Chinese characters and Hangul are written in Latin letters, where it is not as they are read."""
    tree: Mapping[str, Mapping[str, str]] = read_table("wishes/surnames.json")
    found: dict[str, tuple[str, ...]] = {}
    for names in tree.values():
        for name, joined in names.items():
            found[name] = (*found.get(name, ()), *joined.split("|"))
    return found


def _letters(text: str) -> list[str]:
    latin = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", anyascii(text)).casefold()
    return [word for word in re.split(r"[^a-z]+", latin) if word]


@lru_cache(maxsize=64)
def spellings(name: str) -> list[tuple[str, ...]]:
    """Return how a person's name may be written in Latin letters, word by word, the surname first."""
    bare = re.sub(r"[\s・·]+", "", name)
    found = [tuple(_letters(name))]
    for size in range(min(_LONGEST, len(bare)), 0, -1):
        found += [(surname, *_letters(bare[size:])) for surname in _surnames().get(bare[:size], ())]
    return [words for words in found if words]


@lru_cache(maxsize=64)
def _written(name: str) -> tuple[str, ...]:
    """How the surname of a name in Latin letters, its last word or else its first, is written in other scripts."""
    named = [word for word in _letters(name) if len(word) > 1]
    of = {word: tuple(surname for surname, forms in _surnames().items() if word in forms) for word in named}
    return of[named[-1]] or of[named[0]] if named else ()


def called(asked: str, words: Sequence[str], runs: Sequence[str]) -> float:
    """Return how surely a board bears a person's name in another script, 0 to 1, by its Latin words or other runs."""
    if not is_unspaced(asked):
        return float(any(run.startswith(_written(asked)) for run in runs))
    return max((_spelled(spelled, words) for spelled in spellings(asked)), default=0.0)


def _spelled(spelled: Sequence[str], words: Sequence[str]) -> float:
    """How surely words hold a name: its surname as it is written, or all its consonants in a row."""
    starts = range(len(words))
    if spelled[0] in words and (len(spelled) == 1 or any(_alike(spelled[1:], words, at) for at in starts)):
        return 1.0
    return max((_alike(spelled, words, at) for at in starts), default=0.0)


def _alike(spelled: Sequence[str], words: Sequence[str], start: int) -> float:
    whole = "".join(spelled)
    sought, said = consonants(whole), ""
    for at in range(start, len(words)):
        said = consonants(said + consonants(words[at]))
        if said == sought:
            letters = fuzz.ratio(whole, "".join(words[start : at + 1])) / 100.0
            return letters if letters >= (_LETTERS if len(sought) >= _SKELETON else _SURE) else 0.0
        if len(said) >= len(sought):
            return 0.0
    return 0.0
