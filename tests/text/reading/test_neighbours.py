import numpy as np
from numpy.typing import NDArray

from lpslam.text.reading.neighbours import are_among_marks


def box(left: float, top: float, width: float, height: float) -> NDArray[np.float64]:
    return np.array([[left, top], [left + width, top], [left + width, top + height], [left, top + height]])


TEXT = box(100.0, 100.0, 40.0, 50.0)


def among(*marks: NDArray[np.float64]) -> bool:
    return bool(are_among_marks(TEXT[None], np.array(marks).reshape(-1, 4, 2))[0])


def test_marks_as_large_stand_beside_it_above_or_below() -> None:
    assert among(box(160.0, 100.0, 40.0, 50.0))
    assert among(box(90.0, 190.0, 50.0, 44.0))
    assert among(box(300.0, 0.0, 9.0, 9.0), box(40.0, 110.0, 36.0, 60.0)), "one of them is enough"


def test_what_is_larger_smaller_or_farther_says_nothing() -> None:
    assert not among()
    assert not among(box(160.0, 100.0, 40.0, 90.0))
    assert not among(box(160.0, 100.0, 20.0, 25.0))
    assert not among(box(160.0, 100.0, 140.0, 50.0))
    assert not among(box(200.0, 100.0, 40.0, 50.0))
    assert not among(box(150.0, 210.0, 40.0, 50.0))


def test_each_text_is_asked_for_itself() -> None:
    texts = np.array([TEXT, box(400.0, 100.0, 40.0, 50.0)])
    marks = np.array([box(450.0, 100.0, 40.0, 50.0)])
    assert are_among_marks(texts, marks).tolist() == [False, True]
    assert are_among_marks(texts[:0], marks).tolist() == []
