"""Little words that look like something one could want, and wants that stand beside little words."""

import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel


@pytest.mark.parametrize(
    ("question", "shop", "other"),
    [
        ("¿Es una tienda?", "Fnac", "Toilet"),  # una is no uña
        ("여기는 물건을 파는 가게예요?", "UNIQLO", "화장실"),  # 물건 is no 물
        ("Ist das ein Geschäft?", "Saturn", "Ausgang"),
    ],
)
def test_a_shop_is_asked_for_whatever_little_words_look_like(question: str, shop: str, other: str) -> None:
    yes, no = OfflineModel().judge([shop, other], question)
    assert (yes.answer, no.answer) == (True, False)


@pytest.mark.parametrize("question", ["這是吃東西的地方嗎？", "Kann man hier essen gehen?", "Is this a place to eat?"])
def test_a_place_to_eat_is_more_than_a_place(question: str) -> None:
    pizza, gap, gate = OfflineModel().judge(["Pizza Hut", "GAP", "Gate 12"], question)
    assert (pizza.answer, gap.answer, gate.answer) == (True, False, False)


@pytest.mark.parametrize(
    "question",
    [
        "Starbucks is packed, is there another café?",
        "スターバックス以外のカフェはありますか",
        "Starbucks ist zu voll, gibt es ein anderes Café?",
        "除了星巴克还有别的咖啡店吗",
    ],
)
def test_another_one_is_not_the_one_that_is_named(question: str) -> None:
    names = ["Starbucks", "Costa Coffee", "Foot Locker"]
    choice = OfflineModel().choose(question, [Candidate(at, name) for at, name in enumerate(names)])
    assert choice.landmark == 1
