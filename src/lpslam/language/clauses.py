"""Clauses of a question, and what each of them refuses (choosing, III-I).

A refusal in front reaches forward to the end of its clause, one behind reaches back over what is linked; a clause that
is nothing but a refusal (“no thanks”, 受不了) speaks of the one before it.
"""

from collections.abc import Sequence

from lpslam.language.knowledge import Knowledge, Meaning
from lpslam.language.words import Span

NEXT_TO = 3  # units between two phrases that speak of one another
_BREAKING_MARKS = frozenset(",.;:!?，。；：！？…")
_VERB_LAST = frozenset({"ja", "ko"})  # languages whose refusals always stand behind
# Asked for by its kind, a restaurant is refused by what it serves.
_PLAIN_KINDS = frozenset({"amenity/restaurant"})

Clause = list[Span[Meaning]]
Told = list[tuple[Span[Meaning], bool]]


def clauses_of(
    units: Sequence[str], spans: Sequence[Span[Meaning]], language: str, knowledge: Knowledge
) -> list[Clause]:
    """Group phrases into clauses: a refusal does not reach over a comma or a “but”."""
    # A Chinese list has 、 between its items, where Japanese has it between clauses.
    breaking = _BREAKING_MARKS if language == "zh" else _BREAKING_MARKS | {"、"}
    clauses: list[Clause] = [[]]
    marks = [at for at, unit in enumerate(units) if unit in breaking]
    for before, span in zip((None, *spans), spans, strict=False):
        while marks and marks[0] < span.start:
            marks.pop(0)
            clauses.append([])
        if span.value.role == "break":
            if span.key in knowledge.turning:
                clauses.append([span])
                continue
            if before is not None and before.end == span.start and _goes_on(before, span, knowledge):
                # “Don't recommend me” refuses what comes after it.
                clauses[-1][-1] = Span(before.start, span.end, before.key, Meaning("refuse_before"))
            else:
                clauses.append([])
        else:
            clauses[-1].append(span)
    return [clause for clause in clauses if clause]


def _goes_on(before: Span[Meaning], asking: Span[Meaning], knowledge: Knowledge) -> bool:
    """Whether a refusal and the words of asking right after it are one: 不要带我去, “don't take me to”."""
    role = before.value.role
    return role == "refuse_before" or (role == "refuse_either" and asking.key in knowledge.asking)


def told_in(clauses: Sequence[Clause], language: str, knowledge: Knowledge) -> list[Told]:
    """Return for each clause the phrases that mean something, each with whether it is refused.

    Beside a refused dish, “eat” itself is not refused.
    """
    refused = [_refused_within(clause, language, knowledge) for clause in clauses]
    for at in range(1, len(clauses)):
        if _refuses_back(clauses[at], language):
            whole = language in _VERB_LAST
            start = 0 if whole else _linked_from(clauses[at - 1], 0, len(clauses[at - 1]))
            refused[at - 1][start:] = [True] * (len(clauses[at - 1]) - start)
    told = [_told(clause, flags, knowledge) for clause, flags in zip(clauses, refused, strict=True)]
    for at in range(1, len(clauses)):
        # “I need shoes, but Bata's are for aunties.”
        wants = any(not no and span.value.role == "means" for each in told[:at] for span, no in each)
        if wants and clauses[at][0].key in knowledge.turning and all(span.value.role == "name" for span, _ in told[at]):
            told[at] = [(span, True) for span, _ in told[at]]
    return told


def _refused_within(clause: Clause, language: str, knowledge: Knowledge) -> list[bool]:
    refused = [False] * len(clause)
    ahead = False
    since = int(clause[0].value.role == "break")
    for at, span in enumerate(clause):
        role = span.value.role
        if role == "refuse_either":
            # 火锅不要 refuses what stands before, 不要火锅 what comes after.
            follows = at + 1 < len(clause) and clause[at + 1].start - span.end <= 1
            role = "refuse_before" if follows else "refuse_after"
        elif role == "refuse_before" and at > since and at + 1 == len(clause) and clause[at - 1].end == span.start:
            # “McDonald's no, gracias.”
            role = "refuse_after"
        if role == "refuse_before" or (role == "refuse_after" and at == since and language not in _VERB_LAST):
            ahead = True
        elif role == "refuse_after":
            start = _linked_from(clause, since, at)
            refused[start:at] = [True] * (at - start)
            since, ahead = at, False
        refused[at] = refused[at] or ahead
    if any(span.value.role == "past" for span in clause):
        # What was eaten yesterday is not what is wanted today.
        refused = [no or _is_meal(span, knowledge) for span, no in zip(clause, refused, strict=True)]
    return refused


def _refuses_back(clause: Clause, language: str) -> bool:
    """Whether a clause refuses what the one before it speaks of."""
    first = clause[1 if clause[0].value.role == "break" and len(clause) > 1 else 0]
    if first.value.role not in ("refuse_after", "refuse_either"):
        return False
    says_more = any(span.value.role in ("means", "name", "refuse_before", "neutral") for span in clause)
    return not says_more or (language in _VERB_LAST and first.value.role == "refuse_after")


def _linked_from(clause: Sequence[Span[Meaning]], since: int, at: int) -> int:
    """Where a refusal that stands behind begins: “coffee, but the queue at Costa is too long” wants the coffee."""
    start = at
    while start > since and (start == at or clause[start].start - clause[start - 1].end <= NEXT_TO):
        start -= 1
    return start


def _told(clause: Clause, refused: Sequence[bool], knowledge: Knowledge) -> Told:
    told = [(span, no) for span, no in zip(clause, refused, strict=True) if span.value.role in ("means", "name")]
    if any(no and not _is_plain(span, knowledge) for span, no in told):
        told = [(span, no and not _is_plain(span, knowledge)) for span, no in told]
    return told


def _is_meal(span: Span[Meaning], knowledge: Knowledge) -> bool:
    return span.value.role == "means" and any(is_eaten(concept, knowledge) for concept, _ in span.value.concepts)


def is_eaten(concept: str, knowledge: Knowledge) -> bool:
    """Whether a concept is food or drink of some sort."""
    return any(knowledge.instead.get(above) in ("food", "drink") for above in knowledge.above(concept))


def is_general(span: Span[Meaning], knowledge: Knowledge) -> bool:
    """Whether a phrase says no more than “eat”, “buy” or “a place”."""
    return span.value.role == "means" and all(concept in knowledge.general for concept, _ in span.value.concepts)


def _is_plain(span: Span[Meaning], knowledge: Knowledge) -> bool:
    return is_general(span, knowledge) or (
        span.value.role == "means" and all(concept in _PLAIN_KINDS for concept, _ in span.value.concepts)
    )
