"""What is wanted before something else comes first, whichever is said first."""

import pytest

from lpslam.language.offline import OfflineModel


@pytest.fixture(scope="module")
def model() -> OfflineModel:
    return OfflineModel()


@pytest.mark.parametrize(
    ("question", "first", "then"),
    [
        ("Before we eat I need to buy a charger", "charger", "eat"),
        ("I want a coffee, but first the toilet", "toilet", "coffee"),
        ("Bevor wir essen, muss ich Geld abheben", "Geld", "essen"),
        ("Ich will einen Kaffee, aber vorher aufs Klo", "Klo", "Kaffee"),
        ("Antes de comer quiero sacar dinero", "dinero", "comer"),
        ("Quiero un café, pero antes el baño", "baño", "café"),
        ("Avant de manger, je voudrais retirer de l'argent", "argent", "manger"),
        ("Je veux un café, mais d'abord les toilettes", "toilettes", "café"),
        ("吃饭之前我想取点钱", "取点钱", "吃饭"),
        ("食べる前に本を買いたい", "本", "食べる"),
        ("밥 먹기 전에 현금을 뽑고 싶어", "현금", "밥"),
    ],
)
def test_what_is_wanted_before_comes_first(model: OfflineModel, question: str, first: str, then: str) -> None:
    stops = model.read_wish(question).stops
    assert len(stops) == 2
    assert first in stops[0].what
    assert then in stops[1].what


@pytest.mark.parametrize(
    "question",
    ["Which shop is just before the exit?", "Qué hay antes de la salida?", "出口前面有什么?", "駅の前に何がありますか"],
)
def test_before_a_place_is_no_plan(model: OfflineModel, question: str) -> None:
    assert len(model.read_wish(question).stops) == 1
