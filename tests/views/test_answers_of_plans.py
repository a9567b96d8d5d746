"""A plan in words: each stop has its number, the last one too."""

from lpslam.pipeline import ask
from lpslam.views.answers import answer_text
from small_maps import small_map


def test_every_stop_of_a_plan_has_its_number() -> None:
    lines = answer_text(ask(small_map(), "First Pizza Hut, then KFC")).splitlines()
    assert [line[:3] for line in lines if line[:1].isdigit()] == ["1. ", "2. "]
    assert lines[1].startswith("2. KFC at ")
    assert not answer_text(ask(small_map(), "Where is KFC?")).startswith("1.")


def test_reasons_are_said_in_the_language_of_the_question() -> None:
    told = answer_text(ask(small_map(), "Wo ist KFC neben dem Bahnhof?"))
    assert "das Schild nennt den Namen; dem Bahnhof: nicht auf dieser Karte" in told
