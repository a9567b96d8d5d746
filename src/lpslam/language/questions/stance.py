"""What of a question is wanted, what is refused, and what is only said by the way (choosing, III-I).

A refusal in front reaches forward to the end of its clause, one behind reaches back over what is linked; a clause that
is nothing but a refusal (“no thanks”, 受不了) speaks of the one before it. Where one clause asks, another that only
tells is no wish: who says what Zara is like and then asks for a dress wants another shop.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

from lpslam.language.questions.wanted import (
    is_drink_of_cafes,
    is_general,
    is_meal,
    is_modifier,
    is_place,
    is_plain,
    is_vague,
    is_ware,
)
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import Span, is_mark, is_unspaced

BREAKING_MARKS = frozenset(",.;:!?，。；：！？…")
_TELLING = 2  # words beside a name that make a statement of it
NEXT_TO = 3  # units between two phrases that speak of one another
_VERB_LAST = frozenset({"ja", "ko"})  # languages whose refusals always stand behind
_WHOLE_BACK = _VERB_LAST | {"zh"}  # whose short clauses are refused as a whole
_PASTIMES = frozenset({"entertainment", "children_play", "rest"})


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


class Stand(Enum):
    """How the speaker stands to what is said."""

    WANTED = "wanted"
    REFUSED = "refused"
    ASIDE = "aside"


Told = list[tuple[Span[Meaning], Stand]]


def told_in(
    clauses: Sequence[Clause], units: Sequence[str], language: str, knowledge: Knowledge, wants_another: bool = False
) -> list[Told]:
    """Return for each clause the phrases that mean something, each with how the speaker stands to it.

    Beside a refused dish, “eat” itself is not refused.

    Args:
        clauses: as `clauses_of` gives them.
        units: of the question.
        language: of the question.
        knowledge: the tables.
        wants_another: whether the question asks for something else than it names.
    """
    stands = [_stands_within(clause.spans, units, language, knowledge) for clause in clauses]
    for at in range(1, len(clauses)):
        before = clauses[at - 1].spans
        is_settled = Stand.REFUSED in stands[at - 1] and language not in _WHOLE_BACK
        if _refuses_back(clauses[at], language) and not is_settled:
            stands[at - 1] = [Stand.REFUSED] * len(before)
        elif stands[at - 1][-1:] == [Stand.REFUSED] and _goes_on_listing(clauses[at], knowledge):
            # “No pizza, burgers or kebab.”
            stands[at] = [Stand.REFUSED] * len(stands[at])
    told = [_told(clause.spans, each, knowledge) for clause, each in zip(clauses, stands, strict=True)]
    for at in range(1, len(clauses)):
        # “I need shoes, but Bata's are for aunties.”
        wants = any(_is_wanted(one) and one[0].value.role == "means" for each in told[:at] for one in each)
        turns = any(span.key in knowledge.turning for span in clauses[at].spans[:1])
        if wants and turns and all(span.value.role == "name" for span, _ in told[at]):
            told[at] = [(span, Stand.REFUSED) for span, _ in told[at]]
    return _without_telling(clauses, told, knowledge, wants_another)


def spilled(
    spans: Sequence[Span[Meaning]], stains: Sequence[frozenset[int]], units: Sequence[str], knowledge: Knowledge
) -> set[int]:
    """Starts of the drinks and dishes that made a stain: “I poured coffee over my shirt”."""
    reach = {at for stain in stains for at in between_marks(min(stain), units)}
    return {
        span.start for span in spans if span.start in reach and (is_meal(span, knowledge) or is_drink_of_cafes(span))
    }


def _goes_on_listing(clause: Clause, knowledge: Knowledge) -> bool:
    return (
        clause.lists
        and not clause.asks
        and all(
            span.value.role == "name" or is_meal(span, knowledge) or (span.value.role == "means" and not clause.tells)
            for span in clause.spans
        )
    )


def _without_telling(
    clauses: Sequence[Clause], told: Sequence[Told], knowledge: Knowledge, wants_another: bool
) -> list[Told]:
    """Where one clause asks for something, the others only tell: of places not wanted, and of things by the way."""
    asking = [clause.asks for clause in clauses]
    if clauses and not any(asking):
        # Without a word that asks, the last thing that is said is what is wanted.
        asking[-1] = True
    asked = _Asked(clauses, told, asking, knowledge, wants_another)
    return [
        each
        if asking[at]
        else [
            (span, asked.stand(at, span, before[0] if before else None) if stand is Stand.WANTED else stand)
            for before, (span, stand) in zip((None, *each), each, strict=False)
        ]
        for at, each in enumerate(told)
    ]


class _Asked:
    """What the clauses that ask want, and how the speaker stands to what the others tell of."""

    def __init__(
        self,
        clauses: Sequence[Clause],
        told: Sequence[Told],
        asking: Sequence[bool],
        knowledge: Knowledge,
        wants_another: bool,
    ) -> None:
        self._clauses = clauses
        self._knowledge = knowledge
        self._wants_another = wants_another
        spans = [
            span
            for is_asking, each in zip(asking, told, strict=True)
            for span, stand in each
            if is_asking and stand is Stand.WANTED and span.value.role == "means"
        ]
        self._concepts = {concept for span in spans for concept, _ in span.value.concepts}
        # Who asks for a playground by that word wants no cinema, though the child is bored.
        self._names_a_place = any(is_place(span) for span in spans)
        self._is_special = any(not is_vague(span, knowledge) for span in spans)
        self._diets = {*knowledge.instead_of.values(), *knowledge.refusing}
        self._is_asked = any(clause.asks for clause in clauses)
        self._wants_anything = bool(spans)

    def stand(self, at: int, span: Span[Meaning], before: Span[Meaning] | None) -> Stand:
        """How the speaker stands to a phrase of a clause that does not ask; `before` is what is said before it."""
        clause, concepts = self._clauses[at], {concept for concept, _ in span.value.concepts}
        if span.value.role == "name":
            return Stand.REFUSED if clause.tells and self._wants_anything else Stand.WANTED
        is_past = any(other.value.role == "past" for other in clause.spans)
        if (
            not (self._wants_anything or self._wants_another)
            # “I was X-rayed yesterday” asks for no X-ray, whatever is asked for.
            or not (self._is_asked or (is_past and not clause.echoes))
            or clause.is_near_asking
            or is_plain(span, self._knowledge)
            or not self._concepts.isdisjoint(concepts)
        ):
            return Stand.WANTED
        is_doubted = clause.denies or (clause.echoes and (bool(self._concepts) or self._wants_another))
        # A brand's coffee says nothing against coffee, and “no meat” is a wish.
        is_named = before is not None and before.value.role == "name" and span.start - before.end <= 1
        is_spared = is_named or (concepts <= self._diets and not is_place(span))
        if is_doubted and not is_spared and (is_place(span) or is_meal(span, self._knowledge)):
            return Stand.REFUSED
        is_by_the_way = self._is_special and (
            (self._names_a_place and concepts <= _PASTIMES) or is_place(span) or is_ware(span, self._knowledge)
        )
        return Stand.ASIDE if is_by_the_way else Stand.WANTED


def _stands_within(
    clause: Sequence[Span[Meaning]], units: Sequence[str], language: str, knowledge: Knowledge
) -> list[Stand]:
    stands = [Stand.WANTED] * len(clause)
    ahead = is_lacking = False
    since = int(bool(clause) and clause[0].value.role == "break")
    for at, span in enumerate(clause):
        role = span.value.role
        if role == "refuse_either":
            # 火锅不要 refuses what stands before, 不要火锅 what comes after.
            follows = at + 1 < len(clause) and clause[at + 1].start - span.end <= 1
            role = "refuse_before" if follows else "refuse_after"
        elif role == "refuse_before" and at > since and at + 1 == len(clause) and _stands_last(clause, units):
            # “McDonald's no, gracias”, “gafas de ver no”.
            role = "refuse_after"
        if role == "refuse_before" and is_lacking and span.key in knowledge.both:
            # “There is no milk nor eggs”: both are missing.
            continue
        if role == "refuse_before" or (role == "refuse_after" and at == since and language not in _VERB_LAST):
            ahead = True
        elif role in ("refuse_after", "refuse_back"):
            stands[since:at] = [Stand.REFUSED] * (at - since)
            since, ahead = at, False
        elif role == "neutral":
            # “Not from Rewe, and they have run out of water.”
            ahead, is_lacking = False, True
        if ahead:
            stands[at] = Stand.REFUSED
    if any(span.value.role == "past" for span in clause):
        # What was eaten yesterday is not what is wanted today.
        stands = [
            Stand.REFUSED
            if (is_meal(span, knowledge) and not is_general(span, knowledge)) or is_drink_of_cafes(span)
            else stand
            for span, stand in zip(clause, stands, strict=True)
        ]
    return stands


def _stands_last(clause: Sequence[Span[Meaning]], units: Sequence[str]) -> bool:
    """Whether the last phrase of a clause, a refusal, is right behind another or its last words at all."""
    before, last = clause[-2:]
    is_end = last.end == len(units) or is_mark(units[last.end])
    return before.end == last.start or (is_end and last.start - before.end <= NEXT_TO)


def _refuses_back(clause: Clause, language: str) -> bool:
    """Whether a clause refuses what the one before it speaks of."""
    spans = [span for span in clause.spans if span.value.role != "break"] or clause.spans
    role = spans[0].value.role if spans else ""
    if role == "refuse_back":
        # “Anything but that.”
        return True
    if role not in ("refuse_after", "refuse_either") or (clause.trails and language not in _VERB_LAST):
        return False
    says_more = any(span.value.role in ("means", "name", "refuse_before", "neutral") for span in spans)
    return not says_more or (language in _VERB_LAST and role == "refuse_after")


def _told(clause: Sequence[Span[Meaning]], stands: Sequence[Stand], knowledge: Knowledge) -> Told:
    told = [(span, stand) for span, stand in zip(clause, stands, strict=True) if span.value.role in ("means", "name")]
    refused = [span for span, stand in told if stand is Stand.REFUSED]
    for spared in (is_plain, is_modifier):
        if any(not spared(span, knowledge) for span in refused):
            told = [
                (span, Stand.WANTED if stand is Stand.REFUSED and spared(span, knowledge) else stand)
                for span, stand in told
            ]
    return told


def _is_wanted(one: tuple[Span[Meaning], Stand]) -> bool:
    return one[1] is Stand.WANTED
