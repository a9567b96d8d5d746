"""Numbers and codes: what is asked for, what boards bear, and ranges."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.code import Code
from lpslam.language.wishes.codes import alike_key, asked_codes, board_codes, board_keys, code_of, identities


def fits(question: str, board: str) -> bool:
    return all(any(code.bears(asked) for code in board_codes(board)) for asked in asked_codes(question))


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("gate B31", "Gates B20–B38"),
        ("B31番ゲート", "ゲート B20〜B38"),
        ("三号登机口", "登机口 1-9"),
        ("Zimmer 203", "Room 201-215"),
        ("terminal two", "Terminal 2"),
        ("chambre deux cent quatre-vingt-dix-sept", "Chambres 290-299"),
        ("Zimmer dreihundertelf", "Zimmer 305-315"),
        ("la habitación quinientos dos", "Habitaciones 501-520"),
        ("the third floor", "Floor 3"),
        ("im 3. Stock", "3. Stock"),
        ("第一百零二号房", "房间 102"),
        ("이십삼번 게이트", "게이트 21-30"),
        ("从C出口出去", "出口 C"),
        ("the D gates", "Gate D"),
        ("Halle-B", "Halle B"),
        ("andén 5", "Platforms 5-8"),
        ("dock 9", "Dock 7 to 12"),
        ("Zone C", "Zones A–D"),
        ("salle 2.14", "Salle 2.14"),
        ("gates A", "Gates A1-A15"),
        ("Schließfach 32", "Schließfach 32"),
        ("whereabouts is Track 11G", "Track 11G"),
        ("5G病棟ってどこにあるの", "5G病棟"),
        ("会议室2D", "Conference Rooms 2A–2F"),
        ("room 2d", "Räume 2A–F"),
        ("Zimmer 2.07", "Räume 2.01–2.12"),
        ("room one point oh seven", "Room 1.07"),
        ("two point oh four", "2.04 Computer Lab"),
        ("got a tutorial in 2.08", "Rooms 2.01–2.15"),
        ("my locker is H12", "Lockers G–M"),
        ("C 개찰구로 오래요", "개찰구 C"),
        ("Stimmraum 6", "Stimmräume 5–8"),
        ("screen 7", "Salas 6–9"),
        ("Schrank 42", "Garderobenschränke 1–60"),
        ("gates M1-4", "Gates M1–M8"),
        ("el juzgado número 3", "Juzgado n.º 3"),
    ],
)
def test_a_board_bears_what_is_asked(question: str, board: str) -> None:
    assert asked_codes(question)
    assert fits(question, board)


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("gate B31", "Gates A1-A40"),
        ("gate B39", "Gates B20–B38"),
        ("room 203", "Room 101"),
        ("platform 2", "Platform 12"),
        ("gate 12", "Platform 12"),
        ("room 2", "Rooms 201-215"),
        ("Zone E", "Zones A–D"),
        ("Zimmer 2.07", "Räume 1–6"),
        ("Zimmer 2.07", "Räume 3.01–3.12"),
        ("room 2g", "Conference Rooms 2A–2F"),
        ("my locker is N12", "Lockers G–M"),
        ("Stimmraum 6", "Tor 4–6"),
        ("Terminal 5", "Gepäckausgabe 5–8"),
        ("aisle 14", "Express checkouts 13-20"),
        ("allée 14", "Caisses automatiques 13-20"),
    ],
)
def test_another_board_does_not(question: str, board: str) -> None:
    assert not fits(question, board)


@pytest.mark.parametrize(
    "question",
    [
        "in 20 minutes",
        "a table for 4 people",
        "at 5 pm",
        "under 10 €",
        "2時間あるんだけど",
        "one coffee",
        "8キロの荷物",
        "I am lost",
        "at the school office first",
        "busco una sentencia de 1987",
        "Lorena Casillas 씨를 만나러 왔습니다",
    ],
)
def test_hours_prices_and_people_are_no_codes(question: str) -> None:
    assert not asked_codes(question)


@given(st.integers(0, 900), st.integers(0, 90), st.integers(0, 999), st.sampled_from("ABCDK"))
def test_a_range_bears_just_its_numbers(first: int, size: int, asked: int, letter: str) -> None:
    board = f"Gates {letter}{first}-{letter}{first + size}"
    assert fits(f"gate {letter}{asked}", board) == (first <= asked <= first + size)


def test_an_identity_is_its_code() -> None:
    codes = asked_codes("gate B31")
    assert [code_of(each) for each in identities(codes)] == codes


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("Raum zwo null vier", "Raum 204"),
        ("room two oh four", "Room 204"),
        ("gate b one two", "Gate B12"),
        ("salle deux zéro quatre", "Salle 204"),
        ("la sala dos cero cuatro", "Sala 204"),
    ],
)
def test_digits_are_heard_one_by_one(question: str, board: str) -> None:
    assert fits(question, board)
    assert not fits(question, board.replace("2", "3"))


@pytest.mark.parametrize(
    "question", ["one two three, where is the toilet", "이번 정류장", "oh, a coffee", "二人で一日"]
)
def test_words_that_sound_like_digits_are_no_codes(question: str) -> None:
    assert not asked_codes(question)


@pytest.mark.parametrize(("code", "board"), [("14", "Docks 1-4"), ("25", "Gates 2–5, 6–9"), ("a112", "Gates A1-A12")])
def test_the_ends_of_a_range_are_no_code_together(code: str, board: str) -> None:
    assert alike_key(code) not in board_keys(board)


@pytest.mark.parametrize(("code", "board"), [("a16", "Gate Al6"), ("2.14", "Salle 2.14"), ("b-31", "Gate B31")])
def test_codes_that_readers_confuse_have_one_key(code: str, board: str) -> None:
    assert alike_key(code) in board_keys(board)


def test_a_number_is_not_looked_for_on_boards_of_other_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    names = [f"Gate {number}" for number in range(1, 500)]
    marks = [Candidate(at, name) for at, name in enumerate([*names, "Gates 600-620", "Gate B7", "Zone C", "Gate 7a"])]
    model = OfflineModel()
    scorer = model.scorer(marks)
    looked_at: list[str] = []
    bears = Code.bears

    def counted(code: Code, asked: Code) -> bool:
        looked_at.append(code.value)
        return bears(code, asked)

    monkeypatch.setattr(Code, "bears", counted)
    for asked, board in (("gate 217", "Gate 217"), ("gate 611", "Gates 600-620"), ("gate B7", "Gate B7")):
        scores = scorer.serve(model.read_wish(asked).stops[0]).scores
        assert [marks[id_].name for id_ in scores] == [board]
    assert len(looked_at) < len(marks)
