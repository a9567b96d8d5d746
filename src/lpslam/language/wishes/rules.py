"""Rules of a language as rows of a table, read from `data/wishes/LANGUAGE.json`; one evaluator for all of them.

A row has a pattern of its own (`when`), or words (`said`) that stand in each of the language's `shapes`. `<next>` in a
pattern is the part of that name; `<ordinal>` is every ordinal number of the language.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain
from typing import Any

from lpslam.language.sanitise import clean_text
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.patterns import keep_ready, ready, standing
from lpslam.language.wishes.form import Ask, Which
from lpslam.language.wishes.numerals import ordinals

_NAMED = standing(r"(?<!\(\?P)<(\w+)>")
LONGEST = 400  # letters of a question
_ENDS = " .。!！?？,，、;；¿¡"
_CASED = "(?-i:"  # a pattern with it heeds case in part
_TABLES = ("asks", "orders", "sequences", "relations", "exclusions", "refusals", "among", "persons", "cues")
_WORDS = (
    *("here", "previous", "filler", "any", "spots", "meeting", "inside", "unsaid", "between", "alternative_ends"),
    *("joints", "ordering", "resumed"),
)
_ANY_CASE = re.IGNORECASE
_DEEPEST = 3  # parts within parts
ALIKE = 0.9  # of the best score: what serves what is refused, or what is left of what is wanted, as well
LEAST_REFUSED = 0.4  # probability that a place is what is refused, from which it is left out
_EACH = standing(
    r"[,，、;] ?|(?<![何誰])でも|(?: |^)(?:ni|nor|or|noch|und|oder|et|ou|y|o|and)(?: |$)"
    r"|(?<=[^、,])和(?![食室式風菓服])|[或とや]|也(?=不|别)|(?:이나|하고) "
)
_CAPITAL = standing(r"(?<![^\W_\u2e80-\uffff])[A-Z](?![^\W_\u2e80-\uffff]|['’])")
_BRIEF = 9  # letters of what is refused by a letter alone: “el A no”
_PART_ENDS = " .。!！?？,，、;；:"
ALL_REFUSED = "all that serves is refused"
_NO = standing(read_table("patterns.json")["no"])
"""A negation said once more: “nothing frozen and nothing with gluten”."""


@dataclass(frozen=True, slots=True)
class Row:
    """When the pattern is found, and not the other, then this."""

    when: str
    unless: str | None
    then: Mapping[str, Any]

    def match(self, text: str) -> re.Match[str] | None:
        """Return where the row's pattern is, if the row holds."""
        lowered = text.lower()
        if _CASED not in self.when and ready(self.when).search(lowered) is None:
            return None
        # Few rows are found: what they have beside is looked for last.
        if self.unless is not None and ready(self.unless).search(lowered):
            return None
        return ready(self.when, _ANY_CASE).search(text)

    def prepare(self) -> None:
        """Make its patterns ready, so that no text has to wait for that."""
        for pattern in (self.when, self.unless):
            if pattern is not None:
                ready(pattern)


@dataclass(frozen=True, slots=True)
class Rules:
    """The rules of one language: rows that ask, order, relate and so on; words that say no place, or part others."""

    tables: Mapping[str, tuple[Row, ...]]
    words: Mapping[str, str]
    ranks: Mapping[str, int]
    then: str

    def __getitem__(self, name: str) -> re.Pattern[str]:
        """Return the pattern of some words, made ready when it is first asked for."""
        return ready(self.words[name], _ANY_CASE)

    @property
    def rows(self) -> Iterator[Row]:
        """The rows of all tables."""
        return chain(*self.tables.values())

    def holding(self, table: str, text: str) -> Iterator[tuple[Row, re.Match[str]]]:
        """The rows of a table that hold, in their order."""
        return ((row, found) for row in self.tables[table] if (found := row.match(text)))

    def resuming(self, text: str) -> str:
        """Return a text with “then” for each clause that says that what was said is done: “看电影，看完再去”."""
        return self["resumed"].sub(self.then, text)

    def first(self, table: str, text: str) -> tuple[Row, re.Match[str]] | None:
        """The first row of a table that holds; rows stand in order, the most particular first."""
        return next(self.holding(table, text), None)


@lru_cache(maxsize=8)
def rules_of(language: str) -> Rules:
    """Read the rules of a language, once a process."""
    tree: Mapping[str, Any] = read_table(f"wishes/{language}.json")
    ranks = ordinals(language)
    parts: Mapping[str, str] = {**tree.get("parts", {}), "ordinal": _any_of(ranks)}

    def filled(pattern: str) -> str:
        # A part may hold another.
        for _ in range(_DEEPEST):
            pattern = _NAMED.sub(lambda found: parts.get(found.group(1), found.group(0)), pattern)
        return pattern

    def rows(name: str) -> tuple[Row, ...]:
        return tuple(
            Row(filled(when), filled(row["unless"]) if "unless" in row else None, row.get("then", {}))
            for row in tree.get(name, ())
            for when in ([row["when"]] if "when" in row else [_said(shape, row["said"]) for shape in tree["shapes"]])
        )

    rules = Rules(
        {name: rows(name) for name in _TABLES}, {name: filled(tree[name]) for name in _WORDS}, ranks, tree["then"]
    )
    said = [(each, flags) for row in rules.rows for each in (row.when, row.unless) if each for flags in (0, _ANY_CASE)]
    keep_ready(language, (*said, *((each, _ANY_CASE) for each in (*rules.words.values(), *tree["polarity"].values()))))
    return rules


def _said(shape: str, words: str) -> str:
    return shape.replace("<said>", words)


def _any_of(words: Iterable[str]) -> str:
    """A pattern of any of some words, the longest first."""
    return "(?:" + "|".join(map(re.escape, sorted(words, key=lambda word: (-len(word), word)))) + ")"


def content_left(text: str, rules: Rules, least: int = 1) -> str:
    """Return what of a text is not filler; empty where nothing is left."""
    left = " ".join(rules["filler"].sub(" ", text).split()).strip(_ENDS + "'’")
    return left if len(left) >= least else ""


def content_of(text: str, languages: Sequence[str]) -> str:
    """Return what is left of a text without the filler of its likeliest language."""
    return content_left(clean_text(text, LONGEST).strip(_ENDS), rules_of(languages[0]))


def ask_of(text: str, languages: tuple[str, ...]) -> tuple[Ask, str]:
    """Return what a text asks, and in which language it says so."""
    for language in languages:
        found = rules_of(language).first("asks", text)
        if found is not None:
            return Ask(found[0].then["ask"]), language
    return Ask.WHERE, languages[0] if languages else "en"


def orders_of(text: str, languages: tuple[str, ...]) -> list[tuple[Which, int]]:
    """Return all orders that are asked for, each with its rank, in the first language that has any."""
    for language in languages:
        rules, found = rules_of(language), list[tuple[Which, int]]()
        for row, match in rules.holding("orders", text):
            said = (value for name, value in match.groupdict().items() if name.startswith("rank") and value)
            found.append((Which(row.then["which"]), rules.ranks.get(next(said, "").casefold(), 1)))
        if found:
            return found
    return []


def relation_of(text: str, languages: tuple[str, ...]) -> tuple[Row, re.Match[str], Rules] | None:
    """Return the first row of a relation whose anchor is told, where it stands, and its language's rules."""
    for language in languages:
        rules = rules_of(language)
        for row, match in rules.holding("relations", text):
            if content_left(match.group("anchor"), rules, least=1):
                return row, match, rules
            if rules["previous"].match(match.group("anchor").strip(_ENDS)):
                return row, match, rules
    return None


def person_of(text: str, languages: Iterable[str]) -> str | None:
    """Return the person whom a text names by a title, by the first language that hears one."""
    found = (rules_of(language).first("persons", text) for language in languages)
    return next((each[1].group("person") for each in found if each is not None), None)


def parted(text: str, language: str) -> tuple[str, list[str]] | None:
    """Return what a text wants, and each thing that it refuses; None where no word parts them."""
    rules = rules_of(language)
    said = text.strip(_PART_ENDS)
    found = rules.first("refusals", said) or rules.first("exclusions", said)
    if found is None:
        return None
    groups = found[1].groupdict()
    # “Clothes, not for women but for men”: what is said after the refusal is wanted as well.
    what = " ".join(each.strip(_PART_ENDS) for each in (groups["what"], groups.get("rest", "")) if each)
    out = groups["not"].strip(_PART_ENDS)
    refused = [each for each in each_of(out) if content_left(each, rules) or letter_of(each)]
    return (what, refused) if refused and content_left(what, rules) else None


def letter_of(text: str) -> str:
    """Return the capital that is all that a text names: “the A”, “el A no”."""
    capitals = _CAPITAL.findall(text)
    return capitals[0].casefold() if len(capitals) == 1 and len(text) <= _BRIEF else ""


def each_of(out: str) -> list[str]:
    """Each thing that a text refuses, without the words that say so."""
    named = (_NO.sub("", each.strip(_PART_ENDS)).strip(_PART_ENDS) for each in _EACH.split(out) if each)
    return [each for each in named if each]
