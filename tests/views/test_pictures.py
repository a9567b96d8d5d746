from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from lpslam.config import MemoryConfig
from lpslam.errors import UserError
from lpslam.evaluation.trajectory import absolute_trajectory_error
from lpslam.ground.grid import FREE, Grid
from lpslam.mapfile.language_map import LanguageMap
from lpslam.poses import StampedPoses
from lpslam.text.remembering.histories import ScoreHistory, score_histories
from lpslam.text.remembering.memory import LongShortTermMemory
from lpslam.text.types import BoxFate, FrameReading, PlacedTexts, SpottedText
from lpslam.views import pictures
from lpslam.views.labels import place_labels
from lpslam.views.map_picture import draw_map
from lpslam.views.memory_plot import draw_memory
from lpslam.views.overlay import draw_boxes, draw_reading
from lpslam.views.trajectory_plot import draw_trajectories
from small_maps import small_map, with_floor


@dataclass
class Mark:
    name: str
    position: np.ndarray
    is_landmark: bool | None = True
    normal: np.ndarray = field(default_factory=lambda: np.array([0.0, -1.0, 0.0]))


HOSTILE = ["$\\frac{a}{", "\x1b[31m\x00", "🍕\ud800", "[bold]x[/]", "\u202eabc\u202c", "x" * 500, "", "必胜客\n出口"]


def near(picture: np.ndarray, colour: tuple[int, int, int]) -> np.ndarray:
    return (np.abs(picture.astype(int) - colour) < 40).all(axis=2)


def drawn(path: Path) -> np.ndarray:
    return np.array(Image.open(path).convert("RGB"))


def test_the_map_shows_landmarks_blue_and_other_texts_pink_at_their_places(tmp_path: Path) -> None:
    cloud = np.random.default_rng(0).uniform((0, 0, 0), (10, 10, 3), (2000, 3))
    walk = np.column_stack([np.linspace(1, 9, 50), np.full(50, 5.0), np.full(50, 1.5)])
    marks = [Mark("STARBUCKS", np.array([2.0, 9.0, 2.0])), Mark("No Smoking", np.array([8.0, 1.0, 2.0]), False)]
    draw_map(tmp_path / "map.png", cloud, walk, marks, title="a map")
    picture = drawn(tmp_path / "map.png")
    height, width = picture.shape[:2]
    body = picture[: int(height * 0.93)]
    blue, pink = np.argwhere(near(body, (31, 79, 216))), np.argwhere(near(body, (224, 71, 158)))
    assert len(blue) > 300
    assert len(pink) > 300
    # y is up and x to the right: the blue name stands upper left, the pink one lower right.
    assert blue[:, 0].mean() < height / 2 < pink[:, 0].mean()
    assert blue[:, 1].mean() < width / 2 < pink[:, 1].mean()
    assert near(body, (18, 129, 61)).sum() > 1000, "the trajectory is green"


def test_the_same_map_gives_the_same_picture(tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        draw_map(tmp_path / name, np.eye(3), np.eye(3), [Mark("X", np.ones(3))])
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_hostile_names_and_numbers_are_drawn(tmp_path: Path) -> None:
    marks = [Mark(name, np.array([i, 0.0, 0.0]), [True, False, None][i % 3]) for i, name in enumerate(HOSTILE)]
    marks.append(Mark("nowhere", np.full(3, np.nan)))
    cloud = np.array([[np.nan, 0, 0], [1e9, 1e9, 0], [0, 0, 0], [1, 1, 1]])
    walk = np.array([[0, 0, 0], [np.nan, 0, 0], [1, 0, 0]])
    colours = np.zeros((4, 3), np.uint8)
    draw_map(tmp_path / "map.png", cloud, walk, marks, title=HOSTILE[0], cloud_colours=colours)
    assert drawn(tmp_path / "map.png").std() > 0


@pytest.mark.parametrize("points", [0, 1])
def test_maps_of_nothing_are_drawn(tmp_path: Path, points: int) -> None:
    draw_map(tmp_path / "map.png", np.zeros((points, 3)), np.zeros((points, 3)), [])
    assert (tmp_path / "map.png").stat().st_size > 0


def test_each_storey_has_a_picture_with_what_is_on_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    world, shown = with_floor(small_map(["Below", "Above"])), dict[str, Any]()
    free = np.full((80, 80), FREE, np.int8)
    grids = [Grid(free, (0.0, 0.0), 0.1, storeys=(-1.2, 2.0), storey=storey) for storey in (0, 1)]
    below, above = world.landmarks()
    above = replace(above, position=above.position + np.array([0.0, 0.0, 3.0]))
    walked = np.array([[0.0, 0.0, 0.0], [np.nan] * 3, [1.0, 0.0, 3.2]])
    monkeypatch.setattr(LanguageMap, "grids", lambda self: grids)
    monkeypatch.setattr(LanguageMap, "frame_poses", lambda self: SimpleNamespace(positions=walked))
    monkeypatch.setattr(LanguageMap, "landmarks", lambda self: [below, above])

    def draw(out: Path, *what: Any, ground: Grid, **more: Any) -> None:
        shown[out.name] = *what, ground

    monkeypatch.setattr(pictures, "draw_map", draw)
    paths = pictures.draw_language_map(world, tmp_path / "map.png")
    assert [path.name for path in paths] == ["map-storey_0.png", "map.png"]
    for path, mark, row, grid in zip(paths, (below, above), (0, 2), grids, strict=True):
        cloud, camera, marks, ground = shown[path.name]
        assert marks == [mark]
        assert np.flatnonzero(np.isfinite(camera).all(axis=1)).tolist() == [row]
        assert ground is grid
        # The floor that is seen lies below.
        assert (len(cloud) > 0) == (grid.storey == 0)


def test_unwritable_pictures_are_clear_errors(tmp_path: Path) -> None:
    for out, words in (
        (tmp_path / "none" / "map.png", "cannot be written"),
        (tmp_path / "map.docx", "no picture format"),
        (tmp_path / "map", "no suffix"),
    ):
        with pytest.raises(UserError, match=words):
            draw_map(out, np.eye(3), np.eye(3), [])


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_labels_do_not_cover_each_other(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = 40
    anchors = rng.uniform((100, 100), (1400, 900), (n, 2))
    anchors[:8] = anchors[0] + rng.normal(0, 3, (8, 2))
    sizes = np.column_stack([rng.uniform(30, 200, n), np.full(n, 20.0)])
    centres = place_labels(anchors, sizes, (1500, 1000))
    gap = np.abs(centres[:, None] - centres[None]) - (sizes[:, None] + sizes[None]) / 2
    overlapping = (gap < 0).all(axis=2) & ~np.eye(n, dtype=bool)
    assert not overlapping.any()
    assert (centres - sizes / 2 >= 0).all()
    assert (centres + sizes / 2 <= (1500, 1000)).all()


def test_a_lone_label_stands_right_beside_its_point() -> None:
    centre = place_labels(np.array([[100.0, 100.0]]), np.array([[60.0, 20.0]]), (500, 500))
    np.testing.assert_allclose(centre, [[136, 100]])


def test_memory_scores_are_drawn(tmp_path: Path) -> None:
    histories = [
        ScoreHistory("KFC", [(0, 0), (1, 3), (2, 2.5)], True),
        ScoreHistory("KFO", [(0.5, 0), (0.6, 0.9), (4, 0)], False),
        ScoreHistory("never seen", [], False),
        *(ScoreHistory(name, [(3, 1 + i)], True) for i, name in enumerate(HOSTILE)),
    ]
    draw_memory(tmp_path / "memory.png", histories, 2.3, title="$scores")
    picture = drawn(tmp_path / "memory.png")
    assert near(picture, (31, 119, 180)).sum() > 500, "the first promoted class has the first colour"
    draw_memory(tmp_path / "none.png", [], 2.3)
    assert (tmp_path / "none.png").stat().st_size > 0


def test_trajectories_are_drawn(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    poses = np.tile(np.eye(4), (100, 1, 1))
    poses[:, :3, 3] = np.cumsum(rng.normal(size=(100, 3)), axis=0)
    truth = StampedPoses(np.arange(100) / 30, poses)
    noisy = poses.copy()
    noisy[:, :3, 3] += rng.normal(0, 0.1, (100, 3))
    estimate = StampedPoses(truth.timestamps, noisy)
    draw_trajectories(tmp_path / "t.png", truth, estimate, absolute_trajectory_error(truth, estimate), title="walk $1")
    assert near(drawn(tmp_path / "t.png"), (31, 79, 216)).sum() > 1000


def test_boxes_are_green_when_kept_and_yellow_when_dropped() -> None:
    image = np.zeros((120, 200, 3), np.uint8)
    boxes = np.array([[[20, 50], [80, 50], [80, 70], [20, 70]], [[120, 50], [180, 50], [180, 70], [120, 70]]], float)
    out = draw_boxes(image, boxes, [True, False], ["", ""])
    assert out.shape == image.shape
    assert (image == 0).all(), "the frame itself is not drawn on"
    green, yellow = near(out, (40, 200, 80)), near(out, (250, 205, 30))
    assert green[50, 20:80].mean() > 0.9
    assert yellow[50, 120:180].mean() > 0.9
    assert not green[:, 100:].any()
    assert not yellow[:, :100].any()


def test_a_reading_is_drawn_by_the_fate_of_its_boxes() -> None:
    image = np.zeros((120, 300, 3), np.uint8)
    kept = np.array([[20, 60], [80, 60], [80, 80], [20, 80]], float)
    boxes = np.stack([kept + np.array([200, 0]), kept])
    text = SpottedText("KFC", 0.9, kept, 20.0)
    out = draw_reading(image, FrameReading(0, boxes, (BoxFate.BORDER, BoxFate.KEPT), PlacedTexts((text,), (None,))))
    np.testing.assert_array_equal(out, draw_boxes(image, boxes, [False, True], ["border", "KFC 0.90"]))
    assert near(out, (40, 200, 80))[:, :150].any()
    assert not near(out, (40, 200, 80))[:, 200:].any()


def test_labels_of_boxes_stay_in_the_image_and_may_be_hostile() -> None:
    image = np.zeros((100, 160, 3), np.uint8)
    box = np.array([[150, 0], [159, 0], [159, 9], [150, 9]], float)
    beyond = box + np.array([1000, -500])
    boxes = np.stack([box, beyond, np.full((4, 2), np.nan)] + [box] * len(HOSTILE))
    out = draw_boxes(image, boxes, [True] * len(boxes), ["STAR", "FAR", "NAN", *HOSTILE])
    assert near(out, (40, 200, 80)).any()
    assert (draw_boxes(image, np.zeros((0, 4, 2)), [], []) == 0).all()


def test_what_is_remembered_is_shown_fading_until_now() -> None:
    memory = LongShortTermMemory(MemoryConfig())
    for second in range(4):
        memory.forget(float(second))
        memory.sight("STARBUCKS", 0.9, float(second))
    memory.forget(9.0)
    (history,) = score_histories(memory)
    assert history.is_long_term
    assert history.samples[-1] == (9.0, pytest.approx(history.samples[-2][1] - 6 * 30 * memory.config.forgetting))
