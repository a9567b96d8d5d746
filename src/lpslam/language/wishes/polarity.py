"""What a text wants and what it refuses, clause by clause: “shoes, not for running”, “Glücksspiel ja, Rauchen nein”.

A text is cut at its marks. A clause that begins with a negation and has no verb of its own (“not the deep one”), or
ends with one (“swimming is out”, 辣的不行), refuses what else it says. What is said after a refusal, where something
was wanted before it, is its reason, unless it asks.
"""

import re
from collections.abc import Iterator
from functools import cache

from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.patterns import ready
from lpslam.language.wishes.rules import content_left, each_of, letter_of, rules_of

_ENDS = " .。!！?？,，、;；:¿¡…"


@cache
def _pattern(language: str, name: str) -> re.Pattern[str]:
    return ready(read_table(f"wishes/{language}.json")["polarity"][name], re.IGNORECASE)


def parted_by_clauses(text: str, language: str) -> tuple[str, list[str]] | None:
    """Return what a text wants, and each thing that it refuses; None where no clause of it refuses anything."""
    rules = rules_of(language)
    wanted: list[str] = []
    refused: list[str] = []
    for clause, out in _clauses(text, language):
        if out:
            said = (each for each in each_of(out) if not _pattern(language, "rest").match(each))
            refused += [each for each in said if content_left(each, rules) or letter_of(each)]
        elif not (wanted and refused) or _pattern(language, "keeps").search(clause):
            wanted.append(_pattern(language, "yes").sub("", clause))
    what = " ".join(wanted)
    return (what, refused) if refused and content_left(what, rules) else None


def _clauses(text: str, language: str) -> Iterator[tuple[str, str]]:
    """The clauses of a text, each with what it refuses; “Flowers? No.” is one."""
    for piece in _pattern(language, "cut").split(re.sub(r"\? (?=(?:no|nein|non)\b)", " ", text, flags=re.IGNORECASE)):
        clause = piece.strip(_ENDS)
        found = _pattern(language, "starts").match(clause) or _pattern(language, "ends").match(clause)
        if clause:
            yield clause, found["not"].strip(_ENDS) if found else ""
