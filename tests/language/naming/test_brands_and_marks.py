"""A shop that is called like a known brand keeps the marks that are painted."""

import pytest

from lpslam.language.model import Reading
from lpslam.language.offline import embedded_model


@pytest.mark.parametrize(
    ("often", "once", "name"),
    [
        ("FOSTER'S", "FOSTERS", "FOSTER'S"),
        ("FOSTERS", "FOSTER'S", "FOSTERS"),
        ("MCDONALDS", "MCDONALD'S", "MCDONALD'S"),
        ("BURGERKING", "BURGER KING", "BURGER KING"),
    ],
)
def test_marks_that_most_readings_have_stay_and_a_brands_own_need_but_one(often: str, once: str, name: str) -> None:
    read = [Reading(often, 5, 0.99, 0.99, 3.5), Reading(once, 1, 0.99, 0.99, 1.0)]
    assert embedded_model().name(read).name == name
