"""People whom another script names by a title, and titles of trades."""

import pytest
from asking import solved

from lpslam.language.offline import OfflineModel

MODEL = OfflineModel()
BOARDS = (
    ("Plant Office", "Ing. Rodolfo Padilla"),
    ("Quality Lab", "Q.F.B. Lorena Casillas"),
    ("Dr Priyanka Solomon",),
    ("Lockers A–F",),
    ("Chemistry Lab",),
)


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("I've an appointment with engineer Padilla", "Plant Office"),
        ("Lorena Casillas 씨를 만나러 왔습니다", "Quality Lab"),
        ("Padillaさんに会いに来ました", "Plant Office"),
        ("我找Padilla先生", "Plant Office"),
        ("솔로몬 박사님 연구실이 어디예요?", "Dr Priyanka Solomon"),
    ],
)
def test_a_person_is_found(question: str, board: str) -> None:
    assert solved(MODEL, question, BOARDS) == [board]


@pytest.mark.parametrize("question", ["Sandra Kowalski 씨를 만나러 왔습니다", "슈나이더 박사님 계세요?"])
def test_who_is_not_there_is_nobody_else(question: str) -> None:
    assert solved(MODEL, question, BOARDS) == [None]
