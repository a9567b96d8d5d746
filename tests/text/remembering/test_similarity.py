from functools import cache

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.text.remembering.similarity import best_class, comparison_key, is_fragment, similarity

# Few letters, so that equal letters meet often; Chinese among them.
texts = st.text(alphabet="abA 星巴克'", max_size=8)


def paper_distance(a: str, b: str) -> int:
    """Eq. 1 and 2, letter by letter as they stand."""

    @cache
    def d(i: int, j: int) -> int:
        if i == 0 or j == 0:
            return i + j
        k = 1 if a[i - 1] == b[j - 1] else 0
        return 1 + min(d(i - 1, j), d(i, j - 1), d(i - 1, j - 1) - k)

    return d(len(a), len(b))


@given(texts, texts)
def test_similarity_is_eq_1_to_3(a: str, b: str) -> None:
    longest = max(len(a), len(b))
    expected = 1.0 - paper_distance(a, b) / longest if longest else 1.0
    assert similarity(a, b) == pytest.approx(expected)


@given(texts, texts)
def test_similarity_is_symmetric_and_bounded(a: str, b: str) -> None:
    assert similarity(a, b) == similarity(b, a)
    assert 0.0 <= similarity(a, b) <= 1.0
    assert (similarity(a, b) == 1.0) == (a == b)


def test_misreadings_of_the_paper_find_their_class() -> None:
    classes = {1: ["Alienware"], 2: ["请勿拍打"], 3: ["HIGHTEMPERATURE"], 4: ["Don't Touch"]}
    for text, expected in {
        "Allenware": 1,
        "Alienvvare": 1,
        "Aiienware": 1,
        "请切拍打": 2,
        "HIG/eMPERAURe": 3,
        "Dont'tTouch": 4,
        "Don'tlouch": 4,
    }.items():
        assert best_class(text, classes, 0.6) == expected, text
    assert best_class("GUCCI", classes, 0.6) is None


def test_the_most_similar_class_wins_whatever_the_order() -> None:
    assert best_class("WASHROOM", {1: ["BATHROOM"], 2: ["WASHROOM"]}, 0.6) == 2
    assert best_class("WASHROOM", {2: ["WASHROOM"], 1: ["BATHROOM"]}, 0.6) == 2


def test_the_threshold_is_reached_not_passed() -> None:
    assert best_class("KFG", {1: ["KFC"]}, 2 / 3 - 1e-9) == 1
    assert best_class("KFG", {1: ["KFC"]}, 0.67) is None


def test_case_and_spaces_are_ignored_in_comparing() -> None:
    assert comparison_key("No  Smoking") == comparison_key("NOSMOKING")
    assert best_class("no smoking", {1: ["NOSMOKING"]}, 1.0) == 1


def test_fragments() -> None:
    assert is_fragment("STARB", "STARBUCKS")
    assert is_fragment("TARBUCK", "STARBUCKS COFFEE")
    assert is_fragment("巴克", "星巴克")
    assert not is_fragment("STARBUCKS", "STARBUCKS")
    assert not is_fragment("GUCCI", "STARBUCKS COFFEE")
