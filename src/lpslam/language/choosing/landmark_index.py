"""Landmarks as they are looked up: by what their signs mean, and by their names and parts of them."""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from lpslam.language.choosing.serving import Kinds, likeness, match, whom_for
from lpslam.language.kept import kept_of_boards
from lpslam.language.model import Candidate
from lpslam.language.questions.question import spoken_key
from lpslam.language.signs.hours import without_hours
from lpslam.language.signs.meaning import SignMeaning, for_whom, joined
from lpslam.language.signs.reader import SignReader
from lpslam.language.tables.knowledge import Knowledge, load_words
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.patterns import standing
from lpslam.language.tables.words import UNSPACED_RUN, PhraseTable, is_unspaced

_NUMBERED = standing(r"[A-Z]?\d+(?:[.-]\d+)*(?:\s*[-–—~〜]\s*[A-Z]?\d+)?")
_SURELY = 0.5  # a place is of a kind when its words say so at least this surely
_IS_NUMBER = standing(r"^[\W\d]*\w?[\W\d]+$")
_SHORTEST_WORD = 4  # letters of a word that may stand for the name that it is part of
_PARTS = standing(r"[·•,、・|/]")  # what parts the things that a line lists
_MOST_OF_LINE = 0.6  # of a line's parts: so many must be read before it is believed
_OF_LINE = 0.85  # of what a further line says: a board whose name says it goes before
_SHORTEST_RUN = 3  # characters without spaces that may be a name or a part of one


class LandmarkIndex:
    """Landmarks by what their signs mean, judged once however many mean the same, and by their names."""

    def __init__(self, landmarks: Sequence[Candidate], signs: SignReader, knowledge: Knowledge) -> None:
        self._given, self._knowledge = landmarks, knowledge
        self.landmarks = list(landmarks)
        self.name_of = {landmark.id: landmark.name for landmark in landmarks}
        self.groups: dict[Kinds, list[int]] = {}
        self.signs: dict[int, SignMeaning] = {}
        # Questions ask for the same again and again.
        self.matches, self.alike = cache(self._matches), cache(self._alike)
        for landmark, sign in zip(landmarks, _signs_of(landmarks, signs), strict=True):
            self.signs[landmark.id] = sign
            self.groups.setdefault(sign.kinds, []).append(landmark.id)
        self.kinds, self.members = list(self.groups), list(self.groups.values())
        self.group_of = {id_: at for at, ids in enumerate(self.members) for id_ in ids}
        people = ((at, whom_for(kinds, knowledge)) for at, kinds in enumerate(self.kinds))
        self.people = {at: whom for at, whom in people if whom}  # groups whose goods are for some alone
        unread = sum(not self.signs[mark.id].kinds and not _IS_NUMBER.search(mark.name) for mark in landmarks)
        self.unread = unread / max(len(landmarks), 1)  # share of the landmarks that no table reads
        groups = self.groups.items()
        shops = sum(len(ids) for kinds, ids in groups if likeness("business", kinds, knowledge) >= _SURELY)
        self.shops = shops / max(len(landmarks), 1)  # share of the landmarks that are shops and places to eat

        def called() -> tuple[Any, ...]:
            return _called([(mark, self.signs[mark.id]) for mark in landmarks], signs, knowledge)

        at_of, self.phrase_of, self._initials, self._plurals = kept_of_boards(
            "called", len(landmarks), told_by(landmarks), called
        )
        ids = [landmark.id for landmark in landmarks]
        self.ids_of: dict[str, tuple[int, ...]] = {
            phrase: tuple([ids[at] for at in places]) for phrase, places in at_of.items()
        }
        self.names = PhraseTable((phrase, Meaning("name", ((phrase, 1.0),))) for phrase in self.ids_of)
        self.ids_by_word = _ids_by_word(self.ids_of)

    def _matches(self, concept: str) -> Mapping[int, float]:
        """How well the groups serve a concept, by their place in `groups`: those that do."""
        every = enumerate(match(concept, kinds, self._knowledge) for kinds in self.groups)
        return {at: served for at, served in every if served}

    def _alike(self, kind: str) -> Mapping[int, float]:
        """How surely groups of landmarks are of a kind, by their place in `groups`: those that may be."""
        every = enumerate(likeness(kind, kinds, self._knowledge) for kinds in self.kinds)
        return {at: sure for at, sure in every if sure}

    def has(self, concept: str) -> bool:
        """Whether any place here is surely of a kind."""
        return max(self.alike(concept).values(), default=0.0) >= _SURELY

    def is_unsaid(self, question: str, phrase: str) -> bool:
        """Whether a name only seems to be said.

        Phrases drop the plural, but “the sole of my boot” does not say “Boots”; and two letters are a name only where
        they stand in capitals of their own.
        """
        plural, name = self._plurals.get(phrase), self._initials.get(phrase)
        if plural is not None and plural not in self._knowledge.folder.fold(question):
            return True
        return name is not None and not re.search(rf"(?<![A-Za-z]){name}(?![A-Za-z])", question)

    def is_of(self, landmarks: Sequence[Candidate]) -> bool:
        """Whether the index was made of just these landmarks."""
        if landmarks is self._given and isinstance(landmarks, tuple):
            return True
        return len(landmarks) == len(self.landmarks) and self.landmarks == list(landmarks)


def _called(
    marks: Sequence[tuple[Candidate, SignMeaning]], signs: SignReader, knowledge: Knowledge
) -> tuple[dict[str, list[int]], dict[str, str], dict[str, str], dict[str, str]]:
    """What landmarks are called, in plain values: their places by phrase; of brands, the phrase; initials; plurals."""
    called, of_brand = _Called(signs, knowledge), dict[str, list[int]]()
    for at, (landmark, sign) in enumerate(marks):
        if sign.kinds and not sign.is_place:
            continue
        if sign.identity:
            of_brand.setdefault(sign.identity, []).append(at)
        called.add_landmark(landmark, at, bool(sign.identity))
    # “Family Mart” is the brand of ファミリーマート, however it is written.
    phrase_of: dict[str, str] = {}
    for identity, places in of_brand.items():
        for name in signs.names_of(identity):
            phrase = called.add(name, places, is_brand=True)
            if phrase is not None:
                phrase_of[identity] = phrase
    # McDonald's is called McDonalds too, and by some Starbucks Starbuck.
    plurals = {phrase: said for phrase, said in called.plurals.items() if phrase not in called.singular}
    return {phrase: sorted(places) for phrase, places in called.ids.items()}, phrase_of, called.initials, plurals


class _Called:
    """What landmarks are called, by phrase: names, their parts, other lines, and brands' other names.

    Landmarks are told by their place among all.
    """

    def __init__(self, signs: SignReader, knowledge: Knowledge) -> None:
        self._signs, self._knowledge = signs, knowledge
        self.ids: dict[str, dict[int, None]] = {}
        self.initials: dict[str, str] = {}
        self.plurals: dict[str, str] = {}
        self.singular: set[str] = set()

    def add_landmark(self, landmark: Candidate, at: int, is_brand: bool) -> None:
        """Add the name of the landmark at a place, its parts and its lines."""
        own = (at,)
        self.add(landmark.name, own, is_brand)
        for part in (*_in_each_script(landmark.name), *landmark.lines):
            self.add(part, own, is_brand=False)
        if "'" in landmark.name:
            # Who types quickly leaves the apostrophe out.
            self.add(landmark.name.replace("'", ""), own, is_brand)

    def add(self, text: str, ids: Sequence[int], is_brand: bool) -> str | None:
        """Add what some landmarks are called; return its phrase, None where it may be any word."""
        phrase, knowledge = self._signs.phrase(text), self._knowledge
        is_short = _is_short_name(text, phrase, knowledge)
        if not (spoken_key(phrase) or is_short) or (phrase in knowledge.painted and not is_brand):
            return None
        self.ids.setdefault(phrase, {}).update(dict.fromkeys(ids))
        if is_short:
            self.initials[phrase] = text
        folded = knowledge.folder.fold(text)
        if folded == f"{phrase}s":
            self.plurals[phrase] = folded
        elif folded.replace("'s", "") == phrase:
            self.singular.add(phrase)
        return phrase


def _in_each_script(name: str) -> tuple[str, ...]:
    """The parts of a name that is painted in two scripts, each long enough to be a name: 鼎泰豐 and DIN TAI FUNG."""
    parts = [part for part in (each.strip(" ·|/-–") for each in UNSPACED_RUN.split(name)) if part]
    runs = UNSPACED_RUN.findall(name)
    if len(parts) != 1 or len(runs) != 1:
        return ()
    words = parts[0].split()
    is_own = any(word.casefold() not in load_words() for word in words) and len(parts[0]) >= _SHORTEST_WORD
    return (*(parts if is_own else ()), *(runs if len(runs[0]) >= _SHORTEST_RUN else ()))


def _is_short_name(name: str, phrase: str, knowledge: Knowledge) -> bool:
    """Whether two letters are a name that is one only where it stands as it is painted: GU, dm."""
    if len(name) != 2 or not (name.isascii() and name.isalpha()):
        return False
    return name.isupper() or not any(phrase in common for common in knowledge.common.values())


def _ids_by_word(ids_by_phrase: Mapping[str, Collection[int]]) -> dict[str, set[int]]:
    """Landmarks by the words of names of several words: “not Kaya's” refuses “Key Service Kaya”."""
    found: dict[str, set[int]] = {}
    for phrase, ids in ids_by_phrase.items():
        words = phrase.split()
        for word in words if len(words) > 1 else ():
            if len(word) >= _SHORTEST_WORD and not is_unspaced(word):
                found.setdefault(word, set()).update(ids)
    return found


def _signs_of(landmarks: Sequence[Candidate], signs: SignReader) -> list[SignMeaning]:
    """What boards mean; as they were read before, where they are many."""
    kinds, rows = kept_of_boards(
        "signs", len(landmarks), told_by(landmarks), lambda: _packed([_sign_of(mark, signs) for mark in landmarks])
    )
    return [SignMeaning(kinds[at], *rest) for at, *rest in rows]


def _packed(signs: Sequence[SignMeaning]) -> tuple[list[Kinds], list[tuple[Any, ...]]]:
    """Meanings of plain values: each group of kinds once."""
    kinds = {each: at for at, each in enumerate(dict.fromkeys(sign.kinds for sign in signs))}
    return list(kinds), [(kinds[each.kinds], each.evidence, each.identity, each.name_like) for each in signs]


def told_by(landmarks: Sequence[Candidate]) -> Iterator[str]:
    """What tells some boards from others: all that stands there."""
    return (text for mark in landmarks for text in (mark.name, *mark.aliases, "", *mark.lines, ""))


def _sign_of(landmark: Candidate, signs: SignReader) -> SignMeaning:
    """What a board means: its name, else its first line that says anything; the other lines say what is had there."""
    # “9–17 Uhr” sells no watches.
    name = without_hours(landmark.name)
    sign = signs.read(name)
    bare = _NUMBERED.sub(" ", name).strip(" -–—,.:·~〜")
    if not sign.kinds and bare and bare != name:
        sign = signs.read(bare)
    if sign.kinds and not sign.is_place:
        return sign
    lines = [told for line in landmark.lines if (told := _told_by(without_hours(line), signs)) is not None]
    if sign.kinds and bare != name and not sign.identity:
        # “Aisle 6” and “Pier 2” say which one it is; their other lines say what is there.
        return joined([sign, *lines]) if lines else sign
    if not sign.kinds:
        # The name says nothing: another line of the same board may, even in part, or another reading.
        others = (signs.read(without_hours(text)) for text in (*landmark.lines, *landmark.aliases))
        sign = next((each for each in (*lines, *others) if each.kinds and each.is_place), sign)
    return _with_lines(sign, lines)


def _told_by(line: str, signs: SignReader) -> SignMeaning | None:
    """What a further line of a board says, if it is read for the most part: of “Lufthansa · Swiss” one word is food."""
    parts = [part for each in _PARTS.split(line) if (part := each.strip())]
    read = [told for part in parts if (told := signs.listed(part)) is not None]
    return joined(read) if read and len(read) >= _MOST_OF_LINE * len(parts) else None


def _with_lines(sign: SignMeaning, lines: Sequence[SignMeaning]) -> SignMeaning:
    kinds = dict(sign.kinds)
    # Below the name of a trade “Gents only” says whom it is for.
    read = (for_whom(dict(line.kinds)) if sign.kinds else dict(line.kinds) for line in lines)
    for kind, weight in (each for line in read for each in line.items()):
        kinds.setdefault(kind, _OF_LINE * weight)
    return replace(sign, kinds=tuple(kinds.items()))
