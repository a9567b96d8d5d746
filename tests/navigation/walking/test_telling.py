"""Ways in words: sides, marks and seven languages; signs' words are never patterns."""

import json
from importlib.resources import files

import numpy as np
import pytest

from lpslam.navigation.walking.telling import LANGUAGES, Sign, length_told, told
from lpslam.navigation.walking.ways import Way

BENT = Way(np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 5.0]]), 1.0)


def test_a_bend_to_the_left_at_a_sign() -> None:
    kfc, goal = Sign("KFC", np.array([4.5, -1.0, 2.0])), Sign("Exit", np.array([3.0, 5.2, 2.0]))
    steps = told(BENT, [kfc], goal, "en", heading=0.0)
    assert steps == ["go 4 m", "at KFC, turn left", "go 5 m", "Exit is on your left"]
    assert told(BENT, [], goal, "en", heading=np.pi)[0] == "turn around"
    assert told(Way(BENT.points * [1.0, -1.0], 1.0), [], goal, "en")[1] == "turn right"
    assert length_told(BENT, "en") == "9 m, about 9 s"


def test_a_sign_that_is_far_from_where_the_way_ends_is_told_with_its_distance() -> None:
    """A sign over a shut off yard: one stands as near to it as the ground is known."""
    assert told(BENT, [], Sign("KFC", np.array([4.0, 17.0])), "en")[-1] == "KFC is ahead of you, 12 m away"
    assert told(BENT, [], Sign("KFC", np.array([4.0, 17.0])), "de")[-1] == "KFC ist vor Ihnen, 12 m entfernt"
    assert told(BENT, [], Sign("KFC", np.array([4.0, 7.0])), "en")[-1] == "KFC is ahead of you"


def test_where_one_goes_is_no_mark_of_a_turn_on_the_way() -> None:
    goal, twin = Sign("Exit", np.array([4.0, 2.0])), Sign("Exit", np.array([4.5, -1.0]))
    assert told(BENT, [goal], goal, "en", heading=0.0)[1] == "turn left"
    assert told(BENT, [goal, twin], goal, "en", heading=0.0)[1] == "at Exit, turn left"


def test_traditional_chinese_is_told_in_chinese() -> None:
    goal = Sign("A", np.array([4.0, 6.0]))
    assert told(BENT, [], goal, "zh-Hant") == told(BENT, [], goal, "zh") != told(BENT, [], goal, "en")


def test_hardly_a_turn_is_not_told() -> None:
    straight = Way(np.array([[0.0, 0.0], [3.0, 0.2], [6.0, 0.0], [9.0, 0.3]]), 1.0)
    assert told(straight, [], Sign("A", np.array([10.0, 0.0])), "en") == ["go 9 m", "A is ahead of you"]


@pytest.mark.parametrize("language", LANGUAGES)
def test_all_languages_say_all_of_it(language: str) -> None:
    folder = files("lpslam.navigation.walking").joinpath("data")
    words, english = (json.loads(folder.joinpath(f"{name}.json").read_text("utf-8")) for name in (language, "en"))
    assert words.keys() == english.keys()
    assert all(("{" in words[key]) == ("{" in english[key]) for key in english)
    goal = Sign("星巴克", np.array([4.0, 7.0]))
    steps = told(BENT, [Sign("KFC", np.array([4.5, -1.0]))], goal, language, 0.0)
    assert len(steps) == 4
    assert "KFC" in steps[1]
    assert "星巴克" in steps[3]
    assert "4" in steps[0]


@pytest.mark.parametrize("name", ["{turn}", "{name}{side}", "{0.__class__}", "%s", "{"])
def test_what_a_sign_says_is_never_a_pattern(name: str) -> None:
    steps = told(BENT, [Sign(name, np.array([4.5, -1.0]))], Sign(name, np.array([4.0, 6.0])), "en", 0.0)
    assert steps[1] == f"at {name}, turn left"
    assert steps[3] == f"{name} is ahead of you"


def test_an_unknown_language_is_told_in_english() -> None:
    assert told(BENT, [], Sign("A", np.array([4.0, 6.0])), "xx") == told(
        BENT, [], Sign("A", np.array([4.0, 6.0])), "en"
    )
