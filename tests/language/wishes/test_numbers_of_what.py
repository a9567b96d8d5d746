"""What a number is of, on boards and in questions; and what is refused of two at once."""

from collections.abc import Sequence

import pytest

from language.asking import solved
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.codes import asked_codes, board_codes

MODEL = OfflineModel()


def found(question: str, boards: Sequence[Sequence[str]]) -> str | None:
    return solved(MODEL, question, boards)[-1]


@pytest.mark.parametrize(
    ("board", "numbers"),
    [
        ("Iniciación musical · 4 a 7 años", []),
        ("Spielstube, ab 6 Jahren", []),
        ("Pools for 3 to 5 years", []),
        ("Rooms 4 to 7", [4]),
        ("Raum 6", [6]),
    ],
)
def test_an_age_on_a_board_numbers_nothing(board: str, numbers: list[int]) -> None:
    assert [code.number for code in board_codes(board) if code.until is not None or len(numbers) < 2][:1] == numbers


@pytest.mark.parametrize("question", ["Stiefel in Größe 145", "boots, size 145", "des bottes en pointure 145"])
def test_a_size_is_no_number_of_a_place(question: str) -> None:
    assert not asked_codes(question)
    assert asked_codes(question.replace("Größe", "Raum").replace("size", "room").replace("pointure", "salle"))


READING = [("Freihand", "000–400"), ("Lesesaal A", "Sitz 1–80"), ("Plätze 81–160",), ("Rooms 1–20",)]


@pytest.mark.parametrize(
    ("question", "expected"),
    [("seat 112", "Plätze 81–160"), ("seat 245", None), ("112번 자리", "Plätze 81–160"), ("room 245", "Freihand")],
)
def test_a_long_number_of_seats_is_theirs_alone(question: str, expected: str | None) -> None:
    assert found(question, READING) == expected


@pytest.mark.parametrize(
    ("question", "expected"), [("box 9", "Balkon links"), ("palco 9", "Balkon links"), ("Haken 150", "Garderobe 1–200")]
)
def test_a_box_of_a_theatre_is_no_cloakroom(question: str, expected: str) -> None:
    assert found(question, [("Garderobe 1–200",), ("Balkon links", "Logen 1–12"), ("Foyer",)]) == expected


CHANGING = [("Umkleide Damen",), ("Umkleide Herren",), ("Familienumkleide",)]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("Umziehen, aber weder bei den Damen noch bei den Herren", ["Familienumkleide"]),
        ("eine Umkleide, aber nicht die der Damen", ["Umkleide Herren", "Familienumkleide"]),
    ],
)
def test_neither_of_two_that_attributes_tell(question: str, expected: list[str]) -> None:
    assert found(question, CHANGING) in expected


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("una sala de ensayo, la A no, que está ocupada", "Sala de ensayo B"),
        ("una sala de ensayo, la B no porque huele", "Sala de ensayo A"),
        ("la sala de ensayo A, que está libre", "Sala de ensayo A"),
    ],
)
def test_a_reason_may_follow_what_is_refused(question: str, expected: str) -> None:
    assert found(question, [("Sala de ensayo A",), ("Sala de ensayo B",), ("Cafetería",)]) == expected
