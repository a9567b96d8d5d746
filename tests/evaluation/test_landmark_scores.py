import json
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lpslam.errors import UserError
from lpslam.evaluation.landmarks import score_landmarks
from lpslam.evaluation.signs import TrueLine, TrueSign, read_signs
from lpslam.text.types import Landmark, LandmarkLine


@dataclass(frozen=True)
class Mark:
    id: int
    name: str
    position: np.ndarray
    normal: np.ndarray = field(default_factory=lambda: np.array([0.0, -1.0, 0.0]))


def mark(identifier: int, name: str, *position: float, turned: float = 0.0) -> Mark:
    """A landmark that faces -y, or is turned from there by some degrees."""
    radians = np.radians(turned)
    normal = np.array([np.sin(radians), -np.cos(radians), 0.0])
    return Mark(identifier, name, np.array(position, dtype=float), normal)


def sign(
    identifier: int, text: str, *centre: float, aliases: tuple[str, ...] = (), frames: int | None = 50
) -> TrueSign:
    return TrueSign(identifier, text, aliases, "shop", (centre[0], centre[1], centre[2]), (0.0, -1.0, 0.0), frames)


SIGNS = [
    sign(0, "STARBUCKS", 0, 0, 2, aliases=("星巴克", "星巴克 STARBUCKS")),
    sign(1, "WASHROOM", 5, 0, 2),
    sign(2, "EXIT", 9, 0, 2),
    sign(3, "ATM", 12, 0, 2, frames=4),
]


def test_counts_by_hand() -> None:
    marks = [
        mark(10, "starbucks", 0.3, 0, 2),  # right, 0.3 m off
        mark(11, "星巴克", 0.1, 0, 2),  # an alias of the same sign: a duplicate, or the match with 10 the duplicate
        mark(12, "WASHR0OM", 5, 0.1, 2),  # one slip of eight: right but not exact
        mark(13, "EXIT", 9, 3, 2),  # right name, wrong place
        mark(14, "ATM", 12, 0, 2.2),  # a sign that nobody expects: right, but not in the recall
        mark(15, "POSTER", 5, 0, 2),  # right place, wrong name
    ]
    score = score_landmarks(marks, SIGNS, np.eye(4))
    assert score.readable_signs == 3
    assert score.recall == pytest.approx(2 / 3)
    assert score.precision == pytest.approx(3 / 6)
    assert {(match.landmark, match.sign) for match in score.matches} == {(11, 0), (12, 1), (14, 3)}
    assert score.median_position_error == pytest.approx(0.1)
    assert score.exact_name_share == pytest.approx(2 / 3)
    assert [miss.id for miss in score.misses] == [2]
    assert {stray.landmark: stray.duplicate_of for stray in score.strays} == {10: 0, 13: None, 15: None}
    exit_stray = next(stray for stray in score.strays if stray.landmark == 13)
    assert (exit_stray.likest, exit_stray.similarity, exit_stray.distance) == ("EXIT", 1.0, 3.0)


def test_the_alignment_is_applied() -> None:
    truth_from_map = np.eye(4)
    truth_from_map[:3, :3] = Rotation.from_euler("xyz", [0.1, -0.2, 2.0]).as_matrix()
    truth_from_map[:3, 3] = [3, -4, 1]
    map_from_truth = np.linalg.inv(truth_from_map)
    marks = [mark(s.id, s.text, *(map_from_truth @ [*s.centre, 1])[:3]) for s in SIGNS]  # type: ignore[arg-type]
    score = score_landmarks(marks, SIGNS, truth_from_map)
    assert (score.recall, score.precision, score.exact_name_share) == (1.0, 1.0, 1.0)
    assert score.median_position_error == pytest.approx(0, abs=1e-9)
    assert score_landmarks(marks, SIGNS, np.eye(4)).recall == 0.0


BOARD = replace(
    sign(0, "HUAWEI", 2, 0, 2.1, aliases=("华为", "HUAWEI 华为", "华为 HUAWEI")),
    lines=(TrueLine("HUAWEI", (2, 0, 2.1), 1.0, 0.2, 50), TrueLine("华为", (2, 0, 1.8), 0.4, 0.2, 20)),
)


@pytest.mark.parametrize(
    ("name", "height", "whole"),
    [("HUAWEI", 2.1, False), ("华为", 1.8, False), ("HUAWEI 华为", 1.95, True), ("华为 HUAWEl", 1.95, True)],
)
def test_a_landmark_belongs_to_the_middle_of_the_lines_that_it_says(name: str, height: float, whole: bool) -> None:
    (match,) = score_landmarks([mark(0, name, 2, 0, height)], [BOARD], np.eye(4)).matches
    assert match.distance == pytest.approx(0, abs=1e-9)
    assert match.whole is whole
    score = score_landmarks([mark(0, name, 2.03, 0.04, height)], [BOARD], np.eye(4))
    assert score.median_position_error == pytest.approx(0.05)
    assert score.whole_name_share == float(whole)
    # A second line that nobody could read is not missed.
    faint = replace(BOARD, lines=(BOARD.lines[0], replace(BOARD.lines[1], readable_frames=3)))
    assert score_landmarks([mark(0, name, 2, 0, height)], [faint], np.eye(4)).whole_name_share is None


def test_a_landmark_with_lines_of_its_own_belongs_to_the_middle_of_those() -> None:
    """Its name is the primary line alone; all of the board is its place."""

    def line(text: str) -> LandmarkLine:
        return LandmarkLine(text, "primary", 0.9, np.zeros(3), 1.0, 0.2, 5)

    at = np.array([2.0, 0.0, 1.95])
    board = Landmark(0, "HUAWEI", {}, at, np.array([0.0, -1.0, 0.0]), 0.0, 1.0, 0.5, 5, 0.9)
    (match,) = score_landmarks([replace(board, lines=(line("HUAWEI"), line("华为")))], [BOARD], np.eye(4)).matches
    assert (match.distance, match.whole) == (pytest.approx(0, abs=1e-9), True)
    (match,) = score_landmarks([replace(board, lines=(line("HUAWEI"), line("FOO")))], [BOARD], np.eye(4)).matches
    assert (match.distance, match.whole) == (pytest.approx(0.15), False)


def test_the_middle_of_lines_of_different_lengths_is_that_of_their_ink() -> None:
    # Reading from the left, along +x for someone who looks at a face towards -y.
    lines = (TrueLine("AB", (1.0, 0, 2.0), 2.0, 0.4), TrueLine("CD", (0.5, 0, 1.5), 1.0, 0.2))
    two = replace(sign(0, "AB", 1.0, 0, 2.0, aliases=("CD", "AB CD")), lines=lines)
    np.testing.assert_allclose(two.middle_of("AB CD"), [1.0, 0, (2.2 + 1.4) / 2])
    turned = replace(two, normal=(0.0, 1.0, 0.0))
    np.testing.assert_allclose(turned.middle_of("AB CD"), [1.0, 0, 1.8])
    np.testing.assert_allclose(replace(two, lines=()).middle_of("AB CD"), [1.0, 0, 2.0])


def test_facings_are_counted_within_ten_degrees() -> None:
    marks = [
        mark(0, "STARBUCKS", 0, 0, 2, turned=9),
        mark(1, "WASHROOM", 5, 0, 2, turned=-11),
        mark(2, "EXIT", 9, 0, 2),
    ]
    score = score_landmarks(marks, SIGNS, np.eye(4))
    assert [match.angle for match in score.matches] == pytest.approx([9, 11, 0], abs=1e-5)
    assert score.facing_share == pytest.approx(2 / 3)
    unknown = [replace(each, normal=None) for each in SIGNS]
    assert score_landmarks(marks, unknown, np.eye(4)).facing_share is None


def test_a_sign_with_two_sides_is_right_from_either() -> None:
    hung = replace(sign(0, "EXIT", 0, 0, 2), double_sided=True, thickness=0.06)
    for depth, error in ((0.0, 0.0), (0.03, 0.0), (0.06, 0.0), (0.16, 0.1), (-0.1, 0.1)):
        (match,) = score_landmarks([mark(0, "EXIT", 0, depth, 2, turned=180)], [hung], np.eye(4)).matches
        assert match.distance == pytest.approx(error, abs=1e-9)
        assert match.angle == pytest.approx(0, abs=1e-5)
    (match,) = score_landmarks(
        [mark(0, "EXIT", 0, 0.06, 2, turned=180)], [SIGNS[0], sign(1, "EXIT", 0, 0, 2)], np.eye(4)
    ).matches
    assert match.distance == pytest.approx(0.06)
    assert match.angle == pytest.approx(180, abs=1e-5)


def test_duplicates_are_apart_when_each_has_its_own_landmark() -> None:
    exits = [sign(n, "EXIT", x, 0, 2) for n, x in enumerate((0.0, 3.0, 18.0))]
    other = [sign(3, "EXIT 2", 6, 0, 2), sign(4, "EXIT", 30, 0, 2, frames=2), sign(5, "EXIT", 1.5, 0, 2, frames=0)]
    near = sign(6, "exit", 19.5, 0, 2)
    marks = [mark(0, "EXIT", 0, 0, 2), mark(1, "EXIT", 3, 0, 2)]
    score = score_landmarks(marks, [*exits, *other], np.eye(4))
    assert (score.duplicates, score.duplicates_apart) == (3, 1)
    # Nearer than two metres is one place; 18 and 19.5 m are, and both are apart from the rest.
    score = score_landmarks([*marks, mark(2, "EXIT", 19.0, 0, 2)], [*exits, *other, near], np.eye(4))
    assert (score.duplicates, score.duplicates_apart) == (5, 3)
    merged = score_landmarks([mark(0, "EXIT", 1.5, 0, 2)], exits, np.eye(4))
    assert (merged.duplicates, merged.duplicates_apart) == (3, 0)


def test_a_landmark_on_a_sign_that_nobody_could_read_is_right() -> None:
    unread = [sign(0, "EXIT", 0, 0, 2, frames=0)]
    score = score_landmarks([mark(0, "EXIT", 0, 0, 2)], unread, np.eye(4))
    assert (score.recall, score.precision, score.strays) == (None, 1.0, ())


def test_two_signs_of_the_same_words_are_matched_the_best_way_overall() -> None:
    signs = [sign(0, "EXIT", 0, 0, 0), sign(1, "EXIT", 0.8, 0, 0)]
    # The first landmark is nearer to sign 1, but only it can be sign 0 as well.
    marks = [mark(0, "EXIT", 0.5, 0, 0), mark(1, "EXIT", 1.4, 0, 0)]
    score = score_landmarks(marks, signs, np.eye(4))
    assert {(match.landmark, match.sign) for match in score.matches} == {(0, 0), (1, 1)}


@pytest.mark.parametrize(("name", "matched"), [("WASHROOM", True), ("WASHROO", True), ("WASHRO", False), ("", False)])
def test_similarity_threshold(name: str, matched: bool) -> None:
    assert bool(score_landmarks([mark(0, name, 5, 0, 2)], SIGNS, np.eye(4)).matches) is matched


def test_nothing_to_score() -> None:
    nothing = score_landmarks([], [], np.eye(4))
    assert (nothing.recall, nothing.precision, nothing.median_position_error) == (None, None, None)
    no_marks = score_landmarks([], SIGNS, np.eye(4))
    assert (no_marks.recall, no_marks.precision) == (0.0, None)
    no_signs = score_landmarks([mark(0, "X", 0, 0, 0)], [], np.eye(4))
    assert (no_signs.recall, no_signs.precision) == (None, 0.0)
    assert len(no_signs.strays) == 1


@pytest.mark.parametrize("bare", [True, False])
def test_signs_file(tmp_path: Path, bare: bool) -> None:
    listed = [
        {"id": 4, "text": "必胜客", "aliases": ["PIZZA HUT"], "kind": "restaurant", "centre": [1, 2, 3],
         "normal": [0, 1, 0], "width": 1, "height": 0.3, "readable_frames": 12},
        {"text": "EXIT", "center": [0, 0, 0]},
        {"text": "ATM", "centre": [0, 0, 2], "double_sided": True, "thickness": 0.05, "readable_from": 3.5, "lines": [
            {"text": "ATM", "centre": [0, 0, 2], "width": 0.4, "height": 0.1, "readable_frames": 7}]},
        {"text": "TAXI", "centre": [0, 0, 2], "lines": [{"text": "TAXI"}]},
    ]  # fmt: skip
    path = tmp_path / "signs.json"
    path.write_text(json.dumps(listed if bare else {"signs": listed}), encoding="utf-8")
    signs = read_signs(tmp_path)
    assert signs is not None
    assert signs[0] == TrueSign(4, "必胜客", ("PIZZA HUT",), "restaurant", (1, 2, 3), (0, 1, 0), 12)
    assert (signs[1].id, signs[1].readable_frames, signs[1].normal) == (1, None, None)
    assert (signs[1].lines, signs[1].double_sided, signs[1].readable_from) == ((), False, None)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "is not JSON"),
        ('{"signs": [', "is not JSON"),
        ('{"boards": []}', "expected"),
        ('"EXIT"', "expected"),
        ('[{"centre": [0, 0, 0]}]', "sign 0 has no text"),
        ('[{"text": "EXIT"}]', "needs its centre"),
        ('[{"text": "EXIT", "centre": [0, 0]}]', "needs its centre"),
        ('[{"text": "EXIT", "centre": [0, 0, NaN]}]', "needs its centre"),
    ],
)
def test_malformed_signs_are_one_clear_line(tmp_path: Path, content: str, words: str) -> None:
    (tmp_path / "signs.json").write_text(content)
    with pytest.raises(UserError, match=words) as caught:
        read_signs(tmp_path)
    assert "\n" not in str(caught.value)


def test_no_signs_file(tmp_path: Path) -> None:
    assert read_signs(tmp_path) is None
