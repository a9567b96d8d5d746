"""Names as they are heard: a question that spells by ear what stands on a board.

Both are spelt in Latin letters, one spelling for each sound, and compared by their consonants and by all letters.
"""

import re
from collections.abc import Iterable, Sequence
from functools import lru_cache

from rapidfuzz import fuzz, process

from lpslam.language.tables.knowledge import load_words
from lpslam.language.tables.lexicon import read_table

_CONSONANTS = 4  # of a name that is known by them even where other words of the question are not heard
_SOUNDS_ALIKE, _SPELT_ALIKE = 80.0, 0.55  # of many consonants, and of all letters, of names that sound the same
_MANY, _MANY_ALIKE = 5, 0.4  # consonants that are the same in their order tell a name whatever its vowels, nearly
_WORDS_ALIKE = 0.72  # of all letters of what is heard in common words
_FEW_ALIKE = 0.8  # of all letters of names of fewer consonants, which must be the same
_FEWEST = 3  # letters of a word that is heard
_LEAST_LONG = 0.72  # of all letters that are asked for: a name is no part of a sentence
_APART = 0.05  # by which the name that sounds likest must lead
_SPELT_APART = 1  # letters by which surnames of one sound may differ in length
_RUN = 4  # words that may be one name
_KEPT = 64  # runs of words of which it is kept what sounds like them
_CONSONANT = str.maketrans("vbplgckqzjxd", "fffrkkkksss" + "t", "aeiouhwy")
Name = tuple[str, Sequence[str], Sequence[str]]
"""A board's name in Latin letters: all of it, its words in order, and its runs of scripts without spaces."""
Sounds = dict[str, tuple[list[str], list[tuple[str, int, bool]]]]
"""By their first consonant: all consonants; and beside them the sound, which name, and whether it is its own."""


@lru_cache(maxsize=1)
def _spellings() -> tuple[tuple[re.Pattern[str], str], ...]:
    """One spelling for each sound, in the order in which they are looked for."""
    return tuple((re.compile(pattern), sound) for pattern, sound in read_table("wishes/spellings.json"))


def by_ear(latin: str) -> str:
    """Return a word as it sounds: taquilla and takilla are one, and so are gym and jim."""
    for pattern, sound in _spellings():
        latin = pattern.sub(sound, latin)
    return latin


def sound_the_same(word: str, other: str, is_across: bool = False) -> bool:
    """Whether two surnames in Latin letters sound the same: Nair and Nayr, Brzezinski and Bresinski.

    `is_across` says that one was written in another script, which has other vowels: アルブラント, Albrand.
    """
    first, second = by_ear(word), by_ear(other)
    if not is_across and abs(len(word) - len(other)) > _SPELT_APART:
        return False  # Schneider is no Schneiderei
    own = _skeleton(first)
    is_long = len(own) >= _CONSONANTS and own == _skeleton(second)
    least = _SPELT_ALIKE if is_across else _WORDS_ALIKE
    return first == second or (is_long and fuzz.ratio(first, second) >= 100.0 * least)


def _skeleton(sound: str) -> str:
    """The consonants of a sound, those that scripts do not tell apart as one, doubled ones once."""
    kept = sound.replace("S", "s").translate(_CONSONANT)
    return "".join(ch for at, ch in enumerate(kept) if not at or kept[at - 1] != ch)


def beginning(names: Iterable[Name]) -> Sounds:
    """Return how names sound: whole, their runs of words, and their words."""
    found: Sounds = {}
    for at, (whole, words, runs) in enumerate(names):
        for word in {whole, *runs, *map("".join, _runs_of(words))}:
            sound = by_ear(word)
            skeleton = _skeleton(sound)
            skeletons, rows = found.setdefault(skeleton[:1], ([], []))
            skeletons.append(skeleton)
            # A common word of a board is heard only where all that is asked for is.
            rows.append((sound, at, word == whole or word not in load_words()))
    return found


class HeardNames:
    """The names of all boards, looked up by how they sound; `ids` of the landmarks that bear them."""

    def __init__(self, ids: Sequence[int], sounds: Sounds) -> None:
        self._ids, self._beginning = ids, sounds
        # A stop is listened to where no kind serves, and again where that is unsure.
        self._alike = lru_cache(maxsize=_KEPT)(self._sounding_like)

    def sounding(self, words: Sequence[str], is_all: bool) -> dict[int, float]:
        """Return the landmark whose name sounds like words of a question, and how alike, 0 to 1; none where two do.

        `is_all` says that the question is made of these words: they are heard together, or each for itself; else a name
        is known by many consonants alone.
        """
        found: dict[int, float] = {}
        for run in [words] if is_all else _runs_of(words):
            for id_, alike in self._alike(tuple(run), is_all).items():
                found[id_] = max(alike, found.get(id_, 0.0))
        each = [self._alike((word,), True) for word in words] if is_all and not found else []
        for id_ in set.intersection(*map(set, each)) if each else ():
            found[id_] = min(heard[id_] for heard in each)
        best = max(found.values(), default=0.0)
        near = {id_: alike for id_, alike in found.items() if alike >= best - _APART}
        return near if len(near) == 1 else {}

    def _sounding_like(self, run: tuple[str, ...], is_all: bool) -> dict[int, float]:
        """The landmarks whose names sound like a run of words, and how alike; few consonants must be the same."""
        said = "".join(run)
        sound = by_ear(said)
        sought = _skeleton(sound)
        is_few = len(sought) < _CONSONANTS
        # Who writes a word of a language rightly hardly means another.
        if len(said) < _FEWEST or not sought or (is_few and (not is_all or said in load_words())):
            return {}
        # “Serving” is no EV Charging.
        least = _SPELT_ALIKE if is_all and load_words().isdisjoint(run) else _WORDS_ALIKE
        skeletons, rows = self._beginning.get(sought[0], ([], []))
        cutoff = 100.0 if is_few else _SOUNDS_ALIKE
        found: dict[int, float] = {}
        for other, _, at in process.extract(sought, skeletons, scorer=fuzz.ratio, score_cutoff=cutoff, limit=None):
            alike, (_, name, is_own) = fuzz.ratio(sound, rows[at][0]) / 100.0, rows[at]
            id_ = self._ids[name]
            enough = _FEW_ALIKE if min(len(sought), len(other)) < _CONSONANTS else least
            # Other scripts spell the same consonants with vowels of their own.
            is_same = other == sought and not is_few and load_words().isdisjoint(run)
            is_long = len(rows[at][0]) >= _LEAST_LONG * len(sound)
            same = _MANY_ALIKE if len(sought) >= _MANY else _SPELT_ALIKE
            enough = min(enough, same) if is_same else enough if is_long else 1.0
            if alike >= enough and (is_all or (is_own and len(other) >= _CONSONANTS)):
                found[id_] = max(alike, found.get(id_, 0.0))
        return found


def _runs_of(words: Sequence[str]) -> list[Sequence[str]]:
    return [words[start:end] for end in range(len(words) + 1) for start in range(max(0, end - _RUN), end)]
