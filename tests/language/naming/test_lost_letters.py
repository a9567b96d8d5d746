"""A gap within a word is a letter that no view shows; a space between two words is a space."""

import pytest

from lpslam.language.model import Reading
from lpslam.language.naming.lost_letters import LostLetters
from lpslam.language.offline import embedded_model

LOST = LostLetters({"velour", "quilts", "hotspot", "toilet", "moor"}, {"to", "let"}, ["Happy Hot Pot", "Hot Pot House"])


@pytest.mark.parametrize(
    ("text", "filled"),
    [
        ("Old Vel ur Mill", ["Old Velour Mill"]),
        ("V lour", ["Velour"]),
        ("QU LTS", ["QUILTS"]),
        ("vel our", []),
        ("HOT POT", []),
        ("TO LET", []),
        ("mo r", []),
        ("Vel-ur & Q ilts", ["Vel-ur & Quilts"]),
        ("", []),
    ],
)
def test_a_space_is_a_lost_letter_if_the_word_is_known_with_it_alone(text: str, filled: list[str]) -> None:
    assert list(LOST.filled(text)) == filled
    assert len(LOST.spaces(text)) == len(filled)


def test_a_dead_tube_in_a_word_of_signs_is_read_as_its_letter() -> None:
    model = embedded_model()
    assert model.name([Reading("Orsol Haberdash ry", 9, 0.97, 0.95, 3.0)]).name == "Orsol Haberdashery"
    assert model.name([Reading("Orsol Ta lor", 9, 0.97, 0.95, 3.0)]).name == "Orsol Tailor"
    assert model.name([Reading("Orsol To Let", 9, 0.97, 0.95, 3.0)]).name == "Orsol To Let"
    assert model.name([Reading("Orsol Hot Pot", 9, 0.97, 0.95, 3.0)]).name == "Orsol Hot Pot"


def test_a_rare_word_that_signs_bear_makes_a_name_surer_than_none() -> None:
    model = embedded_model()
    known, unknown = (
        model.name([Reading(text, 3, 0.9, 0.6, 1.0)]).confidence for text in ("Orsol Haberdashery", "Orsol Habqrdashry")
    )
    assert known > unknown
