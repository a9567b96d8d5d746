"""Readers as a noisy channel: which painted text explains what was read."""

from collections.abc import Callable
from math import log

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.language.model import Reading, Slots
from lpslam.language.naming.channel import Seen, evidence_of, log_likelihood, paint_key
from lpslam.language.offline import embedded_model

letters = st.text("abcdefgmnorst必胜客", min_size=1, max_size=10)


def looks(text: str) -> str:
    return text.replace("0", "o")


def misreading_cost(painted: str, read: str, looks: Callable[[str], str], right: float = 0.8) -> float:
    return -log_likelihood(painted, [Seen(read, right, 1.0)], looks)


@given(letters, letters)
def test_only_the_text_itself_costs_no_more_than_doubt(painted: str, read: str) -> None:
    least = misreading_cost(read, read, looks)
    assert least == pytest.approx(-log(0.8))
    assert (misreading_cost(painted, read, looks) == least) == (painted == read)


def test_a_cut_end_is_cheaper_than_the_same_letters_lost_inside() -> None:
    cut = misreading_cost("starbucks", "starb", looks)
    assert cut < misreading_cost("starbucks", "stcks", looks)
    assert misreading_cost("starbucks", "bucks", looks) == pytest.approx(cut, abs=0.5)
    assert misreading_cost("starbucks", "starbuck", looks) < misreading_cost("starbucks", "starbuxks", looks)


def test_letters_that_look_alike_are_cheaper_to_confuse() -> None:
    assert misreading_cost("room", "r0om", looks) < misreading_cost("room", "rxom", looks)


def test_repetition_counts_for_less_than_variety() -> None:
    readings = [Reading("a", 4, 0.8), Reading("b", 1, 0.8), Reading("B ", 1, 0.8), Reading("-", 3, 1.0)]
    seen = {each.key: each for each in evidence_of(readings)}
    assert set(seen) == {"a", "b"}
    assert 2.0 < seen["a"].weight < 4.0
    assert seen["b"].weight == 2.0


def test_readings_that_contradict_each_other_are_less_sure_than_they_say() -> None:
    alone = evidence_of([Reading("abcd", 2, 0.9, 0.9, 1.0)])
    against = evidence_of([Reading("abcd", 2, 0.9, 0.9, 1.0), Reading("xbcy", 2, 0.9, 0.9, 1.0)])
    assert alone[0].right == pytest.approx(0.9)
    assert sum(each.weight * each.right for each in against) <= 1.0


@given(letters, letters, st.floats(0.1, 0.98))
def test_a_surer_reading_says_more_against_what_it_does_not_read(painted: str, read: str, right: float) -> None:
    if painted != read:
        against = [
            misreading_cost(painted, read, looks, sure) - misreading_cost(read, read, looks, sure)
            for sure in (right, right + 0.01)
        ]
        assert against[0] <= against[1] + 1e-9


def test_what_the_reader_held_for_possible_is_cheap() -> None:
    sure = evidence_of([Reading("abc", 1, 0.9, 0.9, 1.0, ((("a", 0.99),), (("b", 0.99),), (("c", 0.99),)))])[0]
    unsure = evidence_of(
        [Reading("abc", 1, 0.9, 0.9, 1.0, ((("a", 0.99),), (("b", 0.55), ("x", 0.4)), (("c", 0.99),)))]
    )[0]
    assert log_likelihood("axc", [unsure], looks) > log_likelihood("axc", [sure], looks) + 2.0
    assert log_likelihood("axc", [unsure], looks) < log_likelihood("abc", [unsure], looks)


def test_a_key_keeps_the_form_of_its_letters() -> None:
    assert paint_key("國 門-A") == "國門a"


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
    assert embedded_model().name([Reading(*each) for each in readings]).name == name


@pytest.mark.parametrize(
    ("readings", "name"),
    [
        # Near and sharp against many far slips that differ: the string that was read, not one that nobody read.
        ([("BLENNAMO", 6, 0.98, 2.5), *((slip, 1, 0.08, 0.3) for slip in (
            "BENNAMO", "LENAMO", "BLENAM", "BIENAMO", "BENAMO", "8LENAMO", "ENNAM0", "BLENAMQ"))], "BLENNAMO"),
        # A line read in two parts from near, and whole and worse from afar.
        ([("VARNISH ON", 11, 0.97, 2.0), ("THE PLINTH", 12, 0.97, 2.0), *((slip, 1, 0.05, 0.3) for slip in (
            "VARNIS ON TE PLINTH", "VARNIS ON TE PINTH", "VARNSH ON TE PLINTH", "VRNIS ON TE PLINT"))],
            "VARNISH ON THE PLINTH"),
        # Cut off from afar again and again, whole once from near.
        ([("QUORVEX", 8, 0.9, 2.3), ("QUORVEX 47", 1, 0.985, 1.0)], "QUORVEX 47"),
        # A mark that was read twice from near, against many unsure readings without the head.
        ([("Melf&Tarrow", 2, 0.97, 1.3), ("Tarow", 12, 0.3, 2.2), ("Tarrw", 13, 0.2, 2.2)], "Melf&Tarrow"),
        # One letter that is failed on in many ways is one failure.
        ([("Tall Meadow", 10, 0.74, 3.6), ("Tallfeadow", 15, 0.25, 3.8), ("Tall feadow", 9, 0.2, 1.6),
          ("Tallfieadow", 7, 0.2, 1.4), ("Tallfleadow", 7, 0.15, 1.3), ("Tall fleadow", 3, 0.3, 0.5)], "Tall Meadow"),
        # A mark read for a digit is no sign that there was none.
        ([("BAY STALL :", 4, 0.35, 1.2), ("BAY STALL 1", 4, 0.45, 1.3), ("BAY STALL!", 1, 0.1, 0.3),
          ("BAY STALL :]", 1, 0.3, 0.4), ("BAY STALL:", 1, 0.2, 0.3)], "BAY STALL 1"),
        # Whole, against one letter of it.
        ([("鵝葉仔", 12, 0.9, 2.5), ("葉", 6, 0.7, 1.5)], "鵝葉仔"),
    ],
)  # fmt: skip
def test_names_by_the_quality_of_readings(readings: list[tuple[str, int, float, float]], name: str) -> None:
    given = [Reading(text, count, 0.9, right, looks) for text, count, right, looks in readings]
    assert embedded_model().name(given).name == name


def test_a_letter_is_decided_by_the_sum_of_views_and_not_by_the_first_of_each() -> None:
    def slots(second: tuple[tuple[str, float], ...]) -> Slots:
        return ((("鵝", 0.99),), second, (("仔", 0.99),))

    slips = Reading("鵝勒仔", 13, 0.8, 0.5, 3.0, slots((("勒", 0.5), ("動", 0.45))))
    right = Reading("鵝動仔", 5, 0.9, 0.85, 1.6, slots((("動", 0.97), ("勒", 0.02))))
    assert embedded_model().name([slips, right]).name == "鵝動仔"


@given(st.permutations(["abcde", "abcdx", "abde", "zabcde"]), st.floats(0.3, 0.99))
def test_a_name_does_not_depend_on_the_order_of_readings(texts: list[str], right: float) -> None:
    model = embedded_model()
    given = {text: Reading(text, 2, 0.9, right, 1.0) for text in texts}
    first = model.name(list(given.values()))
    assert model.name([given[text] for text in sorted(given)]).name == first.name
    assert 0.0 <= first.confidence <= 1.0


@pytest.mark.parametrize(("one", "other"), ["未末", "土士", "人入", "ce", "oq", "8b"])
def test_letters_that_look_alike_from_afar_are_cheap_to_confuse(one: str, other: str) -> None:
    assert misreading_cost(one, other, looks) == misreading_cost(other, one, looks) < misreading_cost(one, "x", looks)


def test_a_mark_of_a_brand_that_was_read_once_is_kept() -> None:
    readings = [Reading("WENDYS", 5, 0.95), Reading("WENDY'S", 1, 0.9)]
    assert embedded_model().name(readings).name == "WENDY'S"
