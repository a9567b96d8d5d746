"""Names of Chinese characters as they are read aloud: ほしあかり and Hoshiakari are 星あかり, 大李堂 sounds as 大礼堂.

A question spells such a name by its sound, in kana, in Latin letters, or in other characters of that sound.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import product
from pathlib import Path

from anyascii import anyascii

from lpslam.language.tables.patterns import standing

_TABLE = Path(__file__).parent.parent / "data" / "wishes" / "readings_ja.txt"
_KANA = standing("[\u3041-\u3096\u30a1-\u30fa]")
_HAN = standing("[\u4e00-\u9fff]")
_SAID_IN_KANA = standing("(?:(?<=[はがをにでとのもやへ])|(?<![\u3041-\u30ff\u4e00-\u9fff]))(?=([\u3041-\u30ff]{3,}))")
"""Kana that begin a word: not behind a character whose ending they are, 置いてきて."""
_SAID_IN_HAN = standing("[\u4e00-\u9fff々]{2,}")
_WORD = standing("[A-Za-zÀ-ÿ]+")
_MOST_READINGS = 256  # of one name: longer ones are seldom spelt by their sound
_FEWEST_LETTERS = 5  # of a name's sound
_MOST_LETTERS = 12  # of the part of a question that is a name, in its own script
_MOST_WORDS = 4  # of a name in Latin letters
_SAME = 0.5  # of a name's characters that stand in a question which writes the others by their sound
_SOUNDS = ((r"(sh|ch|j)iy(?=[aou])", r"\1"), (r"iy(?=[aou])", "y"), ("sh|j", "s"), ("ch|ts", "t"), ("ou", "o"))
_AS_ONE = str.maketrans("gzdbpfl", "ksthhhr")
"""Voiced and voiceless are one: within a word the first sound of a part changes (hi, bi)."""
Sounds = dict[str, list[tuple[int, str]]]
"""By how a name or a part of it sounds: which name, and that part as it is painted."""


def _heard(latin: str) -> str:
    """A word of Japanese in Latin letters as it sounds, long vowels short and double letters single."""
    for pattern, sound in _SOUNDS:
        latin = re.sub(pattern, sound, latin)
    return re.sub(r"(.)\1+", r"\1", latin.translate(_AS_ONE))


def _in_latin(text: str) -> str:
    return _heard(re.sub("[^a-z]", "", anyascii(re.sub("[っッ]", "", text)).casefold()))


@lru_cache(maxsize=1)
def _readings() -> Mapping[str, tuple[str, ...]]:
    lines = _TABLE.read_text(encoding="utf-8").splitlines()
    return {letter: tuple(said) for letter, *said in map(str.split, lines)}


def _spoken(run: str) -> Iterator[str]:
    """How a name of kana and Chinese characters may sound in Japanese."""
    parts = [_readings().get(each) or (said,) for each, said in zip(run, _syllables(run), strict=True)]
    is_short = math.prod(map(len, parts)) <= _MOST_READINGS
    return (_heard("".join(each)) for each in product(*parts)) if is_short else iter(())


def _syllables(run: str) -> list[str]:
    """How each character is said in Chinese, kana in Japanese."""
    return [anyascii(each).casefold() for each in run]


def sounds_of(names: Iterable[Sequence[str]]) -> Sounds:
    """Return how the runs of each name that have Chinese characters sound, in Japanese where any name has kana."""
    every = list(names)
    is_japanese = any(_KANA.search(run) for runs in every for run in runs)
    found: Sounds = {}
    for at, runs in enumerate(every):
        for run in filter(_HAN.search, runs):
            for sound in {" ".join(_syllables(run)), *(_spoken(run) if is_japanese else ())}:
                found.setdefault(sound, []).append((at, run))
    return found


def named_aloud(text: str, sounds: Sounds) -> set[int]:
    """Return the one name, else none, that a text spells by its sound; the longest where there are more."""
    if not sounds:
        return set()
    said: set[str] = set()
    for hit in _SAID_IN_KANA.finditer(text):
        run = hit.group(1)[:_MOST_LETTERS]
        said |= {_in_latin(run[:end]) for end in range(3, len(run) + 1)}
    words = _WORD.findall(text)
    said |= {_in_latin("".join(words[part])) for part in _parts(len(words), 1, _MOST_WORDS)}
    by_sound = {key: sounds[key] for key in said if len(key) >= _FEWEST_LETTERS and key in sounds}
    for hit in _SAID_IN_HAN.finditer(text):
        syllables = _syllables(hit.group())
        for part in _parts(len(syllables), 2):
            sound = " ".join(syllables[part])
            alike = [(at, run) for at, run in sounds.get(sound, ()) if _is_nearly(hit.group()[part], run)]
            by_sound |= {sound: alike} if alike else {}
    longest = max(map(len, by_sound), default=0)
    found = {at for key, names in by_sound.items() if len(key) == longest for at, _ in names}
    return found if len(found) == 1 else set()


def _parts(length: int, least: int, most: int = _MOST_LETTERS) -> Iterator[slice]:
    return (slice(at, end) for at in range(length) for end in range(at + least, min(length, at + most) + 1))


def _is_nearly(part: str, run: str) -> bool:
    """Whether a part of a question writes a name with some, not all, of its characters."""
    same = sum(a == b for a, b in zip(part, run, strict=False))
    return len(part) == len(run) and _SAME * len(run) <= same < len(run)
