"""What a sieve leaves out cannot be found; and it leaves out nearly all."""

import json
import re
from pathlib import Path

import pytest

from lpslam.language.languages import LANGUAGES
from lpslam.language.wishes.rules import Rules, rules_of
from lpslam.language.wishes.sieve import Sieve

SETS = Path(__file__).parents[3] / "benchmarks" / "language"


def possible(pattern: str, text: str) -> bool:
    return 0 in Sieve([pattern]).possible(text)


@pytest.mark.parametrize(
    ("pattern", "texts", "others"),
    [
        ("north|south", ["the NORTH gate", "due south"], ["the east gate", ""]),
        (r"^(?P<what>.+?) (?:next to|beside) (?P<anchor>.+)$", ["a café beside the bank"], ["a café near the bank"]),
        (r"(?:very )?near", ["near here"], ["very far"]),
        (r"(?:not ){1,3}here", ["not here"], ["there or so"]),
        ("[上下]楼", ["我要上楼"], ["厕所在哪里"]),
        (r"\d+", ["room 12", "no number"], []),
        ("a|", ["", "x"], []),
        ("(?<!un)clear", ["clear"], ["brief"]),
        (r"\bstraße\b", ["die Straße"], ["der Weg"]),
        ("kiosk", ["the K\u0131O\u017fk", "\u212aiosk"], ["the shop", "Kasse und Koffer"]),
    ],
)
def test_a_pattern_may_be_found_where_one_of_its_pieces_stands(
    pattern: str, texts: list[str], others: list[str]
) -> None:
    assert all(possible(pattern, text) for text in texts)
    assert not any(possible(pattern, text) for text in others)


def rows(rules: Rules) -> list[tuple[int, re.Pattern[str]]]:
    tables = (rules.asks, rules.orders, rules.corrections, rules.sequences, rules.relations, rules.exclusions)
    return [
        (row.number, re.compile(row.when, re.IGNORECASE))
        for table in (*tables, rules.among, rules.persons, rules.counts)
        for row in table
    ]


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_rule_that_holds_is_left_out(language: str) -> None:
    worlds = json.loads((SETS / "wishes_development.json").read_text(encoding="utf-8"))["worlds"].values()
    rules = rules_of(language)
    numbered = rows(rules)
    left, found = 0, 0
    asked = [wish["question"] for world in worlds for wish in world["wishes"]][:150]
    for text in asked:
        within = set(rules.sieve.possible(text))
        left += len(within)
        holding = {number for number, when in numbered if when.search(text)}
        found += len(holding)
        assert holding <= within
    assert found > 0
    assert left < 0.25 * len(numbered) * len(asked)
