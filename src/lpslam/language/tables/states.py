"""What is wrong with what: “the heel of my shoe came off” names no service, but a thing and its state do together.

The tables (`lexicon/states.json`) name things and states in every language, and what someone wants whose thing is in
that state; so a few words of each make hundreds of sentences understood.
"""

from bisect import bisect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, product

from lpslam.language.tables.words import PhraseTable, Span, is_unspaced, longest_phrases

_SENTENCE_ENDS = frozenset(".?!。？！;；")
_LONGEST = 8  # units of a state
_FARTHEST_WORDS, _FARTHEST_LETTERS = 9, 16  # between a thing and its state
_TOGETHER_WORDS, _TOGETHER_LETTERS = 14, 24  # from the first of words that mean something together to the last

_BEGINNING = 4  # letters by which words that mean something together are looked up, the space before them among these

Names = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Trouble:
    """A want that a thing and its state make together, and the units that say so."""

    concept: str
    units: frozenset[int]


@dataclass(frozen=True)
class StateTables:
    """Phrases of one language: for things, for states, and for being at home with what was left there.

    `apart` are beginnings of words that mean something together (the rows of `concepts.py` with `+`).
    """

    things: PhraseTable[Names]
    states: PhraseTable[Names]
    at_home: PhraseTable[Names]
    together: Mapping[tuple[str, str], str]
    apart: Sequence[tuple[tuple[str, ...], str]]

    def apart_in(self, text: str) -> list[tuple[tuple[str, ...], str]]:
        """The rows of `apart` whose first part may stand in a text, by how it begins, in their order."""
        lengths = range(1, _BEGINNING + 1)
        begun = {text[at : at + length] for length in lengths for at in range(len(text) - length + 1)}
        known = begun & self._apart_by_beginning.keys()
        return [self.apart[row] for row in sorted(row for each in known for row in self._apart_by_beginning[each])]

    @cached_property
    def _apart_by_beginning(self) -> dict[str, list[int]]:
        rows: dict[str, list[int]] = {}
        for row, (parts, _) in enumerate(self.apart):
            rows.setdefault(parts[0][:_BEGINNING], []).append(row)
        return rows

    @cached_property
    def words(self) -> frozenset[str]:
        """The words of all phrases for things and states."""
        return frozenset(word for phrase in (*self.things, *self.states) for word in phrase.split())


def troubles_in(units: Sequence[str], tables: StateTables) -> list[Trouble]:
    """Return the wants of a question's things and states, the closest pairs first; a pair uses its words up."""
    things = longest_phrases(units, (tables.things,))
    states = list(_everywhere(units, tables.states))
    is_at_home = says_at_home(units, tables)
    pairs = sorted(
        (_gap(thing, state), thing.start, state.start, concept, thing, state)
        for thing, state in product(things, states)
        for concept in _wants(thing, state, tables)
        if _is_close(thing, state, units) and not (concept == "lost_item" and is_at_home)
    )
    found: dict[str, Trouble] = {}
    used: set[int] = set()
    for _, _, _, concept, thing, state in pairs:
        own = frozenset((*range(thing.start, thing.end), *range(state.start, state.end)))
        if concept not in found and not (used & own):
            found[concept] = Trouble(concept, own)
            used |= own
    return list(found.values())


def together_in(units: Sequence[str], tables: StateTables) -> list[Trouble]:
    """Return what words mean together wherever they stand in a question, “borrow … wheelchair”, and which say so."""
    is_spaced = any(parts[0].startswith(" ") for parts, _ in tables.apart[:1])
    pieces = [f" {unit}" if is_spaced else unit for unit in units]
    text, ends = "".join(pieces) + " ", list(accumulate(map(len, pieces)))
    found: dict[str, set[int]] = {}
    for parts, concept in tables.apart_in(text):
        if all(part in text for part in parts):
            starts = [text.index(part) + is_spaced for part in parts]
            stops = [start + len(part.strip()) - 1 for start, part in zip(starts, parts, strict=True)]
            spans = zip(starts, stops, strict=True)
            own = {at for start, stop in spans for at in range(bisect(ends, start), bisect(ends, stop) + 1)}
            if max(own) - min(own) <= (_TOGETHER_WORDS if is_spaced else _TOGETHER_LETTERS):
                found.setdefault(concept, set()).update(own)
    return [Trouble(concept, frozenset(own)) for concept, own in found.items()]


def says_at_home(units: Sequence[str], tables: StateTables) -> bool:
    """Whether what is missing lies at home: then it is bought anew, not asked for where lost things are kept."""
    return any(True for _ in _everywhere(units, tables.at_home))


def _wants(thing: Span[Names], state: Span[Names], tables: StateTables) -> list[str]:
    """What the pair stands for; the first of a thing's meanings that the state goes with."""
    wants = (tables.together.get(pair) for pair in product(thing.value, state.value))
    return [want for want in wants if want is not None][:1]


def _everywhere(units: Sequence[str], table: PhraseTable[Names]) -> Iterator[Span[Names]]:
    """Every phrase of the table at every place, also where they overlap: “won't turn on” has no work of “on” in it."""
    for at in range(len(units)):
        for size in sorted(table.sizes(units, at), reverse=True):
            key = " ".join(units[at : at + size])
            if size <= min(len(units) - at, _LONGEST) and key in table:
                yield Span(at, at + size, key, table[key])
                break


def _gap(one: Span[Names], other: Span[Names]) -> int:
    return max(other.start - one.end, one.start - other.end, 0)


def _is_close(thing: Span[Names], state: Span[Names], units: Sequence[str]) -> bool:
    if max(thing.start, state.start) < min(thing.end, state.end):
        return False
    first, last = sorted((thing, state), key=lambda span: span.start)
    between = units[first.end : last.start]
    farthest = _FARTHEST_LETTERS if is_unspaced(thing.key) else _FARTHEST_WORDS
    return len(between) <= farthest and not _SENTENCE_ENDS.intersection(between)
