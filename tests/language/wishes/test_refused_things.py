"""Which part of a question wants and which refuses, in seven languages; and negations that only tell of something."""

import pytest

from language.asking import solved
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.rules import parted


@pytest.mark.parametrize(
    ("language", "text", "what", "refused"),
    [
        ("en", "somewhere to eat, but I can't have nuts", "somewhere to eat", ["nuts"]),
        ("en", "something sweet, though not chocolate", "something sweet", ["chocolate"]),
        ("en", "lunch, but we don't eat pork or shellfish", "lunch", ["pork", "shellfish"]),
        ("en", "a way up, but on no account the stairs", "a way up", ["the stairs"]),
        ("de", "etwas zu essen, aber auf gar keinen Fall Fisch", "etwas zu essen", ["Fisch"]),
        ("de", "nach oben, aber Treppen gehen nicht", "nach oben", ["Treppen"]),
        ("de", "ein Geschenk, aber bitte keine Blumen und nichts aus Glas", "ein Geschenk", ["Blumen", "Glas"]),
        ("es", "algo dulce, pero chocolate no", "algo dulce", ["chocolate"]),
        ("es", "comer, pero no comemos cerdo", "comer", ["cerdo"]),
        ("es", "algo de beber que no lleve alcohol", "algo de beber", ["alcohol"]),
        ("fr", "déjeuner, mais on ne mange pas de porc", "déjeuner", ["porc"]),
        ("fr", "quelque chose de sucré, mais le chocolat non", "quelque chose de sucré", ["le chocolat"]),
        ("zh", "想上楼,但千万别走楼梯", "想上楼", ["楼梯"]),
        ("zh", "想吃甜的,不过巧克力不行", "想吃甜的", ["巧克力"]),
        ("ja", "上に行きたいけど、階段は無理", "上に行きたい", ["階段"]),
        ("ja", "昼ごはん、豚肉は食べられません", "昼ごはん", ["豚肉"]),
        ("ko", "선물 사고 싶은데 꽃은 싫어요", "선물 사고 싶", ["꽃"]),
    ],
)
def test_what_is_refused_is_told_from_what_is_wanted(language: str, text: str, what: str, refused: list[str]) -> None:
    assert parted(text, language) == (what, refused)


def test_who_tells_of_a_lost_card_refuses_nothing() -> None:
    assert parted("我把卡弄丢了，不知道怎么办", "zh") is None


@pytest.mark.parametrize(
    "question",
    [
        "my good suit is stained and that can't go in a washing machine",
        "mein Anzug hat Flecken und darf nicht in die Waschmaschine",
    ],
)
def test_a_negation_may_only_tell_of_something(question: str) -> None:
    boards = [["Dry Cleaners"], ["Shoe Repair"], ["Pharmacy"], ["Café Luna"], ["Toilets"]]
    assert solved(OfflineModel(), question, boards) == ["Dry Cleaners"]


def test_what_is_refused_by_a_but_is_not_answered() -> None:
    asked = "a chemist's, but please, please don't take me to a chemist's"
    assert solved(OfflineModel(), asked, [["Pharmacy"], ["Zara"]]) == [None]


def test_nothing_is_left_where_all_that_serves_is_refused() -> None:
    boards = [["Tennis Courts 1-4"], ["Swimming Pool"], ["Café"], ["Toilets"]]
    asked = "some sport, but nothing in the water and nothing with a racket"
    assert solved(OfflineModel(), asked, boards) == [None]


def test_one_of_several_is_not_told_where_nobody_knows_what_is_refused() -> None:
    boards = [["Sushi Maki"], ["Burger Yard"], ["Noodle House"], ["Toilets"]]
    assert solved(OfflineModel(), "lunch, but nothing grumbulous", boards) == [None]
    assert solved(OfflineModel(), "lunch, but nothing grumbulous", [boards[0], boards[3]]) == ["Sushi Maki"]
