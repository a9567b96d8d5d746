import pytest

from lpslam.text.remembering.known_names import ends_are_there, is_spelt_as_names


@pytest.mark.parametrize(("text", "is_whole"), [("ill & Ink", False), ("书店", False), ("SHOE LAB", True)])
def test_a_begin_that_no_view_showed_is_one_if_names_begin_so(text: str, is_whole: bool) -> None:
    begin, end = ends_are_there(text, (0.0, 5.0))
    assert (begin > 0.5) is is_whole
    assert end == 1.0


@pytest.mark.parametrize(
    ("text", "is_whole"), [("和美", False), ("大利藥", False), ("面馆", True), ("FRESH JUICE", True)]
)
def test_an_end_that_no_view_showed_is_one_if_names_end_so(text: str, is_whole: bool) -> None:
    begin, end = ends_are_there(text, (5.0, 0.0))
    assert (end > 0.5) is is_whole
    assert begin == 1.0


def test_where_the_view_goes_on_nothing_is_asked() -> None:
    assert ends_are_there("ill & Ink", (0.4, 0.4)) == (1.0, 1.0)


def test_where_a_word_ends_only_ends_of_words_count() -> None:
    as_letters, _ = ends_are_there("ill & Ink", (0.0, 5.0))
    as_words, _ = ends_are_there("ill & Ink", (0.2, 5.0))
    assert as_letters < 0.01 < as_words


def test_letters_follow_each_other_as_in_names_or_as_in_rows_of_runes() -> None:
    assert all(map(is_spelt_as_names, ("Thistle & Oak", "Uniqlo", "Koke")))
    assert not any(map(is_spelt_as_names, ("HEYFPFFF", "IHCF", "GGGL", "11H411", "-")))


def test_a_capital_before_a_small_letter_begins_a_word_where_the_view_ends() -> None:
    by_case, _ = ends_are_there("Quill & Ink", (0.0, 5.0))
    assert by_case == ends_are_there("Quill & Ink", (0.2, 5.0))[0] > 0.5
    # Small letters may stand within one, and such capitals may be small letters.
    for text in ("quill & ink", "Compass & Rose", "QUILL & INK"):
        assert ends_are_there(text, (0.0, 5.0)) == ends_are_there(text.casefold(), (0.0, 5.0))
