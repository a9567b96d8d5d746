"""Numbers as people say them: in groups, behind a letter's name, and of whatever boards of the map number."""

import pytest

from lpslam.language.choosing.guessing import LEAST_SURE
from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.codes import asked_codes, board_codes
from lpslam.language.wishes.served import Way

MODEL = OfflineModel()


@pytest.mark.parametrize(
    ("question", "code"),
    [
        ("room three twelve", "312"),
        ("Zimmer elf null sechs", "1106"),
        ("gate dee eight", "d8"),
        ("puerta be diecisiete", "b17"),
        ("Gleis ce fünf", "c5"),
        ("la puerta D ocho", "d8"),
        ("voy a la K catorce", "k14"),
        ("오강의실", "5"),
    ],
)
def test_a_number_is_read_as_it_is_said(question: str, code: str) -> None:
    assert code in [each.value for each in asked_codes(question)]


@pytest.mark.parametrize("question", ["I have two kids", "a table for four people", "twenty one of us", "be seven"])
def test_a_number_of_nothing_is_no_code(question: str) -> None:
    assert asked_codes(question) == []


def test_all_numbers_of_a_list_are_of_what_stands_behind_it() -> None:
    assert all("platform" in code.of for code in board_codes("5・6番線 海浜方面"))


def served(question: str, *boards: str) -> set[str]:
    marks = [Candidate(at, board) for at, board in enumerate(boards)]
    found = MODEL.scorer(marks).serve(MODEL.read_wish(question).stops[0])
    return {boards[id_] for id_ in found.scores}


@pytest.mark.parametrize(
    ("question", "board"),
    [("berths thirty three", "Berths 31–40"), ("pod 14", "Pods 11–20"), ("la grada siete", "Gradas 5–9")],
)
def test_whatever_a_board_numbers_is_found_by_its_number(question: str, board: str) -> None:
    assert served(question, board, "Pods 1–10", "Toilets", "Gradas 1–4") == {board}


@pytest.mark.parametrize(
    ("question", "board", "others"),
    [
        ("63번 가게 찾아요", "Stands 56–70", ["Stands 40–55", "Placier"]),
        ("Koje 30", "Kojen 20–39", ["Kojen 40–59", "Waschraum"]),
        ("lecture theater b", "Lecture Theatre B", ["Lecture Theatre A", "Café"]),
        ("el juzgado número 3", "Juzgado de lo Penal n.º 3", ["Salas de vistas 1–3", "Juzgado n.º 4"]),
        ("a ballroom A", "연회장 A", ["연회장 B", "회의실 1–4"]),
    ],
)
def test_the_board_that_alone_holds_a_number_is_it(question: str, board: str, others: list[str]) -> None:
    assert served(question, board, *others) == {board}


@pytest.mark.parametrize(
    ("question", "board", "others"),
    [
        ("亀の間で宴会と聞いておりますが。", "宴会場 亀", ["宴会場 鶴", "大浴場"]),
        ("竹那间会议室", "会议室 B 竹", ["会议室 A 松", "会议室 C 梅"]),
        ("a toilet", "Toilets", ["Toilets"]),
    ],
)
def test_of_boards_of_a_kind_the_one_whose_own_word_is_said(question: str, board: str, others: list[str]) -> None:
    assert served(question, board, *others) == {board}


def test_a_word_of_its_own_does_not_tell_what_an_order_tells() -> None:
    assert served("the second closest coffee shop", "Costa Coffee", "Starbucks") == {"Costa Coffee", "Starbucks"}


def test_two_numbers_of_two_boards_are_neither() -> None:
    assert (
        MODEL.scorer([Candidate(0, "Pods 1–9"), Candidate(1, "Pods 10–19")])
        .serve(MODEL.read_wish("is it in 7 or 12?").stops[0])
        .way
        is not Way.IDENTITY
    )


def test_a_numbered_place_that_is_taken_is_left_out() -> None:
    stop = MODEL.read_wish("Ein Gruppenraum zum Lernen, der Gruppenraum 1 ist aber schon belegt.").stops[0]
    assert [identity.value for each in stop.without for identity in each.identity] == ["1"]


def test_a_seat_in_a_row_is_in_the_row() -> None:
    marks = [Candidate(0, "Stalls", (), ("Rows A–M",)), Candidate(1, "Circle", (), ("Rows N–T",))]
    assert list(MODEL.scorer(marks).serve(MODEL.read_wish("Row H seat 14").stops[0]).scores) == [0]


def test_a_common_word_before_a_number_is_not_what_a_board_numbers() -> None:
    marks = [Candidate(0, "Lockers for 20"), Candidate(1, "Toilets")]
    found = MODEL.scorer(marks).serve(MODEL.read_wish("a gift for 20").stops[0])
    assert found.way is not Way.IDENTITY
    assert found.sure < LEAST_SURE


@pytest.mark.parametrize("question", ["Stall thirty-four", "stall 34", "Where is stall three four?"])
def test_a_number_in_a_further_line_is_found_in_words_too(question: str) -> None:
    marks = [Candidate(0, "Henley", (), ("Cheese · Ham", "Stall 34")), Candidate(1, "Brook", (), ("Stall 12",))]
    found = MODEL.scorer(marks).serve(MODEL.read_wish(question).stops[0])
    assert set(found.scores) == {0}
