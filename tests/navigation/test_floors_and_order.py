"""Floors, hours, counting along the way, lists of stops and wishes against themselves, on one map of two floors."""

import numpy as np
import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solution import Solution
from lpslam.navigation.solver import solve

BOARDS = [
    ("Main Entrance", (0.0, 0.0, 1.0), 90.0),
    ("Shoes & More", (8.0, 0.0, 1.0), 90.0),
    ("Pharmacy 8:00-18:00", (16.0, 0.0, 1.0), 90.0),
    ("Toilets", (24.0, 0.0, 1.0), 90.0),
    ("Bank", (32.0, 0.0, 1.0), 90.0),
    ("Bookshop", (4.0, 6.0, 1.0), -90.0),
    ("Café Luna 9am–5pm", (16.0, 6.0, 1.0), -90.0),
    ("Meeting Room 101", (24.0, 6.0, 1.0), -90.0),
    ("Meeting Room 102", (32.0, 6.0, 1.0), -90.0),
    ("Toilets", (24.0, 0.0, 6.0), 90.0),
    ("Meeting Room 201", (24.0, 6.0, 6.0), -90.0),
    ("Meeting Room 202", (32.0, 6.0, 6.0), -90.0),
    ("Night Bar 18:00-03:00", (16.0, 6.0, 6.0), -90.0),
    ("Lift", (28.0, 3.0, 1.0), 180.0),
]


@pytest.fixture(scope="module")
def model() -> OfflineModel:
    return OfflineModel()


def answered(model: OfflineModel, question: str) -> Solution:
    places, marks = [], []
    for id_, (name, position, facing) in enumerate(BOARDS):
        angle = np.radians(facing)
        places.append(Place(id_, name, np.array(position), np.array([np.cos(angle), np.sin(angle), 0.0])))
        marks.append(Candidate(id_, name))
    return solve(model.read_wish(question), places, model.scorer(marks), Here(np.array([20.0, 3.0, 1.0])))


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("the toilets upstairs", [9]),
        ("die Toiletten auf dieser Etage", [3]),
        ("2층 화장실", [9]),
        ("a café open at 10 am", [6]),
        ("a café open at 7 pm", [None]),
        ("a bar at eleven at night", [12]),
        ("the second shop from the main entrance, on the same side", [2]),
        ("un café, mais pas un café", [None]),
        ("the bank, but not the bank", [None]),
        ("pharmacy, bank, bookshop", [2, 4, 5]),
        ("first the pharmacy, then the bank and finally the bookshop", [2, 4, 5]),
        ("the toilets on the ninth floor", [None]),
        # A lift is on every floor that it leads to.
        ("mit dem Rollstuhl in den ersten Stock", [13]),
        ("mi madre va en silla de ruedas y tenemos que subir a la primera planta", [13]),
    ],
)
def test_answers(model: OfflineModel, question: str, expected: list[int | None]) -> None:
    solution = answered(model, question)
    assert [stop.place and stop.place.id for stop in solution.stops] == expected, solution.notes


def test_a_contradiction_says_so(model: OfflineModel) -> None:
    solution = answered(model, "the toilet on the first floor that is on the ground floor")
    assert solution.stops[0].place is None
    assert any("at once" in note for note in solution.notes)


def test_what_is_shut_is_told_with_its_hours(model: OfflineModel) -> None:
    solution = answered(model, "a café open at 7 pm")
    assert any("09:00 to 17:00" in note for note in solution.notes)


def test_neighbours_are_on_one_floor(model: OfflineModel) -> None:
    solution = answered(model, "what is opposite Meeting Room 201?")
    place = solution.stops[0].place
    assert place is not None
    assert place.id == 9


def test_an_anchor_whose_board_hangs_on_another_floor_is_not_on_the_map(model: OfflineModel) -> None:
    stop = answered(model, "the toilets next to the bank on floor 2").stops[-1]
    assert stop.place is None
    assert any("not on this map" in note for note in stop.notes)
