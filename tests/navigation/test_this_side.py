"""“On this side of”, in seven languages; and lists of shops without what belongs to the house."""

import numpy as np
import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.form import Relation
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solution import Solution
from lpslam.navigation.solver import solve

MODEL = OfflineModel()
NAMES = ("Café Luna", "Zara", "Pharmacy", "Starbucks", "DRINKING WATER", "Toilets")


def answered(question: str) -> Solution:
    places = [Place(at, name, np.array([5.0 * at, 0.0, 0.0])) for at, name in enumerate(NAMES)]
    scorer = MODEL.scorer([Candidate(at, name) for at, name in enumerate(NAMES)])
    return solve(MODEL.read_wish(question), places, scorer, Here(np.array([-2.0, 0.0, 0.0])))


@pytest.mark.parametrize(
    "question",
    [
        "a café on this side of the pharmacy",
        "un café de este lado de la Pharmacy",
        "ein Café diesseits der Pharmacy",
        "un café de ce côté de Pharmacy",
        "Pharmacy这边的咖啡店",
        "Pharmacyのこちら側のカフェ",
        "Pharmacy 이쪽에 있는 카페",
    ],
)
def test_this_side_is_nearer_than_the_anchor(question: str) -> None:
    (stop,) = answered(question).stops
    assert stop.stop.relation is Relation.THIS_SIDE
    assert stop.place is not None
    assert stop.place.name == "Café Luna"


def test_a_list_of_shops_holds_nothing_of_the_house() -> None:
    (stop,) = answered("list all shops").stops
    assert stop.place is not None
    assert {stop.place.name, *(each.name for each in stop.others)} == {"Café Luna", "Zara", "Pharmacy", "Starbucks"}
