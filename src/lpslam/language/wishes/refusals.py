"""Wishes that refuse something: what serves the one part of them, less what serves the other."""

import re

from lpslam.language.tables.lexicon import read_table
from lpslam.language.wishes.rules import content_left, rules_of

ALIKE = 0.9  # of the best score: what serves what is refused, or what is left of what is wanted, as well
LEAST_REFUSED = 0.4  # probability that a place is what is refused, from which it is left out
_EACH = re.compile(
    r"[,，、;] ?|(?: |^)(?:ni|nor|or|noch|und|oder|et|ou|y|o|and)(?: |$)|[和或とや]|也(?=不要|别)|(?:이나|하고) "
)
_CAPITAL = re.compile(r"(?<![^\W_\u2e80-\uffff])[A-Z](?![^\W_\u2e80-\uffff]|['’])")
_BRIEF = 9  # letters of what is refused by a letter alone: “el A no”
_ENDS = " .。!！?？,，、;；:"
ALL_REFUSED = "all that serves is refused"
_NO = re.compile(read_table("patterns.json")["no"])
"""A negation said once more: “nothing frozen and nothing with gluten”."""


def parted(text: str, language: str) -> tuple[str, list[str]] | None:
    """Return what a text wants, and each thing that it refuses; None where no word parts them."""
    rules = rules_of(language)
    said = text.strip(_ENDS)
    found = rules.first("refusals", said) or rules.first("exclusions", said)
    if found is None:
        return None
    groups = found[1].groupdict()
    # “Clothes, not for women but for men”: what is said after the refusal is wanted as well.
    what = " ".join(each.strip(_ENDS) for each in (groups["what"], groups.get("rest", "")) if each)
    out = groups["not"].strip(_ENDS)
    refused = [each for each in each_of(out) if content_left(each, rules) or letter_of(each)]
    return (what, refused) if refused and content_left(what, rules) else None


def letter_of(text: str) -> str:
    """Return the capital that is all that a text names: “the A”, “el A no”."""
    capitals = _CAPITAL.findall(text)
    return capitals[0].casefold() if len(capitals) == 1 and len(text) <= _BRIEF else ""


def each_of(out: str) -> list[str]:
    """Each thing that a text refuses, without the words that say so."""
    named = (_NO.sub("", each.strip(_ENDS)).strip(_ENDS) for each in _EACH.split(out) if each)
    return [each for each in named if each]
