"""Which of the texts that seem to stand in one spot are one paint."""

from dataclasses import replace

import numpy as np

from lpslam.config import InstanceConfig, MemoryConfig
from lpslam.text.boards.overlaps import without_overlaps
from lpslam.text.placing.places import Place
from lpslam.text.types import TextObservation

CONFIG = InstanceConfig()


def place(identifier: int, name: str, x: float, y: float, width: float, height: float, count: int = 10) -> Place:
    """A text on a wall before the camera, never seen in a frame with another."""
    position = np.array([x, y, 3.0])
    normal, baseline = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    empty: dict[int, np.ndarray] = {}
    return Place(
        identifier, name, {name: count}, position, normal, baseline, 0.02, width, height, empty, empty, {}, count,
        0.95 * count, 0.95,
    )  # fmt: skip


def seen_in(place: Place, frame: int, x: float, y: float) -> Place:
    return replace(
        place,
        positions_by_frame={frame: np.array([x, y, 3.0])},
        sizes_by_frame={frame: (place.width, place.height)},
    )


def kept(*places: Place) -> set[str]:
    return {each.name for each in without_overlaps(list(places), CONFIG, MemoryConfig())}


def test_a_small_line_within_the_width_of_a_large_one_stands() -> None:
    assert kept(place(0, "永順木工", 0, 0, 2.0, 0.5, 40), place(1000, "VEX", 0.6, 0.02, 0.3, 0.15, 16)) == {
        "永順木工",
        "VEX",
    }


def test_a_number_whose_place_overlaps_another_line_stands() -> None:
    other = place(1000, "5550-1942", 0.1, 0.09, 0.9, 0.2, 8)
    assert kept(place(0, "修繕粉刷", 0, 0, 1.2, 0.2, 20), other) == {"修繕粉刷", "5550-1942"}


def test_what_one_frame_showed_side_by_side_are_two_texts() -> None:
    first, second = place(0, "LUMO", 0, 0, 0.5, 0.2, 20), place(1000, "LIMA", 0.05, 0, 0.5, 0.2)
    assert kept(first, second) == {"LUMO"}
    assert kept(seen_in(first, 7, 0, 0), seen_in(second, 7, 0.6, 0)) == {"LUMO", "LIMA"}


def test_a_misread_piece_of_a_long_line_is_dropped() -> None:
    assert kept(place(0, "MARLOWE GARDENS", 0, 0, 2.0, 0.2, 30), place(1000, "WE GARQEMS", 0.4, 0, 1.2, 0.2, 5)) == {
        "MARLOWE GARDENS"
    }


def test_of_a_block_of_columns_the_lines_across_go_whose_characters_stand_farther_apart() -> None:
    columns = [
        place(1000 * n, name, 0.14 * (1 - n), 0.0, 0.11, 0.36, 6)
        for n, name in enumerate(["烏龍茶", "豆花湯", "芋圓冰"])
    ]
    across = [place(9000, "芋豆烏", 0.0, -0.12, 0.42, 0.12, 40), place(9001, "冰湯茶", 0.0, 0.12, 0.42, 0.12, 30)]
    assert kept(*columns, *across) == {"烏龍茶", "豆花湯", "芋圓冰"}
    lines = [replace(each, height=0.50) for each in columns]
    assert kept(*lines, *across) == {"芋豆烏", "冰湯茶"}


def read_as(place: Place, sure: float, *texts: str) -> Place:
    """The place as it was read, once a second, each reading as likely right as not."""
    seen = [TextObservation(10 * at, float(at), 0, text, 0.9, None, 20.0, right=0.5) for at, text in enumerate(texts)]
    return replace(place, confidence=sure, seen=tuple(seen))


def test_readings_that_joined_the_class_of_an_equal_text_say_what_it_is_called() -> None:
    slips = read_as(place(0, "COLONIA", 0, 0, 0.7, 0.15, 20), 0.88, "COLONIA", "COLONBA", "COLONSIA", "COLONIA")
    sure = read_as(place(1000, "COLOMBIA", 0.02, 0, 0.7, 0.15, 10), 0.98, "COLOMBIA", "COLONBIA", "COLOMBIA")
    below = place(1001, "COLOMBIA", 0, 0.5, 0.7, 0.15, 30)
    assert kept(slips, sure, below) == {"COLOMBIA"}
    # What stands nowhere else was named by readings of this text alone, and by fewer.
    assert kept(slips, sure) == {"COLONIA"}


def test_a_name_that_stands_elsewhere_renames_nothing_that_is_read_well() -> None:
    often = replace(place(0, "LUMINA", 0, 0, 0.7, 0.15, 20), confidence=0.9)
    often = replace(often, seen=tuple(replace(each, right=0.95) for each in read_as(often, 0.9, *["LUMINA"] * 8).seen))
    once = read_as(place(1000, "LAMINA", 0.02, 0, 0.7, 0.15, 2), 0.98, "LAMINA")
    below = place(1001, "LAMINA", 0, 0.5, 0.7, 0.15, 30)
    assert kept(often, once, below) == {"LUMINA", "LAMINA"}


def test_a_name_of_other_letters_in_the_same_box_renames_nothing() -> None:
    often = read_as(place(0, "LUMO", 0, 0, 0.7, 0.15, 20), 0.5, *["LUMO"] * 4)
    other = read_as(place(1000, "OPEN", 0.02, 0, 0.7, 0.15, 3), 0.98, *["OPEN"] * 3)
    below = place(1001, "OPEN", 0, 0.5, 0.7, 0.15, 30)
    assert kept(often, other, below) == {"LUMO", "OPEN"}
