"""The clauses of a question, and what their words do beside the phrases that mean something."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import Span, is_mark, is_unspaced

BREAKING_MARKS = frozenset(",.;:!?，。；：！？…")
_TELLING = 2  # words beside a name that make a statement of it


@dataclass(frozen=True, slots=True)
class Clause:
    """Phrases of one thought, and what the words beside them do.

    Whether they ask for something and deny something, how many there are beside what is named; whether they are thrown
    in as a question (“Porridge again?”), list one thing or another, and end in what no table knows; and whether
    anything between the marks around them asks.
    """

    spans: list[Span[Meaning]]
    asks: bool
    denies: bool
    says: int
    echoes: bool
    lists: bool
    trails: bool
    is_near_asking: bool
    units: range

    @property
    def tells(self) -> bool:
        """Whether it makes a statement of what it names."""
        return self.says >= _TELLING


def clauses_of(
    units: Sequence[str], spans: Sequence[Span[Meaning]], language: str, knowledge: Knowledge
) -> list[Clause]:
    """Group phrases into clauses: a refusal does not reach over a comma or a “but”."""
    # A Chinese list has 、 between its items, where Japanese has it between clauses.
    breaking = BREAKING_MARKS if language == "zh" else BREAKING_MARKS | {"、"}
    clauses: list[list[Span[Meaning]]] = [[]]
    starts = [0]
    marks = [at for at, unit in enumerate(units) if unit in breaking]
    for before, span in zip((None, *spans), spans, strict=False):
        while marks and marks[0] < span.start:
            starts.append(marks.pop(0) + 1)
            clauses.append([])
        if span.value.role != "break":
            clauses[-1].append(span)
        elif before is not None and before.end == span.start and _goes_on(before, span, knowledge):
            # “Don't recommend me” refuses what comes after it.
            clauses[-1][-1] = Span(before.start, span.end, before.key, Meaning("refuse_before"))
        else:
            if clauses[-1]:
                starts.append(span.start)
                clauses.append([])
            if span.key in knowledge.turning:
                clauses[-1] = [span]
    starts += [at + 1 for at in marks]
    clauses += [[] for _ in marks]
    ends = [*starts[1:], len(units)]
    words = _Words(units, spans, language, knowledge)
    parts = zip(clauses, starts, ends, strict=True)
    return [words.clause(clause, start, end) for clause, start, end in parts if clause or words.puzzles(start, end)]


class _Words:
    """What the words of a question do beside the phrases that mean something."""

    def __init__(
        self, units: Sequence[str], spans: Sequence[Span[Meaning]], language: str, knowledge: Knowledge
    ) -> None:
        self._units = units
        self._asking = places_of(knowledge.wishing[language], units, knowledge.negating[language])
        covered = {at for span in spans for at in range(span.start, span.end)}
        said = [span for span in spans if span.value.role in ("means", "name")]
        self._denying = places_of(knowledge.negating[language], units) - {
            at for span in said for at in range(span.start, span.end)
        }
        self._listing = {at for at, unit in enumerate(units) if unit in knowledge.both} - covered
        known = knowledge.common[language]
        self._puzzling = {
            at
            for at, unit in enumerate(units)
            if at not in covered and unit not in known and not is_mark(unit) and not unit.isdigit()
        }

    def clause(self, spans: list[Span[Meaning]], start: int, end: int) -> Clause:
        inside = range(start, end)
        return Clause(
            spans,
            not self._asking.isdisjoint(inside),
            not self._denying.isdisjoint(inside),
            _words_beside(spans, self._units[start:end]),
            end > start and self._units[end - 1 : end + 1][-1] in ("?", "？"),
            not self._listing.isdisjoint(inside),
            bool(spans) and not self._puzzling.isdisjoint(range(spans[-1].end, end)),
            not self._asking.isdisjoint(between_marks(start, self._units)),
            inside,
        )

    def puzzles(self, start: int, end: int) -> bool:
        """Whether a stretch of units holds a word that no table knows."""
        unknown = [at for at in range(start, end) if at in self._puzzling and at not in self._asking]
        return bool(unknown) and (not is_unspaced(self._units[unknown[0]]) or len(unknown) > 1)


def between_marks(at: int, units: Sequence[str]) -> range:
    """The units around one up to the nearest marks on either side; a mark itself ends what stands before it."""
    before = next((other for other in range(at - 1, -1, -1) if units[other] in BREAKING_MARKS), -1)
    after = next((other for other in range(at, len(units)) if units[other] in BREAKING_MARKS), len(units))
    return range(before + 1, after)


def _goes_on(before: Span[Meaning], asking: Span[Meaning], knowledge: Knowledge) -> bool:
    """Whether a refusal and the words of asking right after it are one: 不要带我去, “don't take me to”."""
    role = before.value.role
    return role == "refuse_before" or (role == "refuse_either" and asking.key in knowledge.asking)


def places_of(phrases: frozenset[str], units: Sequence[str], without: frozenset[str] = frozenset()) -> set[int]:
    """Where any of some phrases begins, not right beside one of `without`: 想, but not 不想, nor “kann ich nicht”."""
    sizes = _sizes(phrases)
    return {
        at
        for at, unit in enumerate(units)
        if unit in sizes
        and not (at and units[at - 1] in without)
        and any(
            " ".join(units[at : at + size]) in phrases and not without.intersection(units[at + size : at + size + 1])
            for size in sizes[unit]
        )
    }


@lru_cache(maxsize=64)
def _sizes(phrases: frozenset[str]) -> Mapping[str, frozenset[int]]:
    """How many units the phrases have that begin with a unit."""
    found: dict[str, set[int]] = {}
    for phrase in phrases:
        found.setdefault(phrase.partition(" ")[0], set()).add(phrase.count(" ") + 1)
    return {unit: frozenset(sizes) for unit, sizes in found.items()}


def _words_beside(clause: Sequence[Span[Meaning]], units: Sequence[str]) -> int:
    """How many words a clause has beside its names and kinds; of a script without spaces three letters make two."""
    named = sum(span.end - span.start for span in clause if span.value.role in ("name", "means"))
    words = [unit for unit in units if not is_mark(unit)]
    return len(words) - named - any(map(is_unspaced, words))
