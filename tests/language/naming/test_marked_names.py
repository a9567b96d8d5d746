"""Words of a name that marks part are known words, as those are that spaces part."""

import pytest

from lpslam.language.model import Reading
from lpslam.language.offline import embedded_model


@pytest.mark.parametrize("mark", ["&", "-", "/", ".", "+", " "])
def test_a_cut_reading_with_a_space_does_not_win_over_a_whole_one_without(mark: str) -> None:
    read = [Reading(f"COPPER{mark}LANTERN", 3, 0.9, 0.5, 1.0), Reading(f"ER{mark} LANTERN", 3, 0.9, 0.9, 1.0)]
    named = embedded_model().name(read)
    assert named.name == f"COPPER{mark}LANTERN"
    assert named.confidence > 0.9


@pytest.mark.parametrize("mark", ["&", "-", "/"])
def test_a_slip_in_a_word_beside_a_mark_is_mended_as_beside_a_space(mark: str) -> None:
    read = [Reading(f"COPPER{mark}LAMTERN", 3, 0.9, 0.5, 1.0), Reading(f"COPPFR{mark}LANTERN", 3, 0.9, 0.5, 1.0)]
    assert embedded_model().name(read).name == f"COPPER{mark}LANTERN"
