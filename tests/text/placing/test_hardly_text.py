from dataclasses import replace

import numpy as np
import pytest

from lpslam.config import InstanceConfig, MemoryConfig
from lpslam.language.model import Naming
from lpslam.text.placing.places import places_of_class
from lpslam.text.remembering.evidence import Glance, note
from lpslam.text.remembering.memory import TextClass, Variant
from lpslam.text.types import Placement, TextObservation


def read(text: str, rights: list[float | None]) -> TextClass:
    """A text 2 m before the camera, read so surely, once a frame."""
    placement = Placement((0.0, 0.0, 2.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 0.4, 0.1, 0.01)
    seen = [TextObservation(at, 0.2 * at, 0, text, 0.8, placement, 30.0, right=one) for at, one in enumerate(rights)]
    return TextClass(1, 0.0, 1.0, {text: Variant(len(seen), 0.8 * len(seen))}, observations=seen)


def count(text_class: TextClass) -> int:
    return len(places_of_class(text_class, lambda keyframe: np.eye(4), InstanceConfig(), MemoryConfig()))


@pytest.mark.parametrize("text", ["XX1", "00", "习", "不凶"])
def test_few_letters_read_badly_every_time_are_no_text(text: str) -> None:
    assert count(read(text, [0.2, 0.3, 0.1, 0.4])) == 0


@pytest.mark.parametrize("text", ["WC", "ATM", "男", "P2"])
def test_one_good_reading_makes_a_short_text_believed(text: str) -> None:
    assert count(read(text, [0.2, 0.9, 0.1, 0.4])) == 1
    assert count(read(text, [None, None, None])) == 1


def test_few_letters_whose_name_is_unsure_are_no_text() -> None:
    for sure, expected in ((0.2, 0), (0.8, 1)):
        text_class = read("80E", [0.2, 0.7, 0.1, 0.6])
        text_class.naming = Naming("80E", sure, "", "offline")
        assert count(text_class) == expected
    longer = read("Willow & Pine", [0.2, 0.7])
    longer.naming = Naming("Willow & Pine", 0.2, "", "offline")
    assert count(longer) == 1


@pytest.mark.parametrize("text", ["Willow & Pine", "危险"])
def test_longer_texts_are_believed_as_ever(text: str) -> None:
    assert count(read(text, [0.2, 0.3, 0.1, 0.4])) == 1


@pytest.mark.parametrize(("sure", "best", "expected"), [(0.1, 0.1, 0), (0.1, 0.3, 1), (0.6, 0.1, 1)])
def test_a_name_that_no_reading_can_be_is_none(sure: float, best: float, expected: int) -> None:
    """Small print that every view reads in another way, none of them well."""
    text_class = read("Willow & Pine", [0.01, best, 0.02])
    text_class.naming = Naming("Willow & Pine", sure, "", "offline")
    assert count(text_class) == expected


@pytest.mark.parametrize("text", ["ErkrrKPHINP", "HEYFPFFF", "FHrKI", "1917999", "POJトS", "里因圈困"])
def test_what_is_spelt_as_no_name_is_and_read_badly_every_time_is_no_text(text: str) -> None:
    """Rows of runes, lanes' arrows, pictograms and lattices."""
    assert count(read(text, [0.2, 0.45, 0.1])) == 0
    assert count(read(text, [0.2, 0.8, 0.1])) == 1


@pytest.mark.parametrize("text", ["Farmer Dividend", "THISTLE& OAK", "Wivenhoe Park", "KOKE", "кофейня"])
def test_what_is_spelt_as_names_are_is_a_text_however_badly_read(text: str) -> None:
    assert count(read(text, [0.2, 0.38, 0.1])) == 1


def test_an_ideograph_that_signs_do_not_bear_by_itself_is_no_text() -> None:
    """A square code read as 器 and a plate with a meander read as 可, from every side; doors have 男."""
    assert count(read("器", [0.97, 0.96, 0.97])) == count(read("可", [0.6, 0.65, 0.65])) == 0
    assert count(read("男", [0.97, 0.96, 0.97])) == 1


def test_a_name_is_no_surer_than_two_readings_that_are_independent() -> None:
    for best, most in ((0.65, 0.88), (0.3, 0.51), (0.97, 0.98)):
        text_class = read("Willow & Pine", [best] * 8)
        for _ in range(8):
            note(text_class.looks, "Willow & Pine", 0.9, 0, Glance(30.0, 1.0, best))
        text_class.naming = Naming("Willow & Pine", 0.98, "", "offline")
        (place,) = places_of_class(text_class, lambda keyframe: np.eye(4), InstanceConfig(), MemoryConfig())
        assert place.confidence == pytest.approx(most, abs=0.005)


def test_a_text_whose_end_no_view_shows_is_as_sure_as_that_it_is_whole_and_none_if_it_is_likelier_a_piece() -> None:
    def standing(*whole: tuple[float, float]) -> list[float]:
        text_class = read("SHOE LAB", [0.99] * len(whole))
        text_class.naming = Naming("SHOE LAB", 0.9, "", "offline")
        text_class.observations = [
            replace(each, whole=ends) for each, ends in zip(text_class.observations, whole, strict=True)
        ]
        places = places_of_class(text_class, lambda keyframe: np.eye(4), InstanceConfig(), MemoryConfig())
        return [each.confidence for each in places]

    assert standing((0.8, 1.0), (0.7, 1.0)) == [pytest.approx(0.72)]
    assert standing((0.4, 1.0), (0.3, 1.0)) == []
    # One view shows its begin, another one its end.
    assert standing((0.4, 1.0), (1.0, 0.2)) == [pytest.approx(0.9)]


def test_sure_texts_need_no_tables_of_words(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever opens a map sees it before the tables are read."""

    def not_yet() -> None:
        raise AssertionError("the tables are read")

    monkeypatch.setattr("lpslam.text.remembering.ends.load_knowledge", not_yet)
    assert count(read("危险", [0.2, 0.9, 0.1, 0.4])) == 1


@pytest.mark.parametrize("text", ["00", "0000", "O0 o"])
def test_rings_are_no_text_however_well_they_are_read(text: str) -> None:
    assert count(read(text, [0.9, 0.95, 0.9])) == 0
    assert count(read("100", [0.9, 0.95, 0.9])) == 1


def test_a_slip_with_as_many_letters_shows_that_nothing_stands_before_them() -> None:
    """寶利空館 is read where all is in view, 寶利賓館 where the image's border touches its first character."""
    text_class = read("寶利賓館", [0.7, 0.6])
    text_class.naming = Naming("寶利賓館", 0.6, "", "offline")
    cut = [replace(each, whole=(0.1, 1.0)) for each in text_class.observations]
    whole = [replace(each, text="寶利空館", whole=(1.0, 1.0)) for each in cut]
    shorter = [replace(each, text="利賓館", whole=(1.0, 1.0)) for each in cut]
    for observations, expected in ((cut, 0), (cut + shorter, 0), (cut + whole, 1)):
        text_class.observations = observations
        assert count(text_class) == expected


def test_a_piece_that_shows_an_end_tells_that_the_text_ends_there() -> None:
    """From one side the wall goes on beyond the first letter, from the other beyond the last; no view shows both."""
    text_class = read("SHOE LAB", [0.99] * 3)
    text_class.naming = Naming("SHOE LAB", 0.99, "", "offline")
    text_class.observations = [replace(each, whole=(1.0, 0.3)) for each in text_class.observations]
    assert count(text_class) == 0
    cut = text_class.observations[0]
    for text, expected in (("E LAB", 1), ("SHOE", 0), ("B", 0)):
        piece = replace(cut, frame=9, text=text, whole=(0.2, 1.0))
        assert count(replace(text_class, observations=[*text_class.observations, piece])) == expected, text
