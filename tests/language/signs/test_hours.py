"""Opening hours on boards, and times that questions ask for."""

import pytest

from lpslam.language.signs.hours import asked_time, board_hours, without_hours


@pytest.mark.parametrize(
    ("board", "open_at", "shut_at"),
    [
        ("Mo–Sa 9–20 Uhr", (9, 19), (8, 20)),
        ("Open 10am–4pm", (10, 15), (9, 16)),
        ("11h30-14h", (12,), (11, 14)),
        ("営業時間 10:00〜22:00", (10, 21), (9, 22)),
        ("18:00 – 02:00", (19, 1), (3, 12)),
        ("bis 18 Uhr", (12, 17), (18, 23)),
        ("jusqu'à 23h", (12, 22), (23,)),
        ("24시간", (0, 3, 12), ()),
        ("24h/24", (0, 3, 12), ()),
    ],
)
def test_hours_of_boards(board: str, open_at: tuple[int, ...], shut_at: tuple[int, ...]) -> None:
    hours = board_hours(board)
    assert hours
    assert all(any(each.holds(hour * 60) for each in hours) for hour in open_at)
    assert not any(each.holds(hour * 60) for each in hours for hour in shut_at)


@pytest.mark.parametrize("board", ["Gates 20-38", "Salas 1-6", "Aula 2.01-2.20", "Halle 3.1", "Room 1.04", "B11-B17"])
def test_numbers_are_no_hours(board: str) -> None:
    assert board_hours(board) == ()
    assert without_hours(board) == board


@pytest.mark.parametrize(
    ("question", "hours"),
    [
        ("a café that is still open at 7 pm", {19}),
        ("somewhere to eat at nine in the evening", {21}),
        ("ein Supermarkt, der um 21 Uhr noch offen ist", {21}),
        ("半夜十二点还开着的餐厅", {0}),
        ("晚上十二点还能吃饭吗", {0}),
        ("中午十二点吃饭", {12}),
        ("une pharmacie ouverte à 8 h", {8}),
        ("una farmacia abierta a las nueve de la noche", {21}),
        ("晚上九点还开着的餐厅", {21}),
        ("夜9時に開いている店", {21}),
        ("밤 열 시에 여는 약국", {22}),
        ("lunch at noon", {12}),
        ("a drink at eight", {8, 20}),
        ("un café vers 15h30", {15}),
    ],
)
def test_times_that_are_asked_for(question: str, hours: set[int]) -> None:
    asked = asked_time(question)
    assert asked is not None
    assert {minute // 60 for minute in asked.minutes} == hours
    assert not any(ch.isdigit() for ch in asked.rest)


@pytest.mark.parametrize(
    "question", ["gate 12", "room 203", "Gleis 8", "the second shop", "2 coffees", "3番線", "5号门"]
)
def test_numbers_are_no_times(question: str) -> None:
    assert asked_time(question) is None
