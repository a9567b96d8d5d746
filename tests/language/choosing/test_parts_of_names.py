"""A place is refused by the part of its name that people say."""

import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel

SIGNS = [
    "Barbier Hassan",
    "Coiffure Lucille",
    "Pizzeria Giacomo",
    "Trattoria Beppe",
    "Sommer Apotheke",
    "Bäckerei Huber",
    "Toilet",
]


def answer(question: str) -> str | None:
    chosen = OfflineModel().choose(question, [Candidate(at, name) for at, name in enumerate(SIGNS)]).landmark
    return None if chosen is None else SIGNS[chosen]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("I need a haircut, but not at Hassan's", "Coiffure Lucille"),
        ("any hairdresser except Lucille", "Barbier Hassan"),
        ("Ich brauche einen Haarschnitt, aber nicht bei Hassan", "Coiffure Lucille"),
        # A trattoria has pizza too.
        ("une pizzeria, mais pas chez Giacomo", "Trattoria Beppe"),
        ("Gibt es noch eine andere Pizzeria außer Giacomo?", "Trattoria Beppe"),
        ("a bakery but not Huber's", None),
    ],
)
def test_who_is_refused_by_a_part_of_the_name_is_not_chosen(question: str, expected: str | None) -> None:
    assert answer(question) == expected


@pytest.mark.parametrize("question", ["ich will im Sommer Pizza essen", "where can I get pizza at Giacomo's"])
def test_a_word_that_is_part_of_a_name_asks_for_nothing_by_itself(question: str) -> None:
    assert answer(question) == "Pizzeria Giacomo"
