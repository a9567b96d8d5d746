import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.config import SpottingConfig
from lpslam.errors import UserError
from lpslam.text.reading import networks
from lpslam.text.reading.borders import cut_by_border
from lpslam.text.reading.boxes import letter_heights
from lpslam.text.reading.certainty import probability_right
from lpslam.text.reading.detection import boxes_from_probability, network_input
from lpslam.text.reading.networks import load_network
from lpslam.text.reading.recognition import decode_ctc, rectify
from lpslam.text.reading.spotting import PaddleSpotter, TextSpotter, accepted_texts
from lpslam.text.remembering.similarity import comparison_key, similarity
from lpslam.text.types import Recognition, SpottedText

CONFIG = SpottingConfig()
SIGNS = Path(__file__).parents[4] / "shared" / "data" / "signs"


@pytest.fixture(scope="module")
def spotter() -> PaddleSpotter:
    return PaddleSpotter(CONFIG)


def spot(spotter: TextSpotter, rgb: NDArray[np.uint8], config: SpottingConfig) -> list[SpottedText]:
    """Find and read all text of an image that is wholly in view, large enough and surely read."""
    boxes, _ = spotter.detect(rgb)
    boxes = boxes[~cut_by_border(rgb, boxes)]
    boxes = boxes[letter_heights(boxes) >= config.min_letter_height]
    return [text for text in accepted_texts(boxes, spotter.recognise(rgb, boxes), config) if text is not None]


def painted(*lines: tuple[str, int, int, float]) -> NDArray[np.uint8]:
    """A grey wall with (text, x, y, scale) painted on it."""
    image = np.full((480, 640, 3), (190, 185, 175), np.uint8)
    for text, x, y, scale in lines:
        cv2.putText(image, text, (x, y), cv2.FONT_HERSHEY_DUPLEX, scale, (30, 20, 120), round(2 * scale), cv2.LINE_AA)
    return image


def test_text_is_found_and_read_as_painted(spotter: PaddleSpotter) -> None:
    image = painted(("Hotel Lisboa", 60, 120, 1.5), ("NO SMOKING!", 200, 330, 1.0))
    texts = sorted(spot(spotter, image, CONFIG), key=lambda each: each.box[0, 1])
    assert [each.text for each in texts] == ["Hotel Lisboa", "NO SMOKING!"]
    assert all(each.confidence > 0.95 for each in texts)
    (width, height), _ = cv2.getTextSize("Hotel Lisboa", cv2.FONT_HERSHEY_DUPLEX, 1.5, 3)
    assert height < texts[0].letter_height < 2 * height
    assert texts[0].box.mean(axis=0) == pytest.approx([60 + width / 2, 120 - height / 2], abs=5)


def test_a_slanted_sign_is_rectified(spotter: PaddleSpotter) -> None:
    image = painted(("WASHROOM", 150, 250, 2.0))
    source = np.array([[0, 0], [640, 0], [640, 480], [0, 480]], np.float32)
    target = np.array([[60, 0], [600, 90], [600, 400], [60, 479]], np.float32)
    slanted = cv2.warpPerspective(
        image, cv2.getPerspectiveTransform(source, target), (640, 480), borderValue=(190, 185, 175)
    )
    turned = cv2.warpAffine(
        image, cv2.getRotationMatrix2D((320, 240), 20, 1.0), (640, 480), borderValue=(190, 185, 175)
    )
    for view in (slanted, turned):
        assert [each.text for each in spot(spotter, np.asarray(view, np.uint8), CONFIG)] == ["WASHROOM"]


def test_letters_that_are_narrow_because_they_are_seen_aslant_are_read() -> None:
    words = ["GULLS AND TERNS", "MILLINERY HALL", "ILLUSTRATED", "WILLIAM TELL", "KITTEN SUPPLIES", "PARALLEL LIVES"]
    right = []
    for narrow in (0.0, CONFIG.narrow_letters):
        reader, read = PaddleSpotter(CONFIG.model_copy(update={"narrow_letters": narrow})), []
        for word in words:
            (width, height), _ = cv2.getTextSize(word, cv2.FONT_HERSHEY_DUPLEX, 2.0, 4)
            squeezed = cv2.resize(painted((word, 20, 120, 2.0)), None, fx=0.3, fy=1.0, interpolation=cv2.INTER_AREA)
            end, top, bottom = 0.3 * (30 + width), 110.0 - height, 135.0
            box = np.array([[3.0, top], [end, top], [end, bottom], [3.0, bottom]])
            read.append(reader.recognise(squeezed, box[None])[0].text)
        right.append(sum(comparison_key(each) == comparison_key(word) for each, word in zip(read, words, strict=True)))
    assert right[1] >= right[0] + 4


def test_an_empty_wall_has_no_text(spotter: PaddleSpotter) -> None:
    boxes, scores = spotter.detect(painted())
    assert boxes.shape == (0, 4, 2)
    assert scores.shape == (0,)
    assert spotter.recognise(painted(), boxes) == []


def test_company_does_not_change_a_reading(spotter: PaddleSpotter) -> None:
    image = painted(("HUAWEI", 60, 100, 1.2), ("HIGH TEMPERATURE", 60, 250, 1.2), ("ATM", 60, 400, 1.2))
    boxes, _ = spotter.detect(image)
    together = spotter.recognise(image, boxes)
    assert together == [spotter.recognise(image, boxes[row : row + 1])[0] for row in range(len(boxes))]


def test_it_is_a_text_spotter(spotter: PaddleSpotter) -> None:
    assert isinstance(spotter, TextSpotter)


@pytest.mark.skipif(not SIGNS.exists(), reason="the photographs of ../shared/data/signs are not here")
@pytest.mark.slow
def test_photographed_signs_are_read(spotter: PaddleSpotter) -> None:
    labels = json.loads((SIGNS / "labels.json").read_text(encoding="utf-8"))["images"]
    wanted = found = 0
    for name, lines in labels.items():
        image = cv2.cvtColor(cv2.imread(str(SIGNS / name)), cv2.COLOR_BGR2RGB)
        read = [comparison_key(each.text) for each in spot(spotter, np.asarray(image, np.uint8), CONFIG)]
        for line in lines:
            wanted += 1
            found += any(similarity(comparison_key(line), each) >= 0.8 for each in read)
    assert found / wanted >= 0.75, f"{found} of {wanted} lines"


def test_no_boxes_have_no_letters() -> None:
    assert letter_heights(np.zeros((0, 4, 2))).shape == (0,)


def test_unsure_short_and_empty_readings_are_refused() -> None:
    boxes = np.tile(np.array([[0, 0], [50, 0], [50, 20], [0, 20]], float), (5, 1, 1))
    readings = [Recognition(*each) for each in (("KFC", 0.95), ("KFC", 0.3), ("A", 0.99), ("", 0.0), ("-/-", 0.9))]
    accepted = accepted_texts(boxes, readings, CONFIG)
    assert [each and each.text for each in accepted] == ["KFC", None, None, None, None]


def test_a_logo_beside_the_name_is_not_part_of_it() -> None:
    box = np.array([[[0, 0], [50, 0], [50, 20], [0, 20]]], float)
    for raw, text in {
        "★回力": "回力",
        "● Miniso ®": "Miniso",
        "A★B": "A★B",
        "Don't!": "Don't!",
        "OVelvet Lane": "Velvet Lane",
        "OPPO": "OPPO",
        "Omega": "Omega",
    }.items():
        (accepted,) = accepted_texts(box, [Recognition(raw, 0.99)], CONFIG)
        assert accepted is not None
        assert accepted.text == text


def test_letters_of_a_line_that_runs_downwards_are_as_high_as_it_is_wide() -> None:
    lying = np.array([[0, 0], [90, 0], [90, 20], [0, 20]], float)
    standing = np.array([[0, 0], [20, 0], [20, 90], [0, 90]], float)
    assert letter_heights(np.array([lying, standing])).tolist() == [20.0, 20.0]


def test_rectifying_undoes_the_perspective() -> None:
    board = np.zeros((48, 240, 3), np.uint8)
    board[8:40, 20:70], board[8:40, 150:160] = 255, 200
    box = np.array([[50, 40], [290, 60], [290, 108], [50, 140]], float)
    edges = np.array([[0, 0], [240, 0], [240, 48], [0, 48]], np.float32)
    seen = cv2.warpPerspective(board, cv2.getPerspectiveTransform(edges, box.astype(np.float32)), (400, 200))
    line = rectify(np.asarray(seen, np.uint8), box, 1280)
    upright = cv2.resize(line, (240, 48), interpolation=cv2.INTER_AREA)
    assert line.shape[0] == 48
    assert np.abs(upright.astype(float) - board).mean() < 6.0


def test_ctc_removes_repeats_and_blanks() -> None:
    alphabet = np.array(["", "A", "B", " "])
    steps = [1, 1, 0, 1, 2, 2, 0, 0, 3, 2]
    probabilities = np.full((len(steps), 4), 0.1, np.float32)
    probabilities[np.arange(len(steps)), steps] = 0.7
    read = decode_ctc(probabilities, alphabet)
    assert read.text == "AAB B"
    assert read.confidence == pytest.approx(0.7)
    assert decode_ctc(probabilities[[2, 6]], alphabet) == Recognition("", 0.0)


def test_a_letter_keeps_what_else_it_may_be_and_a_gap_what_was_nearly_read() -> None:
    alphabet = np.array(["", "A", "B", "C"])
    steps = [[0.02, 0.6, 0.38, 0.0], [0.02, 0.9, 0.08, 0.0], [0.7, 0.0, 0.0, 0.3], [0.01, 0.0, 0.99, 0.0]]
    read = decode_ctc(np.array(steps, np.float32), alphabet)
    assert read.text == "AB"
    (first, between, last) = read.slots
    assert [letter for letter, _ in first] == ["A", "B", ""], "where the letter is surest"
    assert between == (("", pytest.approx(0.7)), ("C", pytest.approx(0.3)))
    assert [letter for letter, _ in last] == ["B", ""]


@pytest.mark.parametrize(
    ("places", "has_hole"),
    [
        ([2, 8, 14, 20], False),
        ([2, 8, 20, 26], True),
        ([2, 8, 16, 22], False),
        ([2, 5, 9, 12], False),
        ([2, 20], False),
    ],
)
def test_ideographs_with_room_for_one_more_between_two_have_a_hole(places: list[int], has_hole: bool) -> None:
    alphabet = np.array(["", "恒", "达", "子", "馆"])
    probabilities = np.zeros((30, 5), np.float32)
    probabilities[:, 0] = 1.0
    probabilities[places, np.arange(1, len(places) + 1)] = 2.0
    read = decode_ctc(probabilities / 2.0, alphabet)
    assert read.has_hole is has_hole
    kept, taken = (probability_right(read.text, 0.99, has_hole=hole) for hole in (False, True))
    assert taken < 0.3 * kept
    latin = decode_ctc(probabilities / 2.0, np.array(["", "A", "B", "C", "D"]))
    assert not latin.has_hole


@pytest.mark.parametrize(
    ("read", "text"),
    [("コ一ヒ一", "コーヒー"), ("コ一", "コー"), ("の一番", "の一番"), ("一の", "一の"), ("番一番", "番一番")],
)
def test_a_stroke_behind_kana_is_a_long_vowel(read: str, text: str) -> None:
    """Before an ideograph it is one: the first of something."""
    alphabet = np.array(["", "コ", "ヒ", "一", "番", "の", "ー"])
    steps = np.zeros((2 * len(read), len(alphabet)), np.float32)
    for at, letter in enumerate(read):
        steps[2 * at, alphabet.tolist().index(letter)] = 0.8
        steps[2 * at, -1] += 0.2
        steps[2 * at + 1, 0] = 1.0
    found = decode_ctc(steps, alphabet)
    assert found.text == text
    assert "".join(slot[0][0] for slot in found.slots) == text
    assert all(slot[0][1] == pytest.approx(0.8) for slot in found.slots)
    assert all([letter for letter, _ in slot].count("ー") == 1 for slot in found.slots)


def test_letters_on_an_arc_are_a_box_though_most_of_it_is_empty() -> None:
    probability = np.zeros((240, 320), np.uint8)
    cv2.ellipse(probability, (160, 200), (130, 130), 0, 210, 330, 200, 16)
    boxes, scores = boxes_from_probability(probability.astype(np.float32) / 255.0, CONFIG)
    assert len(boxes) == 1
    assert scores[0] < CONFIG.box_score
    # Less sure of itself, it is none.
    boxes, _ = boxes_from_probability(probability.astype(np.float32) * 0.5 / 200.0, CONFIG)
    assert len(boxes) == 0


def test_a_region_of_the_probability_map_becomes_a_grown_box() -> None:
    probability = np.zeros((240, 320), np.float32)
    probability[100:120, 50:150] = 0.9
    probability[200:202, 200:202] = 0.9
    probability[30:50, 200:260] = 0.4
    boxes, scores = boxes_from_probability(probability, CONFIG)
    assert len(boxes) == 1
    # The mask is a pixel larger than the region on two sides.
    assert scores[0] == pytest.approx(0.9 * (100 * 20) / (101 * 21), abs=0.01)
    growth = 1.6 * (100 * 20) / (2 * 120)
    assert boxes[0].min(axis=0) == pytest.approx([50 - growth, 100 - growth], abs=2)
    assert boxes[0].max(axis=0) == pytest.approx([149 + growth, 119 + growth], abs=2)
    top_left, top_right, bottom_right, _ = boxes[0]
    assert top_left[0] < top_right[0]
    assert top_right[1] < bottom_right[1]


def test_the_networks_read_blue_green_red_between_minus_one_and_one() -> None:
    batch = network_input(np.array([[[255, 0, 51]]], np.uint8))
    assert batch[0, :, 0, 0] == pytest.approx([-0.6, -1.0, 1.0])


def test_the_alphabet_comes_with_the_model() -> None:
    alphabet = load_network("rec", "auto", 1).alphabet
    assert len(alphabet) == 18708
    assert {"星", "巴", "克", "A", "é"} <= set(alphabet)


def test_a_missing_engine_is_a_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    real = networks.importlib.util.find_spec
    monkeypatch.setattr(
        networks.importlib.util, "find_spec", lambda name: None if name in ("openvino", "onnxruntime") else real(name)
    )
    with pytest.raises(UserError, match="pip install openvino"):
        load_network("det", "openvino", 1)
    with pytest.raises(UserError, match=r"lp-slam\[onnx\]"):
        load_network("det", "auto", 1)


def test_missing_models_are_a_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(networks.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UserError, match="reading models are not installed"):
        load_network("det", "auto", 1)


def test_both_engines_read_the_same(spotter: PaddleSpotter) -> None:
    for engine in ("openvino", "onnxruntime"):
        pytest.importorskip(engine)
    image = painted(("Hotel Lisboa", 60, 120, 1.5), ("NO SMOKING!", 200, 330, 1.0))
    other = PaddleSpotter(SpottingConfig(engine="onnxruntime"))
    boxes, _ = spotter.detect(image)
    assert other.detect(image)[0] == pytest.approx(boxes, abs=1.0)
    for mine, theirs in zip(spotter.recognise(image, boxes), other.recognise(image, boxes), strict=True):
        assert mine[0] == theirs[0]
        assert mine[1] == pytest.approx(theirs[1], abs=1e-3)


@pytest.mark.parametrize(
    ("text", "is_kept"), [("男", True), ("药", True), ("A", False), ("8", False), ("口", False), ("ス", False)]
)
def test_a_single_ideograph_is_a_word(text: str, is_kept: bool) -> None:
    boxes = np.array([[[0, 0], [40, 0], [40, 40], [0, 40]]], np.float64)
    assert (accepted_texts(boxes, [Recognition(text, 0.95)], CONFIG) != [None]) == is_kept


def test_of_too_many_regions_the_largest_are_kept() -> None:
    """Specks come first in the list of contours, being lowest in the image; the sign hangs above them."""
    probability = np.zeros((480, 640), np.float32)
    probability[40:60, 200:400] = 0.9
    for row in range(200, 470, 12):
        for column in range(10, 630, 12):
            probability[row : row + 5, column : column + 5] = 0.9
    boxes, scores = boxes_from_probability(probability, CONFIG)
    assert len(boxes) == len(scores) == CONFIG.max_boxes
    assert any(np.ptp(each[:, 0]) > 190 for each in boxes)


@pytest.mark.parametrize(
    ("raw", "is_text"), [("0000000", False), ("COOOOOOO", False), ("WWW", True), ("A00000B12345", True)]
)
def test_equal_letters_in_a_row_are_no_text(raw: str, is_text: bool) -> None:
    box = np.array([[[0.0, 0.0], [200.0, 0.0], [200.0, 40.0], [0.0, 40.0]]])
    (accepted,) = accepted_texts(box, [Recognition(raw, 0.99)], CONFIG)
    assert (accepted is not None) is is_text


@pytest.mark.parametrize(("raw", "is_text"), [("--99", False), ("ww////hl", False), ("99", True), ("2.90", True)])
def test_what_is_marks_for_the_most_part_is_no_text(raw: str, is_text: bool) -> None:
    """Bottles on a shelf are read as dashes and a number or two."""
    box = np.array([[[0, 0], [100, 0], [100, 30], [0, 30]]], float)
    (accepted,) = accepted_texts(box, [Recognition(raw, 0.99)], CONFIG)
    assert (accepted is not None) == is_text


@pytest.mark.parametrize(
    ("read", "text"),
    [
        ("1.050円", "1,050円"),
        ("1.05円", "1.05円"),
        ("1.050", "1.050"),
        ("12.500元", "12,500元"),
        ("元1.050", "元1.050"),
    ],
)
def test_a_point_before_three_digits_and_yen_is_a_comma(read: str, text: str) -> None:
    """No price has thousandths of a yen; of a weight, or in other money, it may be a point."""
    alphabet = np.array(["", *"0125.,円元"])
    steps = np.zeros((2 * len(read), len(alphabet)), np.float32)
    for at, letter in enumerate(read):
        steps[2 * at, alphabet.tolist().index(letter)] = 0.8
        steps[2 * at + 1, 0] = 1.0
    found = decode_ctc(steps, alphabet)
    assert found.text == text
    assert "".join(slot[0][0] for slot in found.slots) == text
