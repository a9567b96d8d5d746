"""Boards drawn from a seed: what they say, that ink is where labels say, and that texture has none."""

from collections import Counter

import numpy as np
import pytest

from lpslam.simulation.boards.ageing import AGEINGS, age
from lpslam.simulation.boards.finishes import LETTERINGS
from lpslam.simulation.boards.labels import LabelledBoard
from lpslam.simulation.boards.ornaments import ORNAMENTS, Ornament, paint_ornament
from lpslam.simulation.boards.painting import SCALE, paint_shop_board
from lpslam.simulation.boards.strokes import LOOSE, covers, dots, draw_words
from lpslam.simulation.boards.traditional import traditional
from lpslam.simulation.boards.wording import OTHER_LINES, ROLES, SCRIPTS, characters, compose
from lpslam.simulation.lettering import is_chinese


@pytest.fixture(scope="module")
def boards() -> list[LabelledBoard]:
    """One board of every lettering."""
    return [paint_shop_board(3, number) for number in range(len(LETTERINGS))]


def test_streets_show_every_lettering_and_are_drawn_again_the_same(boards: list[LabelledBoard]) -> None:
    assert {board.features["lettering"] for board in boards} == set(LETTERINGS)
    again = paint_shop_board(3, 4)
    assert np.array_equal(again.image, boards[4].image)
    assert again.lines == boards[4].lines
    assert not np.array_equal(paint_shop_board(4, 4).image.shape, boards[4].image.shape)


def test_ink_is_inside_the_boxes_that_the_labels_give(boards: list[LabelledBoard]) -> None:
    for board in boards:
        height, width = board.image.shape[:2]
        assert board.width == pytest.approx(width / SCALE)
        assert board.lines[0].role == "primary"
        for line in board.lines:
            assert line.box is not None
            left, top, right, bottom = line.box
            assert 0 <= left < right <= width
            assert 0 <= top < bottom <= height
            assert line.role in ROLES
            box = board.image[int(top) : int(bottom), int(left) : int(right)].astype(float).mean(axis=2)
            assert np.ptp(box) > 25, f"{line.text} does not stand out on {board.name}"
        for first in board.lines:
            for second in board.lines:
                if first is not second:
                    assert not _overlap(first.box, second.box), f"{first.text} lies on {second.text} on {board.name}"


def _overlap(first: tuple[float, ...] | None, second: tuple[float, ...] | None) -> bool:
    assert first is not None
    assert second is not None
    wide = min(first[2], second[2]) - max(first[0], second[0])
    tall = min(first[3], second[3]) - max(first[1], second[1])
    return wide > 1 and tall > 1


def test_wordings_have_one_name_few_other_lines_and_the_script_asked_for() -> None:
    rng = np.random.default_rng(5)
    for script in SCRIPTS:
        for _ in range(60):
            lines = compose(rng, script)
            assert Counter(line.role for line in lines)["primary"] == 1
            assert len(lines) <= OTHER_LINES + 1
            assert len({line.text for line in lines}) == len(lines)
            if script == "english":
                assert not any(is_chinese(line.text) for line in lines)
            if script in ("simplified", "traditional"):
                assert is_chinese(lines[0].text)
            if script == "traditional":
                assert all(traditional(line.text) == line.text for line in lines)
            if script == "mixed":
                assert len({is_chinese(line.text) for line in lines}) == 2


def test_seeds_share_few_names() -> None:
    names = [[compose(np.random.default_rng([s, i]), "simplified")[0].text for i in range(100)] for s in (1, 101)]
    assert len(set(names[0]) & set(names[1])) <= 8
    assert traditional("面馆的发") == "麵館的發"
    assert traditional("理发 修面") == "理髮 修面"


def test_fonts_have_every_character_of_boards() -> None:
    assert covers("chinese-kai-bold", characters())
    assert covers("chinese-hei-bold", characters())
    assert not covers("chinese-brush", "樓")
    assert not covers("latin-comic-bold", "店")


def test_columns_run_down_arcs_bend_and_hands_shake() -> None:
    def draw(course: str, hand: object = None) -> np.ndarray:
        rng = np.random.default_rng(1)
        return draw_words(rng, "青山酒楼", "chinese-kai-bold", 40, course, hand or LOOSE.__class__())  # type: ignore[arg-type]

    line, column, arc = draw("line"), draw("column"), draw("arc")
    assert line.shape[1] > 3 * line.shape[0]
    assert column.shape[0] > 3 * column.shape[1]
    assert line.shape[0] < arc.shape[0] < 2.5 * line.shape[0]
    assert line.max() == pytest.approx(1.0, abs=0.05)
    assert not np.array_equal(draw("line", LOOSE)[:30, :100], line[:30, :100])
    lit, every = dots(line, 40, 20)
    assert 0 < lit.sum() < every.sum()


@pytest.mark.parametrize("kind", AGEINGS)
def test_age_changes_a_board_but_not_its_size(kind: str) -> None:
    plain = np.full((120, 400, 3), 90.0, np.float32)
    plain[40:80, 100:300] = 220
    aged = age(np.random.default_rng(2), plain.copy(), kind, SCALE)  # type: ignore[arg-type]
    assert aged.shape == plain.shape
    assert np.isfinite(aged).all()
    assert np.abs(aged - plain).mean() > 0.5
    assert aged[50:70, 120:280].mean() > aged[100:, 120:280].mean() + 15


@pytest.mark.parametrize("kind", ORNAMENTS)
def test_ornaments_have_contrast_and_differ_by_seed(kind: Ornament) -> None:
    first, second = (paint_ornament(np.random.default_rng(seed), kind, 0.25, 1.1) for seed in (1, 2))
    assert first.shape == second.shape == (85, 374, 3)
    assert first.astype(float).mean(axis=2).std() > 8
    assert not np.array_equal(first, second)
