"""Streets of boards: truth on the wall, depth that is missing where it should be, ornaments beside no board."""

import json
from pathlib import Path

import numpy as np
import pytest

from lpslam.camera import inverse_transform, transform_points
from lpslam.errors import UserError
from lpslam.evaluation.signs import read_signs
from lpslam.simulation.boards.labels import LabelledBoard, LabelledLine
from lpslam.simulation.boards.street import (
    HEIGHT,
    LINTEL,
    StreetSource,
    bays_of,
    read_distractors,
    streets_of,
    write_distractors,
)
from lpslam.simulation.recording import Recording

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def street() -> StreetSource:
    return StreetSource(3)


def test_walks_are_short_and_show_the_boards(street: StreetSource) -> None:
    assert len(street) <= 400
    assert len(street.signs) == len(street.boards) >= 5
    readable = [sign.readable_frames >= 10 for sign in street.signs]
    assert np.mean(readable) > 0.7
    for sign, board in zip(sorted(street.signs, key=lambda each: each.id), street.boards, strict=True):
        assert sign.features["lettering"] in {each.features["lettering"] for each in street.boards}
        assert all(0.5 < corner[2] < HEIGHT for corner in sign.corners)
        assert board.width is not None


def test_truth_lies_on_ink(street: StreetSource) -> None:
    sign = max(street.signs, key=lambda each: each.readable_frames)
    seen = np.flatnonzero(street.sign_views[sign.id].readable())
    index = int(seen[len(seen) // 2])
    frame, pose = street.frame(index), street.ground_truth.world_from_camera[index]
    line = sign.lines[0]
    box = street.camera.project(transform_points(inverse_transform(pose), line.corners))
    (left, top), (right, bottom) = box.min(axis=0).astype(int), box.max(axis=0).astype(int)
    assert np.ptp(frame.rgb[top:bottom, left:right].astype(float).mean(axis=2)) > 50


def test_dark_glass_gives_no_depth() -> None:
    image = np.full((200, 500, 3), 120, np.uint8)
    lines = (LabelledLine("NIGHT BAR", "primary", (50, 50, 450, 150), 100.0),)
    boards = [LabelledBoard(f"{seen}.png", image, lines, 1.6, has_depth=seen) for seen in (True, False)]
    source = StreetSource(1, boards)
    for sign, seen in zip(source.signs, (0.8, 0.0), strict=True):
        shares = []
        for index in range(0, len(source), 12):
            pose = inverse_transform(source.ground_truth.world_from_camera[index])
            u, v = source.camera.project(transform_points(pose, sign.centre[None]))[0]
            if 20 < u < 620 and 20 < v < 460:
                depth = source.frame(index).depth
                shares.append(float((depth[int(v) - 4 : int(v) + 5, int(u) - 4 : int(u) + 5] > 0).mean()))
        assert len(shares) >= 2
        assert np.mean(shares) >= seen if seen else np.max(shares) == 0.0
    assert [sign.features["depth"] for sign in source.signs] == ["yes", "no"]


def test_ornaments_hang_beside_boards_and_are_listed(street: StreetSource, tmp_path: Path) -> None:
    assert len(street.distractors) >= 4
    write_distractors(tmp_path, street.distractors)
    again = read_distractors(tmp_path)
    assert [each.kind for each in again] == [each.kind for each in street.distractors]
    assert np.allclose(again[0].corners, street.distractors[0].corners, atol=1e-3)
    assert read_distractors(tmp_path / "absent") == []
    for each in street.distractors:
        low, high = each.corners.min(axis=0), each.corners.max(axis=0)
        for sign in street.signs:
            middle = sign.centre
            assert not (low[0] < middle[0] < high[0] and low[2] < middle[2] < high[2])


def test_roles_and_features_are_in_the_truth(street: StreetSource, tmp_path: Path) -> None:
    Recording(tmp_path).describe(street.camera, street.signs)
    signs = read_signs(tmp_path)
    assert signs is not None
    for drawn, read in zip(street.signs, signs, strict=True):
        assert [line.role for line in read.lines] == [line.role for line in drawn.lines]
        assert read.features == dict(drawn.features)
    tree = json.loads((tmp_path / "signs.json").read_text(encoding="utf-8"))
    tree["signs"][0]["features"] = ["hostile"]
    tree["signs"][0]["lines"][0]["role"] = 5
    (tmp_path / "signs.json").write_text(json.dumps(tree), encoding="utf-8")
    hostile = read_signs(tmp_path)
    assert hostile is not None
    assert (hostile[0].features, hostile[0].lines[0].role) == ({}, "")


def test_boards_are_shared_out_among_streets_and_houses() -> None:
    image = np.zeros((60, 200, 3), np.uint8)
    boards = [LabelledBoard(f"{number}.png", image, (), 1.5) for number in range(20)]
    streets = streets_of(boards)
    assert [board.name for each in streets for board in each] == [board.name for board in boards]
    assert len(streets) >= 2
    assert [len(bay) for bay in bays_of(boards)][:6] == [1, 2, 1, 1, 2, 1]
    tall = [LabelledBoard("tall.png", np.zeros((400, 100, 3), np.uint8), (), 1.0)] * 4
    assert all(len(bay) == 1 for bay in bays_of(tall))
    assert LINTEL < HEIGHT
    with pytest.raises(UserError, match="no boards"):
        StreetSource(1, [])
