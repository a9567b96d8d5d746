import numpy as np
import pytest

from lpslam.config import MemoryConfig, ReadingConfig
from lpslam.text.placing.spots import Spots
from lpslam.text.reading.legibility import SeenSize
from lpslam.text.remembering.memory import LongShortTermMemory
from lpslam.text.types import Placement


def standing(x: float, y: float, width: float = 1.0, height: float = 0.2) -> Placement:
    return Placement((x, y, 3.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), width, height, 0.01)


@pytest.mark.parametrize(
    ("placement", "here"),
    [
        (standing(0.05, 0.02), True),
        (standing(-0.25, 0.0, width=0.5), True),  # a piece of it
        (standing(0.0, 0.25), False),  # the next line of the board
        (standing(1.1, 0.0), False),  # its neighbour
        (standing(0.0, 0.05, height=0.3), True),  # its box drawn larger
        (standing(0.0, 0.1, height=0.4), False),  # it and the next line in one box
    ],
)
def test_a_spot_is_where_texts_overlap(placement: Placement, here: bool) -> None:
    spots = Spots()
    spots.add(7, "GUCCI", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0))
    assert spots.classes_at(placement, np.eye(4)) == ({7} if here else set())


def test_spots_are_in_the_world() -> None:
    spots = Spots()
    assert spots.classes_at(standing(0.0, 0.0), np.eye(4)) == set()
    spots.add(7, "GUCCI", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0))
    # The next keyframe stands two metres to the right, and sees the same sign two metres to the left.
    world_from_keyframe = np.eye(4)
    world_from_keyframe[0, 3] = 2.0
    assert spots.classes_at(standing(-2.0, 0.0), world_from_keyframe) == {7}
    assert spots.classes_at(standing(0.0, 0.0), world_from_keyframe) == set()


def test_a_poor_reading_joins_the_class_of_its_spot_only() -> None:
    memory = LongShortTermMemory(MemoryConfig())
    first = memory.sight("STARBUCKS", 0.9, 0.0)
    assert memory.sight("STARB", 0.9, 0.2, here={first.id}) is first
    assert memory.sight("STARB", 0.9, 0.4) is first  # by now a known spelling
    assert memory.sight("TARBU", 0.9, 0.6, here={99}).id == first.id  # as like that spelling
    assert memory.sight("GUCCI", 0.9, 0.8, here={first.id}) is not first


FOUR = ReadingConfig(settled_sightings=4)


def unsure(identifier: int) -> bool:
    return False


def settled(readings: list[str]) -> bool:
    spots = Spots()
    for reading in readings:
        spots.add(7, reading, standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0))
    return spots.settled_at(standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0), unsure, FOUR) == 7


def test_a_text_is_settled_by_readings_that_agree() -> None:
    assert settled(["New Arrivals", "NEW ARRIVALS", "NewArrivals", "New Arrivals"])
    assert not settled(["New Arrivals", "Newfrrivals", "Newflrrivals", "New Arrivals"])
    assert settled(["New Arrivals", "Newfrrivals"] * 4), "sooner or later there is no more to learn"


def test_the_back_of_a_thin_sign_is_a_spot_of_its_own() -> None:
    spots = Spots()
    for _ in range(8):
        spots.add(7, "ENTRANCE", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0))
    back = Placement((0.0, 0.0, 3.02), (0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), 1.0, 0.2, 0.01)
    assert spots.classes_at(back, np.eye(4)) == set()
    assert spots.settled_at(back, np.eye(4), SeenSize(10.0, 1.0), unsure, FOUR) is None


def test_a_slip_does_not_unsettle_a_text_for_ever() -> None:
    spots = Spots()
    spots.add(8, "Free", standing(-0.2, 0.0, width=0.4), np.eye(4), SeenSize(20.0, 1.0))
    for _ in range(4):
        spots.add(7, "Free Delivery", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0))
    assert spots.settled_at(standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0), unsure, FOUR) == 7


def test_a_text_read_as_two_is_settled_in_the_end() -> None:
    spots = Spots()
    rounds = 0
    while spots.settled_at(standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0), unsure, FOUR) is None:
        spots.add(7, "SALE", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0))
        spots.add(8, "5A1E!", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0))
        rounds += 1
        assert rounds < 50, "a robot parked before it would read it for hours"
    assert rounds > 8


@pytest.mark.parametrize(
    ("size", "width", "is_settled"),
    [
        (20.0, 1.0, True),
        (29.0, 1.0, True),
        (31.0, 1.0, False),  # half as large again: there is more to see
        (20.0, 1.3, False),  # longer than any reading of it: there is more to read
    ],
)
def test_a_settled_text_is_read_again_when_it_is_seen_better(size: float, width: float, is_settled: bool) -> None:
    spots = Spots()
    for _ in range(8):
        spots.add(7, "HARNOW", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0))
    seen = spots.settled_at(standing(0.0, 0.0, width=width), np.eye(4), SeenSize(size, 1.0), lambda _: True, FOUR)
    assert (seen == 7) == is_settled


def test_larger_than_the_recogniser_can_use_is_no_better() -> None:
    spots = Spots()
    for _ in range(8):
        spots.add(7, "HARNOW", standing(0.0, 0.0), np.eye(4), SeenSize(FOUR.full_size, 1.0))
    assert spots.settled_at(standing(0.0, 0.0), np.eye(4), SeenSize(5.0 * FOUR.full_size, 1.0), unsure, FOUR) == 7


def test_a_sure_name_takes_half_as_many_readings() -> None:
    spots = Spots()
    for _ in range(2):
        spots.add(7, "HARNOW", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0))
    assert spots.settled_at(standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0), unsure, FOUR) is None
    assert spots.settled_at(standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0), lambda _: True, FOUR) == 7


def test_an_unsure_name_is_not_settled_by_what_was_read_from_farther_off() -> None:
    spots = Spots()
    for _ in range(8):
        spots.add(7, "220", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0))
    now = standing(0.0, 0.0), np.eye(4), SeenSize(27.0, 1.0)
    assert spots.settled_at(*now, lambda _: True, FOUR) == 7
    for _ in range(2):
        assert spots.settled_at(*now, unsure, FOUR) is None, "commas are seen from near"
        spots.add(7, "220", standing(0.0, 0.0), np.eye(4), SeenSize(27.0, 1.0))
    assert spots.settled_at(*now, unsure, FOUR) == 7, "it is not read for ever"


def test_what_was_never_seen_large_enough_to_be_believed_is_read_again_once_it_is() -> None:
    spots = Spots()
    for _ in range(8):
        spots.add(7, "HARNOW", standing(0.0, 0.0), np.eye(4), SeenSize(18.0, 1.0))
    assert spots.settled_at(standing(0.0, 0.0), np.eye(4), SeenSize(19.0, 1.0), unsure, FOUR) == 7
    assert spots.settled_at(standing(0.0, 0.0), np.eye(4), SeenSize(20.5, 0.8), unsure, FOUR) is None


def test_a_piece_read_often_does_not_settle_the_whole() -> None:
    """One ideograph of five, read again and again from afar; then the whole is seen near by, once."""
    spots = Spots()
    for _ in range(8):
        spots.add(7, "院", standing(0.4, 0.0, width=0.2), np.eye(4), SeenSize(20.0, 15.0))
    spots.add(8, "星河电影院", standing(0.0, 0.0), np.eye(4), SeenSize(60.0, 50.0))
    near = SeenSize(60.0, 50.0)
    assert spots.settled_at(standing(0.0, 0.0), np.eye(4), near, unsure, FOUR) is None
    assert spots.spellings_at(standing(0.0, 0.0), np.eye(4)) == {"院", "星河电影院"}


def test_a_text_is_read_again_once_when_the_view_first_goes_on_beyond_its_end() -> None:
    spots = Spots()
    here, size = standing(0.0, 0.0), SeenSize(20.0, 1.0)

    def settled(room: tuple[float, float]) -> int | None:
        return spots.settled_at(here, np.eye(4), size, unsure, FOUR, lambda: room)

    for _ in range(FOUR.settled_sightings):
        spots.add(7, "GUCCI", here, np.eye(4), size, (5.0, 0.1))
    assert settled((5.0, 0.1)) == 7
    assert settled((5.0, 2.0)) is None
    spots.add(7, "GUCCI", here, np.eye(4), size, (5.0, 2.0))
    assert settled((5.0, 2.0)) == 7


@pytest.mark.parametrize(
    ("text", "placement", "is_all"),
    [
        ("寶利賓館", standing(0.02, 0.0), True),
        ("寶利賓館", standing(0.1, 0.0, width=0.8), False),  # its begin is not in view
        ("利賓館", standing(0.02, 0.0), False),
        (
            "老寶利賓館",
            standing(-0.1, 0.0, width=1.2),
            False,
        ),  # it begins before the other one, and perhaps farther off
        ("歡迎光臨", standing(0.02, 0.0), False),  # something else
        ("老寶利賓館", standing(0.0, -0.03, height=0.3), False),  # a column that begins higher up
    ],
)
def test_what_reaches_as_far_as_a_whole_text_shows_all_of_it(text: str, placement: Placement, is_all: bool) -> None:
    spots = Spots()
    assert not spots.is_as_long_at(text, placement, np.eye(4))
    spots.add(7, "寶利空館", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0), (0.1, 5.0))
    assert not spots.is_as_long_at(text, placement, np.eye(4)), "it may begin before the view"
    spots.add(7, "寶利空館", standing(0.0, 0.0), np.eye(4), SeenSize(20.0, 1.0), (5.0, 5.0))
    assert spots.is_as_long_at(text, placement, np.eye(4)) is is_all
