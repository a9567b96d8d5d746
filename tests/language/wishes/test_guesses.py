"""Guesses by meaning: where tables find nothing sure, and never against what is asked for in so many words."""

from collections.abc import Sequence

import numpy as np
import pytest
from asking import solved

from lpslam.language.choosing.evidence import Support
from lpslam.language.choosing.guessing import COLUMNS, Guessing
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.signs.reader import load_sign_reader
from lpslam.language.tables.knowledge import load_knowledge
from lpslam.language.wishes.served import Way

MODEL = OfflineModel()
STREET = ("Tailor", "Bakery", "Aquarium", "Dental Surgery", "Opticians")


def found(question: str, boards: Sequence[str]) -> list[str | None]:
    return solved(MODEL, question, [(name,) for name in boards])


def guessing_of(boards: Sequence[str]) -> Guessing:
    knowledge = load_knowledge()
    index = LandmarkIndex([Candidate(at, name) for at, name in enumerate(boards)], load_sign_reader(), knowledge)
    return Guessing(index, Support(index, lambda word: set(), lambda word: set(), knowledge))


def test_what_no_table_reads_is_guessed_by_its_meaning() -> None:
    question = "everything is blurred when I drive at dusk"
    assert found(question, STREET) == ["Opticians"]
    served = MODEL.scorer([Candidate(at, name) for at, name in enumerate(STREET)]).serve(
        MODEL.read_wish(question).stops[0]
    )
    assert served.way is Way.GUESS


@pytest.mark.parametrize(
    "question", ["where can I moor a zeppelin", "I want to see a volcano", "eine Kirche für die Taufe"]
)
def test_what_is_not_here_is_not_guessed(question: str) -> None:
    assert found(question, STREET) == [None]


@pytest.mark.parametrize("boards", [("KFC",), ("KFC", "Pizza Hut"), ("Pizza Hut", "KFC", "Apple")])
def test_what_tables_know_stands_on_maps_of_a_few_signs(boards: Sequence[str]) -> None:
    assert found("I am hungry", boards)[0] in ("KFC", "Pizza Hut")
    assert found("I am hungry, but not pizza", boards) == ["KFC"]
    assert found("Where is Starbucks?", boards) == [None]


@pytest.mark.parametrize(("question", "board"), [("milk", "Dairy"), ("toilet", "Toilets"), ("fruit", "Fresh Fruit")])
def test_a_kind_in_so_many_words_is_not_doubted(question: str, board: str) -> None:
    assert found(question, ("Frozen Foods", board, "Bread")) == [board]


def test_a_guess_is_as_sure_on_a_map_of_many_numbered_boards_as_on_one_of_few() -> None:
    few = guessing_of(STREET).heard("my eyes are tired", "en", {})
    many = guessing_of([f"{name} {at}" for at in range(4) for name in STREET]).heard("my eyes are tired", "en", {})
    column = COLUMNS.index("board")
    assert np.allclose(few.columns[:, column].max(), many.columns[:, column].max())


def test_a_map_without_places_has_no_guess() -> None:
    assert found("bread", ("Danger High Voltage",)) == [None]
    assert found("bread", ()) == [None]


def test_what_is_read_and_not_here_is_answered_where_words_are_sure() -> None:
    boards = ("Cloakroom", "Canteen", "Toilets", "Lift", "Packing", "Loading Dock")
    assert found("my parka is soaked, where can I leave it", boards) == ["Cloakroom"]
    assert found("is there a swimming pool?", ("Water Dispenser", *boards)) == [None]


def test_what_words_say_outright_is_outdone_by_a_sure_guess_alone() -> None:
    boards = ("Information", "Left Luggage", "Café", "Restrooms", "Cloakroom")
    assert found("drop off my suitcase", boards) == ["Left Luggage"]
    assert found("the information desk", boards) == ["Information"]
    assert found("I want to eat", boards) == ["Café"]
