"""A plan whose next stop is the same place goes there once; a time of day leaves what is wanted."""

from asking import solved

from lpslam.language.offline import OfflineModel

MODEL = OfflineModel()


def test_one_place_for_two_clauses_is_told_once() -> None:
    boards = (("Optique Fundy Optical",), ("Cinéma Starlite 6",), ("Café Papaya",))
    question = "먼저 안경점에 들러서 맞춘 안경 받고, 그다음에 영화 보러 갈 거예요"
    assert solved(MODEL, question, boards) == ["Optique Fundy Optical", "Cinéma Starlite 6"]


def test_to_eat_at_noon_is_to_eat() -> None:
    assert solved(MODEL, "中午大家在哪儿吃饭？", (("Recepción de Leche",), ("Comedor",), ("Pasteurización",))) == [
        "Comedor"
    ]
