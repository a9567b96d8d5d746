"""Wishes that say the order last, or spell a name as it is heard."""

import numpy as np
import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solution import Solution
from lpslam.navigation.solver import solve

NAMES = ("Bakery", "Pharmacy", "Bank", "Bookshop", "Hairdresser", "Jean-Claude Biguine", "Marionnaud")


def solved(question: str, names: tuple[str, ...] = NAMES, heights: tuple[float, ...] = ()) -> Solution:
    model = OfflineModel()
    marks = [Candidate(id_, name) for id_, name in enumerate(names)]
    places = [
        Place(id_, name, np.array([8.0 * id_, 0.0, heights[id_] if heights else 0.0]), np.array([0.0, 1.0, 0.0]))
        for id_, name in enumerate(names)
    ]
    return solve(model.read_wish(question), places, model.scorer(marks), Here())


def found(question: str, names: tuple[str, ...] = NAMES, heights: tuple[float, ...] = ()) -> list[str | None]:
    return [stop.place and stop.place.name for stop in solved(question, names, heights).stops]


@pytest.mark.parametrize(
    "question",
    [
        *("I want to go to the bookshop, but only after the bank", "the bookshop, but before that the bank"),
        *("In die Buchhandlung, aber vorher zur Bank", "La librairie, mais d'abord la banque"),
        *("La librería, pero antes el banco", "去书店，但要先去银行", "本屋に行きたいけど、その前に銀行"),
    ],
)
def test_what_must_come_first_is_first_wherever_it_is_said(question: str) -> None:
    assert found(question) == ["Bank", "Bookshop"]


@pytest.mark.parametrize("question", ["chez Marionaud", "Zu Schan Klod Bigin"])
def test_a_name_is_found_by_how_it_sounds(question: str) -> None:
    assert found(question)[0] in ("Marionnaud", "Jean-Claude Biguine")


@pytest.mark.parametrize("question", ["chez Dumontel", "Zu Friedrich Hollerbach"])
def test_another_name_is_none(question: str) -> None:
    assert found(question) == [None]


def test_of_two_names_that_sound_alike_none_is_guessed() -> None:
    def sounding(*boards: str) -> set[int]:
        marks = [Candidate(id_, board) for id_, board in enumerate(boards)]
        return set(OfflineModel().scorer(marks)._names.sounding(["bernadot"]))

    assert sounding("Bernadotte", "Kowalewski") == {0}
    assert sounding("Bernadotto", "Bernadotta") == set()


def test_upstairs_is_above_the_ground_floor_where_nobody_says_where_they_stand() -> None:
    names, heights = ("Bakery", "Pizzeria Roma", "Bank", "Sushi Bar"), (0.0, 0.0, 4.0, 4.0)
    assert found("somewhere to eat upstairs", names, heights) == ["Sushi Bar"]
    assert any("where you stand" in note for note in solved("somewhere to eat upstairs", names, heights).notes)


def test_a_plan_has_no_gap_where_its_stops_are_likely() -> None:
    names = ("Reception", "Nurse Clinic", "Payments")
    assert found("Check in first, then the jab at the nurse's, then pay", names)[:2] == ["Reception", "Nurse Clinic"]


@pytest.mark.parametrize("question", ["Where is a restaurant?", "Is there a restaurant?", "restaurant"])
def test_a_kind_asked_for_in_so_many_words_is_not_doubted_beside_unread_signs(question: str) -> None:
    assert found(question, ("KFO", "Pizza Hut 必胜客", "Toilets", "KFC")) in (["KFC"], ["Pizza Hut 必胜客"])
