"""Stops of a plan are read in the language of the whole question: a few words alone may be of any."""

import numpy as np
import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.form import Wish
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solution import Solved
from lpslam.navigation.solver import solve

NAMES = ("Reception", "Nurse Clinic", "Payments & Insurance", "Toilets")


def stops(question: str, names: tuple[str, ...] = NAMES) -> tuple[Solved, ...]:
    model = OfflineModel()
    marks = [Candidate(id_, name) for id_, name in enumerate(names)]
    places = [Place(id_, name, np.array([8.0 * id_, 0.0, 0.0])) for id_, name in enumerate(names)]
    return solve(model.read_wish(question), places, model.scorer(marks), Here()).stops


def test_pay_is_english_in_an_english_plan() -> None:
    solved = stops("Check in first, then the jab at the nurse's, then pay")
    assert [each.stop.language for each in solved] == ["en"] * 3
    assert [each.place and each.place.name for each in solved] == ["Reception", "Nurse Clinic", "Payments & Insurance"]


@pytest.mark.parametrize(
    ("question", "names", "said"),
    [
        ("Check in first, then the toilet, then pay", ("Reception", "Toilets"), "asked for"),
        ("erst zum Empfang, dann aufs Klo, dann Brot kaufen", ("Empfang", "WC"), "gesucht"),
    ],
)
def test_why_not_is_said_in_the_language_of_the_whole(question: str, names: tuple[str, ...], said: str) -> None:
    last = stops(question, names)[-1]
    assert last.place is None
    assert said in " ".join(last.notes)


def test_the_language_of_a_stop_is_kept_in_a_document() -> None:
    wish = OfflineModel().read_wish("first the toilet, then a coffee")
    assert [each.language for each in Wish.from_document(wish.to_document()).stops] == ["en", "en"]


def test_a_question_of_one_stop_is_in_no_language_given() -> None:
    assert [each.language for each in OfflineModel().read_wish("the toilet").stops] == [None]


def test_a_plan_is_in_the_language_of_the_words_that_order_it() -> None:
    # No common word of German is in it but those; the reason of “Pizza” was said in English.
    wish = OfflineModel().read_wish("Zuerst zur Toilette, dann Pizza")
    assert [(stop.what, stop.language) for stop in wish.stops] == [("zur Toilette", "de"), ("Pizza", "de")]


@pytest.mark.parametrize(
    "question", ["everything is blurred when I drive at dusk", "first bread, then everything is blurred at dusk"]
)
def test_a_guess_that_is_told_is_told_with_how_probable_it_is(question: str) -> None:
    last = stops(question, ("Tailor", "Bakery", "Aquarium", "Opticians"))[-1]
    assert last.place is not None
    assert last.place.name == "Opticians"
    assert last.confidence >= 0.25


BOARDS = ("Registrar", "Citizens Advice", "Bike Sheds", "Admissions Office", "Refectory", "Print Shop", "Toilets")


@pytest.mark.parametrize(
    ("question", "names"),
    [
        ("register a birth and then use the toilet", ["Registrar", "Toilets"]),
        ("park my bike, eat a hot meal and finally print my flyer", ["Bike Sheds", "Refectory", "Print Shop"]),
    ],
)
def test_the_map_says_whether_a_text_has_several_stops(question: str, names: list[str]) -> None:
    assert [each.place and each.place.name for each in stops(question, BOARDS)] == names


def test_other_readings_of_a_wish_are_kept_in_a_document() -> None:
    wish = OfflineModel().read_wish("park the bike, sign up, eat something and finally print my flyer")
    assert len(wish.stops) == 4
    assert wish.instead is not None
    assert len(wish.instead.stops) == 2
    assert Wish.from_document(wish.to_document()) == wish


@pytest.mark.parametrize(
    ("question", "names"),
    [
        ("bread, a bottle of wine and a coffee", ("Bakery", "Wine Shop", "Café")),
        ("aceite, una botella de vino y pan", ("Pasillo 3 Aceite", "Vinos", "Panadería")),
        ("buy bread, then wash my hands", ("Bakery", "Toilets")),
    ],
)
def test_a_list_ends_with_and(question: str, names: tuple[str, ...]) -> None:
    assert [each.place and each.place.name for each in stops(question, (*names, "Exit"))] == list(names)


@pytest.mark.parametrize(
    "question", ["my trousers are too long, can someone shorten them", "I'm thirsty, a coffee please"]
)
def test_what_is_told_beside_a_wish_is_no_stop(question: str) -> None:
    assert len(stops(question, ("Tailor", "Café", "Hairdresser", "Toilets"))) == 1
