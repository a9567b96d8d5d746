"""What tracking says of itself: states, reasons and events; and maps that are only read."""

import hashlib
from collections.abc import Iterable
from dataclasses import replace
from itertools import islice, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from disturbances import WITHOUT_COASTING, Clip, Disturbed, gap, hand_over_lens
from slam_scenes import pose_error

from lpslam.config import KeyframeConfig, SlamConfig, TrackingConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.association import Associator, View
from lpslam.slam.map import SlamMap
from lpslam.slam.state import EventKind, SlamEvent, TrackedFrame, TrackingState
from lpslam.slam.system import RgbdSlam
from lpslam.slam.tracking.guesses import Search
from lpslam.slam.tracking.local_search import LocalSearch

pytestmark = pytest.mark.slow

FRAMES = 42
HIDDEN = range(22, 28)


@pytest.fixture(scope="module")
def clip(walk: Path) -> Clip:
    return Clip(walk, range(FRAMES))


def run(slam: RgbdSlam, frames: Iterable[RgbdFrame]) -> list[TrackedFrame]:
    tracked = [slam.process(frame) for frame in frames]
    slam.finish()
    return tracked


@pytest.fixture(scope="module")
def covered(clip: Clip) -> tuple[RgbdSlam, list[TrackedFrame]]:
    """The clip, with a hand over the lens for six frames."""
    slam = RgbdSlam(clip.camera, WITHOUT_COASTING)
    return slam, run(slam, Disturbed(clip, hand_over_lens(HIDDEN.start, HIDDEN.stop)))


@pytest.fixture(scope="module")
def plain(clip: Clip) -> tuple[RgbdSlam, list[TrackedFrame], list[int]]:
    """The clip as it is, and the keyframes all of whose descriptors were compared with all of a frame's."""
    compared: list[int] = []
    match_descriptors = Associator.match_descriptors

    def counting(associator: Associator, view: View, keyframe: int) -> np.ndarray:
        compared.append(keyframe)
        return match_descriptors(associator, view, keyframe)

    slam = RgbdSlam(clip.camera)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Associator, "match_descriptors", counting)
        return slam, run(slam, clip), compared


def fingerprint(slam_map: SlamMap) -> dict[str, str]:
    """A hash of every column."""
    return {
        name: hashlib.sha256(array.tobytes()).hexdigest() + str(array.shape)
        for name, array in slam_map.to_arrays().items()
    }


def test_no_descriptor_is_compared_with_every_other_where_the_next_view_can_be_predicted(
    plain: tuple[RgbdSlam, list[TrackedFrame], list[int]],
) -> None:
    """It takes longer than all other matching; while the camera is followed nothing is gained by it."""
    _, tracked, compared = plain
    assert all(each.state is TrackingState.TRACKING for each in tracked)
    # The second frame has no motion to go by.
    assert len(compared) <= 1


# Events ------------------------------------------------------------------------------------------------------------


def test_waiting_for_a_first_view_is_no_event_and_the_beginning_is_one(clip: Clip) -> None:
    slam = RgbdSlam(clip.camera, WITHOUT_COASTING)
    frames = list(clip)[:6]
    blind = [replace(frame, depth=np.where(frame.depth < 1.2, frame.depth, 0)) for frame in frames[:3]]
    for frame, tracked in zip(frames[:3], [slam.process(frame) for frame in blind], strict=True):
        assert tracked.state is TrackingState.INITIALISING
        assert (tracked.index, tracked.timestamp) == (frame.index, frame.timestamp)
        assert tracked.reason.startswith("waiting for a first view: ")
        assert "of " in tracked.reason
        assert tracked.reason.endswith(f"{KeyframeConfig().min_start_depths} needed")
    assert slam.events == []
    tracked = slam.process(frames[3])
    assert tracked.state is TrackingState.TRACKING
    assert tracked.is_keyframe
    (event,) = slam.events
    assert (event.kind, event.frame, event.timestamp) == (EventKind.INITIALISED, 3, frames[3].timestamp)
    assert event.reason.endswith(" keypoints with depth")
    assert int(event.reason.split()[0]) >= 150


def test_after_a_while_a_view_with_less_depth_begins_the_map(clip: Clip) -> None:
    config, first = KeyframeConfig(), next(iter(clip))

    def process(slam: RgbdSlam, columns: int, seconds: float) -> TrackedFrame:
        depth = first.depth.copy()
        depth[:, columns:] = 0.0
        return slam.process(replace(first, index=round(30 * seconds), timestamp=seconds, depth=depth))

    def depths(columns: int) -> int:
        said = process(RgbdSlam(clip.camera), columns, 0.0).reason
        return int(said.removeprefix("waiting for a first view: ").split()[0]) if said else 1000

    shown = {columns: depths(columns) for columns in range(40, 400, 20)}
    few = next(columns for columns, count in shown.items() if count >= config.patient_start_depths)
    fewer = max(columns for columns, count in shown.items() if count < config.patient_start_depths)
    assert shown[few] < config.min_start_depths
    for columns, begins in ((few, True), (fewer, False)):
        slam = RgbdSlam(clip.camera)
        states = [process(slam, columns, step / 4).state for step in range(7)]
        early, late = states[: round(4 * config.start_patience)], states[round(4 * config.start_patience) :]
        assert set(early) == {TrackingState.INITIALISING}
        assert (TrackingState.INITIALISING not in late) == begins


def test_losing_and_finding_are_said_once_each_with_reasons(covered: tuple[RgbdSlam, list[TrackedFrame]]) -> None:
    slam, tracked = covered
    lost = [event for event in slam.events if event.kind is EventKind.LOST]
    found = [event for event in slam.events if event.kind is EventKind.RELOCALISED]
    assert [event.frame for event in lost] == [HIDDEN.start]
    assert "no place in the map matched" in lost[0].reason
    assert "keypoints" in lost[0].reason
    assert len(found) == 1
    assert HIDDEN.stop <= found[0].frame <= HIDDEN.stop + 2
    assert int(found[0].reason.split()[0]) >= TrackingConfig().min_recovery_inliers
    assert [event.frame for event in slam.events] == sorted(event.frame for event in slam.events)
    assert all("\n" not in event.reason for event in slam.events)
    for frame in tracked[HIDDEN.start : HIDDEN.stop]:
        assert frame.state is TrackingState.LOST
        assert frame.reason
        assert frame.matches == 0
        assert not frame.is_tracked
        assert frame.keyframe >= 0, "the last known reference"


def test_every_change_of_state_has_its_event_and_no_event_is_without_one(
    covered: tuple[RgbdSlam, list[TrackedFrame]],
) -> None:
    slam, tracked = covered
    changed = [now.index for before, now in pairwise(tracked) if now.state is not before.state]
    said = [event.frame for event in slam.events if event.kind not in (EventKind.INITIALISED, EventKind.LOOP)]
    assert sorted(set(said)) == changed


def test_few_matches_are_weak_and_said_so(clip: Clip) -> None:
    config = SlamConfig(tracking=TrackingConfig(weak_inliers=100_000))
    slam = RgbdSlam(clip.camera, config)
    tracked = run(slam, list(clip)[:8])
    assert [frame.state for frame in tracked] == [TrackingState.TRACKING] + [TrackingState.WEAK] * 7
    assert all(frame.is_tracked and frame.reason.endswith("map points matched") for frame in tracked[1:])
    assert [event.kind for event in slam.events] == [EventKind.INITIALISED, EventKind.WEAK]


def test_poses_after_the_hand_are_those_without_it(
    covered: tuple[RgbdSlam, list[TrackedFrame]], plain: tuple[RgbdSlam, list[TrackedFrame], list[int]]
) -> None:
    slam, _ = covered
    times, poses = slam.trajectory.world_from_camera(slam.map)
    all_times, all_poses = plain[0].trajectory.world_from_camera(plain[0].map)
    assert len(all_times) == FRAMES
    assert len(times) >= FRAMES - len(HIDDEN) - 2
    expected = all_poses[np.searchsorted(all_times, times - 1e-6)]
    errors = np.array([pose_error(*pair) for pair in zip(poses, expected, strict=True)])
    assert errors[:, 0].max() < 0.03
    assert np.degrees(errors[:, 1].max()) < 1.0


def test_a_gap_in_time_asks_for_more_matches(clip: Clip) -> None:
    """After frames were missing, a view that fits by few points only could be anywhere."""
    needs_all = TrackingConfig(min_recovery_inliers=100_000, coast_seconds=0.0)
    for missing, state in ((3, TrackingState.TRACKING), (8, TrackingState.LOST)):
        slam = RgbdSlam(clip.camera, SlamConfig(tracking=needs_all))
        tracked = run(slam, islice(Disturbed(clip, gap(10, 10 + missing)), 11))
        assert tracked[10].index == 10 + missing
        assert tracked[10].state is state


# Maps that are only read ---------------------------------------------------------------------------------------------


def test_localisation_changes_not_one_byte_and_finds_the_frames_where_they_were(
    clip: Clip, plain: tuple[RgbdSlam, list[TrackedFrame], list[int]]
) -> None:
    mapping = plain[0]
    _, poses = mapping.trajectory.world_from_camera(mapping.map)
    before, version = fingerprint(mapping.map), mapping.map.version
    reading = RgbdSlam(clip.camera, WITHOUT_COASTING, base=mapping.map, grows=False)
    # With a hand over the lens, and upside down for more than the time after which a sub-map would begin.
    strange = [
        replace(frame, index=FRAMES + n, timestamp=5.0 + n / 15, rgb=frame.rgb[::-1].copy(), depth=frame.depth[::-1])
        for n, frame in enumerate(list(clip)[:24])
    ]
    tracked = run(reading, [*Disturbed(clip, hand_over_lens(HIDDEN.start, HIDDEN.stop)), *strange])
    assert reading.map is mapping.map
    assert fingerprint(mapping.map) == before
    assert mapping.map.version == version
    assert not any(frame.is_keyframe for frame in tracked)
    assert {event.kind for event in reading.events} == {EventKind.LOST, EventKind.RELOCALISED}
    found = [frame for frame in tracked[:FRAMES] if frame.is_tracked]
    assert len(found) >= FRAMES - len(HIDDEN) - 4
    assert not any(frame.is_tracked for frame in tracked[FRAMES + 2 :])
    errors = np.array([pose_error(np.asarray(f.world_from_camera), poses[f.index]) for f in found])
    assert np.median(errors[:, 0]) < 0.01
    assert errors[:, 0].max() < 0.03
    assert np.degrees(errors[:, 1].max()) < 1.0
    # What was given frame by frame is what the trajectory holds.
    at, given = reading.trajectory.world_from_camera(reading.map)
    at_once = np.isin(at, [frame.timestamp for frame in found])
    assert at_once.sum() == len(found)
    np.testing.assert_allclose(given[at_once], [frame.world_from_camera for frame in found], atol=1e-9)
    # Others were placed from the frame after them, when the camera was found again.
    assert set(at[~at_once]) <= {frame.timestamp for frame in tracked[HIDDEN.stop : FRAMES]}


def test_a_map_of_nothing_that_is_only_read_stays_empty(clip: Clip) -> None:
    empty = RgbdSlam(clip.camera).map
    slam = RgbdSlam(clip.camera, base=empty, grows=False)
    tracked = run(slam, list(clip)[:3])
    assert empty.keyframe_count == 0
    assert not any(frame.is_tracked for frame in tracked)
    assert all(frame.reason for frame in tracked)


def test_in_a_map_that_grows_the_first_frame_is_looked_for_before_anything_is_added(clip: Clip) -> None:
    mapping = RgbdSlam(clip.camera, WITHOUT_COASTING)
    run(mapping, list(clip)[:24])
    keyframes = mapping.map.keyframe_count
    going_on = RgbdSlam(clip.camera, base=mapping.map)
    later = [replace(frame, index=100 + frame.index) for frame in list(clip)[20:36]]
    tracked = run(going_on, later)
    assert going_on.events[0].kind is EventKind.RELOCALISED
    assert going_on.events[0] == SlamEvent(
        EventKind.RELOCALISED, 120, later[0].timestamp, f"{tracked[0].matches} map points matched"
    )
    assert all(frame.is_tracked for frame in tracked)
    assert mapping.map.keyframe_count > keyframes
    assert set(mapping.map.submaps().tolist()) == {0}
    new = [mapping.map.frame_of(k)[0] for k in range(keyframes, mapping.map.keyframe_count)]
    assert min(new) >= 120


# Carried away ------------------------------------------------------------------------------------------------------


def test_a_view_of_elsewhere_after_a_time_without_one_gets_no_guessed_pose(clip: Clip) -> None:
    """A hand over the lens while the camera is carried into another room: where it is now is not where it was going."""
    slam = RgbdSlam(clip.camera)
    frames = list(clip)[:20]
    run_up = [slam.process(frame) for frame in frames]
    assert run_up[-1].is_tracked
    last = frames[-1]
    dark = np.zeros_like(last.rgb)
    count = 10  # a third of a second: coasting goes on for half a one
    for k in range(1, count + 1):
        hidden = RgbdFrame(last.index + k, last.timestamp + k / 30, dark, np.zeros_like(last.depth))
        slam.process(hidden)
    random = np.random.default_rng(3)
    wall = np.kron(random.integers(0, 255, (30, 40, 3)), np.ones((24, 24, 1))).astype(np.uint8)
    height, width = last.depth.shape
    elsewhere = RgbdFrame(
        last.index + count + 1,
        last.timestamp + (count + 1) / 30,
        np.ascontiguousarray(wall[:height, :width]),
        np.full((height, width), 1.7, np.float32),
    )
    tracked = slam.process(elsewhere)
    assert tracked.world_from_camera is None
    assert tracked.state is TrackingState.LOST


def test_a_pose_to_which_the_camera_cannot_have_come_is_not_taken(
    clip: Clip, plain: tuple[RgbdSlam, list[TrackedFrame], list[int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before fronts all alike, points that look the same may hold a pose one front beside."""
    best, calls = LocalSearch.best, iter(range(10**6))

    def beside(search: LocalSearch, *asked: Any, **more: Any) -> Search | None:
        found = best(search, *asked, **more)
        if found is None or next(calls) != 6:
            return found
        pose = found.estimate.camera_from_world.copy()
        pose[0, 3] += 1.0
        return replace(found, estimate=replace(found.estimate, camera_from_world=pose))

    monkeypatch.setattr(LocalSearch, "best", beside)
    tracked = run(RgbdSlam(clip.camera), islice(clip, 20))
    assert next(calls) > 7, "no pose was put beside: the test tests nothing"
    for one, other in zip(tracked, plain[1][:20], strict=True):
        assert one.world_from_camera is not None
        assert other.world_from_camera is not None
        assert pose_error(one.world_from_camera, other.world_from_camera)[0] < 0.05


def test_a_camera_whose_motion_is_not_known_yet_may_have_come_anywhere(clip: Clip) -> None:
    """Of one on a car the second frame is metres away; from the third on its speed is known."""
    slam = RgbdSlam(clip.camera)
    for frame in islice(clip, 4):
        slam.process(frame)
    tracker = slam._tracker
    last = tracker._where.last
    assert last is not None
    pose, soon = last.camera_from_world(slam.map), last.timestamp + 0.03
    far = pose.copy()
    far[0, 3] += 1.0
    assert tracker._guesser.can_have_come(last, pose, soon, None)
    assert not tracker._guesser.can_have_come(last, far, soon, None)
    assert tracker._guesser.can_have_come(last, far, soon + 1.0, None), "in a second"
    tracker._where.motion.forget()
    assert tracker._guesser.can_have_come(last, far, soon, None)
    assert not tracker._guesser.can_have_come(last, far, soon, pose), "frames since were coasted over"
    assert tracker._guesser.can_have_come(last, far, soon + 1.0, pose), "for a second, in which it may have gone"
    assert not tracker._guesser.can_have_come(last, far, soon + 1.0, pose, is_told=True), "it was seen not to go"
