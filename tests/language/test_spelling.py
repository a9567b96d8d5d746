"""Readers as a noisy channel: which painted text explains what was read."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.language.model import Reading
from lpslam.language.offline import OfflineModel
from lpslam.language.spelling import misreading_cost, weigh

letters = st.text("abcdefgmnorst必胜客", min_size=1, max_size=10)


def looks(text: str) -> str:
    return text.replace("0", "o")


@given(letters, letters)
def test_only_the_text_itself_costs_nothing(painted: str, read: str) -> None:
    assert (misreading_cost(painted, read, looks) == 0.0) == (painted == read)


def test_a_cut_end_is_cheaper_than_the_same_letters_lost_inside() -> None:
    cut = misreading_cost("starbucks", "starb", looks)
    assert cut < misreading_cost("starbucks", "stcks", looks)
    assert misreading_cost("starbucks", "bucks", looks) == cut
    assert misreading_cost("starbucks", "starbuck", looks) < misreading_cost("starbucks", "starbuxks", looks)


def test_letters_that_look_alike_are_cheaper_to_confuse() -> None:
    assert misreading_cost("room", "r0om", looks) == misreading_cost("restroom", "rcstroom", looks)
    assert misreading_cost("room", "r0om", looks) < misreading_cost("room", "rxom", looks)


def test_repetition_counts_for_less_than_variety() -> None:
    weights = weigh([("a", 4, 1.0), ("b", 1, 1.0), ("b", 1, 0.5), ("", 3, 1.0)])
    assert 2.0 < weights["a"] < 4.0
    assert weights["b"] == pytest.approx(0.75 * 2**0.75)
    assert set(weights) == {"a", "b"}


@pytest.mark.parametrize(
    ("readings", "name"),
    [
        # The same slip again and again, and the word itself now and then.
        ([("RESTROON", 3, 0.95), ("RESTROOM", 2, 0.95)], "RESTROOM"),
        ([("心胜客", 3, 0.9), ("必胜客", 1, 0.9)], "必胜客"),
        ([("Comouter", 5, 0.9), ("Computer", 3, 0.9), ("Comauter", 1, 0.9), ("Cemsuter", 1, 0.8)], "Computer"),
        # A brand that is a piece of what was painted.
        ([("Mobile", 3, 0.96), ("Mobil", 2, 0.95), ("Mob", 1, 1.0), ("Moble", 1, 0.7)], "Mobile"),
        # Read well and often, an unknown name is no misread brand.
        ([("GAO", 5, 0.95)], "GAO"),
        ([("ZAPA", 12, 0.97)], "ZAPA"),
        ([("Stardocks Coffee", 8, 0.97)], "Stardocks Coffee"),
        # Seen poorly but always so, a warning is not the commoner one.
        ([("当心碰头", 6, 0.43), ("当心磁头", 1, 0.33)], "当心碰头"),
        ([("肯德墓", 3, 0.8)], "肯德基"),
        # Whole, where most readings were cut off.
        ([("Blue Lantern", 2, 0.9), ("Blue Lan", 4, 0.95), ("ue Lantern", 2, 0.9)], "Blue Lantern"),
    ],
)
def test_names(readings: list[tuple[str, int, float]], name: str) -> None:
    assert OfflineModel().name([Reading(*each) for each in readings]).name == name


@pytest.mark.parametrize(("one", "other"), ["未末", "土士", "人入", "ce", "oq", "8b"])
def test_letters_that_look_alike_from_afar_are_cheap_to_confuse(one: str, other: str) -> None:
    assert misreading_cost(one, other, looks) == misreading_cost(other, one, looks) < misreading_cost(one, "x", looks)


def test_a_mark_of_a_brand_that_was_read_once_is_kept() -> None:
    readings = [Reading("WENDYS", 5, 0.95), Reading("WENDY'S", 1, 0.9)]
    assert OfflineModel().name(readings).name == "WENDY'S"
