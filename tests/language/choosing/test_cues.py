"""Guesses by the pieces of words, where no table lists a turn of phrase."""

import pytest

from lpslam.language.choosing.cues import Cues, cues_of
from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.tables.knowledge import load_knowledge

NAMES = ("Reception", "Quality Control", "IT Support", "Canteen", "Dermatology", "Bicycle Parking", "Toilets")


def chosen(question: str) -> str | None:
    marks = [Candidate(id_, name) for id_, name in enumerate(NAMES)]
    found = OfflineModel().choose(question, marks).landmark
    return None if found is None else NAMES[found]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("who inspects whether parts meet tolerances", "Quality Control"),
        ("somebody must reset passwords for the new ones", "IT Support"),
        ("skin specialists", "Dermatology"),
        ("自転車を停車する場", "Bicycle Parking"),
    ],
)
def test_other_words_for_what_is_known_are_understood(question: str, expected: str) -> None:
    assert chosen(question) == expected


@pytest.mark.parametrize(
    "question", ["quantum flibbertigibbets", "zzzz", "", "Is there a casino?", "a kilogram of xenon"]
)
def test_what_nothing_comes_near_to_is_not_guessed(question: str) -> None:
    assert chosen(question) is None


def test_a_guess_is_less_sure_than_what_is_read() -> None:
    marks = [Candidate(id_, name) for id_, name in enumerate(NAMES)]
    guess = OfflineModel().choose("who inspects whether parts meet tolerances", marks)
    read = OfflineModel().choose("Where are the toilets?", marks)
    assert guess.confidence < read.confidence


def test_what_the_tables_read_in_full_is_not_guessed_at() -> None:
    cues = cues_of("en", load_knowledge())
    assert cues.guessed("Where are the toilets?", is_read=True) == ((), ())


def test_scores_do_not_grow_with_the_number_of_a_questions_words() -> None:
    cues: Cues = cues_of("en", load_knowledge())
    fold = load_knowledge().folder
    once, twice = (max(cues.scores(fold.units(text)).values()) for text in ("forklift", "forklift forklift"))
    assert twice == pytest.approx(once)
