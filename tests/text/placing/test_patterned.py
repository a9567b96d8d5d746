"""Texts at whose place boxes were refused as patterns."""

from dataclasses import replace

import numpy as np
import pytest

from lpslam.config import PatternConfig
from lpslam.text.placing.patterned import Patterns, without_patterned
from lpslam.text.placing.places import Place
from lpslam.text.types import Placement


def poses(keyframe: int) -> np.ndarray | None:
    """Keyframe k stands k metres to the right; of keyframe 9 it is not known where."""
    pose = np.eye(4)
    pose[0, 3] = keyframe
    return pose if keyframe != 9 else None


def place(name: str, read: int = 15, at: float = 0.0, key: int = 1) -> Place:
    """A text two metres ahead, 0.4 m wide."""
    return Place(
        id=key * 1000, name=name, variants={name: read}, position=np.array([at, 0.0, 2.0]),
        normal=np.array([0.0, 0.0, -1.0]), baseline=np.array([1.0, 0.0, 0.0]), spread=0.01, width=0.4, height=0.1,
        positions_by_frame={}, normals_by_frame={}, grounds_by_frame={}, observations=read, evidence=0.9 * read,
        confidence=0.9,
    )  # fmt: skip


def refused(count: int, at: float = 0.0, width: float = 2.0, keyframe: int = 0, down: float = 0.0) -> Patterns:
    """A frieze 2 m long, seen from a keyframe so many metres to the right."""
    patterns = Patterns()
    for _ in range(count):
        position = at - keyframe, down, 2.0
        patterns.add(keyframe, Placement(position, (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), width, 0.1, 0.01))
    return patterns


def stays(patterns: Patterns, *places: Place, config: PatternConfig | None = None) -> list[str]:
    kept = without_patterned(places, patterns.standing(poses), config or PatternConfig())
    return [each.name for each in kept]


def test_what_is_refused_in_most_views_is_no_text_and_what_is_in_few_stays() -> None:
    assert stays(refused(0), place("0XO")) == ["0XO"]
    assert stays(refused(20), place("0XO")) == []
    assert stays(refused(1), place("KOVKE", 20)) == ["KOVKE"]
    assert stays(refused(20, keyframe=3), place("0XO")) == [], "seen from elsewhere"


def test_a_known_word_stays_however_it_looks() -> None:
    assert stays(refused(40), place("coffee")) == ["coffee"]


def test_one_row_of_shapes_that_is_read_in_two_ways_is_a_pattern() -> None:
    assert stays(Patterns(), place("XOOX", 8), place("DOXO", 5, 0.5, 2)) == ["DOXO"], "spelt as patterns are, or not"
    assert stays(Patterns(), place("AAA", 9), place("IAAA", 7, 0.5, 2)) == []
    assert stays(Patterns(), place("XOOX", 8), place("DOXO", 5, 5.0, 2)) == ["XOOX", "DOXO"], "far apart"
    assert stays(Patterns(), place("OPPO", 8), place("food", 8, 0.5, 2)) == ["OPPO", "food"], (
        "a word of the same shapes"
    )
    assert stays(Patterns(), place("OPPO", 8), place("TAXI", 8, 0.5, 2)) == ["OPPO", "TAXI"], "other shapes"


def test_what_speaks_for_patterns_weighs_as_it_is_configured() -> None:
    row = [place("ww", 6, 0.5 * number, number) for number in range(4)]
    assert stays(Patterns(), *row, config=PatternConfig(twin=0.0)) == ["ww"] * 4
    assert stays(Patterns(), *row, config=PatternConfig(twin_reach=1.0)) == ["ww"] * 4
    assert stays(Patterns(), place("0XO"), config=PatternConfig(probability=0.999)) == []
    assert stays(refused(20), place("0XO"), config=PatternConfig(refused_of_texts=(10.0, 10.0))) == ["0XO"]


@pytest.mark.parametrize("elsewhere", [refused(20, at=3.0), refused(20, down=0.2), refused(20, keyframe=9), Patterns()])
def test_patterns_elsewhere_say_nothing(elsewhere: Patterns) -> None:
    assert stays(elsewhere, place("0XO")) == ["0XO"]


def test_short_texts_of_a_patterns_spelling_that_come_again_along_a_wall_are_motifs() -> None:
    row = [place("ww", 6, 0.5 * number, number) for number in range(4)]
    assert stays(Patterns(), *row) == []
    assert stays(Patterns(), row[0], place("ww", 6, 9.0, 7)) == ["ww", "ww"]
    exits = [place("Exit 4", 6, 0.5 * number, number) for number in range(4)]
    assert stays(Patterns(), *exits) == ["Exit 4"] * 4


def test_boxes_of_one_keyframe_at_one_place_are_one_row() -> None:
    patterns = refused(7)
    assert [each.count for each in patterns.seen] == [7]
    patterns.add(0, Placement((5.0, 0.0, 2.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 2.0, 0.1, 0.01))
    assert [each.count for each in patterns.seen] == [7, 1]


def test_arrays_give_back_what_they_were_made_of_and_nothing_else_is_taken() -> None:
    patterns = refused(4, at=0.5, keyframe=2)
    again = Patterns.from_arrays(patterns.to_arrays())
    assert stays(again, place("0XO")) == stays(patterns, place("0XO"))
    assert again.to_arrays()["rows"].tolist() == patterns.to_arrays()["rows"].tolist()
    assert Patterns.from_arrays({}).seen == []
    rows = patterns.to_arrays()["rows"].astype(np.float64)
    for column, value in ((1, 0.0), (2, np.nan), (5, 7.0), (11, -1.0)):
        wrong = rows.copy()
        wrong[0, column] = value
        with pytest.raises(ValueError, match="patterns"):
            Patterns.from_arrays({"rows": wrong})
    with pytest.raises(ValueError, match="shape"):
        Patterns.from_arrays({"rows": rows[:, :5]})


def test_what_is_hardly_a_text_tells_of_the_pattern_beside_it() -> None:
    """Of two pieces of one frieze the first is read so badly that it is none anyhow."""
    first, second = place("0000", 4), place("0000", 2, 0.5, 2)
    assert stays(Patterns(), replace(first, is_text=False), second) == stays(Patterns(), first, second) == []
    assert stays(Patterns(), second) == ["0000"]
