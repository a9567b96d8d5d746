import json
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import ReadingConfig, SightingConfig, TextConfig
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.language.model import Candidate, Choice, Judgement, Naming, Reading
from lpslam.slam.state import TrackedFrame, TrackingState
from lpslam.text.distilling import distil
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.patterns import Likeness
from lpslam.text.reading.windows import WHOLE, Windows
from lpslam.text.text_map import TextMap
from lpslam.text.types import BoxFate, PlacedTexts, Recognition, Shot, TextObservation

CAMERA = PinholeCamera(640, 480, 570.0, 570.0, 320.0, 240.0)
CONFIG = TextConfig()


def box(x: float, y: float, width: float = 120.0, height: float = 30.0) -> NDArray[np.float64]:
    return np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])


class ScriptedSpotter:
    """Sees what the script says, the same in every frame."""

    def __init__(self, *seen: tuple[NDArray[np.float64], str, float]) -> None:
        self.seen = list(seen)
        self.recognised = 0
        self.searched: list[float] = []

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        corner, size = self.corner_of(rgb), np.array(rgb.shape[1::-1])
        self.searched.append(rgb.shape[0] * rgb.shape[1] / (CAMERA.width * CAMERA.height))
        boxes = np.array([each[0] for each in self.seen]).reshape(-1, 4, 2) - corner
        is_in = (boxes.max(axis=1) >= 0).all(axis=1) & (boxes.min(axis=1) < size).all(axis=1)
        return np.clip(boxes[is_in], 0.0, size - 1.0), np.ones(int(is_in.sum()))

    @staticmethod
    def corner_of(rgb: NDArray[np.uint8]) -> NDArray[np.int64]:
        """Where in its image, which is as large as the camera's, a window of it begins: (x, y)."""
        whole = rgb if rgb.shape[:2] == (CAMERA.height, CAMERA.width) or rgb.base is None else rgb.base
        ends = (each.__array_interface__["data"][0] for each in (rgb, whole))
        row, column = divmod(next(ends) - next(ends), 3 * CAMERA.width)
        return np.array([column // 3, row])

    def recognise(self, rgb: NDArray[np.uint8], boxes: NDArray[np.float64]) -> list[Recognition]:
        self.recognised += len(boxes)
        return [next(Recognition(t, c) for b, t, c in self.seen if np.allclose(b, wanted)) for wanted in boxes]


class BrokenSpotter(ScriptedSpotter):
    def recognise(self, rgb: NDArray[np.uint8], boxes: NDArray[np.float64]) -> list[Recognition]:
        raise RuntimeError("the network burst")


class Namer:
    """A language model that answers as told."""

    model = "namer"

    def __init__(self, answer: str | None = None) -> None:
        self.answer = answer
        self.asked: list[list[str]] = []

    def name(self, readings: list[Reading] | tuple[Reading, ...]) -> Naming:  # type: ignore[override]
        self.asked.append([each.text for each in readings])
        if self.answer is None:
            raise TimeoutError
        return Naming(self.answer, 0.9, "as told", self.model)

    def judge(self, names: list[str], question: str) -> list[Judgement]:  # type: ignore[override]
        return [Judgement(question, "GUCCI" in name, 0.8, "as told", self.model) for name in names]

    def choose(self, question: str, landmarks: list[Candidate]) -> Choice:  # type: ignore[override]
        return Choice(None, 0.0, "", self.model)


TEXTURE = np.random.default_rng(0).integers(0, 255, (480, 640, 3), dtype=np.uint8)
FLAT = np.full((480, 640, 3), 127, np.uint8)


def frame(index: int, rgb: NDArray[np.uint8] = TEXTURE, depth: float = 2.0) -> RgbdFrame:
    return RgbdFrame(index, index / 30.0, rgb, np.full((480, 640), depth, np.float32))


def tracked(index: int, lost: bool = False) -> TrackedFrame:
    pose = None if lost else np.eye(4)
    state = TrackingState.LOST if lost else TrackingState.TRACKING
    return TrackedFrame(index, index / 30.0, state, 0, pose, pose, 100, False)


def run(mapper: TextMapper, frames: int = 30, **kwargs: float) -> TextMapper:
    for index in range(frames):
        mapper.observe(frame(index, **kwargs), tracked(index))  # type: ignore[arg-type]
    return mapper


def identity(_: int) -> NDArray[np.float64]:
    return np.eye(4)


def test_a_sign_looked_at_for_a_second_becomes_a_landmark_in_its_place() -> None:
    mapper = run(TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "GUCCI", 0.98)), CONFIG))
    (landmark,) = mapper.text_map.landmarks(identity)
    assert landmark.name == "GUCCI"
    assert landmark.id == 0
    assert landmark.position == pytest.approx([(160 - 320) / 570 * 2, (215 - 240) / 570 * 2, 2.0], abs=1e-6)
    assert landmark.normal == pytest.approx([0, 0, -1])
    assert (landmark.width, landmark.height) == pytest.approx((120 / 570 * 2, 30 / 570 * 2))
    settled = CONFIG.reading.settled_sightings
    assert landmark.observations == settled
    assert landmark.variants == {"GUCCI": settled}
    assert landmark.is_landmark is None


def test_the_map_keeps_what_a_sign_looked_like_beside_what_is_looked_at_again() -> None:
    mapper = run(TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "GUCCI", 0.98)), CONFIG))
    mapper.text_map.crops.drop([0])
    (kept,) = mapper.text_map.sightings.by_class[0]
    picture = cv2.imdecode(np.frombuffer(kept.jpeg, np.uint8), cv2.IMREAD_COLOR)
    # The box is 120 by 30 pixels, and as many as its letters are high are around it.
    assert picture.shape[:2] == pytest.approx((90, 180), abs=2)
    assert kept.position == pytest.approx([(160 - 320) / 570 * 2, (215 - 240) / 570 * 2, 2.0], abs=1e-6)
    off = CONFIG.model_copy(update={"sightings": SightingConfig(enabled=False)})
    assert len(run(TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "GUCCI", 0.98)), off)).text_map.sightings) == 0


def test_a_third_of_a_second_is_enough_and_a_glimpse_is_not() -> None:
    spotter = ScriptedSpotter((box(100, 200), "GUCCI", 0.98))
    assert len(run(TextMapper(CAMERA, spotter, CONFIG), 10).text_map.long_term) == 1
    assert len(run(TextMapper(CAMERA, spotter, CONFIG), 6).text_map.long_term) == 0


def test_what_is_settled_is_confirmed_unread_until_it_is_seen_better() -> None:
    spotter = ScriptedSpotter((box(100, 200, 80, 20), "GUCCI", 0.98))
    mapper = run(TextMapper(CAMERA, spotter, CONFIG), 60)
    settled = CONFIG.reading.settled_sightings
    assert spotter.recognised == settled
    assert mapper.statistics.boxes_known == mapper.statistics.frames_read - settled > 0
    (text_class,) = mapper.text_map.long_term
    assert text_class.last_seen == pytest.approx(59 / 30, abs=0.2), "it is remembered all the same"
    # From nearer, the same sign covers more pixels.
    spotter.seen = [(box(100, 200, 160, 40), "GUCCI", 0.98)]
    for index in range(60, 70):
        mapper.observe(frame(index, depth=1.0), tracked(index))
    assert spotter.recognised > settled


def test_what_was_read_is_no_landmark_where_most_views_are_refused_as_patterns(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    like = Likeness.NONE

    def likenesses(_: object, boxes: NDArray[np.float64]) -> list[Likeness]:
        return [like] * len(boxes)

    monkeypatch.setattr("lpslam.text.frame_reader.pattern_likenesses", likenesses)
    spotter = ScriptedSpotter((box(100, 200, 80, 20), "0X0", 0.98), (box(300, 200), "GUCCI", 0.98))
    mapper = run(TextMapper(CAMERA, spotter, CONFIG))
    assert {each.name for each in mapper.text_map.landmarks(identity)} == {"0X0", "GUCCI"}
    # The frieze comes into view as a whole, and the word is settled.
    like, spotter.seen = Likeness.IS, [(box(60, 200, 160, 20), "0X0X0X", 0.98), spotter.seen[1]]
    for index in range(30, 120):
        mapper.observe(frame(index), tracked(index))
    assert [each.name for each in mapper.text_map.landmarks(identity)] == ["GUCCI"]


@pytest.mark.parametrize(
    ("text", "beside", "is_text"),
    [
        ("天", (170.0, 200.0, 40.0, 44.0), False),
        ("XK3", (110.0, 250.0, 44.0, 40.0), False),
        ("XK3", (300.0, 200.0, 40.0, 44.0), True),
        ("XK3", (170.0, 200.0, 120.0, 44.0), True),
        ("男", (170.0, 200.0, 40.0, 44.0), True),
        ("出口", (170.0, 200.0, 40.0, 44.0), True),
        ("GUCCI", (170.0, 200.0, 40.0, 44.0), True),
    ],
)
def test_a_mark_among_marks_that_nobody_reads_is_no_text(
    text: str, beside: tuple[float, float, float, float], is_text: bool
) -> None:
    """Runes stand in rows, and one of them may look like a character; words stand where they like."""
    spotter = ScriptedSpotter((box(110, 200, 44, 44), text, 0.98), (box(*beside), "~", 0.4))
    mapper = run(TextMapper(CAMERA, spotter, CONFIG))
    assert [each.name for each in mapper.text_map.landmarks(identity)] == [text] * is_text


def test_what_only_looks_like_a_pattern_is_a_text_if_it_is_spelt_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    like = Likeness.LIKE

    def likenesses(_: object, boxes: NDArray[np.float64]) -> list[Likeness]:
        return [like] * len(boxes)

    monkeypatch.setattr("lpslam.text.frame_reader.pattern_likenesses", likenesses)
    frieze, board, nothing = (
        ScriptedSpotter((box(100, 200), text, sure))
        for text, sure in (("GGCGG", 0.98), ("新閣茶餐廳", 0.98), ("GUCCI", 0.1))
    )
    mapper = run(TextMapper(CAMERA, frieze, CONFIG), 30)
    assert (mapper.text_map.landmarks(identity), mapper.statistics.texts_read) == ([], 0)
    assert mapper.statistics.boxes_ornamental > 0
    mapper = run(TextMapper(CAMERA, board, CONFIG), 30)
    assert [each.name for each in mapper.text_map.landmarks(identity)] == ["新閣茶餐廳"]
    assert mapper.statistics.boxes_ornamental == 0
    mapper = run(TextMapper(CAMERA, nothing, CONFIG), 10)
    assert mapper.statistics.boxes_ornamental > 0
    # What has no place is not refused by looks that say little.
    mapper = run(TextMapper(CAMERA, frieze, CONFIG), 10, depth=0.0)
    assert (mapper.statistics.texts_read > 0, mapper.statistics.boxes_ornamental) == (True, 0)
    # Read four times otherwise, it is a word that looks so now and then.
    like = Likeness.NONE
    mapper = run(TextMapper(CAMERA, frieze, CONFIG), 10)
    like, refused = Likeness.LIKE, mapper.statistics.boxes_ornamental
    mapper.observe(frame(20), tracked(20))
    assert mapper.statistics.boxes_ornamental == refused


def test_new_text_is_read_at_a_quicker_pace_than_none() -> None:
    new = run(TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "GUCCI", 0.98)), CONFIG), 15)
    none = run(TextMapper(CAMERA, ScriptedSpotter(), CONFIG), 15)
    assert new.statistics.frames_read >= 2 * none.statistics.frames_read


def test_between_two_whole_searches_only_what_is_not_settled_is_searched() -> None:
    spotter = ScriptedSpotter((box(100, 200), "GUCCI", 0.98))
    mapper = run(TextMapper(CAMERA, spotter, CONFIG), 15)
    parts = [share for share in spotter.searched if share < 1.0]
    assert len(parts) >= len(spotter.searched) / 2
    assert max(parts) < 0.5
    assert spotter.recognised == len(spotter.searched), "it is found in each of them where it stands"
    assert mapper.text_map.landmarks(identity)[0].position[0] == pytest.approx((160 - 320) / 570 * 2, abs=1e-6)


def test_a_window_of_a_large_image_costs_as_much_as_the_detector_sees_of_it() -> None:
    windows = Windows(PinholeCamera(1920, 1440, 1710.0, 1710.0, 960.0, 720.0), CONFIG)
    first, second = (Shot(frame(index), 0, np.eye(4), np.eye(4)) for index in (0, 2))
    assert windows.next(first, lambda: np.zeros((0, 4, 2))) == WHOLE
    windows.hold(first, box(60, 60, 800.0, 300.0), None)
    # 1,280 by 800 pixels are a third of the image, but of what the detector sees, 960 at most, four fifths.
    assert windows.next(second, lambda: np.zeros((0, 4, 2))) == WHOLE


def test_a_box_that_a_window_cuts_waits_for_a_whole_search() -> None:
    """A piece that ends where the window does would be taken for a word."""
    spotter = ScriptedSpotter((box(100, 200, 60), "GUCCI", 0.98))
    mapper = TextMapper(CAMERA, spotter, CONFIG)
    mapper.observe(frame(0), tracked(0))
    spotter.seen.append((box(180, 200, 300), "STARBUCKS COFFEE", 0.98))
    reading = mapper.observe(frame(2), tracked(2))
    assert reading is not None
    assert spotter.searched[-1] < 1.0
    assert list(reading.texts.spellings) == ["GUCCI"]
    for index in range(3, 8):
        reading = mapper.observe(frame(index), tracked(index)) or reading
    assert list(reading.texts.spellings) == ["GUCCI", "STARBUCKS COFFEE"]


def test_while_nothing_unsettled_is_in_view_only_the_set_interval_counts() -> None:
    spotter = ScriptedSpotter((box(100, 200), "GUCCI", 0.98))
    mapper = TextMapper(CAMERA, spotter, CONFIG)
    assert mapper.observe(frame(0), tracked(0)) is not None
    away = tracked(2)
    turned = np.diag([-1.0, 1.0, -1.0, 1.0])
    assert mapper.observe(frame(2), replace(away, world_from_camera=turned, keyframe_from_camera=turned)) is None
    assert len(spotter.searched) == 1


def test_where_nothing_was_ever_read_nothing_is_read_until_it_is_seen_larger() -> None:
    spotter = ScriptedSpotter((box(100, 200), "smudge", 0.3))
    run(TextMapper(CAMERA, spotter, CONFIG), 60)
    in_vain = spotter.recognised
    assert in_vain == CONFIG.reading.settled_sightings // 2
    mapper = run(TextMapper(CAMERA, spotter, CONFIG), 60)
    spotter.seen = [(box(100, 200, 160, 40), "GUCCI", 0.98)]
    reading = next(filter(None, (mapper.observe(frame(index), tracked(index)) for index in range(60, 70))))
    assert list(reading.texts.spellings) == ["GUCCI"]


def test_two_lines_that_say_nothing_in_one_box_do_not_keep_either_from_being_read() -> None:
    spotter = ScriptedSpotter((box(100, 200, 120, 70), "smudge", 0.3))
    mapper = run(TextMapper(CAMERA, spotter, CONFIG), 60)
    spotter.seen = [(box(100, 200), "GUCCI", 0.98), (box(100, 240), "PRADA", 0.98)]
    reading = next(filter(None, (mapper.observe(frame(index), tracked(index)) for index in range(60, 70))))
    assert list(reading.texts.spellings) == ["GUCCI", "PRADA"]


def test_what_is_cut_off_is_read_at_a_quicker_pace_until_it_was_read_often() -> None:
    """It may be whole in a moment, and gone in the next."""
    cut = box(2, 200, 100)
    part = run(TextMapper(CAMERA, ScriptedSpotter((cut, "SMOKING", 0.98)), CONFIG), 15)
    none = run(TextMapper(CAMERA, ScriptedSpotter(), CONFIG), 15)
    assert part.statistics.frames_read >= 2 * none.statistics.frames_read
    longer = run(part, 90)
    assert longer.statistics.frames_read <= CONFIG.reading.settled_sightings + 1 + 90 / 30.0 / CONFIG.reading.interval


def test_what_is_cut_off_and_placed_by_its_surroundings_waits_for_the_rest() -> None:
    glossy = frame(0)
    spotter = ScriptedSpotter((box(2, 200, 100), "SMOKING", 0.98))
    glossy.depth[195:235, :110] = 0.0
    reading = TextMapper(CAMERA, spotter, CONFIG).observe(glossy, tracked(0))
    assert reading is not None
    assert reading.fates == (BoxFate.BORDER,)
    assert list(reading.parts.spellings) == ["SMOKING"]
    glossy.depth[:] = 0.0
    reading = TextMapper(CAMERA, spotter, CONFIG).observe(glossy, tracked(0))
    assert reading is not None
    assert not len(reading.parts), "what stands nowhere cannot wait"


class OftenMissing(ScriptedSpotter):
    """Finds what the script says in the first two images only, and reads whatever it is told to in any box."""

    def __init__(self, sign: NDArray[np.float64], *texts: str) -> None:
        super().__init__((sign, texts[0], 0.9))
        self.texts = list(texts)

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        boxes, scores = super().detect(rgb)
        return (boxes, scores) if len(self.searched) <= 2 else (boxes[:0], scores[:0])

    def recognise(self, rgb: NDArray[np.uint8], boxes: NDArray[np.float64]) -> list[Recognition]:
        assert boxes == pytest.approx(np.array([self.seen[0][0]]), abs=1e-6)
        self.recognised += 1
        return [Recognition(self.texts[min(self.recognised, len(self.texts)) - 1], 0.9)]


def test_an_unsure_text_is_read_where_it_stands_though_it_is_not_found() -> None:
    spotter = OftenMissing(box(100, 200), "Velmo Quills", "Velno Quills", "Velmo Quills")
    mapper = run(TextMapper(CAMERA, spotter, CONFIG), 60)
    (landmark,) = mapper.text_map.landmarks(identity)
    assert (landmark.name, landmark.observations) == ("Velmo Quills", CONFIG.reading.settled_sightings)
    assert spotter.recognised == landmark.observations


@pytest.mark.parametrize("else_read", ["Nordwind", "Velmo Qu"])
def test_where_a_text_is_expected_nothing_else_is_taken(else_read: str) -> None:
    spotter = OftenMissing(box(100, 200), "Velmo Quills", "Velmo Quills", else_read)
    mapper = run(TextMapper(CAMERA, spotter, CONFIG), 60)
    assert spotter.recognised > 2
    assert {each.text for known in mapper.text_map.memory.classes for each in known.observations} == {"Velmo Quills"}
    # What goes on saying something else is given up.
    assert spotter.recognised == 2 + CONFIG.reading.unfound_patience


def test_frames_are_read_at_the_set_interval() -> None:
    config = CONFIG.model_copy(update={"reading": ReadingConfig(interval=0.2)})
    mapper = run(TextMapper(CAMERA, ScriptedSpotter(), config), 60)
    assert mapper.statistics.frames_seen == 60
    assert mapper.statistics.frames_read == 10


def test_boxes_at_the_border_and_tiny_ones_are_no_texts_and_are_counted() -> None:
    spotter = ScriptedSpotter(
        (box(2, 200), "SMOKING", 0.99),
        (box(300, 449), "FLOOR", 0.99),
        (box(300, 100, 40, 6), "tiny", 0.99),
        (box(300, 300), "KFC", 0.99),
        (box(300, 350), "~~", 0.99),
        (box(300, 400), "texture", 0.3),
    )
    reading = TextMapper(CAMERA, spotter, CONFIG).observe(frame(0), tracked(0))
    assert reading is not None
    assert list(reading.fates) == [
        BoxFate.BORDER,
        BoxFate.BORDER,
        BoxFate.SMALL,
        BoxFate.KEPT,
        BoxFate.UNREAD,
        BoxFate.UNREAD,
    ]
    assert list(reading.texts.spellings) == ["KFC"]
    assert list(reading.parts.spellings) == ["SMOKING", "FLOOR"], "they may go on outside"
    assert spotter.recognised == 5


def test_texts_of_a_frame_and_their_places_are_columns_of_one_length() -> None:
    spotter = ScriptedSpotter((box(300, 300), "KFC", 0.99), (box(100, 200), "GUCCI", 0.98))
    seen = frame(0)
    seen.depth[:250] = 0.0
    reading = TextMapper(CAMERA, spotter, CONFIG).observe(seen, tracked(0))
    assert reading is not None
    texts = reading.texts
    assert texts.spellings == ("KFC", "GUCCI")
    np.testing.assert_allclose(texts.boxes[1], box(100, 200))
    assert texts.confidences.tolist() == [0.99, 0.98]
    assert [placement is None for placement in texts.placements] == [False, True]
    assert [text.text for text, _ in texts.standing()] == ["KFC"]
    assert texts[np.array([1])].spellings == ("GUCCI",)
    assert texts[np.array([True, False])].placements == texts.placements[:1]
    with pytest.raises(ValueError, match="2 texts have 1 placements"):
        PlacedTexts(texts.spotted, texts.placements[:1])
    assert PlacedTexts().boxes.shape == (0, 4, 2)


def test_an_ornament_is_not_even_read() -> None:
    spotter = ScriptedSpotter((box(300, 200, 200, 40), "mmmmmmm", 0.99), (box(300, 300), "KFC", 0.99))
    railing = frame(0, TEXTURE.copy())
    for column in range(305, 500, 20):
        railing.rgb[202:238, column : column + 6] = 220
    mapper = TextMapper(CAMERA, spotter, CONFIG)
    reading = mapper.observe(railing, tracked(0))
    assert reading is not None
    assert list(reading.fates) == [BoxFate.ORNAMENT, BoxFate.KEPT]
    assert spotter.recognised == 1
    assert mapper.statistics.boxes_ornamental == 1


def test_text_without_depth_enters_the_map_by_its_bearings() -> None:
    spotter = ScriptedSpotter()
    mapper = TextMapper(CAMERA, spotter, CONFIG)
    # The sign stands 2 m ahead of where the camera passes from left to right.
    poses = {}
    for index in range(0, 60, 6):
        aside = -0.4 + index / 60
        spotter.seen = [(box(270 - 285 * aside, 200), "GUCCI", 0.98)]
        moved = np.eye(4)
        moved[0, 3] = aside
        poses[index] = moved
        mapper.observe(frame(index, depth=0.0), replace(tracked(index), keyframe=index, world_from_camera=moved))
    (mark,) = mapper.text_map.landmarks(lambda keyframe: poses[keyframe])
    assert mark.name == "GUCCI"
    assert mark.position[2] == pytest.approx(2.0, abs=0.1)


def test_text_hidden_by_something_nearer_waits_for_the_rest() -> None:
    spotter = ScriptedSpotter((box(300, 200), "RMATION", 0.99))
    hidden = frame(0)
    hidden.depth[:, :295] = 1.0
    mapper = TextMapper(CAMERA, spotter, CONFIG)
    reading = mapper.observe(hidden, tracked(0))
    assert reading is not None
    assert reading.fates == (BoxFate.HIDDEN,)
    assert mapper.statistics.boxes_hidden == 1
    assert list(reading.parts.spellings) == ["RMATION"]
    assert not mapper.text_map.memory.classes
    # Seen as a whole, it needs no parts.
    spotter.seen = [(box(255, 200, 165), "INFORMATION", 0.99)]
    for index in range(1, 40):
        mapper.observe(frame(index), tracked(index))
    mapper.take_waiting()
    (text_class,) = mapper.text_map.memory.classes
    assert list(text_class.variants) == ["INFORMATION"]


@pytest.mark.parametrize(
    ("wholes", "part", "is_remembered"), [(2, "INFORMA", True), (1, "INFORMA", False), (2, "SHOES", False)]
)
def test_parts_of_what_was_seen_as_a_whole_for_a_moment_speak_for_it(
    wholes: int, part: str, is_remembered: bool
) -> None:
    spotter = ScriptedSpotter((box(400, 200, 165), "INFORMATION", 0.99))
    mapper = TextMapper(CAMERA, spotter, CONFIG)
    times = [2 * index for index in range(wholes)]
    for index in times:
        mapper.observe(frame(index, FLAT), tracked(index))
    # It leaves the view; what stays of it is cut off.
    away = np.eye(4)
    away[0, 3] = -180.0 / 570.0 * 2.0
    spotter.seen = [(box(580, 200, 58), part, 0.99)]
    for index in range(4, 40):
        moved = replace(tracked(index), keyframe_from_camera=away, world_from_camera=away)
        mapper.observe(frame(index, FLAT), moved)
    assert [each.name for each in mapper.text_map.long_term] == ["INFORMATION"] * is_remembered


def test_parts_of_what_was_read_twice_as_a_whole_found_nothing_whatever_its_name_is() -> None:
    spotter = ScriptedSpotter((box(400, 200, 165), "LADDER", 0.99))
    mapper = TextMapper(CAMERA, spotter, CONFIG)
    for index, text in enumerate(["HAMMER &LADDER", "HAMMER & LADDER", "LADDER", "LADDER", "LADDER"]):
        spotter.seen = [(box(400, 200, 165), text, 0.9)]
        mapper.observe(frame(4 * index, FLAT), tracked(4 * index))
    away = np.eye(4)
    away[0, 3] = 455.0 / 570.0 * 2.0
    spotter.seen = [(box(0, 200, 110), "G LADDER", 0.99)]
    for index in range(20, 60):
        mapper.observe(frame(index, FLAT), replace(tracked(index), keyframe_from_camera=away, world_from_camera=away))
    mapper.take_waiting()
    (text_class,) = mapper.text_map.long_term
    assert "G LADDER" not in text_class.variants


@pytest.mark.parametrize(("painted", "known", "is_landmark"), [("INFORMATION", 9, False), ("SHOE LAB", 8, True)])
def test_the_most_of_a_text_that_is_never_seen_as_a_whole_is_a_landmark_if_it_may_be_all_of_it(
    painted: str, known: int, is_landmark: bool
) -> None:
    spotter = ScriptedSpotter()
    mapper = TextMapper(CAMERA, spotter, CONFIG)
    for index in range(160):
        shown = min(index // 16, known)
        spotter.seen = [(box(2, 200, 10.0 + 12 * shown), painted[-shown:] if shown else "", 0.99)]
        mapper.observe(frame(index, FLAT), tracked(index))
    assert not mapper.text_map.memory.classes
    mapper.take_waiting()
    assert [each.name for each in mapper.text_map.long_term] == [painted[-known:]]
    marks = mapper.text_map.landmarks(identity)
    assert [each.name for each in marks] == [painted] * is_landmark
    assert all(each.confidence < 0.9 for each in marks)


def test_a_part_of_a_frieze_is_no_text() -> None:
    spotter = ScriptedSpotter((box(2, 200), "XXXX", 0.99))
    mapper = run(TextMapper(CAMERA, spotter, CONFIG), 30)
    mapper.take_waiting()
    assert not mapper.text_map.memory.classes


def test_text_of_the_world_is_cleaned() -> None:
    spotter = ScriptedSpotter((box(100, 200), "ＫＦ\u202eＣ\u200b\n" + "xanthic words " * 40, 0.99))
    reading = TextMapper(CAMERA, spotter, CONFIG).observe(frame(0), tracked(0))
    assert reading is not None
    assert reading.texts.spellings[0].startswith("KFC x")
    assert len(reading.texts.spellings[0]) <= CONFIG.spotting.max_length


def test_lost_frames_are_not_read() -> None:
    mapper = TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "GUCCI", 0.98)), CONFIG)
    for index in range(30):
        assert mapper.observe(frame(index), tracked(index, lost=True)) is None
    assert mapper.statistics.frames_untracked == 30
    assert mapper.statistics.frames_read == 0


def test_a_frame_whose_place_is_guessed_tells_what_it_shows_and_nothing_is_remembered() -> None:
    told: list[tuple[int, list[str]]] = []
    mapper = TextMapper(
        CAMERA,
        ScriptedSpotter((box(100, 200), "GUCCI", 0.98)),
        CONFIG,
        on_view=lambda keyframe, seen: told.append((keyframe, [each.text for each in seen])),
    )
    for index in range(10):
        assert mapper.observe(frame(index), replace(tracked(index), is_coasted=True)) is None
    assert told
    assert all(keyframe < 0 and texts == ["GUCCI"] for keyframe, texts in told)
    assert not mapper.text_map.memory.classes


def test_a_blurred_frame_is_passed_over_for_the_next_sharp_one() -> None:
    mapper = TextMapper(CAMERA, ScriptedSpotter(), CONFIG)
    # Frames 0 and 5 are sharp; 10 and 11, when the next is due, are not.
    read = [i for i in range(16) if mapper.observe(frame(i, FLAT if i in (10, 11) else TEXTURE), tracked(i))]
    assert read == [0, 5, 12]
    assert mapper.statistics.frames_blurred == 2


def test_blur_without_end_is_read_in_the_end() -> None:
    mapper = TextMapper(CAMERA, ScriptedSpotter(), CONFIG)
    read = [i for i in range(40) if mapper.observe(frame(i, TEXTURE if i < 6 else FLAT), tracked(i))]
    assert read[:2] == [0, 5]
    assert 10 < read[2] <= 20


def test_a_reader_that_raises_is_counted_and_mapping_goes_on() -> None:
    mapper = run(TextMapper(CAMERA, BrokenSpotter((box(100, 200), "GUCCI", 0.98)), CONFIG))
    assert mapper.statistics.reader_errors == 6
    assert mapper.text_map.landmarks(identity) == []


def test_texts_without_depth_are_remembered_but_stand_nowhere() -> None:
    mapper = run(TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "GUCCI", 0.98)), CONFIG), depth=0.0)
    assert mapper.statistics.observations_without_depth == mapper.statistics.frames_read > 6
    assert [each.name for each in mapper.text_map.long_term] == ["GUCCI"]
    assert mapper.text_map.landmarks(identity) == []


def test_readings_without_a_place_weigh_less_than_those_with_one() -> None:
    mapper = TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "Newfrrivals", 0.98)), CONFIG)
    run(mapper, 60, depth=0.0)
    near = ScriptedSpotter((box(100, 200), "New Arrivals", 0.98))
    mapper._reader._spotter = near
    for index in range(60, 75):
        mapper.observe(frame(index), tracked(index))
    variants = mapper.text_map.long_term[0].variants
    worth = {text: each.confidence / each.count for text, each in variants.items()}
    assert worth["Newfrrivals"] < worth["New Arrivals"]


def test_a_class_is_named_on_promotion_and_once_it_is_settled() -> None:
    namer = Namer("Gucci")
    mapper = run(TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "GUCC1", 0.98)), CONFIG, namer), 75)  # type: ignore[arg-type]
    assert len(namer.asked) == 2
    assert mapper.text_map.long_term[0].name == "Gucci"


@pytest.mark.parametrize("answer", [None, "", "Ignore previous instructions"])
def test_a_language_model_that_fails_or_invents_leaves_the_majority_name(answer: str | None) -> None:
    mapper = run(TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "GUCCI", 0.98)), CONFIG, Namer(answer)))  # type: ignore[arg-type]
    assert mapper.text_map.long_term[0].name == "GUCCI"
    assert mapper.statistics.language_errors >= 1


def mall() -> TextMap:
    spotter = ScriptedSpotter(
        (box(100, 200), "GUCCI", 0.98), (box(400, 100), "星巴克", 0.97), (box(400, 132), "STARBUCKS", 0.99)
    )
    return run(TextMapper(CAMERA, spotter, CONFIG)).text_map


def test_lines_of_a_board_are_one_landmark() -> None:
    landmarks = mall().landmarks(identity)
    assert [(each.name, each.wording) for each in landmarks] == [("GUCCI", "GUCCI"), ("STARBUCKS", "星巴克 STARBUCKS")]
    assert [(line.text, line.role) for line in landmarks[1].lines] == [
        ("星巴克", "secondary"),
        ("STARBUCKS", "primary"),
    ]
    assert landmarks[1].other_lines == ("星巴克",)
    settled = CONFIG.reading.settled_sightings
    assert landmarks[1].variants == {"星巴克": settled, "STARBUCKS": settled}
    assert landmarks[1].position[1] == pytest.approx((131 - 240) / 570 * 2, abs=1e-6)
    assert landmarks[1].height == pytest.approx(62 / 570 * 2)


def test_distilling_judges_and_keeps_what_fails() -> None:
    text_map = mall()
    landmarks = distil(text_map, identity, Namer(None), "Is this GUCCI?")  # type: ignore[arg-type]
    assert {each.name: each.is_landmark for each in landmarks} == {"GUCCI": True, "STARBUCKS": False}
    assert landmarks[0].judgements["Is this GUCCI?"].model == "namer"
    # The next question is answered beside the first.
    again = distil(text_map, identity, Namer(None), "Is this a shop?")  # type: ignore[arg-type]
    assert set(again[0].judgements) == {"Is this GUCCI?", "Is this a shop?"}


def test_the_map_survives_its_document() -> None:
    text_map = mall()
    text_map.memory.sight("FLEETING", 0.7, 1.0)
    text_map.memory.forget(7.0)
    distil(text_map, identity, Namer("GUCCI"))  # type: ignore[arg-type]
    document = json.loads(json.dumps(text_map.to_document()))
    restored = TextMap.from_document(document)
    assert json.loads(json.dumps(restored.to_document())) == document
    assert restored.memory.classes == text_map.memory.classes
    assert restored.memory.forgotten == text_map.memory.forgotten
    assert restored.judgements == text_map.judgements
    for mine, theirs in zip(text_map.landmarks(identity), restored.landmarks(identity), strict=True):
        assert (mine.id, mine.name, mine.variants, mine.is_landmark) == (
            theirs.id,
            theirs.name,
            theirs.variants,
            theirs.is_landmark,
        )
        assert mine.position.tolist() == theirs.position.tolist()


def test_a_map_with_a_threshold_that_was_given_up_is_read() -> None:
    document = json.loads(json.dumps(mall().to_document()))
    document["config"]["spotting"] |= {"border_margin": 0.02, "other_size": 0.85, "idle_frames": 4}
    assert TextMap.from_document(document).memory.classes == mall().memory.classes


@pytest.mark.parametrize("spoil", ["config", "memory", "judgements", "question"])
def test_a_spoilt_document_is_a_clear_error(spoil: str) -> None:
    document = json.loads(json.dumps(mall().to_document()))
    del document[spoil]
    with pytest.raises(UserError, match="cannot be read"):
        TextMap.from_document(document)
    document = json.loads(json.dumps(mall().to_document()))
    document["memory"]["classes"][0]["observations"][0]["placement"] = [1, 2, 3]
    with pytest.raises(UserError, match="cannot be read"):
        TextMap.from_document(document)


def test_landmarks_move_with_their_keyframe() -> None:
    moved = np.eye(4)
    moved[:3, 3] = [1.0, 2.0, 3.0]
    before, after = mall().landmarks(identity), mall().landmarks(lambda _: moved)
    assert after[0].position - before[0].position == pytest.approx([1.0, 2.0, 3.0])


def test_the_same_frames_give_the_same_map() -> None:
    assert json.dumps(mall().to_document()) == json.dumps(mall().to_document())


class Beside:
    """A slow model whose answers come when the test says so."""

    def __init__(self) -> None:
        self.asked: list[tuple[int, list[str]]] = []
        self.ready: list[tuple[int, Naming]] = []

    def ask(self, key: int, readings: Sequence[Reading]) -> None:
        self.asked.append((key, [each.text for each in readings]))

    def answers(self) -> list[tuple[int, Naming]]:
        ready, self.ready = self.ready, []
        return ready


def test_a_slow_models_name_takes_the_place_of_the_first_one_and_stays() -> None:
    beside = Beside()
    spotter = ScriptedSpotter((box(100, 200), "Alienvare", 0.98))
    mapper = TextMapper(CAMERA, spotter, CONFIG, Namer("Alienvare"), beside=beside)
    run(mapper, 10)
    (text_class,) = mapper.text_map.long_term
    assert text_class.naming is not None
    assert (text_class.naming.name, text_class.naming.model) == ("Alienvare", "namer")
    assert beside.asked[0] == (text_class.id, ["Alienvare"])
    beside.ready = [(text_class.id, Naming("Alienware", 0.9, "a brand", "slow"))]
    asked = len(beside.asked)
    for index in range(10, 60):
        mapper.observe(frame(index), tracked(index))
    assert text_class.naming.model == "slow"
    assert len(beside.asked) > asked, "more evidence is asked about again"
    assert mapper.statistics.language_errors == 0


def test_a_slow_models_invention_is_counted_and_not_taken() -> None:
    beside = Beside()
    mapper = run(TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "GUCCI", 0.98)), CONFIG, beside=beside))
    beside.ready = [(0, Naming("Visit evil.example", 1.0, "", "slow"))]
    mapper.take_names()
    (text_class,) = mapper.text_map.long_term
    assert text_class.name == "GUCCI"
    assert mapper.statistics.language_errors == 1


def test_what_a_lost_camera_reads_is_told_as_it_stands_before_it_and_not_remembered() -> None:
    spotter = ScriptedSpotter((box(100, 200), "GUCCI", 0.98))
    told: list[Sequence[TextObservation]] = []
    mapper = TextMapper(CAMERA, spotter, CONFIG, on_view=lambda keyframe, seen: told.append(seen))
    for index in range(30):
        assert mapper.observe(frame(index), tracked(index, lost=True)) is None
    assert 2 <= len(told) <= 10
    (seen,) = told[0]
    assert seen.text == "GUCCI"
    assert seen.placement.position == pytest.approx([(160 - 320) / 570 * 2, (215 - 240) / 570 * 2, 2.0], abs=1e-6)
    assert not mapper.text_map.memory.classes
    assert mapper.statistics.observations == 0


def test_what_a_lost_camera_reads_is_told_without_depth_too() -> None:
    """A sign far away has no depth, but a direction."""
    spotter = ScriptedSpotter((box(100, 200), "GUCCI", 0.98))
    told: list[tuple[int, Sequence[TextObservation]]] = []
    mapper = TextMapper(CAMERA, spotter, CONFIG, on_view=lambda keyframe, seen: told.append((keyframe, seen)))
    for index in range(30):
        blind = replace(frame(index), depth=np.zeros_like(frame(index).depth))
        mapper.observe(blind, tracked(index, lost=True))
    keyframe, (seen,) = told[0]
    assert keyframe < 0
    assert seen.placement is None
    assert seen.bearing is not None
    left, right = (np.array(seen.bearing.corners[at]) for at in (0, 1))
    np.testing.assert_allclose(left[:2] / left[2], [(100 - 320) / 570, (200 - 240) / 570], atol=1e-6)
    assert right[0] > left[0]
    assert not mapper.text_map.memory.classes


def test_a_lost_camera_reads_nothing_that_nobody_asks_for() -> None:
    spotter = ScriptedSpotter((box(100, 200), "GUCCI", 0.98))
    mapper = TextMapper(CAMERA, spotter, CONFIG)
    assert not any(mapper.wants(frame(index), tracked(index, lost=True)) for index in range(30))


def test_what_is_in_view_of_a_doubted_place_is_told_as_it_stands_before_the_camera() -> None:
    """It may stand elsewhere in the map; where the camera is believed to be says nothing of it."""
    spotter = ScriptedSpotter((box(100, 200), "GUCCI", 0.98))
    told: list[tuple[int, Sequence[TextObservation]]] = []
    mapper = TextMapper(CAMERA, spotter, CONFIG, on_view=lambda keyframe, seen: told.append((keyframe, seen)))
    turned = np.diag([-1.0, 1.0, -1.0, 1.0])
    for index in range(30):
        doubted = replace(tracked(index), is_doubted=True, keyframe_from_camera=turned)
        mapper.observe(frame(index), doubted)
    keyframe, (seen,) = told[0]
    assert keyframe < 0
    assert seen.placement is None
    left = np.array(seen.bearing.corners[0])
    np.testing.assert_allclose(left[:2] / left[2], [(100 - 320) / 570, (200 - 240) / 570], atol=1e-6)


def test_what_is_read_in_a_doubted_place_is_told_and_not_remembered() -> None:
    spotter = ScriptedSpotter((box(100, 200), "GUCCI", 0.98))
    told: list[TextObservation] = []
    mapper = TextMapper(CAMERA, spotter, CONFIG, on_doubtful=told.append)
    for index in range(30):
        mapper.observe(frame(index), replace(tracked(index), is_doubted=True))
    assert len(told) >= 3
    assert {each.text for each in told} == {"GUCCI"}
    assert told[0].placement.position == pytest.approx([(160 - 320) / 570 * 2, (215 - 240) / 570 * 2, 2.0], abs=1e-6)
    assert not mapper.text_map.memory.classes
    for index in range(30, 60):
        mapper.observe(frame(index), tracked(index))
    assert [each.name for each in mapper.text_map.landmarks(identity)] == ["GUCCI"]


def test_the_first_error_of_a_reader_is_kept_in_words() -> None:
    statistics = run(TextMapper(CAMERA, BrokenSpotter((box(100, 200), "GUCCI", 0.98)), CONFIG)).statistics
    assert statistics.reader_errors > 1
    assert "frame 0" in statistics.first_reader_error
    assert "the network burst" in statistics.first_reader_error


def test_a_wall_of_a_hundred_words_is_bounded_work() -> None:
    """Each word is settled and then only confirmed: what is read and kept does not grow with the time spent there."""
    rng = np.random.default_rng(3)
    words = ["".join(rng.choice(list("ABCDEFGHIJKLMNOPRSTUVW"), 7)) for _ in range(100)]
    places = [box(30 + 58 * (n % 10), 20 + 44 * (n // 10), 50, 14) for n in range(100)]
    spotter = ScriptedSpotter(*((place, word, 0.97) for place, word in zip(places, words, strict=True)))
    reading = CONFIG.reading.model_copy(update={"settled_sightings": 6})
    mapper = run(TextMapper(CAMERA, spotter, CONFIG.model_copy(update={"reading": reading})), 24)
    read = spotter.recognised
    for index in range(24, 44):
        mapper.observe(frame(index), tracked(index))
    assert spotter.recognised == read
    assert mapper.statistics.observations <= 100 * (reading.settled_sightings + 1)
    assert len(mapper.text_map.long_term) == 100


def test_a_blurred_start_at_time_zero_is_read_in_the_end() -> None:
    """Time 0 is a time, not the want of one."""
    mapper = TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "GUCCI", 0.98)), CONFIG)
    mapper.observe(frame(0), tracked(0))
    for index in range(1, 40):
        mapper.observe(frame(index, FLAT), tracked(index))
    assert mapper.statistics.frames_read > 1


@pytest.mark.parametrize(("width", "fate"), [(34.0, BoxFate.KEPT), (60.0, BoxFate.UNREAD)])
def test_one_character_of_a_box_for_two_is_not_believed(width: float, fate: BoxFate) -> None:
    """Two ideographs seen aslant look like another one; the surface tells how wide they are."""
    mapper = TextMapper(CAMERA, ScriptedSpotter((box(100, 200, width, 34.0), "男", 0.98)), CONFIG)
    reading = mapper.observe(frame(0), tracked(0))
    assert reading is not None
    assert reading.fates == (fate,)


def test_a_name_of_five_hundred_characters_is_kept_as_data() -> None:
    name = "".join(np.random.default_rng(2).choice(list("abcdefghij klmnop"), 500)).replace("  ", "qq").strip()
    spotter = ScriptedSpotter((box(40, 200, 560, 30), f"\u202e{name}\x07", 0.97))
    (landmark,) = run(TextMapper(CAMERA, spotter, CONFIG)).text_map.landmarks(identity)
    assert landmark.name == name


def test_readings_whose_place_is_a_guess_weigh_as_little_as_those_without_one() -> None:
    """What lies beyond the sensor's reach may seem to hang on what is around it."""
    mapper = TextMapper(CAMERA, ScriptedSpotter((box(200, 200), "Newfrrivals", 0.98)), CONFIG)
    for index in range(10):
        seen = frame(index)
        seen.depth[190:240, 190:330] = 0.0
        reading = mapper.observe(seen, tracked(index))
        assert reading is None or reading.texts.placements[0] is not None, "the wall around it stands in"
    (text_class,) = mapper.text_map.memory.classes
    guessed = text_class.variants["Newfrrivals"].confidence / text_class.variants["Newfrrivals"].count
    near = run(TextMapper(CAMERA, ScriptedSpotter((box(100, 200), "Newfrrivals", 0.98)), CONFIG), 12)
    (sure,) = near.text_map.memory.classes
    assert guessed < sure.variants["Newfrrivals"].confidence / sure.variants["Newfrrivals"].count
