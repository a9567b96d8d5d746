"""What texts tell loop closing, on made-up maps: a wall with signs that a camera passes, and passes again."""

import threading
from dataclasses import dataclass, replace

import numpy as np
import pytest

from lpslam.camera import inverse_transform, transform_points
from lpslam.config import AdviceConfig, SlamConfig
from lpslam.slam.advice import Recalled
from lpslam.slam.features import Features
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.map import SlamMap
from lpslam.text.advice.advising import SIGNS_DIFFER, TextAdvisor
from lpslam.text.placing.views import vector3
from lpslam.text.remembering.memory import TextClass
from lpslam.text.types import Bearing, Placement, TextObservation

CONFIG = AdviceConfig()
FIRST_WALK = 40
STEP = 0.5
"""Metres between keyframes, which look at the wall 3 m away."""

DRIFTED = exponential(np.array([0.8, 0.1, -0.6, 0.02, 0.15, -0.03]))
"""Where the second walk takes the world to be: a metre and nine degrees off."""


@dataclass(frozen=True)
class Sign:
    text: str
    x: float
    y: float = -0.5
    width: float = 0.8
    height: float = 0.2


CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))
SIGNS = [Sign("STARBUCKS", 1.0), Sign("书店", 2.2), Sign("PIZZA HUT", 9.0), Sign("LIBRARY", 11.5), Sign("华为", 16.0)]


class TwoWalks:
    """A map of a walk along the wall and of one that begins anew at its start, with what was read on both.

    Args:
        first, second: the signs that are there and read.
        is_new_submap: whether the second walk is a sub-map of its own.
        readings: of a sign in a keyframe.
    """

    def __init__(
        self,
        first: list[Sign],
        second: list[Sign],
        *,
        is_new_submap: bool = False,
        second_length: int = 7,
        readings: int = 1,
        confidence: float = 0.95,
    ) -> None:
        self.map, self.advisor = SlamMap(4, np.array([1.0])), TextAdvisor(CONFIG)
        self.truth: list[np.ndarray] = []
        self.classes: dict[str, int] = {}
        for number in range(FIRST_WALK + second_length):
            again = number >= FIRST_WALK
            pose = np.eye(4)
            pose[0, 3] = STEP * (number - FIRST_WALK * again)
            estimate = DRIFTED @ pose if again else pose
            is_root = number == 0 or (is_new_submap and number == FIRST_WALK)
            keyframe = self.map.add_keyframe(
                inverse_transform(estimate), _nothing(), np.zeros(0, np.float32), float(number), number,
                -1 if is_root else number - 1,
            )  # fmt: skip
            self.truth.append(pose)
            for sign in second if again else first:
                if abs(sign.x - pose[0, 3]) <= 1.5:
                    for _ in range(readings):
                        self.read(keyframe, sign, confidence)
        self.newest = FIRST_WALK + second_length - 1

    def read(self, keyframe: int, sign: Sign, confidence: float = 0.95) -> None:
        text_class = self.classes.setdefault(sign.text, len(self.classes))
        self.advisor.note(text_class, self.sighting(keyframe, sign, float(keyframe), confidence))

    def sighting(self, keyframe: int, sign: Sign, timestamp: float, confidence: float = 0.95) -> TextObservation:
        local = transform_points(inverse_transform(self.truth[keyframe]), np.array([[sign.x, sign.y, 3.0]]))[0]
        placement = Placement(
            (float(local[0]), float(local[1]), float(local[2])), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0),
            sign.width, sign.height, 0.01,
        )  # fmt: skip
        x, y, z = local.tolist()
        corners = np.array([[x + a * sign.width / 2, y + b * sign.height / 2, z] for a, b in CORNERS])
        first, second, third, fourth = (vector3(corner / np.linalg.norm(corner)) for corner in corners)
        bearing = Bearing((0.0, 0.0, 0.0), (first, second, third, fourth))
        return TextObservation(keyframe, timestamp, keyframe, sign.text, confidence, placement, 30.0, bearing=bearing)

    def propose(self) -> list[int]:
        return [each.keyframe for each in self.advisor.propose(self.map, self.newest)]

    def veto(self, at: float) -> str | None:
        """What is said when the newest keyframe is located `at` metres along the first walk."""
        pose = np.eye(4)
        pose[0, 3] = at
        candidate = round(at / STEP)
        return self.advisor.vetoes(self.map, self.newest, candidate, inverse_transform(pose))


def _nothing() -> Features:
    empty = np.zeros(0, np.float32)
    return Features(
        pixels=np.zeros((0, 2), np.float32), u_right=empty, depth=empty, has_depth=np.zeros(0, np.bool_),
        octave=np.zeros(0, np.uint8), angle=empty, descriptor=np.zeros((0, 4), np.uint64),
    )  # fmt: skip


def repainted(signs: list[Sign], *texts: str) -> list[Sign]:
    return [replace(sign, text=text) for sign, text in zip(signs, texts, strict=True)]


# Proposing -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("is_new_submap", [False, True])
def test_two_texts_propose_the_keyframe_that_sees_them_as_now(is_new_submap: bool) -> None:
    walks = TwoWalks(SIGNS, SIGNS[:2], is_new_submap=is_new_submap)
    first = walks.propose()[0]
    # The newest stands 3 m along the wall, wherever drift has put it.
    assert abs(first - 6) <= 1


def test_one_text_alone_proposes_nothing() -> None:
    assert TwoWalks(SIGNS, SIGNS[:1]).propose() == []


def test_the_same_text_twice_is_one_text() -> None:
    twins = [Sign("EXIT", 1.0), Sign("EXIT", 2.2)]
    assert TwoWalks([*twins, *SIGNS[2:]], twins).propose() == []


def test_a_text_and_its_fragment_are_one_text() -> None:
    parts = [Sign("STARBUCKS COFFEE", 1.0), Sign("STARBUCKS", 2.2)]
    assert TwoWalks([*parts, *SIGNS[2:]], parts).propose() == []


def test_two_lines_of_one_board_are_one_text() -> None:
    board = [Sign("STARBUCKS", 1.0), Sign("星巴克", 1.0, -0.25)]
    assert TwoWalks([*board, *SIGNS[2:]], board).propose() == []


def test_texts_that_stand_everywhere_propose_nothing() -> None:
    everywhere = [Sign(text, x + off) for x in (1.0, 4.0, 7.0) for text, off in (("EXIT", 0.0), ("洗手间", 1.2))]
    assert TwoWalks(everywhere, everywhere[:2]).propose() == []


def test_one_rare_text_makes_a_common_one_count() -> None:
    signs = [*SIGNS, Sign("EXIT", 0.0), Sign("EXIT", 7.0), Sign("EXIT", 13.0)]
    walks = TwoWalks(signs, [SIGNS[0], Sign("EXIT", 0.0)], second_length=6)
    assert abs(walks.propose()[0] - 5) <= 1


def test_the_same_texts_in_another_arrangement_propose_nothing() -> None:
    assert TwoWalks(SIGNS, [Sign("STARBUCKS", 1.0), Sign("书店", 3.2)]).propose() == []


def test_the_way_just_walked_is_not_proposed() -> None:
    walks = TwoWalks(SIGNS, [], second_length=0)
    # The texts of the wall's end were read from the last keyframes, and from the few before.
    walks.newest = FIRST_WALK - 1
    assert walks.propose() == []


def test_a_text_read_once_is_no_evidence() -> None:
    walks = TwoWalks(SIGNS, [])
    walks.read(walks.newest, SIGNS[0])
    walks.read(walks.newest, SIGNS[1])
    assert walks.propose() == []
    walks.read(walks.newest - 1, SIGNS[0])
    walks.read(walks.newest - 1, SIGNS[1])
    assert walks.propose() != []


def test_what_an_earlier_recording_read_is_known() -> None:
    walks = TwoWalks(SIGNS, [])
    classes = []
    for text, number in walks.classes.items():
        text_class = TextClass(number, 0.0, 0.0)
        text_class.observations = [each for each in walks.advisor._by_class[number] if each.text == text]
        classes.append(text_class)
    walks.advisor = TextAdvisor(CONFIG, classes)
    for keyframe in range(FIRST_WALK + 2, walks.newest + 1):
        walks.read(keyframe, SIGNS[0])
        walks.read(keyframe, SIGNS[1])
    assert abs(walks.propose()[0] - 6) <= 1


# Vetoing -------------------------------------------------------------------------------------------------------------


def test_other_signs_in_the_same_spots_veto() -> None:
    walks = TwoWalks(SIGNS, repainted(SIGNS[:2], "GUCCI", "面馆"))
    assert walks.veto(at=3.0) == SIGNS_DIFFER


@pytest.mark.parametrize("is_new_submap", [False, True])
def test_the_right_place_is_not_vetoed(is_new_submap: bool) -> None:
    assert TwoWalks(SIGNS, SIGNS[:2], is_new_submap=is_new_submap).veto(at=3.0) is None


def test_misreadings_agree() -> None:
    assert TwoWalks(SIGNS, repainted(SIGNS[:2], "STARBUCK5", "书后")).veto(at=3.0) is None


def test_one_sign_that_agrees_outweighs_others() -> None:
    signs = [*SIGNS[:2], Sign("ATM", 3.2)]
    walks = TwoWalks([*signs, *SIGNS[2:]], repainted(signs, "GUCCI", "面馆", "ATM"), second_length=9)
    assert walks.veto(at=4.0) is None


def test_one_repainted_sign_is_no_veto() -> None:
    assert TwoWalks(SIGNS, repainted(SIGNS[:1], "GUCCI")).veto(at=3.0) is None


@pytest.mark.parametrize(("first", "second"), [([], SIGNS[:2]), (SIGNS, []), ([], [])])
def test_a_side_that_was_not_read_is_no_veto(first: list[Sign], second: list[Sign]) -> None:
    assert TwoWalks(first, second).veto(at=3.0) is None


def test_texts_beside_one_another_are_no_veto() -> None:
    other = [replace(sign, text=text, x=sign.x + 0.6) for sign, text in zip(SIGNS[:2], ("GUCCI", "面馆"), strict=True)]
    assert TwoWalks(SIGNS, other).veto(at=3.0) is None


def test_the_other_language_of_a_bilingual_board_is_no_veto() -> None:
    lines = [Sign("星巴克", 1.0, -0.27), Sign("BOOKSHOP", 2.2, -0.27)]
    assert TwoWalks(SIGNS, lines).veto(at=3.0) is None


def test_unsure_readings_are_no_veto() -> None:
    assert TwoWalks(SIGNS, repainted(SIGNS[:2], "GUCCI", "面馆"), confidence=0.7).veto(at=3.0) is None


def test_readings_at_odds_are_no_veto() -> None:
    walks = TwoWalks(SIGNS, [])
    for keyframe, (one, other) in enumerate(
        [("GUCCI", "面馆"), ("ZARA", "药房"), ("NIKE", "快餐"), ("MUJI", "图书")], start=FIRST_WALK + 1
    ):
        for sign in repainted(SIGNS[:2], one, other):
            walks.classes[sign.text] = 100 + (sign.x > 2)
            walks.read(keyframe, sign)
    assert walks.veto(at=3.0) is None


# Robustness ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["", " ", "x" * 500, "\u202eEXIT\u0000", "{0} %s ../../", "😀"])
def test_any_text_is_only_compared(text: str) -> None:
    walks = TwoWalks(SIGNS, repainted(SIGNS[:2], text, text + "."))
    walks.propose()
    assert walks.veto(at=3.0) in (None, SIGNS_DIFFER)


def test_the_same_readings_give_the_same_advice() -> None:
    one, other = (TwoWalks(SIGNS, SIGNS[:2], is_new_submap=True) for _ in range(2))
    assert one.propose() == other.propose() != []


def test_texts_may_be_noted_while_advice_is_asked() -> None:
    walks = TwoWalks(SIGNS, SIGNS[:2])
    expected = walks.propose()

    def write() -> None:
        for number in range(300):
            walks.read(number % FIRST_WALK, Sign(f"NOISE {number}", 30.0 + number))

    writer = threading.Thread(target=write)
    writer.start()
    answers = []
    while writer.is_alive() or not answers:
        answers.append((walks.propose(), walks.veto(at=3.0)))
    writer.join()
    assert all(answer == (expected, None) for answer in answers)


def test_a_keyframe_of_one_class_keeps_few_sightings() -> None:
    walks = TwoWalks(SIGNS, [], readings=50)
    assert max(map(len, walks.advisor._by_keyframe.values())) <= 8 * len(SIGNS)


def test_places_are_sought_at_once_in_a_large_map() -> None:
    from time import thread_time

    walks = TwoWalks([*SIGNS, *(Sign(f"SHOP {n}", 0.5 * n) for n in range(40))], SIGNS[:2], readings=4)
    started = thread_time()
    for _ in range(10):
        walks.propose()
        walks.veto(at=3.0)
    assert thread_time() - started < 10 * 0.2


def test_the_switch_is_in_the_configuration() -> None:
    assert isinstance(CONFIG.enabled, bool)
    assert SlamConfig().loops.candidates >= CONFIG.proposals


# Recalling where a lost camera may be --------------------------------------------------------------------------------


def recalled(signs: list[Sign], number: int = 4) -> list[Recalled]:
    """What is recalled when a lost camera sees some signs as the keyframe of that number did."""
    walks = TwoWalks(SIGNS, [])
    walks.advisor.note_view(-1, [replace(walks.sighting(number, sign, 99.0), keyframe=-1) for sign in signs])
    return walks.advisor.recalls(walks.map)


@pytest.mark.parametrize("signs", [SIGNS[:2], repainted(SIGNS[:2], "STARBUCK5", "书店")], ids=["read", "misread"])
def test_two_texts_in_one_view_recall_where_they_were_seen_so(signs: list[Sign]) -> None:
    (place,) = recalled(signs)
    assert abs(place.keyframe - 4) <= 1
    true = np.eye(4)
    true[0, 3] = -STEP * 4
    np.testing.assert_allclose(place.camera_from_world, true, atol=1e-6)


@pytest.mark.parametrize(
    "signs",
    [
        [],
        [Sign("GUCCI", 1.0)],
        [Sign("STARBUCKS", 1.0), Sign("STARBUCKS", 2.2)],
        [Sign("STARBUCKS", 1.0), Sign("书店", 2.9)],
    ],
    ids=["none", "another", "one twice", "elsewhere"],
)
def test_texts_that_stood_nowhere_so_recall_nothing(signs: list[Sign]) -> None:
    assert recalled(signs) == []


@pytest.mark.parametrize(
    "signs", [SIGNS[:1], [SIGNS[0], Sign("GUCCI", 2.2)]], ids=["alone", "beside one that was not read"]
)
def test_one_text_that_stands_nowhere_else_is_an_anchor(signs: list[Sign]) -> None:
    (place,) = recalled(signs)
    assert place.camera_from_world is None
    assert place.anchor is not None
    np.testing.assert_allclose(place.anchor.middles, [[SIGNS[0].x, SIGNS[0].y, 3.0]], atol=1e-9)
    assert place.keyframe in {0, 1, 2, 3, 4, 5}


def test_a_submap_whose_signs_have_no_depth_is_proposed_by_their_directions() -> None:
    walks = TwoWalks(SIGNS, [], is_new_submap=True)
    newest = walks.newest
    assert walks.advisor.propose(walks.map, newest) == []
    seen = [walks.sighting(newest - 1, sign, 99.0) for sign in SIGNS[:2]]
    walks.advisor.note_view(newest - 1, [replace(each, placement=None) for each in seen])
    (place,) = walks.advisor.propose(walks.map, newest)
    assert place.camera_from_world is not None
    np.testing.assert_allclose(place.camera_from_world, inverse_transform(walks.truth[newest]), atol=0.2)
    # What was read long before the keyframe is out of its view.
    assert walks.advisor.propose(walks.map, newest - 3) == []


def test_one_text_that_stands_at_two_places_is_no_anchor() -> None:
    walks = TwoWalks([*SIGNS, replace(SIGNS[0], x=14.0)], [])
    walks.advisor.note_view(-1, [replace(walks.sighting(4, SIGNS[0], 99.0), keyframe=-1)])
    assert walks.advisor.recalls(walks.map) == []


def coaches(read: str) -> list[Recalled]:
    """What is recalled when a sign of a second coach is read, which is alike but for its number."""
    first, second = Sign("Coach 21", 1.0), Sign("Coach 22", 14.0)
    walks = TwoWalks(SIGNS, [])
    for keyframe, sign in ((0, first), (1, first), (2, first), (27, second), (28, second), (29, second)):
        walks.advisor.note(100, walks.sighting(keyframe, sign, float(keyframe)))
    walks.advisor.note_view(-1, [replace(walks.sighting(28, replace(second, text=read), 99.0), keyframe=-1)])
    return walks.advisor.recalls(walks.map)


def test_signs_of_one_class_that_differ_in_a_number_are_told_apart() -> None:
    (place,) = coaches("coach 22")
    assert place.anchor is not None
    np.testing.assert_allclose(place.anchor.middles, [[14.0, -0.5, 3.0]], atol=1e-9)
    assert place.keyframe in {27, 28, 29}


def test_a_reading_that_is_as_like_one_as_the_other_tells_neither() -> None:
    assert coaches("Coach 2") == []


def test_two_of_them_are_told_apart_beside_another_sign() -> None:
    """Both coaches have the same sign beside the number; the number says which."""
    signs = [Sign("Coach 21", 1.0), Sign("EXIT", 2.0), Sign("EXIT", 15.0), Sign("Coach 22", 14.0)]
    walks = TwoWalks([], [])
    for number, sign in ((100, signs[0]), (101, signs[1]), (101, signs[2]), (100, signs[3])):
        for keyframe in range(round(sign.x / STEP) - 2, round(sign.x / STEP) + 3):
            walks.advisor.note(number, walks.sighting(max(keyframe, 0), sign, float(keyframe)))
    seen = [replace(walks.sighting(29, sign, 99.0), keyframe=-1) for sign in signs[2:]]
    walks.advisor.note_view(-1, seen)
    (place,) = walks.advisor.recalls(walks.map)
    true = np.eye(4)
    true[0, 3] = -STEP * 29
    np.testing.assert_allclose(place.camera_from_world, true, atol=1e-6)


def test_only_the_last_view_is_recalled() -> None:
    walks = TwoWalks(SIGNS, [])
    walks.advisor.note_view(-1, [walks.sighting(4, sign, 98.0) for sign in SIGNS[:2]])
    assert walks.advisor.recalls(walks.map)
    walks.advisor.note_view(-1, [])
    assert walks.advisor.recalls(walks.map) == []


# Judging a place in which the camera was found again -----------------------------------------------------------------


def judged(found_at: float, signs: list[Sign], readings: int = 1) -> bool | None:
    """What is said when the camera was found at the beginning of the first walk, and then reads signs on its way."""
    walks = TwoWalks(SIGNS, [])
    assert walks.advisor.knows(walks.map, 4)
    for number in range(7):
        for sign in signs:
            if abs(sign.x - STEP * number) <= 1.5:
                for _ in range(readings):
                    walks.advisor.note_doubtful(walks.sighting(number, sign, found_at + number))
    return walks.advisor.judges(walks.map, 4, found_at)


def test_other_signs_in_the_same_spots_speak_against_a_place() -> None:
    assert judged(100.0, repainted(SIGNS[:2], "GUCCI", "面馆")) is False


@pytest.mark.parametrize("signs", [SIGNS[:2], SIGNS[:1], repainted(SIGNS[:2], "STARBUCK5", "书后")])
def test_a_sign_that_was_there_speaks_for_a_place(signs: list[Sign]) -> None:
    assert judged(100.0, signs) is True


@pytest.mark.parametrize("signs", [[], repainted(SIGNS[:1], "GUCCI"), [Sign("ATM", 3.4, y=0.6)]])
def test_too_little_says_nothing_of_a_place(signs: list[Sign]) -> None:
    assert judged(100.0, signs) is None


@pytest.mark.parametrize(
    ("others", "said"),
    [([], None), (SIGNS[1:2], True), ([Sign("GUCCI", 2.2), Sign("面馆", 3.4)], False)],
    ids=["alone", "with its neighbour", "among others"],
)
def test_a_sign_that_alone_told_the_place_is_no_witness_of_it(others: list[Sign], said: bool | None) -> None:
    """Another shop of the same name tells the same wrong place, and would agree with it."""
    walks = TwoWalks([*SIGNS, Sign("LOTUS TEA", 3.4)], [])
    walks.advisor.note_view(-1, [replace(walks.sighting(3, SIGNS[0], 99.0), keyframe=-1)])
    (place,) = walks.advisor.recalls(walks.map)
    assert place.camera_from_world is None
    for number in range(2, 7):
        for sign in (SIGNS[0], *others):
            walks.advisor.note_doubtful(walks.sighting(number, sign, 100.0 + number))
    assert walks.advisor.judges(walks.map, 4, 100.0) is said


def test_what_was_read_in_an_earlier_doubt_is_not_counted() -> None:
    walks = TwoWalks(SIGNS, [])
    for sign in repainted(SIGNS[:2], "GUCCI", "面馆"):
        for _ in range(8):
            walks.advisor.note_doubtful(walks.sighting(3, sign, 50.0))
    assert walks.advisor.judges(walks.map, 4, 40.0) is False
    assert walks.advisor.judges(walks.map, 4, 60.0) is None


def test_where_nothing_was_read_no_place_is_known() -> None:
    walks = TwoWalks([], [])
    assert not walks.advisor.knows(walks.map, 4)


def test_what_is_in_view_while_a_place_is_doubted_is_a_witness_of_it() -> None:
    """It would tell the place as well, but something else has."""
    walks = TwoWalks(SIGNS, [])
    for number in range(2, 5):
        walks.advisor.note_doubtful(walks.sighting(number, SIGNS[0], 100.0 + number))
        walks.advisor.note_view(-1, [replace(walks.sighting(number, SIGNS[0], 100.0 + number), keyframe=-1)])
        walks.advisor.recalls(walks.map)
    assert walks.advisor.judges(walks.map, 4, 100.0) is True


def test_what_is_recalled_stays_the_same_until_something_else_is_in_view() -> None:
    walks = TwoWalks(SIGNS, [])
    walks.advisor.note_view(-1, [replace(walks.sighting(3, SIGNS[0], 99.0), keyframe=-1)])
    first = walks.advisor.recalls(walks.map)
    assert first
    assert walks.advisor.recalls(walks.map) is first
    walks.advisor.note_view(-1, [replace(walks.sighting(4, SIGNS[0], 99.1), keyframe=-1)])
    assert walks.advisor.recalls(walks.map) is not first


def test_texts_of_one_doubt_are_told_from_those_of_the_next() -> None:
    walks = TwoWalks(SIGNS, [])
    for text, at in (("AAAAAA", 50.0), ("BBBBBB", 70.0)):
        walks.advisor.note_doubtful(walks.sighting(3, Sign(text, 1.0), at))
    walks.advisor.judges(walks.map, 4, 60.0)
    walks.advisor.note_doubtful(walks.sighting(3, Sign("GUCCI", 1.0), 71.0))
    classes = [text_class for text_class, _ in walks.advisor._doubtful]
    assert len(set(classes)) == len(classes) == 2
