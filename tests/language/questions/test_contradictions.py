"""A wish that wants and refuses the same is told so; it is not answered with the next best."""

import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel

NAMES = ("KFC", "DRINKING WATER", "Pharmacy", "Café Luna", "Zara")
MARKS = [Candidate(number, name) for number, name in enumerate(NAMES)]


@pytest.mark.parametrize("question", ["coffee but not coffee", "a café that is no café", "not KFC but KFC"])
def test_what_is_wanted_and_refused_is_told(model: OfflineModel, question: str) -> None:
    choice = model.choose(question, MARKS)
    assert choice.landmark is None
    assert "wants and refuses the same" in choice.evidence


@pytest.mark.parametrize("question", ["coffee, but not from KFC", "shoes, but no sports shoes"])
def test_a_refusal_of_a_part_is_no_contradiction(model: OfflineModel, question: str) -> None:
    assert "refuses the same" not in model.choose(question, MARKS).evidence


def test_a_question_without_common_words_is_read_in_the_language_that_knows_its_words(model: OfflineModel) -> None:
    marks = [Candidate(1, "Hertz Car Rental"), Candidate(2, "Zara")]
    assert model.choose("car rental desk please", marks).landmark == 1
