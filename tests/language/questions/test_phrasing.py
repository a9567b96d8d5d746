"""Answers in the language of their question: kinds of place, and reasons that the solver writes in English."""

import pytest

from lpslam.language.languages import LANGUAGES
from lpslam.language.questions.phrasing import phrases_in
from lpslam.language.tables.lexicon import read_table

OTHERS = [*(language for language in LANGUAGES if language != "en"), "zh-Hant"]


@pytest.mark.parametrize("language", OTHERS)
def test_every_reason_is_said_in_every_language_with_what_it_is_about(language: str) -> None:
    for row in read_table("reasons.json"):
        # Whatever a sign says is no template.
        told = phrases_in(language).reasons(row["en"].format(what="K{F}C", order="next to", count=7))
        assert told == row[language].format(what="K{F}C", count=7)
        assert told != row["en"]


def test_several_reasons_are_said_and_what_is_none_stays() -> None:
    evidence = "gesucht: Kaffee; it is not sure what is meant; he said so"
    assert phrases_in("de").reasons(evidence) == "gesucht: Kaffee; es ist nicht sicher, was gemeint ist; he said so"
    assert phrases_in("en").reasons(evidence) == evidence


def test_kinds_are_named_without_the_table_that_they_are_of() -> None:
    assert phrases_in("en").things(["amenity/toilets", "food", "amenity/fast_food"]) == "toilets, food, fast food"
    assert phrases_in("de").things(["amenity/toilets"]) == "Toilette"
