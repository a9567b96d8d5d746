from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.text.remembering.evidence import Glance
from lpslam.text.remembering.waiting import CutText, WaitingTexts
from lpslam.text.types import Placement, SpottedText, TextObservation

Array = NDArray[np.float64]


def cut(
    text: str,
    timestamp: float,
    x: float = 0.0,
    right: float = 0.9,
    width: float = 0.5,
    room: tuple[float, float] = (5.0, 0.3),
) -> CutText:
    box = np.array([[0, 0], [100, 0], [100, 30], [0, 30.0]])
    placement = Placement((x, 0.0, 2.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), width, 0.1, 0.01)
    observation = TextObservation(0, timestamp, 0, text, 0.99, placement, 30.0)
    return CutText(
        SpottedText(text, 0.99, box, 30.0), placement, Glance(30.0, 1.0, right), observation, np.eye(4), room
    )


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


def appearing(text: str, at: float, right_end: float = 0.0, step: float = 0.02, width: float = 0.07) -> list[CutText]:
    """A text, letters so wide, that comes into view from its right end on, as far as `at`, so much in each reading."""
    lengths = np.arange(2.0 * width, at, step)
    return [
        cut(text[-max(int(length / width), 1) :], index / 10, right_end - length / 2.0, width=length)
        for index, length in enumerate(lengths)
    ]


def test_a_text_whose_end_moves_with_the_view_goes_on_beyond_it() -> None:
    # Letter after letter comes, and the last of them is read again; only when a letter has just come it seems to stay.
    cases = [(step, at) for step in (0.02, 0.035, 0.06) for at in np.arange(0.3, 0.55, 0.02)]
    given = [waiting(*appearing("ESCALATOR", at, step=step)).gone(None, named()) for step, at in cases]
    assert sum(map(bool, given)) <= len(cases) // 10, [spelled(each) for each in given if each]


def test_a_text_that_stays_where_it_ends_is_all_of_it() -> None:
    word = "NORVANE"
    coming = appearing(word, 0.5)
    jitter = 0.004 * np.random.default_rng(5).standard_normal(12)
    there = [cut(word, 3.0 + index / 10, -0.25 + each, width=0.5 - each) for index, each in enumerate(jitter)]
    ((*found,),) = spelled(waiting(*coming, *there).gone(None, named()))
    assert found.count(word) >= len(there)


@pytest.mark.parametrize("room", [(5.0, 0.0), (0.0, 5.0)])
def test_where_a_camera_stands_the_view_ends_again_where_it_did(room: tuple[float, float]) -> None:
    still = [cut("OX", index / 10, room=room) for index in range(12)]
    assert waiting(*still).gone(None, named()) == []
    moved = [cut("OX", 2.0 + index / 10) for index in range(2)]
    assert len(waiting(*still, *moved).gone(None, named())) == 1, "its end was seen twice"


@pytest.mark.parametrize(
    ("text", "room", "is_whole"),
    [
        ("STROOM", (0.0, 5.0), False),
        ("SHOE LAB", (0.0, 5.0), True),
        ("Café Lumi", (5.0, 0.0), False),
        ("NORVANE CAFÉ", (5.0, 0.0), True),
        ("手间", (0.0, 5.0), False),
        ("楼梯", (5.0, 0.0), True),
        ("蒸汽茶楼", (0.0, 5.0), True),
        ("楼", (5.0, 0.0), False),
        ("幸福面馆", (5.0, 0.0), True),
        ("KEEP CLEA", (5.0, 0.0), False),
        ("KEEP CLEA", (5.0, 0.3), True),
    ],
)
def test_an_end_beyond_which_nothing_was_seen_is_one_where_a_word_ends(
    text: str, room: tuple[float, float], is_whole: bool
) -> None:
    # A camera that hardly moves cuts it in the same place again.
    still = [cut(text, index / 10, room=room) for index in range(4)]
    assert bool(waiting(*still).gone(None, named())) is is_whole


def test_a_word_that_one_surer_reading_ends_with_is_enough() -> None:
    readings = [cut(each, index / 10, room=(0.0, 5.0)) for index, each in enumerate(["HOE LAB"] * 4)]
    assert waiting(*readings).gone(None, named()) == []
    assert len(waiting(*readings, cut("SHOE LAB", 0.5, right=0.6, room=(0.0, 5.0))).gone(None, named())) == 1


def test_letters_seen_beyond_a_spelling_say_that_it_is_a_part() -> None:
    # The longer reading begins a letter farther on.
    beyond = cut("LATOR", 0.6, x=-0.06, width=0.62)
    assert waiting(*(cut("ATOR", index / 10) for index in range(5)), beyond).gone(None, named()) == []
    doubted = waiting(*(cut("ATOR", index / 10) for index in range(5)), cut("LATOR", 0.6, right=0.3))
    assert "ATOR" in spelled(doubted.gone(None, named()))[0], "a slip says nothing"


def test_a_letter_that_others_missed_where_they_end_says_nothing_of_what_lies_beyond() -> None:
    """Half of the first letter is in view, and is read once."""
    readings = [*(cut("afé Lumière", index / 10, width=1.2) for index in range(5)), cut("Café Lumière", 0.6, width=1.2)]
    (found,) = spelled(waiting(*readings).gone(None, named()))
    assert found == ["afé Lumière"] * 5 + ["Café Lumière"]


def test_it_is_told_how_often_the_same_waits_at_a_place() -> None:
    texts = WaitingTexts(patience=2.0)
    assert [texts.add(cut(each, 0.0)) for each in ("NORVANE", "NOR", "Nor Vane")] == [1, 1, 2]
    assert texts.add(cut("NORVANE", 0.0, x=3.0)) == 1


def test_a_part_of_what_is_in_memory_need_not_be_the_whole() -> None:
    readings = [cut("MACY 24", index / 10, room=(0.0, 5.0)) for index in range(3)]
    assert waiting(*readings).gone(None, named()) == []
    assert spelled(waiting(*readings).gone(None, named(), lambda text: text == "macy24")) == [["MACY 24"] * 3]
    few = [cut("OX", index / 10, room=(0.0, 5.0)) for index in range(3)]
    assert waiting(*few).gone(None, named(), lambda text: True) == [], "a piece of a frieze is like any"
