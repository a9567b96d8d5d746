"""What boards say in their own words: a name that is asked for is found before any intent is thought of.

Names are compared folded, in part, with a few wrong letters, and in Latin letters where the scripts differ.
"""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from anyascii import anyascii
from rapidfuzz import fuzz

from lpslam.language.knowledge import Knowledge
from lpslam.language.model import Candidate
from lpslam.language.words import UNSPACED_RUN, is_mark, is_unspaced

_SAME = 88.0  # of 100: two words of a name are the same but for a reader's or a typist's slip
_LONG = 5  # letters of a word in which a slip is forgiven
_ACROSS = 80.0  # of 100: a name in other letters sounds the same
_FEWEST = 2  # letters of a script without spaces that may be a part of a name
_SHORTEST = 4  # letters of a name that may be compared across scripts
_KANA = re.compile(r"[\u3040-\u30ff]")


@dataclass(frozen=True, slots=True)
class Words:
    """The words of one line of a board: units of spaced scripts, runs of unspaced ones, and all in Latin letters."""

    units: frozenset[str]
    runs: tuple[str, ...]
    latin: str
    key: str


class Names:
    """The words of all boards, by landmark."""

    def __init__(self, landmarks: Sequence[Candidate], knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self.words = {
            landmark.id: [
                self._words_of(text)
                for text in dict.fromkeys((landmark.name, " ".join((landmark.name, *landmark.lines)), *landmark.lines))
                if text
            ]
            for landmark in landmarks
        }
        counts: Counter[str] = Counter()
        for lines in self.words.values():
            counts.update({unit for line in lines for unit in line.units})
        self._counts = counts

    def _words_of(self, text: str) -> Words:
        fold = self._knowledge.folder
        folded = fold.fold(text)
        units = frozenset(unit for unit in fold.sign_units(text) if not is_mark(unit) and not is_unspaced(unit))
        runs = tuple(UNSPACED_RUN.findall(folded))
        return Words(units, runs, _latin(text), fold.key(text))

    def rarity(self, unit: str) -> int:
        """On how many boards a word stands."""
        return self._counts[unit]

    def covered(self, content: Sequence[str]) -> dict[int, float]:
        """Return by landmark how much of a board's words is named by words all of which it bears, 0 < share <= 1."""
        if not content:
            return {}
        found: dict[int, float] = {}
        for id_, lines in self.words.items():
            share = max((self._share(content, line) for line in lines), default=0.0)
            if share > 0.0:
                found[id_] = share
        return found

    def _share(self, content: Sequence[str], line: Words) -> float:
        if not all(_bears(line, word) for word in content):
            return 0.0
        letters = sum(map(len, content))
        return min(1.0, letters / max(len(line.key), 1))

    def across(self, content: Sequence[str]) -> dict[int, float]:
        """Return by landmark how alike a name sounds that is painted in another script than it is asked for in."""
        asked = "".join(content)
        latin = _latin(asked)
        if len(latin) < _SHORTEST:
            return {}
        found: dict[int, float] = {}
        for id_, lines in self.words.items():
            for line in lines:
                if len(line.latin) < _SHORTEST or bool(line.runs) == is_unspaced(asked):
                    continue
                alike = fuzz.ratio(latin, line.latin) if len(latin) > 0.6 * len(line.latin) else 0.0
                if line.runs:
                    alike = max((alike, *(fuzz.ratio(latin, _latin(run)) for run in line.runs)))
                if alike >= _ACROSS:
                    found[id_] = max(found.get(id_, 0.0), alike / 100.0)
        return found

    def persons(self, name: str) -> list[int]:
        """Landmarks whose board bears every word of a person's name."""
        fold = self._knowledge.folder
        words = [unit for unit in fold.fold(name).replace("-", " ").split() if unit]
        return [
            id_
            for id_, lines in self.words.items()
            if any(all(_bears_person(line, word) for word in words) for line in lines)
        ]


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
    units = {unit for unit in line.units}
    return word in units or word.rstrip("s") in units or (
        len(word) >= _LONG and any(fuzz.ratio(word, unit) >= 90.0 and abs(len(word) - len(unit)) <= 1 for unit in units)
    )


def _latin(text: str) -> str:
    return re.sub(r"[^a-z0-9]", "", anyascii(text).casefold())


def counted(found: Mapping[int, float]) -> list[int]:
    """The landmarks by how much of their board was named, most first."""
    return sorted(found, key=lambda id_: (-found[id_], id_))
