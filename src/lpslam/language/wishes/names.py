"""What boards say in their own words: a name that is asked for is found before any intent is thought of.

Names are compared folded, in part, with a few wrong letters, and in Latin letters where the scripts differ.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from anyascii import anyascii
from rapidfuzz import fuzz, process

from lpslam.language.model import Candidate
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.words import UNSPACED_RUN, is_mark, is_unspaced

_SAME = 88.0  # of 100: two words of a name are the same but for a reader's or a typist's slip
_SAME_PERSON = 90.0  # of 100: Schmidt and Schmitt may be two people, Schneider and Schnieder one
_LONG = 5  # letters of a word in which a slip is forgiven
_ACROSS = 80.0  # of 100: a name in other letters sounds the same
_SHORTEST = 4  # letters of a name that may be compared across scripts


@dataclass(frozen=True, slots=True)
class Words:
    """The words of one line of a board: units of spaced scripts, runs of unspaced ones, and all in Latin letters."""

    units: frozenset[str]
    runs: tuple[str, ...]
    latin: str
    key: str


class Names:
    """The words of all boards, by landmark, looked up by word."""

    def __init__(self, landmarks: Sequence[Candidate], knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self._words = {
            landmark.id: [
                self._words_of(text)
                for text in dict.fromkeys((landmark.name, " ".join((landmark.name, *landmark.lines)), *landmark.lines))
                if text
            ]
            for landmark in landmarks
        }
        self._ids_of: dict[str, set[int]] = {}
        for id_, lines in self._words.items():
            for piece in {piece for line in lines for piece in (*line.units, *_pairs(line.runs))}:
                self._ids_of.setdefault(piece, set()).add(id_)
        self._long = [unit for unit in self._ids_of if len(unit) >= _LONG]

    @cached_property
    def _sounds(self) -> tuple[tuple[list[str], list[int]], tuple[list[str], list[int]]]:
        """Names in Latin letters with their landmarks: those painted in spaced scripts, and those in others."""
        found: tuple[tuple[list[str], list[int]], tuple[list[str], list[int]]] = (([], []), ([], []))
        for id_, lines in self._words.items():
            for line in lines:
                parts = [line.latin, *(map(_latin, line.runs) if line.units else ())]
                for latin in parts:
                    if len(latin) >= _SHORTEST:
                        found[bool(line.runs)][0].append(latin)
                        found[bool(line.runs)][1].append(id_)
        return found

    def _words_of(self, text: str) -> Words:
        fold = self._knowledge.folder
        folded = fold.fold(text)
        units = frozenset(unit for unit in fold.sign_units(text) if not is_mark(unit) and not is_unspaced(unit))
        return Words(units, tuple(UNSPACED_RUN.findall(folded)), _latin(text), fold.key(text))

    def _bearing(self, word: str) -> set[int]:
        """Landmarks that may bear a word: its own, one a slip away, or all pairs of its characters."""
        if is_unspaced(word):
            pairs = [self._ids_of.get(pair, set()) for pair in _pairs((word,))]
            return set.intersection(*pairs) if pairs else set()
        ids = set(self._ids_of.get(word, ()))
        if len(word) >= _LONG:
            for unit, _, _ in process.extract(word, self._long, scorer=fuzz.ratio, score_cutoff=_SAME, limit=None):
                ids |= self._ids_of[unit]
        return ids

    def covered(self, content: Sequence[str]) -> dict[int, float]:
        """Return by landmark how much of a board's letters is asked for, where it bears all words; 0 < share <= 1."""
        if not content:
            return {}
        ids = set.intersection(*(self._bearing(word) for word in content))
        shares = {id_: max(self._share(content, line) for line in self._words[id_]) for id_ in sorted(ids)}
        return {id_: share for id_, share in shares.items() if share > 0.0}

    def _share(self, content: Sequence[str], line: Words) -> float:
        if not all(_bears(line, word) for word in content):
            return 0.0
        return min(1.0, sum(map(len, content)) / max(len(line.key), 1))

    def across(self, content: Sequence[str]) -> dict[int, float]:
        """Return by landmark how alike a name sounds that is painted in another script than it is asked for in."""
        asked = "".join(content)
        latin = _latin(asked)
        if len(latin) < _SHORTEST:
            return {}
        names, ids = self._sounds[not is_unspaced(asked)]
        found: dict[int, float] = {}
        for _, alike, at in process.extract(latin, names, scorer=fuzz.ratio, score_cutoff=_ACROSS, limit=None):
            found[ids[at]] = max(found.get(ids[at], 0.0), alike / 100.0)
        return found

    def persons(self, name: str) -> list[int]:
        """Landmarks whose board bears every word of a person's name on one line."""
        words = self._knowledge.folder.fold(name).replace("-", " ").split()
        if not words:
            return []
        ids = set.intersection(*(self._bearing(word) | self._bearing(word.rstrip("s") or word) for word in words))
        return [
            id_
            for id_ in sorted(ids)
            if any(all(_bears_person(line, word) for word in words) for line in self._words[id_])
        ]


def _pairs(runs: Sequence[str]) -> list[str]:
    """Every two characters that follow one another, and every one: by them runs are found that hold a shorter one."""
    return [run[at : at + 2] for run in runs for at in range(max(1, len(run) - 1))]


def _bears(line: Words, word: str) -> bool:
    if is_unspaced(word):
        return any(word in run for run in line.runs)
    if word in line.units:
        return True
    if len(word) < _LONG:
        return False
    return any(len(unit) >= _LONG and fuzz.ratio(word, unit) >= _SAME and word[0] == unit[0] for unit in line.units)


def _bears_person(line: Words, word: str) -> bool:
    if is_unspaced(word):
        return any(word in run for run in line.runs)
    if word in line.units or word.rstrip("s") in line.units:
        return True
    return len(word) >= _LONG and any(
        abs(len(word) - len(unit)) <= 1 and fuzz.ratio(word, unit) >= _SAME_PERSON for unit in line.units
    )


def _latin(text: str) -> str:
    return re.sub(r"[^a-z0-9]", "", anyascii(text).casefold())
