import numpy as np
import pytest

from lpslam.config import InstanceConfig, MemoryConfig
from lpslam.language.model import Naming
from lpslam.text.placing.places import places_of_class
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
    text_class = read("n ewhto 6 58", [0.01, best, 0.02])
    text_class.naming = Naming("n ewhto 6 58", sure, "", "offline")
    assert count(text_class) == expected


def test_sure_texts_need_no_tables_of_words(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever opens a map sees it before the tables are read."""

    def not_yet() -> None:
        raise AssertionError("the tables are read")

    monkeypatch.setattr("lpslam.text.remembering.ends.load_knowledge", not_yet)
    assert count(read("危险", [0.2, 0.9, 0.1, 0.4])) == 1
