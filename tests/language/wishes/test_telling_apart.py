"""Places of one kind, told apart: by colour and side, by whose they are, by what is left out of them."""

from functools import lru_cache

import numpy as np
import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.sorts import attributes_of, told_apart
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solver import solve

ROOMS = ("Salon Jaune", "Salon Rouge", "Entrée Nord", "Entrée Sud", "Kasse", "SB-Kasse", "Dorm A", "Dorm B", "Ramp 1")
ROOMS = (*ROOMS, "Ramp 2", "Ramp 3", "Brasserie Le Port", "Boulangerie Petit")


@lru_cache(maxsize=1)
def model() -> OfflineModel:
    return OfflineModel()


def answer(question: str, names: tuple[str, ...] = ROOMS) -> list[str | None]:
    marks = [Candidate(id_, name) for id_, name in enumerate(names)]
    places = [Place(mark.id, mark.name, np.array([5.0 * mark.id, 0.0, 0.0])) for mark in marks]
    solution = solve(model().read_wish(question), places, model().scorer(marks), Here(np.zeros(3)))
    return [None if stop.place is None else stop.place.name for stop in solution.stops]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("the red lounge", "Salon Rouge"),
        ("der gelbe Salon", "Salon Jaune"),
        ("the south entrance", "Entrée Sud"),
        ("the lounge that isn't the yellow one", "Salon Rouge"),
        ("un salon, mais pas le rouge", "Salon Jaune"),
        ("I want to pay, but not at the self-service till", "Kasse"),
        ("a dorm, but not dorm A", "Dorm B"),
        ("any ramp except 1 and 2", "Ramp 3"),
        ("un endroit où manger, mais pas la brasserie", "Boulangerie Petit"),
    ],
)
def test_what_tells_a_place_from_others_of_its_kind(question: str, expected: str) -> None:
    assert answer(question) == [expected]


def test_of_two_boards_with_the_name_that_is_said_the_number_tells() -> None:
    studios = ("Oberon Studio 1", "Oberon Studio 2", "Café Linde")
    assert answer("our brass band rehearses in Oberon 2", studios) == ["Oberon Studio 2"]


@pytest.mark.parametrize("question", ["the green lounge", "l'entrée est"])
def test_a_room_of_another_colour_or_side_is_none(question: str) -> None:
    assert answer(question) == [None]


def test_an_attribute_says_what_a_place_is_not() -> None:
    assert attributes_of("Salon Bleu") == {("colour", "blue")}
    asked = attributes_of("the blue lounge")
    assert told_apart(asked, attributes_of("Salon Bleu")) == 1
    assert told_apart(asked, attributes_of("Salon Vert")) == -1
    assert told_apart(asked, attributes_of("Salon")) == 0
    # A pumpkin grows in no south, and a copula is no east.
    assert not attributes_of("南瓜粥")
    assert not attributes_of("où est-ce")


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("the shop", "Museum Shop"),
        ("la tienda", "Museum Shop"),
        ("Tanaka", "Prof. Tanaka"),
        ("田中先生", "Prof. Tanaka"),
        ("Dr. Wang", "王医生"),
        ("room 104", "Chambre l04"),
        ("counter C", "值机柜台 A-F"),
        ("会议室三", "Meeting Room 3"),
    ],
)
def test_names_people_and_codes_across_scripts_and_misreadings(question: str, expected: str) -> None:
    names = ("Museum Shop", "Prof. Tanaka", "김서연 교수 Prof. Kim Seo-yeon", "王医生", "Chambre 101", "Chambre l04")
    assert answer(question, (*names, "C-06", "C-O7", "值机柜台 A-F", "Meeting Room 2", "Meeting Room 3")) == [expected]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("milk, then bread, then the exit", ["Dairy", "Bakery", "Exit"]),
        ("bread, milk and then to the exit", ["Bakery", "Dairy", "Exit"]),
        ("パンを買ってから出口に行きたい", ["Bakery", "Exit"]),
        ("Nachdem ich Brot gekauft habe, suche ich den Ausgang", ["Bakery", "Exit"]),
        ("après la boulangerie, la sortie", ["Bakery", "Exit"]),
        # No meeting is on this map: it says when, not where.
        ("before going to the meeting, some bread", ["Bakery"]),
    ],
)
def test_plans_list_their_stops_and_say_what_comes_after(question: str, expected: list[str]) -> None:
    assert answer(question, ("Dairy", "Bakery", "Exit", "Toilets")) == expected


WHOSE = (
    "Women's Changing Room",
    "Men's Changing Room",
    "Emergency",
    "Children's Emergency",
    "大浴場(男)",
    "大浴場(女)",
    "Café",
)


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("where does my wife get changed?", "Women's Changing Room"),
        ("mi marido quiere cambiarse de ropa", "Men's Changing Room"),
        ("the changing room, for men", "Men's Changing Room"),
        ("아내는 어디서 옷을 갈아입어요", "Women's Changing Room"),
        ("妻はお風呂", "大浴場(女)"),
        ("男の大浴場", "大浴場(男)"),
        ("Casualty, please, for my little boy", "Children's Emergency"),
        ("the emergency room, but not the children's", "Emergency"),
        ("ma femme veut un café", "Café"),
        ("ein Kaffee für meinen Sohn", "Café"),
    ],
)
def test_who_it_is_for_tells_places_of_a_kind_apart(question: str, expected: str) -> None:
    assert answer(question, WHOSE) == [expected]
