"""What becomes of landmarks on shop fronts: real, merged, split, misread, ornaments, inventions."""

from pathlib import Path

import numpy as np
import pytest

from lpslam.config import EvaluationConfig
from lpslam.evaluation.signs import TrueSign, listed_signs
from lpslam.simulation.boards.street import Distractor
from lpslam.text.types import Landmark

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(autouse=True)
def _beside_the_benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def line(text: str, x: float, z: float, role: str) -> dict[str, object]:
    return {"text": text, "centre": [x, 0, z], "width": 0.9, "height": 0.2, "readable_frames": 20, "role": role}


def sign(name: str, motto: str, x: float) -> dict[str, object]:
    lines = [line(name, x, 2.6, "primary"), line(motto, x, 2.3, "secondary")]
    return {"text": name, "centre": [x, 0, 2.6], "normal": [0, -1, 0], "readable_frames": 20, "lines": lines}


SIGNS = [sign("青山五金", "OPEN DAILY", 0.0), sign("Copper Fox", "批发零售", 1.4), sign("福源花店", "鲜花速递", 8.0)]
FRIEZE = Distractor("frieze", np.array([[3.0, 0, 3.2], [5.0, 0, 3.2], [5.0, 0, 3.0], [3.0, 0, 3.0]]))


def mark(name: str, x: float, z: float) -> Landmark:
    out = np.array([0.0, -1.0, 0.0])
    return Landmark(int(1000 * x), name, {name: 3}, np.array([x, 0.0, z]), out, 0.01, 0.9, 0.2, 5, 0.9)


def judged(*marks: Landmark) -> tuple[list[str], list[object]]:
    from text_fronts_scores import judge

    truth: list[TrueSign] = listed_signs(SIGNS, "here")
    each, scores = judge(marks, truth, [FRIEZE], np.eye(4), EvaluationConfig())
    return [one.fate for one in each], list(scores)


def test_landmarks_are_what_they_say_where_they_hang() -> None:
    fates, scores = judged(
        mark("青山五金 OPEN DAILY", 0.0, 2.45),
        mark("Coppar Fox", 1.4, 2.6),
        mark("批发零售", 1.4, 2.3),
        mark("0X0X0X", 4.0, 3.1),
        mark("习", 6.0, 1.0),
        mark("福源花店", 4.6, 2.0),
        mark("鲜花逋遁", 8.0, 2.3),
    )
    assert fates == ["real", "real", "real", "ornament", "invented", "misplaced", "misread"]
    first, second, third = scores
    assert (first.found, first.exact, first.split) == (True, True, False)  # type: ignore[attr-defined]
    assert (second.found, second.exact, second.split) == (True, False, True)  # type: ignore[attr-defined]
    assert not third.found  # type: ignore[attr-defined]


def test_one_landmark_of_two_boards_finds_neither() -> None:
    fates, scores = judged(mark("青山五金 Copper Fox OPEN DAILY 批发零售", 0.7, 2.45))
    assert fates == ["merged"]
    assert [(each.merged, each.found) for each in scores] == [(True, False), (True, False), (False, False)]  # type: ignore[attr-defined]


def test_duplicates_are_counted_and_short_lines_are_not_found_in_long_ones() -> None:
    from text_fronts_scores import lines_said

    _, scores = judged(mark("Copper Fox", 1.4, 2.6), mark("COPPER FOX", 1.41, 2.62))
    assert scores[1].doubles == 1  # type: ignore[attr-defined]
    lines = listed_signs([sign("茶行", "花", 0.0)], "here")[0].lines
    assert [each.text for each in lines_said("花店 茶行", lines, 0.8)] == ["花", "茶行"]
    assert lines_said("茶花女", lines[:1], 0.8) == ()


def test_a_line_is_exact_where_its_board_says_just_that() -> None:
    from dataclasses import replace

    from lpslam.text.types import LandmarkLine
    from text_fronts_scores import stated_and_exact

    def own(text: str, x: float, sure: float) -> LandmarkLine:
        return LandmarkLine(text, "primary", sure, np.array([x, 0.0, 2.6]), 0.9, 0.2, 5)

    lines = own("Copper Fox", 1.4, 0.97), own("Coppar Fox", 1.4, 0.4), own("Copper Fox", 8.0, 0.9)
    board = replace(mark("Copper Fox", 1.4, 2.6), lines=lines)
    stated = stated_and_exact([board], listed_signs(SIGNS, "here"), np.eye(4))
    assert stated == [(0.97, True), (0.4, False), (0.9, False)]


def test_goods_and_price_of_a_row_are_exact_together_however_they_are_parted() -> None:
    from text_rows import RowLine, likenesses

    def at(text: str, x: float, y: float, letter: float = 0.1) -> RowLine:
        return RowLine(text, np.array([x, y, 0.0]), letter)

    whole, parted = [at("桑茶 2元", 0.3, 0.0)], [at("2元", 0.6, 0.01), at("桑茶", 0.0, 0.0)]
    assert likenesses(parted, whole, 0.5) == likenesses(whole, parted, 0.5) * 2 == [1.0, 1.0]
    assert likenesses(parted[:1], whole, 0.5)[0] < 1.0, "a price without its goods is not the row"
    assert likenesses([at("2元", 0.6, 0.3), at("桑茶", 0.0, 0.0)], whole, 0.5)[0] < 1.0, "nor is one of another row"
    assert likenesses([at("2元", 0.6, 0.0, 0.3), at("桑茶", 0.0, 0.0)], whole, 0.5)[0] < 1.0, "or of another size"
    assert likenesses([at("☎ Bob’s 8–12", 0.0, 0.0)], [at("Bob's 8-12", 0.0, 0.0)], 0.5) == [1.0]
    assert likenesses(whole, [at("桑茶 2元", 3.0, 0.0)], 0.5) == [0.0]


def test_few_lines_have_a_calibration_error_by_chance() -> None:
    from text_calibration import error_by_chance

    few, many = (error_by_chance(np.full(count, 0.9)) for count in (30, 3000))
    assert 0.03 < few[0] < few[1] < 0.12
    assert many[1] < 0.015
    assert error_by_chance(np.ones(30)) == (0.0, 0.0)


def test_each_photograph_counts_once_in_the_error_of_certainty() -> None:
    from text_worn import interval

    # Nine lines of one picture are as sure as they are right; the only line of the other is not.
    stated, exact = np.array([0.95] * 9 + [0.95]), np.array([True] * 9 + [False])
    once, low, high = interval(stated, exact, ["a"] * 9 + ["b"])
    assert once == pytest.approx(0.45)
    assert low == pytest.approx(0.05)
    assert high == pytest.approx(0.95)


def test_a_worn_board_says_the_same_and_looks_otherwise() -> None:
    from lpslam.simulation.boards.labels import LabelledBoard, LabelledLine
    from text_worn import looks

    image = np.full((120, 400, 3), 180, np.uint8)
    image[40:80, 60:340] = 20
    board = LabelledBoard("a.jpg", image, (LabelledLine("HOTEL"),), width=1.0)
    first, second = (each[0] for each in looks([board], 2))
    assert first.lines == second.lines == board.lines
    assert first.image.shape == image.shape
    assert first.width != second.width
    assert np.abs(first.image.astype(int) - second.image).mean() > 5
    again = looks([board], 2)[0][0]
    assert np.array_equal(again.image, first.image)
