"""Every line of a board says what is had there: the name first, then what the further lines list."""

import pytest
from asking import solved

from lpslam.language.offline import OfflineModel

MODEL = OfflineModel()
BOARDS: tuple[tuple[str, ...], ...] = (
    ("Hotel Desk", "Luggage storage · Taxi calls"),
    ("Barton & Daughters", "Watch batteries while you shop"),
    ("Gift Corner", "Postcards · Stamps"),
    ("Check-in 7-9", "Delta · Swiss · Air India"),
    ("Station Kiosk", "Bücher · Blumen"),
    ("休憩室", "自動販売機 · コインランドリー"),
    ("Main Entrance",),
    ("Boarding", "Boots · Bats · Braces"),
)


def found(question: str, boards: tuple[tuple[str, ...], ...] = BOARDS) -> str | None:
    return solved(MODEL, question, boards)[-1]


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("somewhere to leave my suitcase", "Hotel Desk"),
        ("where can I leave my luggage", "Hotel Desk"),
        ("my watch has stopped, I need a new battery for it", "Barton & Daughters"),
        ("wo bekomme ich Blumen", "Station Kiosk"),
        ("where is the launderette", "休憩室"),
        ("洗濯したいです", "休憩室"),
    ],
)
def test_what_a_further_line_lists_is_had_there(question: str, board: str) -> None:
    assert found(question) == board


def test_the_name_goes_before_a_further_line() -> None:
    assert found("買花在哪裡", (("Kiosk", "Flowers · Snacks"), ("Florist",))) == "Florist"


@pytest.mark.parametrize("question", ["somewhere to eat Swiss food", "a curry house"])
def test_one_word_of_a_line_that_is_not_read_says_nothing(question: str) -> None:
    assert found(question) is None


def test_a_thing_in_a_list_is_no_brand() -> None:
    assert found("a pharmacy for headache pills") is None
