"""What boards say in their own words: a name that is asked for is found before any intent is thought of.

Names are compared folded, in part, with a few wrong letters, and in Latin letters where the scripts differ.
"""

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

from anyascii import anyascii
from rapidfuzz import process
from rapidfuzz.distance import OSA

from lpslam.language.kept import kept_of_boards
from lpslam.language.model import Candidate
from lpslam.language.signs.repair import Repair
from lpslam.language.tables.knowledge import Knowledge, load_words
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.patterns import standing
from lpslam.language.tables.words import UNSPACED_RUN, Folder, is_mark, is_unspaced
from lpslam.language.wishes.aloud import Sounds as AloudSounds
from lpslam.language.wishes.aloud import named_aloud, sounds_of
from lpslam.language.wishes.heard import HeardNames, Sounds, beginning, sound_the_same

_FAR = 9  # letters of a word in which two slips are forgiven
_LONG = 5  # letters of a word in which a slip is forgiven
_STEM, _STEM_SHARE = 5, 0.6  # letters with which words begin alike, at least, and their share of the shorter one
_LETTERS_A_SLIP = 6  # of a whole name, for each slip that is forgiven in it
_DIGITS = re.compile(r"\d").findall
_LETTERS = standing(r"[^\W\d_]+")
_HANGUL = standing("[\uac00-\ud7a3]+")
_SOUNDS_OF_HANGUL = (("cheu", "tsu"), ("eu", ""), ("eo", "o"), ("l", "r"))
_KEPT = 256  # words of which it is kept who bears them
_SHORTEST = 4  # letters of a surname that is known by its sound


@dataclass(frozen=True, eq=False)
class Words:
    """The words of one line of a board: units of spaced scripts, and runs of unspaced ones."""

    text: str
    units: frozenset[str]
    runs: tuple[str, ...]
    folder: Folder

    @cached_property
    def in_order(self) -> tuple[str, ...]:
        """The words of spaced scripts as they stand there."""
        # In the plural as well: Little Ducks sounds as リトルダックス.
        return tuple(word for word in _LETTERS.findall(self.folder.fold(self.text)) if not is_unspaced(word))

    @cached_property
    def latin(self) -> str:
        """All in Latin letters."""
        return _latin(self.text)

    @cached_property
    def key(self) -> str:
        """Its letters and digits alone."""
        return self.folder.key(self.text)


class Names:
    """The words of all boards, by landmark, looked up by word."""

    def __init__(self, landmarks: Sequence[Candidate], knowledge: Knowledge, repair: Repair) -> None:
        self._knowledge = knowledge
        self._repair = repair
        self._words = self._all_words(landmarks)
        self._words_of_names: dict[int, tuple[frozenset[str], tuple[str, ...]]] = {}
        self._rows = [(id_, line) for id_, lines in self._words.items() for line in lines]
        self._rows_of: dict[str, set[int]] = {}
        for row, (_, line) in enumerate(self._rows):
            for piece in {*line.units, *pairs_of(line.runs)}:
                self._rows_of.setdefault(piece, set()).add(row)
        # Words are asked for again and again of one question.
        self._bearing = lru_cache(maxsize=_KEPT)(self._near)
        self._long = [unit for unit in self._rows_of if len(unit) >= _LONG]

    def _all_words(self, landmarks: Sequence[Candidate]) -> dict[int, list[Words]]:
        """The words of each line of boards, the name first and then all lines together; kept where they are many."""
        texts = {
            mark.id: [text for text in (mark.name, " ".join((mark.name, *mark.lines)), *mark.lines) if text]
            for mark in landmarks
        }
        every = list(dict.fromkeys(text for lines in texts.values() for text in lines))

        def made() -> list[tuple[tuple[str, ...], tuple[str, ...]]]:
            return [self._words_of(text) for text in every]

        cut = kept_of_boards("words", len(every), every, made)
        folder = self._knowledge.folder
        words = {
            text: Words(text, frozenset(units), runs, folder) for text, (units, runs) in zip(every, cut, strict=True)
        }
        return {id_: [words[text] for text in dict.fromkeys(lines)] for id_, lines in texts.items()}

    def _words_of(self, text: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The units of a line in spaced scripts, and its runs in others."""
        fold = self._knowledge.folder
        folded = fold.fold(text)
        painted = fold.sign_units(text)
        units = dict.fromkeys(
            unit
            for unit in (*painted, *fold.units(text), *self._repair.words(painted))
            if not is_mark(unit) and not is_unspaced(unit)
        )
        return tuple(units), tuple(UNSPACED_RUN.findall(folded))

    def bearing(self, piece: str) -> set[int]:
        """Landmarks whose boards bear a word just so, or two characters of a script without spaces."""
        return self._ids(self._rows_of.get(piece, ()))

    def _ids(self, rows: Iterable[int]) -> set[int]:
        return {self._rows[row][0] for row in rows}

    def name_of(self, id_: int) -> str:
        """The name of a board: its first line."""
        return self._words[id_][0].text if self._words[id_] else ""

    def told_by(self, text: str, ids: Sequence[int]) -> list[int]:
        """The one of some landmarks of whose name a word stands in a text that no other's name has."""
        folder = self._knowledge.folder
        said, units = folder.fold(text), set(folder.units(text)).difference(*self._knowledge.common.values())
        names = ((id_, *self._name_words(id_)) for id_ in ids)
        told = {
            id_: (spaced & units) | {word for word in unspaced if word in said}
            for id_, spaced, unspaced in names
            if unspaced or not units.isdisjoint(spaced)
        }
        every = Counter(word for words in told.values() for word in words)
        found = [id_ for id_, words in told.items() if any(every[word] == 1 for word in words)]
        return found if len(found) == 1 else []

    def _name_words(self, id_: int) -> tuple[frozenset[str], tuple[str, ...]]:
        """The words of a board's name in spaced scripts, and those in others; kept: many boards are asked at once."""
        found = self._words_of_names.get(id_)
        if found is None:
            spaced = self._words[id_][0].units
            folded = self._knowledge.folder.fold(self.name_of(id_)).split()
            found = self._words_of_names[id_] = spaced, tuple(word for word in folded if is_unspaced(word))
        return found

    def akin(self, word: str) -> set[int]:
        """Landmarks whose boards bear another word that begins alike: adoptieren, Adoption."""
        found: set[int] = set()
        for unit in self._by_stem.get(word[:_STEM], ()) if len(word) >= _STEM else ():
            alike = next((at for at, (a, b) in enumerate(zip(word, unit, strict=False)) if a != b), None)
            common = min(len(word), len(unit)) if alike is None else alike
            if unit != word and common >= _STEM_SHARE * min(len(word), len(unit)):
                found |= self.bearing(unit)
        return found

    @cached_property
    def _by_stem(self) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        for unit in self._rows_of:
            if len(unit) >= _STEM and not is_unspaced(unit):
                found.setdefault(unit[:_STEM], []).append(unit)
        return found

    def _near(self, word: str, most_slips: int = 2) -> set[int]:
        """The lines that may bear a word: its own, one a slip away, or all pairs of its characters."""
        if is_unspaced(word):
            pairs = [self._rows_of.get(pair, set()) for pair in pairs_of((word,))]
            return set.intersection(*pairs) if pairs else set()
        rows = set(self._rows_of.get(word, ()))
        if len(word) >= _LONG:
            slips = min(most_slips, 1 if len(word) < _FAR else 2)
            near = process.extract(word, self._long, scorer=OSA.distance, score_cutoff=slips, limit=None)
            rows.update(*(self._rows_of[unit] for unit, _, _ in near))
        return rows

    def covered(self, content: Sequence[str], is_name: bool = False) -> dict[int, float]:
        """Return by landmark how much of a line's letters is asked for, where it bears all words; 0 < share <= 1.

        `is_name` says that only the first lines of boards count.
        """
        found: dict[int, float] = {}
        for row in sorted(set.intersection(*map(self._bearing, content))) if content else ():
            id_, line = self._rows[row]
            if not is_name or line is self._words[id_][0]:
                found[id_] = max(found.get(id_, 0.0), self._share(content, line))
        return {id_: share for id_, share in found.items() if share > 0.0}

    def _share(self, content: Sequence[str], line: Words) -> float:
        # Of a board in two scripts, the letters of the one that is asked in.
        in_runs, in_units = sum(map(len, line.runs)), sum(map(len, line.units))
        asked_in = {is_unspaced(word) for word in content}
        whole = len(line.key) if len(asked_in) > 1 else in_runs if True in asked_in else min(in_units, len(line.key))
        return min(1.0, sum(map(len, content)) / max(whole, 1))

    def spelt(self, text: str) -> dict[int, float]:
        """Return the one landmark whose name a text is, spaces and a slip or two aside: Faakersee, Faaker See."""
        key = self._knowledge.folder.key(text)
        slips = min(2, len(key) // _LETTERS_A_SLIP)
        near = process.extract(key, self._keys, scorer=OSA.distance, score_cutoff=slips, limit=None) if slips else []
        best = min((slip for _, slip, _ in near), default=0)
        ids = [id_ for found, slip, id_ in near if slip == best and _DIGITS(found) == _DIGITS(key)]
        return dict.fromkeys(ids, 1.0 - best / max(len(key), 1)) if len(ids) == 1 else {}

    @cached_property
    def _keys(self) -> dict[int, str]:
        """The letters and digits of each name."""
        return {id_: lines[0].key for id_, lines in self._words.items() if lines}

    def sounding(self, words: Sequence[str], is_all: bool = False) -> dict[int, float]:
        """Return the landmark whose name sounds like some words, in whatever script; none where two do.

        `is_all` says that nothing else is asked for.
        """
        return self._heard.sounding([_latin(word) for word in words], is_all)

    @cached_property
    def _heard(self) -> HeardNames:
        names = self._firsts

        def made() -> Sounds:
            return beginning((line.latin, line.in_order, tuple(map(_latin, line.runs))) for line in names.values())

        texts = (line.text for line in names.values())
        return HeardNames(list(names), kept_of_boards("sounds", len(names), texts, made))

    @cached_property
    def _firsts(self) -> dict[int, Words]:
        """Of each board's lines the first, which is its name; a board may say nothing."""
        return {id_: lines[0] for id_, lines in self._words.items() if lines}

    def aloud(self, text: str) -> dict[int, float]:
        """Return the one landmark whose name a text spells by its sound alone: ほしあかり, 星あかり."""
        found = named_aloud(text, self._aloud)
        return {id_: 1.0 for at, id_ in enumerate(self._firsts) if at in found} if found else {}

    @cached_property
    def _aloud(self) -> AloudSounds:
        texts = [line.text for line in self._firsts.values()]
        runs = map(UNSPACED_RUN.findall, texts)
        return dict(kept_of_boards("aloud", len(texts), texts, lambda: sounds_of(runs)))

    def persons(self, name: str) -> list[int]:
        """Landmarks whose board bears a person's name: all words of it, the surname in another script, or its sound."""
        words = self._knowledge.folder.fold(name).replace("-", " ").split()
        # Boards have units without an “s” that may be a plural's.
        forms = [{word, *self._knowledge.folder.units(word)} for word in words]
        # Schneider is no Schneiderei.
        rows = [set().union(*(self._bearing(form, 1) for form in each)) for each in forms]
        found = sorted(self._ids(set.intersection(*rows))) if rows else []
        found = found or self._in_another_script(words) or (self._surnames_heard(words[-1]) if words else [])
        return found or (list(self.sounding(words, is_all=True)) if words and is_unspaced(words[0]) else [])

    def _in_another_script(self, words: Sequence[str]) -> list[int]:
        """Landmarks whose boards bear a surname as another script writes it: 田辺 and Tanabe."""
        whole = "".join(words)
        written = {form for each, forms in _surnames() if whole.startswith(each) for form in forms}
        written |= {each for each, forms in _surnames() if not forms.isdisjoint(words)}
        starts = tuple(written)
        bearing = (
            id_
            for id_, line in self._rows
            if not line.units.isdisjoint(written) or any(run.startswith(starts) for run in line.runs)
        )
        return list(dict.fromkeys(bearing)) if written else []

    def _surnames_heard(self, surname: str) -> list[int]:
        """Landmarks whose boards bear the one surname that sounds so; in its own script it is no word of a language."""
        sound, words = _latin(surname), frozenset[str]() if is_unspaced(surname) else load_words()
        if len(sound) < _SHORTEST:
            return []
        is_across = is_unspaced(surname)
        alike = (word for word in self._rows_of if word not in words and sound_the_same(sound, word, is_across))
        heard = [self._rows_of[word] for word in alike]
        return sorted(self._ids(heard[0])) if len(heard) == 1 else []


@lru_cache(maxsize=1)
def _surnames() -> tuple[tuple[str, frozenset[str]], ...]:
    """Surnames of Chinese characters and Hangul, and how each is written in Latin letters."""
    tree: Mapping[str, Mapping[str, str]] = read_table("wishes/surnames.json")
    rows = ((name, frozenset(joined.split("|"))) for names in tree.values() for name, joined in names.items())
    return tuple(sorted(rows, key=lambda row: -len(row[0])))


def pairs_of(runs: Sequence[str]) -> list[str]:
    """Every two characters that follow one another, and every one: by them runs are found that hold a shorter one."""
    return [run[at : at + 2] for run in runs for at in range(max(1, len(run) - 1))]


def _latin(text: str) -> str:
    # Hangul writes l for r, and puts a vowel after every consonant; a small ッ doubles the next one.
    spelt = _HANGUL.sub(lambda run: _hangul(anyascii(run.group()).casefold()), text.replace("ッ", ""))
    return re.sub(r"[^a-z0-9]", "", anyascii(spelt).casefold())


def _hangul(spelt: str) -> str:
    for letters, sound in _SOUNDS_OF_HANGUL:
        spelt = spelt.replace(letters, sound)
    return spelt
