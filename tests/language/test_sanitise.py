"""Text read in the world is made safe before anything else sees it."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.language.sanitise import clean_text


@pytest.mark.parametrize(
    ("painted", "clean"),
    [
        ("  KFC \n", "KFC"),
        ("ＫＦＣ", "KFC"),
        ("Don't\tTouch", "Don't Touch"),
        ("必胜客\u200b欢乐餐厅", "必胜客欢乐餐厅"),
        ("\u202eTIXE\u202c", "TIXE"),
        ("a\x00b\x1b[31mc", "ab[31mc"),
        ("\ufeff\u2066 \u2069", ""),
        ("ﬁsh ＆ chips", "fish & chips"),
        ("caf\u0065\u0301", "café"),
    ],
)
def test_known_strings(painted: str, clean: str) -> None:
    assert clean_text(painted) == clean


def test_length_is_capped_even_where_normalising_grows_the_text() -> None:
    assert len(clean_text("\ufdfa" * 500, 40)) <= 40
    assert clean_text("abc", 0) == ""
    assert clean_text("word " * 100, 10) == "word word"


@given(st.text(max_size=120), st.integers(0, 60))
def test_result_is_seen_short_and_stable(text: str, limit: int) -> None:
    clean = clean_text(text, limit)
    assert len(clean) <= limit
    assert clean == clean.strip()
    assert all(unicodedata.category(ch) not in {"Cc", "Cf", "Cn", "Co", "Cs"} for ch in clean)
    assert clean_text(clean, limit) == clean


def test_bytes_of_letters_are_letters() -> None:
    """As a system whose locale is ASCII passes them on."""
    question = "哪里有咖啡？"
    assert clean_text(question.encode().decode("ascii", "surrogateescape")) == clean_text(question)
    assert clean_text("caf\udcc3\udca9 \udcff") == "café"
    assert clean_text("a\ud800b") == "ab"
