"""Maps that have just been begun: one to five signs, among which what is asked for may not be yet."""

import numpy as np
import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solver import Solved, solve


def solved(question: str, names: tuple[str, ...]) -> Solved:
    model = OfflineModel()
    marks = tuple(Candidate(id_, name) for id_, name in enumerate(names))
    places = [Place(id_, name, np.array([6.0 * id_, 0.0, 0.0])) for id_, name in enumerate(names)]
    return solve(model.read_wish(question), places, model.scorer(marks), Here()).stops[-1]


def found(question: str, names: tuple[str, ...]) -> str | None:
    place = solved(question, names).place
    return place and place.name


@pytest.mark.parametrize("names", [("KFC",), ("KFC", "Pizza Hut"), ("Zara", "KFC", "Apple"), ("KFC", "Exit", "Lift 2")])
@pytest.mark.parametrize("question", ["I am hungry", "我饿了", "お腹が空いた", "Ich habe Hunger", "J'ai faim"])
def test_who_is_hungry_is_told_where_to_eat(question: str, names: tuple[str, ...]) -> None:
    assert found(question, names) in ("KFC", "Pizza Hut")


@pytest.mark.parametrize("names", [("KFC",), ("KFC", "Pizza Hut"), ("Zara", "KFC", "Apple", "Exit")])
@pytest.mark.parametrize("question", ["Where is Starbucks?", "星巴克在哪里", "Where is the pharmacy?", "gate B31"])
def test_what_is_not_there_is_not_answered(question: str, names: tuple[str, ...]) -> None:
    assert found(question, names) is None


@pytest.mark.parametrize(
    ("question", "names", "place"),
    [
        ("Where is the toilet?", ("Toilets",), "Toilets"),
        ("a restaurant", ("Restaurant Lindenhof", "Exit"), "Restaurant Lindenhof"),
        ("Wo ist die Apotheke?", ("Apotheke am Markt", "WC"), "Apotheke am Markt"),
        ("I need to see a doctor about my heart", ("Cardiology", "Radiology", "Cafeteria"), "Cardiology"),
        ("我想买药", ("药店", "银行"), "药店"),
        ("Where can I buy shoes?", ("Footlocker", "KFC"), "Footlocker"),
        ("My phone screen is cracked", ("KFC",), None),
        ("where do the boats leave", ("Cardiology", "Radiology"), None),
    ],
)
def test_one_sign_is_enough_or_none_serves(question: str, names: tuple[str, ...], place: str | None) -> None:
    assert found(question, names) == place


@pytest.mark.parametrize("names", [("Mind the gap",), ("Caution wet floor", "Staff only"), ("12",)])
def test_a_map_without_a_place_answers_nothing(names: tuple[str, ...]) -> None:
    assert found("I am hungry", names) is None


def test_what_is_read_and_missing_is_named_whatever_else_comes_near() -> None:
    told = solved("is there a swimming pool?", ("Sauna", "Toilets", "Reception"))
    assert told.place is None
    assert "pool" in " ".join(told.notes)
