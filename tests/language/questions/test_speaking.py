"""The language of a question: by the script that most of it is in, and by its commonest words."""

import pytest

from lpslam.language.offline import OfflineModel
from lpslam.language.questions.speaking import is_surely_one, languages_of

KNOWLEDGE = OfflineModel()._knowledge


@pytest.mark.parametrize(
    ("text", "language"),
    [
        ("Zeig mir bitte den Weg zu 岡本教授", "de"),
        ("show me 佐々木教授", "en"),
        ("A号门，但不能是A号门", "zh"),
        ("我得去나래 안경，同事在那儿等我", "zh"),
        ("林教授 쪽으로 가려면 어떻게 하죠", "ko"),
        ("Professor Boyleはどこ？", "ja"),
    ],
)
def test_a_name_of_another_script_is_no_language(text: str, language: str) -> None:
    assert languages_of(text, KNOWLEDGE)[0] == language


def test_a_sentence_is_surely_in_one_language_and_a_few_words_are_not() -> None:
    assert is_surely_one("Where is the toilet?", KNOWLEDGE)
    assert not is_surely_one("gate B31", KNOWLEDGE)
    assert not is_surely_one("pan", KNOWLEDGE)
