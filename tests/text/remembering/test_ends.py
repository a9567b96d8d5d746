import pytest

from lpslam.text.remembering.ends import begins_by_case, is_lone_character


@pytest.mark.parametrize("text", ["当", "薬", "出", "茶", "停。"])
def test_what_signs_bear_by_itself_is_a_text(text: str) -> None:
    assert not is_lone_character(text)


@pytest.mark.parametrize("text", ["可", "习", "·向·"])
def test_other_characters_by_themselves_are_pieces(text: str) -> None:
    assert is_lone_character(text)


@pytest.mark.parametrize("text", ["药店", "P", "", "当A"])
def test_more_or_other_letters_are_no_lone_character(text: str) -> None:
    assert not is_lone_character(text)


@pytest.mark.parametrize(
    ("text", "begins"), [("Quill & Ink", True), ("uill & Ink", False), ("Illow", False), ("Ccent", False), ("", False)]
)
def test_words_begin_with_capitals_that_are_no_large_small_letters(text: str, begins: bool) -> None:
    assert begins_by_case(text) is begins
