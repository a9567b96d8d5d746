"""What readings are worth: how probably each is right, and how much those of one view say together."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.config import MemoryConfig, TextConfig
from lpslam.language.offline import OfflineModel
from lpslam.text.reading.certainty import probability_right
from lpslam.text.remembering.evidence import Glance, Look, looks_of, note, readings_of
from lpslam.text.text_map import TextMap
from lpslam.text.types import Placement, TextObservation

MEMORY = MemoryConfig()
probabilities = st.floats(0.02, 0.99)


def noted(*seen: tuple[str, int, float, float]) -> list[Look]:
    """Looks of (text, visit, height, right)."""
    looks: list[Look] = []
    for text, visit, height, right in seen:
        note(looks, text, 0.9, visit, Glance(height, 1.0, right))
    return looks


def test_readings_of_one_view_are_worth_little_more_than_one() -> None:
    (same,) = readings_of(noted(*[("HARNOW", 0, 24.0, 0.9)] * 16), MEMORY)
    (apart,) = readings_of(noted(*[("HARNOW", visit, 24.0, 0.9) for visit in range(4)]), MEMORY)
    assert same.count == 16
    assert same.looks is not None
    assert 1.0 < same.looks < 4.0
    assert apart.looks == pytest.approx(4.0)


def test_slips_of_one_view_share_what_the_view_is_worth() -> None:
    slips = readings_of(noted(*[(f"HARN{letter}W", 0, 12.0, 0.2) for letter in "ABCDEFGH"]), MEMORY)
    assert sum(each.looks or 0.0 for each in slips) == pytest.approx(8.0**MEMORY.repetition)


def test_readings_without_a_place_are_one_view_of_a_visit() -> None:
    looks: list[Look] = []
    for height in (10.0, 14.0, 20.0, 30.0):
        note(looks, "HARNOW", 0.9, 0, Glance(height, 0.5, 0.8, is_placed=False))
    assert len(looks) == 1


def test_runners_up_are_the_mean_of_what_all_readings_held_for_possible() -> None:
    looks: list[Look] = []
    for right, visit, letter in ((0.4, 0, "X"), (0.9, 0, "Y"), (0.6, 1, "Y"), (0.5, 1, "X")):
        note(looks, "A", 0.9, visit, Glance(24.0, 1.0, right, ((("A", 0.6), (letter, 0.3)), (("", 0.7), ("B", 0.2)))))
    (reading,) = readings_of(looks, MEMORY)
    assert reading.slots == ((("A", 0.6), ("X", 0.15), ("Y", 0.15)), (("", 0.7), ("B", 0.2)))


def test_a_letter_is_told_by_all_views_and_not_by_the_surest_one() -> None:
    """One view is sure of the wrong letter, and six others waver."""
    looks: list[Look] = []
    for at, wrong in enumerate((0.42, 0.34, 0.35, 0.39, 0.36, 0.47, 0.93)):
        slots = ((("徐", 0.99),), (("已", wrong), ("記", min(0.3, 0.98 - wrong))), (("麵", 0.99),), (("館", 0.99),))
        note(looks, "徐已麵館", 0.85, at, Glance(40.0, 1.0, 0.85 if wrong > 0.9 else 0.3, slots))
    for at in range(7, 13):
        slots = ((("徐", 0.99),), (("記", 0.6), ("已", 0.2)), (("麵", 0.99),), (("館", 0.99),))
        note(looks, "徐記麵館", 0.87, at, Glance(40.0, 1.0, 0.45, slots))
    assert OfflineModel().name(readings_of(looks, MEMORY)).name == "徐記麵館"


@given(st.lists(st.tuples(st.sampled_from("AB"), st.integers(0, 2), st.floats(8.0, 90.0), probabilities), min_size=1))
def test_no_reading_is_lost_and_each_view_counts_once_at_least(seen: list[tuple[str, int, float, float]]) -> None:
    looks = noted(*seen)
    readings = readings_of(looks, MEMORY)
    assert sum(each.count for each in readings) == len(seen)
    views = len({look.view for look in looks})
    assert views - 1e-6 <= sum(each.looks or 0.0 for each in readings) <= len(seen) + 1e-6
    assert all(0.0 < (each.right or 0.0) < 1.0 for each in readings)


@given(st.floats(0.6, 0.999), st.floats(10.0, 60.0), st.floats(0.2, 1.0))
def test_larger_and_more_frontal_and_surer_is_more_probably_right(sure: float, height: float, frontal: float) -> None:
    right = probability_right("HARNOW", sure, letter_height=height, frontal=frontal)
    assert 0.0 < right < 1.0
    assert probability_right("HARNOW", sure, letter_height=height + 5.0, frontal=frontal) >= right
    assert probability_right("HARNOW", sure, letter_height=height, frontal=min(frontal + 0.1, 1.0)) >= right
    assert probability_right("HARNOW", min(sure + 0.01, 1.0), letter_height=height, frontal=frontal) >= right


def test_a_doubted_letter_makes_the_whole_less_probably_right() -> None:
    sure = tuple(((letter, 0.99),) for letter in "HARNOW")
    doubted = (*sure[:-1], (("W", 0.55), ("V", 0.4)))
    assert probability_right("HARNOW", 0.95, doubted) < probability_right("HARNOW", 0.95, sure)


def test_sightings_of_maps_that_know_no_probability_are_evidence_all_the_same() -> None:
    placement = Placement((0.0, 0.0, 3.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 0.8, 0.2, 0.01)
    old = [TextObservation(frame, 0.1 * frame, frame, "HARNOW", 0.95, placement, 24.0) for frame in range(3)]
    (reading,) = readings_of(looks_of(old), MEMORY)
    assert reading.count == 3
    assert reading.right is not None


def test_looks_survive_saving_and_maps_without_them_are_read() -> None:
    text_map = TextMap(TextConfig())
    for time in (0.0, 0.2, 0.4, 5.0):
        glance = Glance(24.0, 0.9, 0.8, ((("A", 0.6), ("B", 0.3)), (("T", 0.9),)))
        text_map.memory.sight("AT", 0.9, time, glance=glance)
    document = json.loads(json.dumps(text_map.to_document()))
    (again,) = TextMap.from_document(document).memory.classes
    (first,) = text_map.memory.classes
    assert again == first
    assert again.visits == 1
    for each in document["memory"]["classes"]:
        del each["looks"], each["visits"]
    (old,) = TextMap.from_document(document).memory.classes
    assert [(each.text, each.count) for each in old.readings(MEMORY)] == [("AT", 4)]
