"""Numerals of any script beside what they number, letters alone, and what is numbered beside other words."""

import pytest
from asking import solved

from lpslam.language.offline import OfflineModel

MODEL = OfflineModel()


@pytest.mark.parametrize(
    ("question", "boards", "expected"),
    [
        ("ゲート 一に行きたいのですが", ("ゲート 1", "ゲート 10"), "ゲート 1"),
        ("登机口 八在什么地方", ("登机口 8", "登机口 12"), "登机口 8"),
        ("게이트 사 어디", ("게이트 4", "게이트 5"), "게이트 4"),
        ("사물함 백육십육 있어요?", ("사물함 108", "사물함 166"), "사물함 166"),
        ("이번 출구까지 안내해 주세요", ("2번 출구", "8번 출구"), "2번 출구"),
        ("五十八病棟へ行きたいです", ("10病棟", "58病棟"), "58病棟"),
        ("电梯 七往哪边走", ("电梯 7", "电梯 11"), "电梯 7"),
        ("하역장 42 가는 길 좀", ("하역장 4", "하역장 42"), "하역장 42"),
        ("회의실 비", ("회의실 A", "회의실 B"), "회의실 B"),
        ("ホール ディーはどこですか", ("ホールC", "ホールD"), "ホールD"),
        ("이백이 호실", ("201호실", "202호실"), "202호실"),
        ("halle a", ("Halle A", "Halle D"), "Halle A"),
        ("bゾーンはどこ", ("Bゾーン", "Fゾーン"), "Bゾーン"),
        ("1 b病棟はどちらでしょうか", ("1a病棟", "1b病棟"), "1b病棟"),
        ("2호 엘리베이터", ("1–10호실", "엘리베이터 2"), "엘리베이터 2"),
        ("Find Box 29", ("Taquilla 28", "Taquilla 29"), "Taquilla 29"),
        ("我要去3号厅", ("3号影厅", "4号影厅"), "3号影厅"),
    ],
)
def test_a_numeral_beside_what_it_numbers_is_its_number(question: str, boards: tuple[str, ...], expected: str) -> None:
    assert solved(MODEL, question, [(board,) for board in boards]) == [expected]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("Zeig mir bitte den Weg zu Gebäude 6", "Haus 6"),
        ("Führe mich zu gebäude 5, meine Kollegin wartet dort", "Haus 5"),
        ("Ich habe einen Termin bei Gebäude 5", "Haus 5"),
        ("a toilet in building 5", "Toilets"),
        ("Führe mich zu Haus 7, meine Kollegin wartet dort", None),
    ],
)
def test_what_is_numbered_is_meant_where_nothing_else_is(question: str, expected: str | None) -> None:
    boards = [("Haus 5",), ("Haus 6",), ("Toilets",), ("Kantine",)]
    assert solved(MODEL, question, boards) == [expected]


def test_a_thing_that_is_numbered_otherwise_is_no_answer() -> None:
    assert solved(MODEL, "I'm supposed to meet someone at Hall 4", [("Hall 12",), ("Hall 2",)]) == [None]


def test_what_a_board_is_called_goes_before_what_it_lists() -> None:
    boards = [("Floor Guide", "Gallery 5", "Gallery 6"), ("Gallery 5",), ("Gallery 6",)]
    assert solved(MODEL, "gallery six", boards) == ["Gallery 6"]
