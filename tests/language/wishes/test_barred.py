"""Doors that boards close to the public."""

import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.form import Ask
from lpslam.language.wishes.trust import barred

BOARDS = (
    *("Staff only", "No entry", "Authorised personnel only", "Zutritt verboten", "Nur für Mitarbeiter"),
    *("Accès interdit", "Réservé au personnel", "Prohibido el paso", "Solo personal", "非工作人员止步", "员工专用"),
    *("関係者以外立入禁止", "従業員専用", "관계자 외 출입금지", "직원 전용"),
)
OPEN = ("Staff restaurant", "Personalabteilung", "Entrée", "No smoking", "从业人员体检", "直営店", "직원 식당")


@pytest.mark.parametrize("board", BOARDS)
def test_a_board_that_keeps_people_out_is_known(board: str) -> None:
    assert barred([Candidate(0, "Room", (), (board,))]) == {0}


@pytest.mark.parametrize("board", OPEN)
def test_other_boards_keep_nobody_out(board: str) -> None:
    assert not barred([Candidate(0, board)])


@pytest.mark.parametrize(
    "question",
    [
        *("Where am I not allowed to go?", "Which rooms are off limits?", "Wo darf man nicht hinein?"),
        *("Welche Räume sind gesperrt?", "Où n'a-t-on pas le droit d'entrer ?", "¿Dónde no se puede entrar?"),
        *("哪些地方不能进?", "立ち入り禁止の場所はどこですか", "출입이 금지된 곳이 어디예요?"),
    ],
)
def test_who_asks_where_not_to_go_gets_what_is_closed(question: str) -> None:
    model = OfflineModel()
    marks = (Candidate(0, "Café"), Candidate(1, "Server Room", (), ("Zutritt verboten",)))
    stop = model.read_wish(question).stops[0]
    assert stop.ask is Ask.BARRED
    assert set(model.scorer(marks).serve(stop).scores) == {1}


@pytest.mark.parametrize("question", ["Where may I smoke?", "What is not allowed here?", "I can't enter my car"])
def test_other_questions_ask_for_no_closed_doors(question: str) -> None:
    assert OfflineModel().read_wish(question).stops[0].ask is not Ask.BARRED
