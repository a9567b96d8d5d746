"""Which floor a wish names, in seven languages."""

import pytest

from lpslam.language.wishes.floors import floor_of
from lpslam.language.wishes.form import Counting

ABOVE, ONE, HERE, TOP = Counting.ABOVE_GROUND, Counting.FROM_ONE, Counting.FROM_HERE, Counting.TOP


@pytest.mark.parametrize(
    ("text", "language", "counting", "number", "rest"),
    [
        ("the toilet upstairs", "en", HERE, 1, "the toilet"),
        ("a café one floor down", "en", HERE, -1, "a café"),
        ("a bookshop on the second floor", "en", ABOVE, 2, "a bookshop"),
        ("eine Apotheke im Erdgeschoss", "de", ABOVE, 0, "eine Apotheke"),
        ("ein WC im 3. Stock", "de", ABOVE, 3, "ein WC"),
        ("une banque au rez-de-chaussée", "fr", ABOVE, 0, "une banque"),
        ("un baño en la planta 2", "es", ABOVE, 2, "un baño"),
        ("un ascensor del sótano 2", "es", ABOVE, -2, "un ascensor"),
        ("三楼的书店", "zh", ONE, 3, "书店"),
        ("地下2階の駐車場", "ja", ABOVE, -2, "駐車場"),
        ("2층 화장실", "ko", ONE, 2, "화장실"),
        ("위층 화장실", "ko", HERE, 1, "화장실"),
        ("the bar on the top floor", "en", TOP, 0, "the bar"),
    ],
)
def test_floors(text: str, language: str, counting: Counting, number: int, rest: str) -> None:
    floor, left, is_torn = floor_of(text, language)
    assert floor is not None
    assert (floor.counting, floor.number, left, is_torn) == (counting, number, rest, False)


@pytest.mark.parametrize("text", ["gate B2", "a flower shop", "room 2", "platform 3", "5号楼"])
def test_no_floor(text: str) -> None:
    assert floor_of(text, "en")[0] is None


@pytest.mark.parametrize(
    ("text", "language"),
    [("ein Café im Erdgeschoss, das im ersten Stock ist", "de"), ("3階にある1階のトイレ", "ja")],
)
def test_two_floors_at_once(text: str, language: str) -> None:
    assert floor_of(text, language)[2]
