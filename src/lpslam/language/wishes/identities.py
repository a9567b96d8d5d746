"""The landmarks that bear what must stand on the board: codes, names of people, levels and buildings."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cache, cached_property
from itertools import pairwise
from typing import Any

from lpslam.language.choosing.landmark_index import told_by
from lpslam.language.kept import kept_of_boards
from lpslam.language.languages import UNSPACED
from lpslam.language.model import Candidate
from lpslam.language.questions.question import read_question
from lpslam.language.questions.speaking import wish_languages
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.words import UNSPACED_RUN, is_mark
from lpslam.language.wishes.code import Code, packed, unpacked
from lpslam.language.wishes.codes import (
    alike_key,
    all_numbers,
    asked_codes,
    board_codes,
    board_keys,
    code_of,
    codes_said,
    lettered_numbers,
    spoken_numbers,
    without_codes,
)
from lpslam.language.wishes.form import Identity, Sort, Stop
from lpslam.language.wishes.names import Names
from lpslam.language.wishes.rules import content_of, letter_of, person_of
from lpslam.language.wishes.served import AS_WELL

_SURE = 1.0  # of a code or person
_LONG_NUMBER = 3  # digits of a number that is a room's even where its board does not say so
_LONG_KEY = 2  # letters and digits of a code that may be misread
_FEWEST_OF_A_SORT = 2
_LONG_WORD = 4  # letters of a word that is more than an article
_BY_THE_WAY = frozenset({"floor", "building", "zone"})
"""What may be numbered beside what is asked for: “a toilet on level 2”."""


class Identities:
    """Looks up, among one set of landmarks, who bears a code or a person's name."""

    def __init__(self, landmarks: Sequence[Candidate], names: Names, knowledge: Knowledge) -> None:
        self._landmarks, self._names, self._knowledge = landmarks, names, knowledge
        self._by_id = {mark.id: mark for mark in landmarks}
        self.codes_of = cache(self._codes_of)

    def _codes_of(self, id_: int) -> list[Code]:
        """The codes of one board, read when they are first asked for."""
        mark = self._by_id[id_]
        return [code for text in dict.fromkeys((mark.name, *mark.lines)) for code in board_codes(text)]

    @cached_property
    def _painted(self) -> tuple[dict[int, list[Code]], dict[str, set[int]]]:
        """The codes of every board, and the boards by their codes as readers confuse them; kept where they are many."""
        texts = [dict.fromkeys((mark.name, *mark.lines)) for mark in self._landmarks]

        def made() -> dict[str, tuple[list[Any], list[str]]]:
            every = dict.fromkeys(text for lines in texts for text in lines)
            return {text: ([*map(packed, board_codes(text))], sorted(board_keys(text))) for text in every}

        read = kept_of_boards("codes", len(self._landmarks), told_by(self._landmarks), made)
        codes_of = {text: [*map(unpacked, codes)] for text, (codes, _) in read.items()}
        codes, by_key = dict[int, list[Code]](), dict[str, set[int]]()
        for mark, lines in zip(self._landmarks, texts, strict=True):
            codes[mark.id] = [code for text in lines for code in codes_of[text]]
            for key in {key for text in lines for key in read[text][1]}:
                by_key.setdefault(key, set()).add(mark.id)
        return codes, by_key

    @property
    def codes(self) -> dict[int, list[Code]]:
        """The codes of every board."""
        return self._painted[0]

    @cached_property
    def _things(self) -> frozenset[str]:
        """All that the code of some board numbers."""
        return frozenset(thing for codes in self.codes.values() for code in codes for thing in code.of)

    @cached_property
    def _lettered(self) -> frozenset[str]:
        """All that a letter alone tells apart on some board."""
        every = (code for codes in self.codes.values() for code in codes if code.number is None)
        return frozenset(thing for code in every for thing in code.of)

    @cached_property
    def _letters(self) -> frozenset[str]:
        """The letters of all boards' codes."""
        return frozenset(code.letters for codes in self.codes.values() for code in codes)

    @cached_property
    def _by_number(self) -> dict[int | None, dict[int, int]]:
        """The boards that bear a number, by their order; None: any of several numbers, or letters alone."""
        found: dict[int | None, dict[int, int]] = {}
        for row, (id_, codes) in enumerate(self.codes.items()):
            for number in {None if code.until is not None else code.number for code in codes}:
                found.setdefault(number, {})[row] = id_
        return found

    def _may_bear(self, asked: Code) -> Iterable[tuple[int, list[Code]]]:
        """The boards, in their order, that a code must be looked for on; all others bear other numbers alone."""
        if asked.number is None:
            return self.codes.items()
        ids = {**self._by_number.get(asked.number, {}), **self._by_number.get(None, {})}
        return [(ids[row], self.codes[ids[row]]) for row in sorted(ids)]

    def identified(self, stop: Stop) -> tuple[dict[int, float] | None, tuple[str, ...], str]:
        """The landmarks that bear all that must stand there; what is not heeded; and what stands on none."""
        found: dict[int, float] | None = None
        ignored: list[str] = []
        borne = [self._bearing(identity, stop.what) for identity in stop.identity]
        for identity, bearing in zip(stop.identity, borne, strict=True):
            if any(borne) and not bearing and identity.of and not self._has_such(identity):
                # “Row H, seat 14”, where no board speaks of seats.
                ignored.append(str(identity))
                continue
            is_code = identity.sort is Sort.CODE and not bearing and not self._has_such(identity)
            # Where no board bears such codes at all, “M8 bolts” are bolts.
            if (is_code or _BY_THE_WAY.intersection(identity.of)) and self._says_more(stop):
                ignored += [] if bearing else [str(identity)]
                continue
            if not bearing:
                joined = self._joined(stop)
                return (joined, tuple(ignored), "") if joined else (None, tuple(ignored), str(identity))
            found = bearing if found is None else {id_: found[id_] for id_ in found if id_ in bearing}
            if not found:
                return None, tuple(ignored), " and ".join(map(str, stop.identity))
        return found, tuple(ignored), ""

    def bearing_all(self, stop: Stop) -> dict[int, float]:
        """The landmarks that bear all codes and people of a stop."""
        bearing = [self._bearing(identity, stop.what) for identity in stop.identity]
        return dict.fromkeys(sorted(set.intersection(*map(set, bearing))), _SURE) if bearing else {}

    def differs(self, id_: int, stop: Stop) -> bool:
        """Whether a board bears codes of what a stop numbers, but not the one that is asked for."""
        asked = [code_of(each) for each in stop.identity if each.sort is Sort.CODE]
        # “Squash 9” is no Squash 1–4, whatever is numbered so.
        of_it = [
            (code, [each for each in self.codes_of(id_) if each.of & code.of or not (each.of or code.of)])
            for code in asked
        ]
        return any(same and not any(each.bears(code) for each in same) for code, same in of_it)

    def _has_such(self, identity: Identity) -> bool:
        """Whether any board bears a code of the same things, or with the same letters."""
        asked = code_of(identity)
        return bool(asked.of & self._things) or (bool(asked.letters) and asked.letters in self._letters)

    def _says_more(self, stop: Stop) -> bool:
        """Whether a stop names something else than what is numbered: “a toilet on level 2”, not “parking P7”."""
        said = content_of(without_codes(stop.what), wish_languages(stop.what, self._knowledge))
        meaning = read_question(said, self._knowledge)
        return any(weight > 0.5 for _, weight in meaning.wanted)

    def _bearing(self, identity: Identity, what: str) -> dict[int, float]:
        if identity.sort is Sort.PERSON:
            ids = self._names.persons(identity.value) or self._titled(identity.value)
            return dict.fromkeys(ids, _SURE)
        asked = code_of(identity)
        # What is painted goes before what may be misread.
        found = self._coded(asked) or self._alike(asked) or self._unclassed(asked)
        is_short = not asked.letters and len(asked.value) < _LONG_NUMBER
        # A long number is a room's even where its board does not say so; of seats and lockers it is theirs alone.
        is_strict = is_short or not (asked.letters or "room" in asked.of)
        things = self._lettered if asked.number is None else self._things if is_strict else frozenset()
        if asked.of & things:
            # Where aisles are numbered as aisles, a number that is of nothing is no aisle.
            found = {id_: score for id_, score in found.items() if score > _SURE - 0.1}
        found = self._named_so(what, found) if len(found) > 1 else found
        best = max(found.values(), default=0.0)
        return {id_: score for id_, score in found.items() if score >= best - 0.01}

    def _named_so(self, what: str, found: Mapping[int, float]) -> dict[int, float]:
        """Of landmarks that bear a code, those on which most words of the question stand as well: juzgado 3."""
        units = {unit for unit in self._knowledge.folder.units(what) if unit.isalpha() and len(unit) >= _LONG_WORD}
        said = [self._names.bearing(unit) for unit in units]
        counts = {id_: sum(id_ in bearing for bearing in said) for id_ in found}
        return {id_: score for id_, score in found.items() if counts[id_] == max(counts.values())}

    def _titled(self, name: str) -> list[int]:
        """Landmarks that bear a person of that name with any title: 王大夫 is the 王 of 王医生."""
        return [
            id_
            for id_, persons in self._persons.items()
            if any(each.startswith(name) or name.endswith(each) for each in persons)
        ]

    @cached_property
    def _persons(self) -> dict[int, list[str]]:
        """The people whom boards of scripts without spaces name by a title."""
        found: dict[int, list[str]] = {}
        for mark in self._landmarks:
            said = [person_of(text, UNSPACED) for text in (mark.name, *mark.lines) if UNSPACED_RUN.search(text)]
            found |= {mark.id: [name for name in said if name]} if any(said) else {}
        return found

    def _alike(self, asked: Code) -> dict[int, float]:
        """Landmarks whose code differs by letters that readers confuse."""
        key = alike_key(asked.value)
        ids = self._painted[1].get(key, set()) if len(key) >= _LONG_KEY else set()
        others = {
            id_ for id_ in ids if asked.of and any(code.of and not code.of & asked.of for code in self.codes_of(id_))
        }
        return dict.fromkeys(sorted(ids - others), _SURE)

    def _joined(self, stop: Stop) -> dict[int, float]:
        """“Zone C of level B1” is B1-C where no board bears them apart."""
        codes = [each.value for each in stop.identity if each.sort is Sort.CODE]
        return self._alike(Code("".join(codes), None, "", frozenset())) if len(codes) > 1 else {}

    def _unclassed(self, asked: Code) -> dict[int, float]:
        """Where nothing is numbered as what is asked for (“block 104”), a long number tells alone: Section 104."""
        is_long = len(asked.value) >= _LONG_NUMBER or bool(asked.letters and asked.number is not None)
        if not (asked.of and is_long) or asked.of & self._things:
            return {}
        return self._coded(replace(asked, of=frozenset()))

    def numbered_as_here(self, what: str) -> dict[int, float]:
        """The landmarks that bear a number which is said in words, of whatever: “two oh seven”, “bee twelve”."""
        said = (*lettered_numbers(what), *spoken_numbers(what))
        scores = next((found for code in said if (found := self._coded(code) or self._alike(code))), {})
        best = max(scores.values(), default=0.0)
        return {id_: _SURE for id_ in sorted(scores) if scores[id_] == best > 0.0}

    def held(self, what: str) -> dict[int, float]:
        """The one landmark that bears a number which is said, whatever word stands beside it."""
        said = codes_said(what)
        ids = {id_ for code in said for id_, codes in self._may_bear(code) if any(each.bears(code) for each in codes)}
        return dict.fromkeys(ids, _SURE) if len(ids) == 1 else {}

    def bearing(self, text: str, ids: Callable[[], Iterable[int]]) -> set[int]:
        """Those of some landmarks that bear a number or code which a text says; they are asked for if it says any."""
        said = [*asked_codes(text), *all_numbers(text)]
        letter = letter_of(text)
        found = {
            id_
            for id_ in (ids() if said else ())
            for code in self.codes_of(id_)
            if any(code.bears(each) for each in said)
        }
        return found | (self._names.bearing(letter).intersection(ids()) if letter else set())

    def told_apart(self, what: str, scores: Mapping[int, float], is_one: bool = False) -> dict[int, float]:
        """Of boards that serve as well as any, the one whose number, or a word of its own, is said.

        “Mine is locker 37” is Lockers 1–60, 亀の間 is 宴会場 亀; words tell only where no place, order or refusal does.
        """
        top = max(scores.values(), default=0.0)
        best = [id_ for id_, score in scores.items() if score >= AS_WELL * top]
        if len(best) < _FEWEST_OF_A_SORT:
            return dict(scores)
        told = self._of_the_number(what, best)
        told = told or (self._names.told_by(what, best) if is_one else [])
        return {id_: score for id_, score in scores.items() if not told or id_ in told or id_ not in best}

    def is_another_number(self, what: str, ids: Iterable[int]) -> bool:
        """Whether a number stands beside a word of some boards that are all numbered otherwise: tank 40, Tanks 1–16."""
        numbers = [code for code in codes_said(what) if code.number is not None]
        units = [unit for unit in self._knowledge.folder.units(what) if not is_mark(unit)] if numbers else []
        pairs = [pair for pair in pairwise(units) if any(map(str.isdigit, pair))]
        beside = set[int]().union(*(self._names.bearing(unit) for pair in pairs for unit in pair if unit.isalpha()))
        named = {id_: board_codes(self._by_id[id_].name) for id_ in ids} if beside else {}
        return bool(named) and all(
            id_ in beside and codes and not any(each.bears(code) for each in codes for code in numbers)
            for id_, codes in named.items()
        )

    def _of_the_number(self, what: str, ids: Sequence[int]) -> list[int]:
        """Those of some landmarks that bear a number which is said, where several bear any."""
        # “One” is seldom a number.
        said = codes_said(what) or [code for code in all_numbers(what) if code.number != 1]
        numbered = [id_ for id_ in ids if self.codes_of(id_)] if said else []
        if len(numbered) < _FEWEST_OF_A_SORT:
            return []
        bearing = ([id_ for id_ in numbered if any(e.bears(code) for e in self.codes_of(id_))] for code in said)
        return next((found for found in bearing if found), [])

    def _coded(self, asked: Code) -> dict[int, float]:
        """Landmarks that bear a code: surest the very one, of what is asked for."""
        found: dict[int, float] = {}
        for id_, codes in self._may_bear(asked):
            fits = [code for code in codes if code.bears(asked)]
            if fits:
                is_same = any(code.of & asked.of for code in fits) or not asked.of
                is_exact = any(code.until is None and code.number == asked.number for code in fits)
                # What a board is called goes before what it lists: Gallery 6 before the floor guide.
                is_called = not set(fits).isdisjoint(board_codes(self._by_id[id_].name))
                found[id_] = _SURE - 0.1 * (not is_same) - 0.05 * (not is_exact) - 0.02 * (not is_called)
        return found
