"""Whether a question asks for a thing whose word is not known.

“Where can I eat haggis?” must not be answered with any place to eat: what stands where the thing to eat or to buy
stands is looked at, and when no table knows it, the answer is none.
"""

from collections.abc import Sequence

from lpslam.language.tables.inflection import known_form
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import Span, is_mark, is_unspaced

# On which side of the verb stands what is eaten or drunk.
_AFTER_VERB = frozenset({"en", "es", "fr", "de", "zh"})
_BEFORE_VERB = frozenset({"ja", "ko", "de"})
_PARTICLES = frozenset("をがはの을를이가은는")


def asks_for_unknown(units: Sequence[str], spans: Sequence[Span[Meaning]], language: str, knowledge: Knowledge) -> bool:
    """Whether the place beside a verb such as “eat”, “drink” or “buy” holds a word that no table has."""
    covered = {at for span in spans for at in range(span.start, span.end)}
    for span in spans:
        if span.value.role != "means" or any(concept not in knowledge.general for concept, _ in span.value.concepts):
            continue
        places = [_right(units, span.end, knowledge.articles)] if language in _AFTER_VERB else []
        if language in _BEFORE_VERB:
            places.append(_left(units, span.start))
        for at in places:
            if at is not None and at not in covered and _is_thing(units[at], language, knowledge):
                return True
    return False


def _right(units: Sequence[str], at: int, articles: frozenset[str]) -> int | None:
    """The unit at or after `at` that is no article."""
    while at < len(units) and units[at] in articles:
        at += 1
    return at if at < len(units) and not is_mark(units[at]) else None


def _left(units: Sequence[str], at: int) -> int | None:
    """The unit before, over a particle of Japanese or Korean."""
    if at > 0 and units[at - 1] in _PARTICLES:
        at -= 1
    return at - 1 if at > 0 and not is_mark(units[at - 1]) else None


def _is_thing(unit: str, language: str, knowledge: Knowledge) -> bool:
    common = knowledge.common[language]
    if is_unspaced(unit):
        return unit not in common
    if unit in common or unit in knowledge.common["en"] or len(unit) < 4 or unit.endswith("ly"):
        return False
    return known_form(unit, language, knowledge) is None
