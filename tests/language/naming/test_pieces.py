"""Readings that are pieces of a text say nothing against the letters that they lack at an end."""

import pytest

from lpslam.language.model import Reading
from lpslam.language.naming.channel import Seen, log_likelihood, steps_between
from lpslam.language.offline import embedded_model


@pytest.mark.parametrize(("painted", "piece"), [("candycane", "cane"), ("abaca", "aca"), ("abaca", "aba"), ("xa", "a")])
def test_a_piece_is_the_whole_with_an_end_hidden_wherever_its_letters_come_again(painted: str, piece: str) -> None:
    lacks = steps_between(painted, piece)
    places = {step.src_pos for step in lacks}
    assert places in ({*range(len(painted) - len(piece))}, {*range(len(piece), len(painted))})
    more = steps_between(piece, painted)
    assert {step.dest_pos for step in more} == places
    one_letter_more = log_likelihood(painted, [Seen(piece, 0.8, 1.0)], str)
    assert one_letter_more > log_likelihood("z" * len(painted), [Seen(piece, 0.8, 1.0)], str)


def test_a_second_look_that_lacks_the_beginning_does_not_win_over_the_whole() -> None:
    read = [
        Reading("candle", 4, 1.0, 0.97, 1.5),
        Reading("y candle", 1, 0.94, 0.4, 1.0),
        Reading("cosy candle", 1, 1.0, 0.97, 0.4),
    ]
    assert embedded_model().name(read).name == "cosy candle"


def test_an_end_that_is_hidden_again_says_less_than_one_that_is_hidden_elsewhere() -> None:
    cost = -log_likelihood("cosycandle", [Seen("candle", 0.98, 1.0)], str)
    in_three_views = -log_likelihood("cosycandle", [Seen("candle", 0.98, 3.0)], str)
    elsewhere = [Seen(piece, 0.98, 1.0) for piece in ("candle", "ycandle", "sycandle")]
    assert in_three_views < 0.75 * 3.0 * cost
    assert in_three_views < -log_likelihood("cosycandle", elsewhere, str)


def test_what_the_view_cut_says_little_against_a_longer_text_however_well_it_is_known() -> None:
    """Read seven times as a whole, and once where the image's border cuts its begin off."""
    whole = Reading("鸿达茶餐厅", 7, 0.99, 0.98, 1.4)
    assert embedded_model().name([whole, Reading("茶餐厅", 1, 0.99, 0.98, 0.2, whole=(0.3, 1.0))]).name == "鸿达茶餐厅"
    cut, seen = (Seen("茶餐厅", 0.98, 1.0, whole=ends) for ends in ((0.3, 1.0), (1.0, 1.0)))
    assert log_likelihood("鸿达茶餐厅", [cut], str) > log_likelihood("鸿达茶餐厅", [seen], str) + 1.0


def test_a_name_that_ends_with_what_it_is_is_likelier_than_one_that_ends_with_nothing_known() -> None:
    """The reader holds both for possible, and one of them is an inn."""
    slots = ((("寶", 0.99),), (("利", 0.99),), (("空", 0.5), ("賓", 0.4)), (("館", 0.99),))
    assert embedded_model().name([Reading("寶利空館", 8, 0.87, 0.4, 1.6, slots)]).name == "寶利賓館"


def test_what_is_read_before_a_name_that_ends_with_what_it_is_is_kept_whatever_its_script() -> None:
    """A number stands before a gate as Chinese does; a brand in Latin letters after Chinese is no end of one name."""
    gates = [Reading("3号登机口", 3, 0.9), Reading("号登机口", 1, 0.99), Reading("号壁机口", 1, 0.78)]
    assert embedded_model().name(gates).name == "3号登机口"
    teas = [Reading("HEYTEA", 2, 1.0), Reading("茶HEYTEA", 1, 1.0), Reading("高条HEYTEA", 1, 0.85)]
    assert not embedded_model().name([*teas, Reading("8HEYTEA", 1, 0.85)]).name.startswith("茶")


def test_poor_readings_that_take_in_a_neighbour_do_not_rename_a_text_that_was_read_well_again_and_again() -> None:
    """From afar two lines side by side are in one box, and the second of them is read otherwise each time."""
    read = [Reading("桑田茶社", 22, 0.99, 0.99, 8.4)]
    others = ("山水画院", "山水画完", "山水面院", "山氷画院", "山水画陷")
    read += [Reading(f"桑田茶社 {other}", 1, 0.8, 0.1, 1.0) for other in others]
    assert embedded_model().name(read).name == "桑田茶社"
    well = [Reading("candle", 3, 1.0, 0.97, 1.5), Reading("candle shop", 3, 1.0, 0.97, 1.5)]
    assert embedded_model().name(well).name == "candle shop", "what is read well as a whole is no neighbour's"
