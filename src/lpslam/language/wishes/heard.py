"""Names as they are heard: a question that spells by ear what stands on a board.

Both are spelt in Latin letters, one spelling for each sound, and compared by their consonants and by all letters.
"""

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np
from rapidfuzz import fuzz, process

from lpslam.language.tables.knowledge import load_words
from lpslam.language.wishes.persons import consonants

_CONSONANTS = 4  # of a name that is known by them even where other words of the question are not heard
_SOUNDS_ALIKE, _SPELT_ALIKE = 80.0, 0.55  # of many consonants, and of all letters, of names that sound the same
_WORDS_ALIKE = 0.72  # of all letters of what is heard in common words
_FEW_ALIKE = 0.8  # of all letters of names of fewer consonants, which must be the same
_FEWEST = 3  # letters of a word that is heard
_APART = 0.05  # by which the name that sounds likest must lead
_SPELT_APART = 1  # letters by which surnames of one sound may differ in length
_RUN = 4  # words that may be one name
_SPELLINGS = (
    # One spelling for each sound, in the order in which they are looked for.
    ("dsch|tsch|sch|tch|ch|sh|[cst]i(?=on)", "S"),
    ("ph", "f"),
    ("qu|kw|ck", "k"),
    ("c(?=[eiy])|z", "s"),
    ("c", "k"),
    ("g(?=[eiy])", "j"),
    ("ee|ea|ie", "i"),
    ("oo|ou", "u"),
    ("[ae][iy](?![aeiou])", "e"),
    ("y", "i"),
    ("x", "ks"),
    ("h", ""),
    (r"(.)\1", r"\1"),
    ("(?<=..)e$", ""),
)
_SPELT = tuple((re.compile(pattern), sound) for pattern, sound in _SPELLINGS)

Name = tuple[str, Sequence[str], Sequence[str]]
"""A board's name in Latin letters: all of it, its words in order, and its runs of scripts without spaces."""


def by_ear(latin: str) -> str:
    """Return a word as it sounds: taquilla and takilla are one, and so are gym and jim."""
    for pattern, sound in _SPELT:
        latin = pattern.sub(sound, latin)
    return latin


def sound_the_same(word: str, other: str) -> bool:
    """Whether two surnames in Latin letters sound the same: Nair and Nayr, Brzezinski and Bresinski."""
    first, second = by_ear(word), by_ear(other)
    if abs(len(word) - len(other)) > _SPELT_APART:
        return False  # Schneider is no Schneiderei
    own = _skeleton(first)
    is_long = len(own) >= _CONSONANTS and own == _skeleton(second)
    return first == second or (is_long and fuzz.ratio(first, second) >= 100.0 * _WORDS_ALIKE)


def _skeleton(sound: str) -> str:
    return consonants(sound.replace("S", "s"))


class HeardNames:
    """The names of all boards, looked up by how they sound."""

    def __init__(self, names: Mapping[int, Name]) -> None:
        rows: dict[tuple[str, bool], set[int]] = defaultdict(set)
        for id_, (whole, words, runs) in names.items():
            own = {word for word in words if word not in load_words()}
            for word in {whole, *words, *runs}:
                if len(word) >= _FEWEST:
                    # A common word of a board is heard only where all that is asked for is.
                    rows[word, word in own or word == whole or word in runs].add(id_)
        self._ids = list(rows.values())
        self._is_own = [is_own for _, is_own in rows]
        self._sounds = [by_ear(word) for word, _ in rows]
        self._skeletons = [_skeleton(sound) for sound in self._sounds]
        self._rows_of: dict[str, list[int]] = defaultdict(list)
        # Those are alike whose first consonant is the same.
        self._beginning: dict[str, tuple[list[str], list[int]]] = defaultdict(lambda: ([], []))
        for at, (word, _) in enumerate(rows):
            self._rows_of[word].append(at)
            skeletons, places = self._beginning[self._skeletons[at][:1]]
            skeletons.append(self._skeletons[at])
            places.append(at)

    def sounding(self, words: Sequence[str], is_all: bool) -> dict[int, float]:
        """Return the landmark whose name sounds like words of a question, and how alike, 0 to 1; none where two do.

        `is_all` says that the question is made of these words; else a name is known by many consonants alone.
        """
        runs = {(start, end) for end in range(len(words) + 1) for start in range(max(0, end - _RUN), end)}
        found: dict[int, float] = {}
        heard: dict[int, dict[tuple[int, int], float]] = defaultdict(dict)
        for start, end in sorted(runs):
            # “Serving” is no EV Charging.
            least = _WORDS_ALIKE if load_words().intersection(words[start:end]) else 0.0
            heard_of = self._alike("".join(words[start:end]))
            for at, alike in ((at, alike) for at, alike in heard_of.items() if alike >= least):
                for id_ in self._ids[at]:
                    heard[id_][start, end] = max(alike, heard[id_].get((start, end), 0.0))
                    is_known = self._is_own[at] and len(self._skeletons[at]) >= _CONSONANTS
                    if is_known and not is_all and alike >= _WORDS_ALIKE:
                        found[id_] = max(alike, found.get(id_, 0.0))
        for id_, parts in heard.items() if is_all else ():
            found[id_] = max(found.get(id_, 0.0), _covered(parts, [len(word) for word in words]))
        best = max(found.values(), default=0.0)
        near = {id_: alike for id_, alike in found.items() if alike and alike >= best - _APART}
        return near if len(near) == 1 else {}

    def _alike(self, run: str) -> dict[int, float]:
        """The rows that sound like a run of words, and how alike."""
        sound = by_ear(run)
        sought = _skeleton(sound)
        found = dict.fromkeys(self._rows_of.get(run, ()), 1.0)
        if len(run) < _FEWEST or not sought:
            return found
        is_few = len(sought) < _CONSONANTS
        if is_few and run in load_words():
            # Who writes a word of a language rightly hardly means another.
            return found
        least = 100.0 if is_few else _SOUNDS_ALIKE
        skeletons, places = self._beginning.get(sought[0], ([], []))
        for said, _, row in process.extract(sought, skeletons, scorer=fuzz.ratio, score_cutoff=least, limit=None):
            alike = fuzz.ratio(sound, self._sounds[places[row]]) / 100.0
            is_short = min(len(sought), len(said)) < _CONSONANTS
            if alike >= (_FEW_ALIKE if is_short else _SPELT_ALIKE):
                found[places[row]] = alike
        return found


def _covered(parts: Mapping[tuple[int, int], float], lengths: Sequence[int]) -> float:
    """How alike all words are to what was heard of them, by letters; 0 where one was not heard."""
    ends = np.concatenate([[0], np.cumsum(lengths)])
    best = [0.0] + [-np.inf] * len(lengths)
    for end in range(1, len(lengths) + 1):
        best[end] = max(
            (best[start] + alike * float(ends[to] - ends[start]) for (start, to), alike in parts.items() if to == end),
            default=-np.inf,
        )
    return float(max(best[-1], 0.0) / max(ends[-1], 1))
