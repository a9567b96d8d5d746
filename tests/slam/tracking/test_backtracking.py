"""Frames that came while the camera was lost, and are placed once it is found."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from disturbances import Clip, Disturbed, hand_over_lens
from slam_scenes import pose_error
from test_doubt import Witness

from lpslam.camera import inverse_transform
from lpslam.config import SlamConfig, TrackingConfig
from lpslam.slam.advice import NO_ADVICE, KeyframeMap, LoopAdvisor, Recalled
from lpslam.slam.features import Features
from lpslam.slam.places.located import Fit, Located
from lpslam.slam.places.relocalising import Relocaliser
from lpslam.slam.state import EventKind, TrackingState
from lpslam.slam.system import RgbdSlam

pytestmark = pytest.mark.slow

FRAMES = 40
HIDDEN = range(12, 16)
UNSEEN = range(16, 21)
"""Frames that show the place well, while nobody looks for it in the map."""

STATES = list(TrackingState)


class Tardy(Witness):
    """Says what it is told to when it is asked for the ninth time: the camera has been matched again by then."""

    def judges(self, keyframes: KeyframeMap, keyframe: int, since: float) -> bool | None:
        self.is_asked += 1
        return self.verdict if self.is_asked >= 9 else None


@dataclass(frozen=True)
class Story:
    """A clip in which the camera was lost, and what is said of each frame in the end."""

    clip: Clip
    slam: RgbdSlam
    given: Sequence[TrackingState]
    states: Sequence[TrackingState]
    keyframes: np.ndarray
    poses: np.ndarray

    def error(self, frame: int, before: int) -> tuple[float, float]:
        """Metres and radians by which the way between two frames is off."""
        slam_map, truth = self.slam.map, self.clip.truth.world_from_camera
        one, other = (slam_map.world_from_keyframe(int(self.keyframes[k])) @ self.poses[k] for k in (before, frame))
        return pose_error(inverse_transform(one) @ other, inverse_transform(truth[before]) @ truth[frame])


Tell = Callable[..., Story]


@pytest.fixture(scope="module")
def clip(walk: Path) -> Clip:
    return Clip(walk, range(FRAMES))


@pytest.fixture
def tell(clip: Clip, monkeypatch: pytest.MonkeyPatch) -> Tell:
    """Tracks the clip with a hand over the lens, after which the map is searched for so many calls in vain."""

    def told(in_vain: int = len(HIDDEN) + len(UNSEEN), advisor: LoopAdvisor = NO_ADVICE, **tracking: float) -> Story:
        find, calls = Relocaliser.find, 0

        def late(
            relocaliser: Relocaliser,
            features: Features,
            reference: int,
            likely: Sequence[Recalled],
            may_be_at: Callable[[Located], bool],
            there: Callable[[Located], float] | None,
            fit: Fit | None,
        ) -> Located | None:
            nonlocal calls
            calls += 1
            return None if calls <= in_vain else find(relocaliser, features, reference, likely, may_be_at, there, fit)

        monkeypatch.setattr(Relocaliser, "find", late)
        config = SlamConfig(tracking=TrackingConfig.model_validate({"coast_seconds": 0.0, **tracking}))
        slam = RgbdSlam(clip.camera, config, advisor=advisor)
        given = [slam.process(frame).state for frame in Disturbed(clip, hand_over_lens(HIDDEN.start, HIDDEN.stop))]
        slam.finish()
        columns = slam.trajectory.to_arrays()
        states = [STATES[state] for state in columns["state"]]
        return Story(clip, slam, given, states, columns["keyframe"], columns["keyframe_from_camera"])

    return told


def test_frames_before_the_camera_was_found_are_placed_when_it_is(tell: Tell) -> None:
    story = tell()
    (found,) = [event.frame for event in story.slam.events if event.kind is EventKind.RELOCALISED]
    assert found == UNSEEN.stop
    assert {story.given[k] for k in (*HIDDEN, *UNSEEN)} == {TrackingState.LOST}
    assert {story.states[k] for k in UNSEEN} == {TrackingState.WEAK}
    assert {story.states[k] for k in HIDDEN} == {TrackingState.LOST}
    assert (story.keyframes[HIDDEN] < 0).all()
    for k in UNSEEN:
        metres, radians = story.error(k, HIDDEN.start - 1)
        assert metres < 0.02
        assert np.degrees(radians) < 0.7
    assert story.slam.trajectory.tracked_count == FRAMES - len(HIDDEN)


def test_frames_before_a_submap_are_placed_in_it(tell: Tell) -> None:
    story = tell(in_vain=1000)
    (begun,) = [event.frame for event in story.slam.events if event.kind is EventKind.NEW_SUBMAP]
    unseen = range(HIDDEN.stop, begun)
    assert len(unseen) >= 7
    assert {story.states[k] for k in unseen} == {TrackingState.WEAK}
    assert set(story.slam.map.submaps()[story.keyframes[unseen]].tolist()) == {1}
    for k in unseen:
        metres, radians = story.error(k, begun)
        assert metres < 0.02
        assert np.degrees(radians) < 0.7
    assert (story.keyframes[HIDDEN] < 0).all()


def test_none_are_placed_where_none_is_to_be(tell: Tell) -> None:
    story = tell(backtracked_seconds=0.0)
    assert {story.states[k] for k in (*HIDDEN, *UNSEEN)} == {TrackingState.LOST}
    assert (story.keyframes[HIDDEN.start : UNSEEN.stop] < 0).all()
    assert np.isfinite(story.poses).all()


def test_of_a_long_while_the_latest_are_placed(tell: Tell) -> None:
    story = tell(backtracked_seconds=0.15)
    placed = [k for k in UNSEEN if story.states[k] is TrackingState.WEAK]
    assert placed
    assert placed == list(range(placed[0], UNSEEN.stop))
    assert len(placed) <= 3


def test_what_was_placed_from_a_place_that_is_given_up_is_taken_back(tell: Tell) -> None:
    story = tell(advisor=Tardy(False))
    lost = [event for event in story.slam.events if event.kind is EventKind.LOST]
    assert len(lost) == 2
    assert "signs" in lost[1].reason
    assert lost[1].frame > UNSEEN.stop + 5
    assert (story.keyframes[HIDDEN.start : lost[1].frame] < 0).all()
    assert {story.states[k] for k in range(HIDDEN.start, lost[1].frame)} <= {TrackingState.LOST, TrackingState.WEAK}
    assert (story.keyframes[: HIDDEN.start] >= 0).all()


def test_what_was_placed_from_a_place_that_is_confirmed_stays(tell: Tell) -> None:
    story = tell(advisor=Tardy(True))
    assert {story.states[k] for k in UNSEEN} == {TrackingState.WEAK}
