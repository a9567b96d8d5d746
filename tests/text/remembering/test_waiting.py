from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.text.remembering.evidence import Glance
from lpslam.text.remembering.waiting import CutText, WaitingTexts
from lpslam.text.types import Placement, SpottedText, TextObservation

Array = NDArray[np.float64]


def cut(text: str, timestamp: float, x: float = 0.0, right: float = 0.9) -> CutText:
    box = np.array([[0, 0], [100, 0], [100, 30], [0, 30.0]])
    placement = Placement((x, 0.0, 2.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 0.5, 0.1, 0.01)
    observation = TextObservation(0, timestamp, 0, text, 0.99, placement, 30.0)
    return CutText(SpottedText(text, 0.99, box, 30.0), placement, Glance(30.0, 1.0, right), observation, np.eye(4))


def named(*names: str) -> Callable[[Placement, Array], list[str]]:
    return lambda placement, pose: list(names)


def waiting(*cuts: CutText) -> WaitingTexts:
    texts = WaitingTexts(patience=2.0)
    for each in cuts:
        texts.add(each)
    return texts


def spelled(found: list[list[CutText]]) -> list[list[str]]:
    return [[each.text.text for each in cuts] for cuts in found]


def test_the_longest_spelling_that_was_read_again_is_given_with_its_slips() -> None:
    readings = ["NOR", "NOR", "NORVANE", "NORVAME", "NORVANE", "NO"]
    texts = waiting(*(cut(each, index / 10) for index, each in enumerate(readings)))
    assert spelled(texts.gone(None, named())) == [["NORVANE", "NORVAME", "NORVANE"]]
    assert texts.gone(None, named()) == [], "given once"


def test_a_text_waits_while_it_may_still_come_into_view() -> None:
    texts = waiting(cut("NORVANE", 0.0), cut("NORVANE", 0.5))
    assert texts.gone(2.4, named()) == []
    assert spelled(texts.gone(2.6, named())) == [["NORVANE", "NORVANE"]]


@pytest.mark.parametrize(("name", "is_told"), [("NORVANE", True), ("NORVANE SHOP", True), ("NOR", False)])
def test_what_was_read_as_a_whole_is_not_told_by_its_parts(name: str, is_told: bool) -> None:
    texts = waiting(cut("NORVANE", 0.0), cut("NORVANE", 0.5))
    assert bool(texts.gone(None, named(name))) is not is_told


def test_what_was_read_once_or_unsurely_is_dropped() -> None:
    assert waiting(cut("NORVANE", 0.0)).gone(None, named()) == []
    assert waiting(*(cut(each, 0.0, right=0.3) for each in ("ABC", "XYZ", "QRS", "TUV"))).gone(None, named()) == []


def test_texts_side_by_side_are_kept_apart() -> None:
    readings = [cut(each, index / 10, x) for index in range(3) for each, x in (("NORVANE", 0.0), ("BANK", 1.0))]
    assert spelled(waiting(*readings).gone(None, named())) == [["NORVANE"] * 3, ["BANK"] * 3]


def test_one_letter_repeated_is_no_part_of_a_text() -> None:
    assert waiting(*(cut("XXX", index / 10) for index in range(5))).gone(None, named()) == []
