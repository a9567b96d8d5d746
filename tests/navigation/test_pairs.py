"""What is between two places tells which two are meant, where their words do not."""

from collections.abc import Sequence

import numpy as np
import pytest

from lpslam.config import NavigationConfig
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.form import Relation
from lpslam.navigation.pairs import meant_pair
from lpslam.navigation.places import Here, Place, Straight
from lpslam.navigation.relations import Scene
from lpslam.navigation.sites import Sites

ROW = [Place(at, name, np.array([10.0 * at, 0.0, 0.0])) for at, name in enumerate("ABCDEF")]
ACROSS = [Place(10 + at, name, np.array([10.0 * at, 4.0, 0.0])) for at, name in enumerate("uvwxyz")]


def pair(found: Sequence[str], likely: Sequence[str]) -> list[str]:
    by_name = {place.name: place for place in (*ROW, *ACROSS)}
    scene = Scene(Sites([*ROW, *ACROSS]), Here(), Straight(), NavigationConfig())
    each = ([[by_name[name] for name in names] for names in said] for said in (found, likely))
    return ["".join(place.name for place in places) for places in meant_pair(*each, scene)]


@pytest.mark.parametrize(
    ("found", "likely", "meant"),
    [
        (("A", "C"), ("A", "C"), ["A", "C"]),
        (("A", ""), ("A", "FC"), ["A", "C"]),
        (("A", ""), ("A", "F"), ["A", ""]),
        # Far apart, and nothing likelier: as they were found.
        (("A", "F"), ("A", "F"), ["A", "F"]),
        (("F", "C"), ("FA", "C"), ["A", "C"]),
        # What stands across from what is between is not between.
        (("u", ""), ("u", "Bw"), ["u", "w"]),
        # One place is no pair.
        (("A", "A"), ("AC", "AC"), ["A", "C"]),
    ],
)
def test_two_are_meant_that_have_one_place_between_them(
    found: Sequence[str], likely: Sequence[str], meant: list[str]
) -> None:
    assert pair(found, likely) == meant


def test_a_letter_alone_is_of_what_is_said_before() -> None:
    model = OfflineModel()
    for question, first, second in (
        ("what is between arms A and C?", "arms A", "arms C"),
        ("Was ist zwischen Steg A und C?", "Steg A", "Steg C"),
        ("¿Qué hay entre la puerta 3 y la 5?", "la puerta 3", "la puerta 5"),
        ("what is between gate 3 and the bank?", "gate 3", "the bank"),
    ):
        (stop,) = model.read_wish(question).stops
        assert stop.relation is Relation.BETWEEN
        assert [each.what for each in stop.anchor] == [first, second]
