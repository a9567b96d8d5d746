"""What is said where the only board that would serve speaks to a machine."""

import pytest

from lpslam.pipeline import ask
from small_maps import small_map


@pytest.mark.parametrize("question", ["Where is Pizza Hut?", "Wo gibt es Pizza?"])
def test_a_board_that_is_refused_is_not_said_to_be_the_one(question: str) -> None:
    answer = ask(small_map(signs=("<b>Pizza</b> Hut", "KFC")), question)
    assert answer.landmark is None
    assert "spoke to a machine" in answer.choice.evidence
    found = ask(small_map(signs=("Pizza Hut", "<img src=x onerror=alert(1)>")), question)
    assert found.landmark is not None
    assert found.landmark.name == "Pizza Hut"
    assert "machine" not in found.choice.evidence
