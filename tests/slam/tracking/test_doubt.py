"""A place in which the camera was found again, until signs speak for or against it."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from disturbances import Clip, Disturbed, hand_over_lens
from numpy.typing import NDArray

from lpslam.config import SlamConfig, TrackingConfig
from lpslam.slam.advice import KeyframeMap, Recalled
from lpslam.slam.map import SlamMap
from lpslam.slam.state import EventKind, TrackedFrame, TrackingState
from lpslam.slam.system import RgbdSlam
from lpslam.slam.tracking.doubt import Doubt

FRAMES = 40
HIDDEN = range(12, 18)


class Witness:
    """An advisor that knows every place, and says of it what it is told to, once asked for the third time."""

    def __init__(self, verdict: bool | None, *, knows: bool = True) -> None:
        self.verdict, self.is_asked, self._knows = verdict, 0, knows

    def propose(self, keyframes: KeyframeMap, keyframe: int) -> Sequence[Recalled]:
        return ()

    def vetoes(
        self, keyframes: KeyframeMap, keyframe: int, candidate: int, camera_from_world: NDArray[np.float64]
    ) -> str | None:
        return None

    def recalls(self, keyframes: KeyframeMap) -> Sequence[Recalled]:
        return ()

    def knows(self, keyframes: KeyframeMap, keyframe: int) -> bool:
        return self._knows

    def judges(self, keyframes: KeyframeMap, keyframe: int, since: float) -> bool | None:
        self.is_asked += 1
        return self.verdict if self.is_asked >= 3 else None


@pytest.fixture(scope="module")
def clip(walk: Path) -> Clip:
    return Clip(walk, range(FRAMES))


def covered(clip: Clip, witness: Witness, **tracking: float) -> tuple[RgbdSlam, list[TrackedFrame]]:
    """The clip, with a hand over the lens for six frames."""
    config = SlamConfig(tracking=TrackingConfig.model_validate({"coast_seconds": 0.0, **tracking}))
    slam = RgbdSlam(clip.camera, config, advisor=witness)
    tracked = [slam.process(frame) for frame in Disturbed(clip, hand_over_lens(HIDDEN.start, HIDDEN.stop))]
    slam.finish()
    return slam, tracked


def kinds(slam: RgbdSlam, kind: EventKind) -> list[int]:
    return [event.frame for event in slam.events if event.kind is kind]


@pytest.mark.slow
def test_a_place_whose_signs_differ_is_given_up_and_its_poses_taken_back(clip: Clip) -> None:
    slam, tracked = covered(clip, Witness(False))
    (found,) = kinds(slam, EventKind.RELOCALISED)
    assert HIDDEN.start < found <= HIDDEN.stop + 2
    lost = [event for event in slam.events if event.kind is EventKind.LOST]
    assert len(lost) == 2
    assert "signs" in lost[1].reason
    given_up = lost[1].frame
    assert found < given_up <= found + 4
    assert all(frame.is_doubted for frame in tracked[found:given_up])
    # Keyframes that were made there have gone with the place.
    assert not any(slam.map.is_alive(frame.keyframe) for frame in tracked[found:given_up] if frame.is_keyframe)
    # Nothing is found there again, and after a second a sub-map begins.
    (anew,) = kinds(slam, EventKind.NEW_SUBMAP)
    assert tracked[anew].timestamp - tracked[given_up].timestamp >= TrackingConfig().submap_after
    assert all(frame.state is TrackingState.LOST for frame in tracked[given_up:anew])
    columns = slam.trajectory.to_arrays()
    assert (columns["keyframe"][HIDDEN.start : given_up] < 0).all()
    assert (columns["keyframe"][: HIDDEN.start] >= 0).all()
    # The frames before it that showed its place are placed in it.
    assert set(slam.map.submaps()[columns["keyframe"][given_up:]].tolist()) == {1}


@pytest.mark.slow
def test_a_place_whose_signs_agree_is_mapped_on(clip: Clip) -> None:
    witness = Witness(True)
    slam, tracked = covered(clip, witness)
    (found,) = kinds(slam, EventKind.RELOCALISED)
    assert kinds(slam, EventKind.LOST) == [HIDDEN.start]
    assert witness.is_asked == 3
    assert [frame.index for frame in tracked if frame.is_doubted] == [found, found + 1, found + 2]
    assert all(frame.is_tracked for frame in tracked[found:])
    assert any(frame.is_keyframe for frame in tracked[found + 3 :])


@pytest.mark.slow
def test_a_place_of_which_nothing_is_said_is_believed_after_a_while(clip: Clip) -> None:
    slam, tracked = covered(clip, Witness(None), doubt_seconds=0.3)
    (found,) = kinds(slam, EventKind.RELOCALISED)
    doubted = [frame.timestamp for frame in tracked if frame.is_doubted]
    assert doubted[-1] - tracked[found].timestamp == pytest.approx(0.3, abs=0.05)
    assert any(frame.is_keyframe for frame in tracked[found:])


@pytest.mark.slow
def test_a_place_of_which_nothing_is_known_is_not_doubted(clip: Clip) -> None:
    _, tracked = covered(clip, Witness(False, knows=False))
    assert not any(frame.is_doubted for frame in tracked)
    assert all(frame.is_tracked for frame in tracked[HIDDEN.stop + 2 :])


def test_a_doubt_ends_with_an_answer_or_with_time() -> None:
    slam_map = SlamMap(4, np.array([1.0]))
    for verdict, at, is_open in ((None, 11.0, True), (None, 13.5, False), (True, 11.0, False), (False, 11.0, False)):
        witness = Witness(verdict)
        witness.is_asked = 2
        doubt = Doubt(slam_map, witness, 3.0, 100)
        assert not doubt.is_open
        doubt.begin(0, 10.0)
        assert doubt.is_open
        assert doubt.settle(0, at) is verdict
        assert doubt.is_open is is_open


def test_a_doubt_reaches_back_to_frames_that_came_before() -> None:
    doubt = Doubt(SlamMap(4, np.array([1.0])), Witness(None), 3.0, 100)
    doubt.begin(0, 10.0)
    assert doubt.placed_since == 10.0
    for placed, since in ((np.inf, 10.0), (9.2, 9.2), (9.7, 9.2)):
        doubt.reach_back(placed)
        assert doubt.placed_since == since
    doubt.begin(0, 20.0)
    assert doubt.placed_since == 20.0, "an earlier doubt is settled"


def test_a_place_that_rests_on_one_sign_is_doubted_until_more_tells_it() -> None:
    slam_map = SlamMap(4, np.array([1.0]))
    for points, ends in ((99, False), (100, True)):
        doubt = Doubt(slam_map, Witness(None), 3.0, 100)
        doubt.begin(0, 10.0, rests_on_one_sign=True)
        doubt.matched(points)
        assert doubt.settle(0, 12.9) is None
        assert doubt.is_open
        assert doubt.settle(0, 13.1) is None
        assert doubt.is_open != ends
    doubt = Doubt(slam_map, Witness(True), 3.0, 100)
    doubt.begin(0, 10.0, rests_on_one_sign=True)
    assert [doubt.settle(0, 11.0 + second) for second in range(3)] == [None, None, True]
    assert not doubt.is_open
