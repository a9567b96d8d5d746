"""Brands by any of their names, numbers beside words that boards bear, and boards that say the very words."""

import numpy as np
import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.form import Stop
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solver import solve

MODEL = OfflineModel()


def found(question: str, *names: str) -> str | None:
    marks = [Candidate(at, name) for at, name in enumerate(names)]
    places = [Place(at, name, np.array([5.0 * at, 0.0, 0.0])) for at, name in enumerate(names)]
    place = solve(MODEL.read_wish(question), places, MODEL.scorer(marks), Here(np.zeros(3))).stops[-1].place
    return place and place.name


@pytest.mark.parametrize(
    ("question", "board"),
    [("Where is Uniqlo?", "优衣库"), ("Haidilao please", "海底捞火锅"), ("ファーウェイ", "HUAWEI 华为")],
)
def test_a_brand_is_found_by_any_of_its_names(question: str, board: str) -> None:
    assert found(question, "KFC", "Zara", board) == board


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("I'm looking for unit 45", "Units 40–52"),
        ("aisle number eleven", "Aisle 11"),
        ("shelf B-03", "Regal B-O3"),
        ("el juzgado número 3", "Juzgado n.º 3"),
    ],
)
def test_a_number_is_found_beside_its_word(question: str, board: str) -> None:
    assert found(question, "Units 1–14", "Aisle 12", "Regal B-O4", "Juzgado n.º 1", board) == board


def test_what_says_the_very_words_serves() -> None:
    # Words of the question may speak against a board that a table read: it serves no more, though it says the words.
    boards = (
        "小心地滑",
        "洗手间",
        "WASHROOM",
        "卫生间",
        "Toiletten",
        "KFC",
        "WASHROOM",
        "禁止入内",
        "ユニクロ",
        "危険",
        "トイレ",
    )
    boards += (
        "ABC書店",
        "禁煙",
        "Buchhandlung Schmidt",
        "Achtung Stufe",
        "Toilette",
        "Metzgerei Huber",
        "KFC",
        "WASHROOM",
    )
    marks = [Candidate(at, f"{name} 6") for at, name in enumerate((*boards, "DANGER", "NO SMOKING"))]
    served = MODEL.scorer(marks).serve(Stop("die Toiletten"))
    assert served.exact <= served.scores.keys()
