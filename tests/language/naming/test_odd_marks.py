"""Marks that stand where signs have none were misread."""

import pytest

from lpslam.language.model import Reading
from lpslam.language.naming.marks import odd_marks, with_gaps
from lpslam.language.offline import embedded_model
from lpslam.language.tables.knowledge import load_knowledge


@pytest.mark.parametrize("text", ["12 Harbour,Road", "牛肉7.元", "Greenwich -ark", "Lift|3", "Bar (open", "LADD :R"])
def test_a_mark_where_none_is_painted_is_odd(text: str) -> None:
    assert odd_marks(text)


@pytest.mark.parametrize(
    "text",
    ["H&M", "MON-SAT 8:00-17:30", "Paint 10.90", "(02) 123-4567", "20,000", "St. John's", "你好,欢迎光临", "-20%",
     "E.Leclerc", "Sale!", "Sandwiches, wraps", "24/7", "Tel: 5551", "No.5", "Bar (open)", "Open : daily"],
)  # fmt: skip
def test_marks_that_signs_have_are_not(text: str) -> None:
    assert not odd_marks(text)


def test_hardly_any_known_name_has_an_odd_mark() -> None:
    names = {each.painted for each in load_knowledge().known.values()}
    assert sum(bool(odd_marks(each)) for each in names) < 0.0002 * len(names)


def test_an_odd_mark_between_two_words_is_their_gap() -> None:
    assert with_gaps("12 Harbour,Road", {"harbour", "road"}) == "12 Harbour Road"
    assert with_gaps("12 Harbour,Rxad", {"harbour", "road"}) == "12 Harbour,Rxad"


def test_a_name_with_an_odd_mark_is_unsure_and_one_whose_gap_was_told_is_not() -> None:
    namer = embedded_model()
    odd, mended, plain = (
        namer.name([Reading(text, 6, 0.99, 0.95, 3.0)]) for text in ("牛肉7.元", "Harbour,Road", "牛肉72元")
    )
    assert odd.confidence < 0.5 < plain.confidence
    assert (mended.name, mended.confidence > 0.9) == ("Harbour Road", True)


def test_an_odd_mark_stands_for_a_letter() -> None:
    namer = embedded_model()
    ladder = namer.name(
        [Reading("SCARLET LADD :R", 16, 0.97, 0.7, 2.6), Reading("SCARLET LADDER", 5, 0.96, 0.58, 0.45)]
    )
    assert ladder.name == "SCARLET LADDER"
    harbour = namer.name([Reading("Harbour,Road", 6, 0.99, 0.95, 3.0), Reading("Harbour1Road", 1, 0.8, 0.4, 0.5)])
    assert harbour.name == "Harbour Road"


@pytest.mark.parametrize(
    ("text", "name"), [("CHOOSE A FARM-", "CHOOSE A FARM"), ("– Open –", "Open"), ("MON-SAT", "MON-SAT"), ("-", "-")]
)
def test_dashes_at_the_ends_of_a_name_are_edges(text: str, name: str) -> None:
    assert with_gaps(text, {"choose", "farm"}) == name
    if name != "-":
        assert embedded_model().name([Reading(text, 6, 0.99, 0.95, 3.0)]).name == name
