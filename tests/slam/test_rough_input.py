"""Cameras in the world: each disturbance of a rendered walk. A pose that is given is right, or said to be weak."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from disturbances import (
    Clip,
    Disturbance,
    Disturbed,
    blank_wall,
    doubled,
    exposure,
    frozen_colour,
    gap,
    hand_over_lens,
    out_of_order,
    passer_by,
    rolling_blur,
    without_depth,
)
from numpy.typing import NDArray
from slam_scenes import check_graph

from lpslam.camera import inverse_transform
from lpslam.frames import FrameFault
from lpslam.slam.state import TrackedFrame, TrackingState
from lpslam.slam.system import RgbdSlam
from lpslam.sources.in_order import InOrder

pytestmark = pytest.mark.slow

SECOND = 15  # frames
FIRST = 16  # the first disturbed frame
# A corner of the mall, and back the same way: what was seen before the disturbance is seen again after it.
BEGINNING, TURN, END = 12, 12 + FIRST + SECOND, 20  # frames of the walk
ORDER = [*range(BEGINNING, TURN), *range(TURN, END, -1)]
FRAMES = len(ORDER)
BACK = FIRST + 2 * SECOND  # the frame at which the last view before the disturbance is passed again
# Metres and degrees within which a pose counts as right.
POSITION, ANGLE = 0.05, 2.0


@pytest.fixture(scope="module")
def clip(walk: Path) -> Clip:
    return Clip(walk, ORDER)


@dataclass(frozen=True)
class Outcome:
    """What came of a disturbed clip.

    Attributes:
        slam: after the last frame.
        tracked: frame by frame.
        position, angle: by frame index, metres and degrees off the truth after alignment on the frames before the
            disturbance; not a number where the frame has no pose.
        faults: frames that were not even tried.
    """

    slam: RgbdSlam
    tracked: list[TrackedFrame]
    position: NDArray[np.float64]
    angle: NDArray[np.float64]
    faults: list[FrameFault]

    def states(self, first: int, last: int) -> set[TrackingState]:
        return {frame.state for frame in self.tracked if first <= frame.index < last}

    def wrong(self) -> list[str]:
        """Frames that are said to be tracked and are not where it is said."""
        return [
            f"frame {frame.index}: {self.position[frame.index]:.3f} m, {self.angle[frame.index]:.1f} degrees"
            for frame in self.tracked
            if frame.state is TrackingState.TRACKING
            and not (self.position[frame.index] <= POSITION and self.angle[frame.index] <= ANGLE)
        ]

    def untracked(self, first: int, last: int = FRAMES) -> list[int]:
        return [frame.index for frame in self.tracked if first <= frame.index < last and not frame.is_tracked]


def run(clip: Clip, disturbance: Disturbance) -> Outcome:
    """Track the disturbed clip, and compare the final trajectory with the truth."""
    source = InOrder(Disturbed(clip, disturbance))
    slam = RgbdSlam(clip.camera)
    tracked = [slam.process(frame) for frame in source]
    slam.finish()
    check_graph(slam.map)
    timestamps, world_from_camera = slam.trajectory.world_from_camera(slam.map)
    index = np.searchsorted(clip.truth.timestamps, timestamps - 0.001)
    truth = clip.truth.world_from_camera[index]
    # Each frame before the disturbance proposes an alignment; the middle one is right to a few millimetres.
    middle = int(np.searchsorted(index, FIRST // 2))
    truth_from_map = truth[middle] @ inverse_transform(world_from_camera[middle])
    aligned = truth_from_map @ world_from_camera
    position, angle = np.full(len(clip), np.nan), np.full(len(clip), np.nan)
    position[index] = np.linalg.norm(aligned[:, :3, 3] - truth[:, :3, 3], axis=1)
    cosine = (np.einsum("nij,nij->n", aligned[:, :3, :3], truth[:, :3, :3]) - 1) / 2
    angle[index] = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return Outcome(slam, tracked, position, angle, source.faults)


def test_the_clip_itself_is_tracked_well_within_what_is_asked(clip: Clip) -> None:
    outcome = run(clip, lambda frames: frames)
    assert outcome.states(0, FRAMES) == {TrackingState.TRACKING}
    assert outcome.position.max() < POSITION / 2
    assert outcome.angle.max() < ANGLE / 2


# Delivery ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("disturbance", "faults", "missing"), [(doubled(20, 40), 20, 0), (out_of_order(20, 40), 10, 10)]
)
def test_frames_that_come_twice_or_late_are_left_out_and_counted(
    clip: Clip, disturbance: Disturbance, faults: int, missing: int
) -> None:
    outcome = run(clip, disturbance)
    assert len(outcome.faults) == faults
    assert outcome.states(0, FRAMES) == {TrackingState.TRACKING}
    assert outcome.wrong() == []
    assert outcome.slam.trajectory.tracked_count == FRAMES - missing


def test_after_a_gap_of_a_second_the_camera_is_found_again_where_it_was_long_before(walk: Path) -> None:
    # Carried on and then two metres back: the last view has nothing in common with the next one.
    away, back = 28, 28 + SECOND
    clip = Clip(walk, [*range(20, 48), *range(48, 48 + SECOND), *range(12, 23)])
    outcome = run(clip, gap(away, back))
    assert outcome.wrong() == []
    assert outcome.untracked(0) == []
    assert outcome.states(back, FRAMES) == {TrackingState.TRACKING}
    assert set(outcome.slam.map.submaps().tolist()) == {0}


# Sensor ------------------------------------------------------------------------------------------------------------


def test_a_second_without_depth_and_then_where_the_camera_was_long_before(walk: Path) -> None:
    away, back = 24, 24 + SECOND
    clip = Clip(walk, [*range(24, 48), *range(48, 48 + SECOND), *range(12, 22)])
    outcome = run(clip, without_depth(away, back))
    assert outcome.wrong() == []
    assert outcome.states(away, back) == {TrackingState.TRACKING}, "the map holds for a while"
    assert outcome.untracked(back + 3) == []
    assert set(outcome.slam.map.submaps().tolist()) == {0}


def test_a_colour_camera_that_hangs_is_no_standing_still(clip: Clip) -> None:
    """The picture says that nothing moves, the depth that it does: better no pose than that of a moment gone by."""
    outcome = run(clip, frozen_colour(FIRST, FIRST + SECOND))
    assert [fault.index for fault in outcome.faults] == list(range(FIRST + 1, FIRST + SECOND))
    assert "the camera hangs" in outcome.faults[0].reason
    assert outcome.wrong() == []
    assert outcome.untracked(BACK) == []


@pytest.mark.parametrize("factors", [(0.4,), (2.0,), (0.4, 2.0, 0.4, 2.0)])
def test_sudden_exposure(clip: Clip, factors: tuple[float, ...]) -> None:
    outcome = run(clip, exposure(FIRST, FIRST + SECOND, factors))
    assert outcome.wrong() == []
    assert len(outcome.untracked(FIRST, FIRST + SECOND)) <= 3
    assert outcome.untracked(FIRST + SECOND + 1) == []


def test_a_jerk_with_a_rolling_shutter(clip: Clip) -> None:
    outcome = run(clip, rolling_blur(FIRST, FIRST + 8))
    assert outcome.wrong() == []
    assert outcome.untracked(FIRST + 8 + 3) == []


# World -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("disturbance", [hand_over_lens, blank_wall], ids=["a hand", "a wall without texture"])
def test_a_view_that_shows_nothing_is_lost_and_comes_back(
    clip: Clip, disturbance: Callable[[int, int], Disturbance]
) -> None:
    outcome = run(clip, disturbance(FIRST, FIRST + SECOND))
    assert outcome.wrong() == []
    assert TrackingState.TRACKING not in outcome.states(FIRST + 1, FIRST + SECOND)
    assert all(frame.reason for frame in outcome.tracked if not frame.is_tracked)
    assert outcome.untracked(BACK) == []


def test_someone_who_walks_through_the_view_does_not_take_the_map_along(walk: Path) -> None:
    # Onwards: turning on the spot from one frame to the next is more than a walker does.
    outcome = run(Clip(walk, range(BEGINNING, BEGINNING + FRAMES)), passer_by(FIRST, FIRST + 2 * SECOND))
    assert outcome.wrong() == []
    assert len(outcome.untracked(FIRST, FIRST + 2 * SECOND)) <= SECOND
    assert outcome.untracked(FIRST + 2 * SECOND + 3) == []
