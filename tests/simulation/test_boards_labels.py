"""Labelled folders: written and read again, older ones too, and hostile ones refused in one line."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from lpslam.errors import UserError
from lpslam.simulation.boards.labels import read_labelled, write_labelled
from lpslam.simulation.boards.painting import paint_shop_board

SIGNS = Path(__file__).parents[3] / "shared" / "data" / "signs"


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    boards = [paint_shop_board(3, number) for number in (0, 1)]
    write_labelled(tmp_path, boards)
    for before, after in zip(boards, read_labelled(tmp_path), strict=True):
        assert np.array_equal(before.image, after.image)
        assert (before.name, before.features, before.has_depth, before.glows) == (
            *(after.name, after.features, after.has_depth, after.glows),
        )
        assert after.width == pytest.approx(before.width)
        assert [(line.text, line.role) for line in before.lines] == [(line.text, line.role) for line in after.lines]
        for a, b in zip(before.lines, after.lines, strict=True):
            assert b.box == pytest.approx(a.box, abs=0.06)


def _folder(tmp_path: Path, tree: Any) -> Path:
    cv2.imwrite(str(tmp_path / "a.png"), np.full((40, 60, 3), 90, np.uint8))
    text = tree if isinstance(tree, str) else json.dumps(tree)
    (tmp_path / "labels.json").write_text(text, encoding="utf-8")
    return tmp_path


def test_plain_lists_of_lines_are_enough(tmp_path: Path) -> None:
    (board,) = read_labelled(_folder(tmp_path, {"comment": "mine", "images": {"a.png": ["EXIT", {"text": "出口"}]}}))
    assert [line.text for line in board.lines] == ["EXIT", "出口"]
    assert {line.role for line in board.lines} == {""}
    assert board.width is None
    assert board.has_depth


def test_corners_straighten_a_photograph(tmp_path: Path) -> None:
    folder = _folder(tmp_path, {"images": {"b.png": []}, "boards": {"b.png": {"corners": None}}})
    photograph = np.zeros((100, 200, 3), np.uint8)
    corners = [[40, 10], [160, 30], [150, 80], [50, 90]]
    cv2.fillPoly(photograph, [np.array(corners, np.int32)], (255, 255, 255))
    cv2.imwrite(str(folder / "b.png"), photograph)
    _folder(tmp_path, {"images": {"b.png": []}, "boards": {"b.png": {"corners": corners, "width": 2.0}}})
    (board,) = read_labelled(folder)
    assert board.image.mean() > 245
    assert board.width == 2.0


@pytest.mark.parametrize(
    "tree",
    [
        "no JSON",
        "[" * 100_000,
        [],
        {"images": []},
        {"images": {"../a.png": []}},
        {"images": {"/etc/passwd": []}},
        {"images": {"a\0.png": []}},
        {"images": {"absent.png": []}},
        {"images": {"labels.json": []}},
        {"images": {"a.png": "EXIT"}},
        {"images": {"a.png": [""]}},
        {"images": {"a.png": ["x" * 1000]}},
        {"images": {"a.png": [{"role": "primary"}]}},
        {"images": {"a.png": [{"text": "a", "role": 3}]}},
        {"images": {"a.png": [{"text": "a", "box": [9, 9, 1, 1]}]}},
        {"images": {"a.png": [{"text": "a", "box": ["x"]}]}},
        {"images": {"a.png": [{"text": "a", "letter_height": "tall"}]}},
        {"images": {"a.png": []}, "boards": {"a.png": {"width": 1e9}}},
        {"images": {"a.png": []}, "boards": {"a.png": {"corners": [[0, 0]]}}},
        {"images": {"a.png": []}, "boards": {"a.png": {"features": 1}}},
        {"images": {"a.png": []}, "boards": {"a.png": 1}},
        {"images": {f"{number}.png": [] for number in range(501)}},
    ],
)
def test_hostile_folders_are_refused_in_one_line(tmp_path: Path, tree: Any) -> None:
    with pytest.raises(UserError) as error:
        read_labelled(_folder(tmp_path, tree))
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 600


def test_no_folder_is_said(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be read"):
        read_labelled(tmp_path / "absent")


def test_the_given_photographs_are_boards() -> None:
    if not (SIGNS / "labels.json").exists():
        pytest.skip(f"no photographs in {SIGNS}")
    boards = read_labelled(SIGNS)
    assert len(boards) == 14
    assert all(board.lines for board in boards)
