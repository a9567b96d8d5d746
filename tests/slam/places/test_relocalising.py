"""Which of the places that could be a lost view's is believed."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import pytest
from slam_scenes import SENSOR, add_view, descriptors_of, points_ahead, rigid, view_of

from lpslam.camera import inverse_transform
from lpslam.config import LocatingConfig, TrackingConfig
from lpslam.slam.advice import NO_ADVICE, Anchor, KeyframeMap, LoopAdvisor, Recalled
from lpslam.slam.features import Features
from lpslam.slam.map import SlamMap
from lpslam.slam.places.index import PlaceIndex
from lpslam.slam.places.located import Expected, Fit, Located
from lpslam.slam.places.locating import Locator
from lpslam.slam.places.parts import Parts
from lpslam.slam.places.relocalising import LastSeen, Relocaliser

VIEW = view_of(np.eye(4), np.array([[0.0, 0.0, 2.0]]), np.zeros((1, 4), np.uint64))


class Places:
    """Place recognition with made-up scores."""

    def __init__(self, scores: list[float]) -> None:
        self.scores = np.array(scores, np.float32)

    def query(self, descriptors: np.ndarray) -> np.ndarray:
        return self.scores


@dataclass
class Picture:
    """What a picture shows of each place, and the keyframes of whose places it shows that something is not there."""

    share: Callable[[Located], float] = lambda _: 0.8
    lacking: tuple[int, ...] = ()

    def contradicts(self, located: Located) -> bool:
        return located.keyframe in self.lacking


class Holding:
    """A locator for which some keyframes hold, each with a pose and so many inliers; remembers what it was asked.

    Of a view that was found at one of `fits`, a part fits so many metres from the first keyframe as well.
    """

    def __init__(
        self, holds: dict[int, tuple[float, int]], agreement: float = 1.0, fits: dict[int, float] | None = None
    ) -> None:
        self.holds = holds
        self.fits = fits or {}
        self.parts: dict[int, Parts] = {}
        self.repeated: tuple[int, ...] = ()
        self.agreement = agreement
        self.unlike: set[int] = set()
        self.asked: list[int] = []
        self.guesses: dict[int, np.ndarray] = {}
        self.anchors: dict[int, Anchor] = {}

    def locate(
        self,
        features: Features,
        candidate: int,
        guess: np.ndarray | None = None,
        anchor: Anchor | None = None,
        is_anywhere: bool = True,
        will_look: bool = False,
        fit: Fit | None = None,
    ) -> Located | None:
        self.asked.append(candidate)
        if anchor is not None:
            self.anchors[candidate] = anchor
        if guess is not None:
            self.guesses[candidate] = guess
        if candidate not in self.holds:
            return None
        metres, inliers = self.holds[candidate]
        pose = inverse_transform(rigid([metres, 0.0, 0.0], [0, 0, 0]))
        points, is_told = np.zeros(1, np.int32), guess is not None or anchor is not None
        parts = self.parts.get(candidate, Parts(np.zeros(48, np.intp), np.zeros(48, np.intp)))
        expected = Expected(np.zeros(2 * inliers, np.int32), np.zeros((2 * inliers, 2), np.float32), points)
        agreement = 0.2 if candidate in self.unlike else self.agreement
        return Located(candidate, pose, points, inliers, expected, parts, 1.0, agreement, is_told)

    def is_unique(self, features: Features, located: Located) -> bool:
        return located.keyframe not in self.repeated

    def fit_elsewhere(self, features: Features, located: Located) -> Located | None:
        metres = self.fits.get(located.keyframe)
        if metres is None:
            return None
        return replace(located, camera_from_world=inverse_transform(rigid([metres, 0.0, 0.0], [0, 0, 0])))


def places_apart(count: int, submaps: dict[int, int] | None = None) -> SlamMap:
    """Keyframes that share no points; those named begin a sub-map."""
    random = np.random.default_rng(0)
    slam_map = SlamMap(20, SENSOR.scales)
    for number in range(count):
        points = points_ahead(random, 20)
        parent = -1 if number == 0 or number in (submaps or {}) else number - 1
        add_view(slam_map, np.eye(4), view_of(np.eye(4), points, descriptors_of(random, 20)), parent)
        slam_map.add_points(number, np.arange(20, dtype=np.int32), points)
    return slam_map


class Recalling:
    """An advisor to whom a lost view says something."""

    def __init__(self, *recalled: Recalled) -> None:
        self.recalled = recalled

    def recalls(self, keyframes: KeyframeMap) -> tuple[Recalled, ...]:
        return self.recalled


def relocaliser(
    slam_map: SlamMap, scores: list[float], locator: Holding, advisor: Recalling | None = None, sweep: int = 0
) -> Relocaliser:
    return Relocaliser(
        slam_map,
        cast("PlaceIndex", Places(scores)),
        cast("Locator", locator),
        TrackingConfig(recovery_candidates=4, recovery_sweep=sweep),
        LocatingConfig(rival_share=0.6, rival_distance=0.5),
        cast("LoopAdvisor", advisor or NO_ADVICE),
    )


def test_a_place_that_is_recalled_is_tried_from_where_that_says_whatever_it_looks_like() -> None:
    locator, guess = Holding({2: (1.0, 80)}), rigid([0.9, 0.1, 0.0], [0, 0, 0])
    advisor = Recalling(Recalled(2, guess))
    located = relocaliser(places_apart(5), [0.0] * 5, locator, advisor).find(VIEW, 4)
    assert located is not None
    assert located.keyframe == 2
    np.testing.assert_array_equal(locator.guesses[2], guess)


def test_of_places_that_look_alike_the_one_that_is_told_is_believed() -> None:
    slam_map, advisor = places_apart(5), Recalling(Recalled(2, np.eye(4)))
    assert relocaliser(slam_map, [0.0] * 5, Holding({}), advisor).find(VIEW, 4) is None
    for inliers in (70, 90):
        alike = Holding({2: (1.0, 80), 4: (9.0, inliers)})
        found = relocaliser(slam_map, [0.0] * 5, alike, advisor).find(VIEW, 4)
        assert found is not None
        assert found.keyframe == 2


def test_a_place_that_is_told_is_not_believed_where_much_less_agrees_or_two_are_told() -> None:
    slam_map, advisor = places_apart(5), Recalling(Recalled(2, np.eye(4)), Recalled(3, np.eye(4)))
    poorer = Holding({2: (1.0, 80), 4: (9.0, 200)})
    found = relocaliser(slam_map, [0.0] * 5, poorer, advisor).find(VIEW, 4)
    assert found is not None
    assert found.keyframe == 4
    both = Holding({2: (1.0, 80), 3: (5.0, 75)})
    assert relocaliser(slam_map, [0.0] * 5, both, advisor).find(VIEW, 4) is None


def test_a_view_of_which_a_part_fits_elsewhere_is_not_believed() -> None:
    """Before a row of fronts all alike: the right one need not be mapped."""
    assert relocaliser(places_apart(5), [0.0] * 5, Holding({4: (0.0, 90)})).find(VIEW, 4) is not None
    assert relocaliser(places_apart(5), [0.0] * 5, Holding({4: (0.0, 90)}, fits={4: 6.0})).find(VIEW, 4) is None


def test_a_sign_tells_which_of_the_places_that_a_view_fits_is_the_right_one() -> None:
    told = Holding({2: (1.0, 80)}, fits={2: 6.0})
    advisor = Recalling(Recalled(2, np.eye(4)))
    assert relocaliser(places_apart(5), [0.0] * 5, told, advisor).find(VIEW, 4) is not None


def seen_in_parts(*shares: float) -> Parts:
    """Of twenty points in each of some parts of the image, so many are seen."""
    expected, seen = np.zeros(48, np.intp), np.zeros(48, np.intp)
    expected[: len(shares)] = 20
    seen[: len(shares)] = np.round(20 * np.array(shares))
    return Parts(expected, seen)


def test_a_place_that_looks_like_others_that_do_not_hold_is_not_believed() -> None:
    """Tiles of a floor fit in many places, of which the right one need not be mapped."""
    locator = Holding({4: (0.0, 90)})
    locator.repeated = (4,)
    assert relocaliser(places_apart(5), [0.0] * 5, locator).find(VIEW, 4) is None


def test_a_look_alike_out_of_reach_is_no_rival_a_moment_after_the_camera_was_seen() -> None:
    locator = Holding({4: (0.0, 90)}, fits={4: 6.0})
    seen = LastSeen(4, np.eye(4), 10.0)
    for later, is_found in ((0.1, True), (2.0, False)):
        searching = relocaliser(places_apart(5), [0.0] * 5, locator)
        found = [searching.confirm(VIEW, 4, seen, 10.0 + later + n / 30) for n in range(3)]
        assert any(located is not None for located in found) == is_found


def test_a_place_that_signs_have_spoken_against_is_no_rival() -> None:
    locator = Holding({4: (0.0, 90)}, fits={4: 6.0})
    searching = relocaliser(places_apart(5), [0.0] * 5, locator)
    searching.disown(1, inverse_transform(rigid([6.0, 0.0, 0.0], [0, 0, 0])))
    assert searching.find(VIEW, 4) is not None


def test_what_something_in_view_told_is_looked_for_there_in_the_next_frames() -> None:
    """A sign is read every few frames, and its direction is old by then; where the camera was found is not."""
    anchor = Anchor(np.zeros((1, 4, 3)), np.tile([0.0, 0.0, 1.0], (1, 4, 1)))
    advisor = Recalling(Recalled(2, anchor=anchor))
    locator = Holding({2: (1.0, 80)}, agreement=0.2)
    searching = relocaliser(places_apart(5), [0.0] * 5, locator, advisor)
    assert searching.confirm(VIEW, -1, None, 0.0) is None
    assert locator.anchors == {2: anchor}
    assert 2 not in locator.guesses
    advisor.recalled = ()
    assert searching.confirm(VIEW, -1, None, 1 / 30) is None
    np.testing.assert_allclose(locator.guesses[2], inverse_transform(rigid([1.0, 0.0, 0.0], [0, 0, 0])))
    found = searching.confirm(VIEW, -1, None, 2 / 30)
    assert found is not None
    assert found.is_told


def test_a_place_whose_words_say_nothing_is_found_in_its_turn() -> None:
    """Words are learned on some pictures: a view of another world may share none with its own keyframe."""
    locator = Holding({2: (0.0, 90)})
    searching = relocaliser(places_apart(9), [0.0] * 9, locator, sweep=2)
    found = [searching.find(VIEW, 8) for _ in range(4)]
    assert [located is not None for located in found] == [False, False, False, True]
    assert locator.asked.count(8) == 4
    assert sorted(set(locator.asked)) == [1, 2, 3, 4, 5, 6, 7, 8]


def test_where_nothing_holds_there_is_no_place() -> None:
    locator = Holding({})
    assert relocaliser(places_apart(5), [0.5, 0.5, 0.5, 0.5, 0.5], locator).find(VIEW, 4) is None
    assert sorted(locator.asked) == [0, 1, 2, 3, 4]


def test_the_place_that_most_of_the_view_agrees_with_is_believed() -> None:
    locator = Holding({1: (0.0, 200), 3: (0.2, 240), 2: (9.0, 100)})
    found = relocaliser(places_apart(5), [0.4, 0.5, 0.5, 0.5, 0.4], locator).find(VIEW, -1)
    assert found is not None
    assert (found.keyframe, found.inliers) == (3, 240)


@pytest.mark.parametrize(
    ("metres", "inliers", "believed"),
    [(2.0, 190, False), (2.0, 125, False), (2.0, 115, True), (0.45, 190, True), (0.55, 190, False)],
)
def test_a_rival_elsewhere_makes_both_unbelievable(metres: float, inliers: int, believed: bool) -> None:
    for order in ([0.5, 0.49], [0.49, 0.5]):
        found = relocaliser(places_apart(2), order, Holding({0: (0.0, 200), 1: (metres, inliers)})).find(VIEW, -1)
        assert (found is not None) == believed
        assert found is None or found.keyframe == 0


def test_the_same_view_in_two_submaps_is_no_contradiction() -> None:
    """Before they are merged, the same place has two poses."""
    slam_map = places_apart(4, submaps={2: 1})
    assert slam_map.submaps().tolist() == [0, 0, 1, 1]
    found = relocaliser(slam_map, [0.5, 0.1, 0.5, 0.1], Holding({0: (0.0, 150), 2: (7.0, 160)})).find(VIEW, -1)
    assert found is not None
    assert found.keyframe == 2


def test_the_last_reference_is_tried_first_and_nobody_twice() -> None:
    locator = Holding({})
    relocaliser(places_apart(6), [0.5, 0.5, 0.1, 0.1, 0.1, 0.45], locator).find(VIEW, 5)
    assert locator.asked[0] == 5
    assert len(locator.asked) == len(set(locator.asked))
    assert {0, 1, 5} <= set(locator.asked)


def test_keyframes_that_are_gone_are_not_tried() -> None:
    slam_map = places_apart(5)
    slam_map.remove_keyframe(2)
    slam_map.remove_keyframe(4)
    locator = Holding({2: (0.0, 300), 4: (0.0, 300)})
    assert relocaliser(slam_map, [0.4, 0.4, 0.5, 0.4, 0.5], locator).find(VIEW, 4) is None
    assert {2, 4}.isdisjoint(locator.asked)


def test_no_more_places_are_tried_than_configured() -> None:
    locator = Holding({})
    relocaliser(places_apart(12), [0.5] * 12, locator).find(VIEW, -1)
    assert len(locator.asked) == 4


def test_an_empty_map_has_no_place() -> None:
    locator = Holding({})
    slam_map = SlamMap(20, SENSOR.scales)
    assert relocaliser(slam_map, [], locator).find(VIEW, -1) is None
    assert locator.asked == []


def test_a_place_that_little_tells_is_believed_when_the_next_frames_find_it_too() -> None:
    """What fits by chance fits elsewhere a frame later, or nowhere."""
    slam_map, scores, frame = places_apart(2), [0.5, 0.5], 1 / 30
    locator = Holding({0: (0.0, 60)})
    searching = relocaliser(slam_map, scores, locator)
    assert searching.confirm(VIEW, -1, None, 0.0) is None
    locator.holds = {0: (1.5, 60)}
    assert searching.confirm(VIEW, -1, None, frame) is None, "too far for a thirtieth of a second"
    locator.holds = {0: (1.55, 60)}
    assert searching.confirm(VIEW, -1, None, 2 * frame) is None, "a view that has hardly changed"
    found = searching.confirm(VIEW, -1, None, 3 * frame)
    assert found is not None
    assert found.inliers == 60


def test_a_frame_without_a_place_ends_what_was_found_in_a_row() -> None:
    slam_map, frame = places_apart(2), 1 / 30
    locator = Holding({0: (0.0, 60)})
    searching = relocaliser(slam_map, [0.5, 0.5], locator)
    for index, holds in enumerate([True, True, False, True, True]):
        locator.holds = {0: (0.0, 60)} if holds else {}
        assert searching.confirm(VIEW, -1, None, index * frame) is None
    assert searching.confirm(VIEW, -1, None, 5 * frame) is not None


def test_a_place_that_much_tells_is_believed_at_once() -> None:
    def is_confirmed(agreement: float) -> bool:
        searching = relocaliser(places_apart(2), [0.5, 0.5], Holding({0: (5.0, 100)}, agreement))
        return searching.confirm(VIEW, -1, None, 0.0) is not None

    assert is_confirmed(0.95)
    assert not is_confirmed(0.7), "of a pattern, many points agree anywhere"


def test_a_place_near_which_the_camera_was_is_believed_when_one_more_frame_finds_it() -> None:
    slam_map, frame = places_apart(2), 1 / 30
    last_seen = LastSeen(0, rigid([-4.0, 0.0, 0.0], [0, 0, 0]), 10.0)
    for seconds, is_believed in ((0.3, False), (0.6, True)):
        searching = relocaliser(slam_map, [0.5, 0.5], Holding({0: (5.0, 60)}))
        assert searching.confirm(VIEW, -1, last_seen, 10.0 + seconds) is None
        again = searching.confirm(VIEW, -1, last_seen, 10.0 + seconds + frame)
        assert (again is not None) == is_believed


# A place in which the camera was found, and a sign in view that stands elsewhere -----------------------------------


def told_elsewhere(locator: Holding, *recalled: Recalled) -> bool:
    searching = relocaliser(places_apart(5), [0.0] * 5, locator, Recalling(*recalled))
    return searching.is_told_elsewhere(VIEW, 4, inverse_transform(rigid([0.0, 0.0, 0.0], [0, 0, 0])))


@pytest.mark.parametrize(
    ("holds", "is_elsewhere"),
    [
        ({2: (6.0, 80), 4: (0.0, 90)}, True),
        ({2: (6.0, 80)}, True),
        ({2: (0.2, 80), 4: (0.0, 90)}, False),
        ({2: (0.2, 80)}, False),
        ({2: (6.0, 40), 4: (0.0, 90)}, False),
        ({4: (0.0, 90)}, False),
    ],
    ids=["holds as well", "holds alone", "the same place", "the same place alone", "holds much less", "does not hold"],
)
def test_a_sign_that_stands_elsewhere_speaks_against_a_place_where_that_holds_as_well(
    holds: dict[int, tuple[float, int]], is_elsewhere: bool
) -> None:
    assert told_elsewhere(Holding(holds), Recalled(2, np.eye(4))) == is_elsewhere


def test_a_view_that_speaks_for_the_place_outweighs_a_sign_that_stands_elsewhere_too() -> None:
    locator = Holding({2: (6.0, 80), 4: (0.0, 90)})
    locator.parts = {4: seen_in_parts(0.5, 0.4, 0.5), 2: seen_in_parts(0.0, 0.4, 0.0)}
    assert not told_elsewhere(locator, Recalled(2, np.eye(4)))


def test_a_sign_that_also_stands_here_says_nothing() -> None:
    locator = Holding({2: (6.0, 80), 3: (0.1, 80), 4: (0.0, 90)})
    assert not told_elsewhere(locator, Recalled(2, np.eye(4)), Recalled(3, np.eye(4)))


def test_a_view_is_compared_once() -> None:
    locator, advisor = Holding({2: (6.0, 40), 4: (0.0, 90)}), Recalling(Recalled(2, np.eye(4)))
    searching = relocaliser(places_apart(5), [0.0] * 5, locator, advisor)
    for _ in range(3):
        assert not searching.is_told_elsewhere(VIEW, 4, np.eye(4))
    assert locator.asked == [2, 4]


def test_a_place_that_the_picture_does_not_show_is_not_believed() -> None:
    searching = relocaliser(places_apart(5), [0.9, 0.0, 0.0, 0.0, 0.0], Holding({0: (0.0, 200)}))
    assert searching.find(VIEW, -1, look=Picture(lambda _: 0.8)) is not None
    assert searching.find(VIEW, -1, look=Picture(lambda _: 0.3)) is None


def test_a_place_that_it_shows_is_found_where_a_better_one_is_not_there() -> None:
    holding = Holding({0: (0.0, 200), 1: (0.1, 190), 2: (5.0, 100)})
    searching = relocaliser(places_apart(5), [0.9, 0.8, 0.7, 0.0, 0.0], holding)
    asked: list[int] = []

    def there(located: Located) -> float:
        asked.append(located.keyframe)
        return 0.8 if located.keyframe == 2 else 0.3

    found = searching.find(VIEW, -1, look=Picture(there))
    assert found is not None
    assert found.keyframe == 2
    assert asked == [0, 2], "what is found around a place that is not there is not asked again"


@pytest.mark.parametrize(("there", "is_believed"), [(0.7, True), (0.75, True), (0.95, False)])
def test_what_looks_otherwise_speaks_against_a_place_where_much_more_of_it_is_there(
    there: float, is_believed: bool
) -> None:
    """A hall that is alike when turned round: of the right end, seen from another side, little looks as it did."""
    holding = Holding({0: (0.0, 200), 2: (5.0, 60)})
    searching = relocaliser(places_apart(5), [0.9, 0.0, 0.7, 0.0, 0.0], holding)
    holding.unlike.add(2)
    found = searching.find(VIEW, -1, look=Picture(lambda located: there if located.keyframe == 2 else 0.7))
    assert (found is not None) == is_believed


def test_what_looks_otherwise_is_no_place_by_itself() -> None:
    holding = Holding({2: (5.0, 60)})
    holding.unlike.add(2)
    assert (
        relocaliser(places_apart(5), [0.0, 0.0, 0.7, 0.0, 0.0], holding).find(VIEW, -1, look=Picture(lambda _: 1.0))
        is None
    )


def test_a_place_that_looks_alike_by_one_of_its_keyframes_is_believed() -> None:
    holding = Holding({0: (0.0, 200), 1: (0.1, 150)})
    holding.unlike.add(0)
    found = relocaliser(places_apart(5), [0.9, 0.8, 0.0, 0.0, 0.0], holding).find(VIEW, -1, look=Picture(lambda _: 0.7))
    assert found is not None
    assert found.keyframe == 1


@pytest.mark.parametrize(("seconds", "is_found"), [(0.1, True), (5.0, False)])
def test_a_place_that_lacks_something_is_believed_only_where_the_camera_just_was(
    seconds: float, is_found: bool
) -> None:
    """Someone takes a board from the wall before the camera; or it looks at another wall, alike but for the board."""
    searching = relocaliser(places_apart(5), [0.9, 0.0, 0.0, 0.0, 0.0], Holding({0: (0.0, 200)}))
    seen = LastSeen(0, np.eye(4), 10.0)
    assert searching.confirm(VIEW, -1, seen, 10.0 + seconds, Picture()) is not None
    found = searching.confirm(VIEW, -1, seen, 10.0 + seconds, Picture(lacking=(0,)))
    assert (found is not None) == is_found


def test_what_a_sign_tells_may_lack_something() -> None:
    advisor = Recalling(Recalled(0, np.eye(4)))
    searching = relocaliser(places_apart(5), [0.0] * 5, Holding({0: (0.0, 200)}), advisor)
    assert searching.confirm(VIEW, -1, None, 10.0, Picture(lacking=(0,))) is not None
