"""Maps in pieces: what is mapped after tracking was lost for long, and which piece is home."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from disturbances import WITHOUT_COASTING, Clip, Disturbed, blank_wall, hand_over_lens
from slam_scenes import SENSOR, add_view, check_graph, descriptors_of, points_ahead, pose_error, rigid, view_of

from lpslam.camera import inverse_transform
from lpslam.config import LevellingConfig, SlamConfig, TextConfig, TrackingConfig
from lpslam.frames import RgbdFrame
from lpslam.mapfile.language_map import LanguageMap
from lpslam.slam.map import SlamMap
from lpslam.slam.state import EventKind, TrackedFrame, TrackingState
from lpslam.slam.system import RgbdSlam
from lpslam.slam.trajectory import Trajectory
from lpslam.text.text_map import TextMap

# A walk ------------------------------------------------------------------------------------------------------------

LOST_AT_ONCE = SlamConfig(tracking=TrackingConfig(coast_seconds=0.0, backtracked_seconds=0.0))
"""Nothing is passed over, and nothing gets a place later."""

LEFT, HIDDEN, ARRIVED = 20, 3, 70  # frames before the hand, behind it, and the one after it in the recording
LAST = 108  # of the recording
SOON = TrackingConfig(submap_after=0.2, coast_seconds=0.0)


@dataclass(frozen=True)
class Story:
    """A camera that is carried to another place behind a hand, and every frame as it was tracked."""

    clip: Clip
    slam: RgbdSlam
    tracked: list[TrackedFrame]

    @property
    def away(self) -> list[TrackedFrame]:
        """Frames that were tracked in the second sub-map."""
        submaps = self.slam.map.submaps()
        return [frame for frame in self.tracked if frame.is_tracked and submaps[frame.keyframe] == 1]


def carried_away(clip: Clip, first: int = 0, config: SlamConfig | None = None, hidden: int = HIDDEN) -> Story:
    """`first` is the recording's frame at which the story begins."""

    def disturbance(frames: Iterator[RgbdFrame]) -> Iterator[RgbdFrame]:
        taken = [frame for frame in frames if first <= frame.index < LEFT or ARRIVED <= frame.index < LAST]
        return hand_over_lens(LEFT - first, LEFT - first + hidden)(iter(taken))

    slam = RgbdSlam(clip.camera, config or LOST_AT_ONCE)
    tracked = [slam.process(frame) for frame in Disturbed(clip, disturbance)]
    return Story(clip, slam, tracked)


@pytest.fixture(scope="module")
def clip(walk: Path) -> Clip:
    return Clip(walk, range(LAST))


@pytest.fixture(scope="module")
def story(clip: Clip) -> Story:
    return carried_away(clip)


@pytest.mark.slow
def test_unknown_views_begin_a_submap_after_a_while_and_not_before(story: Story) -> None:
    after = TrackingConfig().submap_after
    begun = [event for event in story.slam.events if event.kind is EventKind.NEW_SUBMAP]
    assert len(begun) == 1
    assert set(story.slam.map.submaps().tolist()) == {0, 1}
    root = next(frame for frame in story.tracked if frame.is_keyframe and frame.index >= ARRIVED)
    assert (begun[0].frame, begun[0].timestamp) == (root.index, root.timestamp)
    assert begun[0].reason.startswith(f"unknown for {after:g} s (")
    # The hand has no depth: only from the first usable view on is it counted.
    usable = next(f for f in story.tracked if f.index >= ARRIVED + HIDDEN)
    assert after <= root.timestamp - usable.timestamp <= after + 1.5 / 15
    waiting = [frame for frame in story.tracked if LEFT <= frame.index < root.index]
    assert all(frame.state is TrackingState.LOST and not frame.is_tracked for frame in waiting)
    assert story.slam.map.is_root(root.keyframe)
    check_graph(story.slam.map)


@pytest.mark.slow
def test_where_a_submap_begins_is_known_unless_the_camera_was_blind(clip: Clip, story: Story) -> None:
    assert story.slam.map.beginnings == {}
    seeing = carried_away(clip, hidden=0)
    slam, last = seeing.slam, seeing.tracked[LEFT - 1].timestamp
    begun = next(event for event in slam.events if event.kind is EventKind.NEW_SUBMAP)
    root = int(np.flatnonzero(slam.map.submaps() == 1)[0])
    [(first, beginning)] = slam.map.beginnings.items()
    assert first == root
    assert slam.map.submaps()[beginning.keyframe] == 0
    assert beginning.metres == pytest.approx(TrackingConfig().carried_speed * (begun.timestamp - last), rel=0.05)


@pytest.mark.slow
def test_frames_in_a_submap_have_a_pose_there_but_none_in_the_map(story: Story) -> None:
    assert len(story.away) >= 15
    for frame in story.away:
        assert frame.world_from_camera is None
        assert frame.keyframe_from_camera is not None
        assert "in a sub-map not joined to the map yet" in frame.reason
        assert frame.state is not TrackingState.LOST
    at_home = [frame for frame in story.tracked if frame.is_tracked and story.slam.map.submaps()[frame.keyframe] == 0]
    assert len(at_home) == LEFT
    assert all(frame.world_from_camera is not None and frame.reason == "" for frame in at_home)


@pytest.mark.slow
def test_a_submap_is_as_accurate_as_a_map(story: Story) -> None:
    first, last = story.away[0], story.away[-1]
    poses = [
        story.slam.map.world_from_keyframe(frame.keyframe) @ np.asarray(frame.keyframe_from_camera)
        for frame in (first, last)
    ]
    truth = story.clip.truth.world_from_camera
    moved, should = (
        inverse_transform(a) @ b for a, b in ((poses[0], poses[1]), (truth[first.index], truth[last.index]))
    )
    assert np.linalg.norm(should[:3, 3]) > 0.5
    metres, radians = pose_error(moved, should)
    assert metres < 0.02
    assert np.degrees(radians) < 0.5


@pytest.mark.slow
def test_no_point_is_seen_from_two_submaps(story: Story) -> None:
    m, submaps = story.slam.map.columns, story.slam.map.submaps()
    for keyframe in story.slam.map.living_keyframes().tolist():
        slot = m.keyframe_slot[keyframe]
        seen = m.point[slot][m.point[slot] >= 0]
        assert (submaps[m.first_keyframe[seen]] == submaps[keyframe]).all()


@pytest.mark.slow
def test_the_trajectory_leaves_out_what_is_not_home_and_the_largest_submap_becomes_home(story: Story) -> None:
    slam_map, trajectory = story.slam.map, story.slam.trajectory
    both = LEFT + len(story.away)
    assert trajectory.tracked_count == both
    times, _ = trajectory.world_from_camera(slam_map)
    np.testing.assert_allclose(times, [frame.timestamp for frame in story.tracked[:LEFT]])
    living = slam_map.submaps()[slam_map.living_keyframes()]
    sizes = np.bincount(living)
    story.slam.finish()
    try:
        assert slam_map.home == int(sizes.argmax())
        times, _ = trajectory.world_from_camera(slam_map)
        assert len(times) == (LEFT if slam_map.home == 0 else both - LEFT)
        slam_map.home = 1
        times, poses = trajectory.world_from_camera(slam_map)
        np.testing.assert_allclose(times, [frame.timestamp for frame in story.away])
        expected = [slam_map.world_from_keyframe(f.keyframe) @ np.asarray(f.keyframe_from_camera) for f in story.away]
        np.testing.assert_allclose(poses, expected, atol=1e-12)
    finally:
        slam_map.home = 0


@pytest.mark.slow
def test_a_longer_stay_in_the_second_place_makes_it_home(clip: Clip) -> None:
    story = carried_away(
        clip,
        first=LEFT - 2,
        config=SlamConfig(tracking=TrackingConfig(submap_after=0.2, coast_seconds=0.0, backtracked_seconds=0.0)),
    )
    assert story.slam.map.home == 0
    story.slam.finish()
    assert story.slam.map.home == 1
    times, poses = story.slam.trajectory.world_from_camera(story.slam.map)
    np.testing.assert_allclose(times, [frame.timestamp for frame in story.away])
    assert len(times) > 20
    # The camera is held upright there too.
    assert (poses[:, 2, 1] < -0.8).all()


@pytest.mark.slow
def test_a_submap_is_levelled_by_the_floor_that_is_seen_there(clip: Clip, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the first place has had all views of the floor that it needs."""
    tilt = np.radians(10.0)
    up = np.array([0.0, -np.cos(tilt), -np.sin(tilt)])
    monkeypatch.setattr("lpslam.slam.system.floor_normal", lambda *_: up)
    config = SlamConfig(
        tracking=TrackingConfig(submap_after=0.2, coast_seconds=0.0), levelling=LevellingConfig(max_views=1)
    )
    story = carried_away(clip, first=LEFT - 2, config=config)
    story.slam.finish()
    assert story.slam.map.home == 1
    root = next(k for k in range(story.slam.map.keyframe_count) if story.slam.map.is_home(k))
    np.testing.assert_allclose(story.slam.map.world_from_keyframe(root)[:3, :3] @ up, [0.0, 0.0, 1.0], atol=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["wall", "dark", "hand"])
def test_views_of_nothing_never_begin_a_submap(clip: Clip, kind: str) -> None:
    frames = list(clip)
    seconds = 3 * TrackingConfig().submap_after
    nothing = range(8, 8 + round(15 * seconds))
    if kind == "dark":
        rest = [replace(frame, rgb=np.full_like(frame.rgb, 12)) for frame in frames[8 : nothing.stop]]
        source: Iterator[RgbdFrame] = iter([*frames[:8], *rest])
    else:
        disturbance = (blank_wall if kind == "wall" else hand_over_lens)(nothing.start, nothing.stop)
        source = iter(Disturbed(clip, lambda given: disturbance(f for f in given if f.index < nothing.stop)))
    slam = RgbdSlam(clip.camera, WITHOUT_COASTING)
    tracked = [slam.process(frame) for frame in source]
    assert {frame.state for frame in tracked[9:]} == {TrackingState.LOST}
    assert set(slam.map.submaps().tolist()) == {0}
    assert EventKind.NEW_SUBMAP not in [event.kind for event in slam.events]


@pytest.mark.slow
def test_submaps_home_events_and_sessions_are_kept_in_the_file(story: Story, tmp_path: Path) -> None:
    slam = story.slam
    trajectory = Trajectory.from_arrays(slam.trajectory.to_arrays())
    following = trajectory.begin_session()
    trajectory.append(replace(story.tracked[0], index=following))
    world = LanguageMap(story.clip.camera, SlamMap.from_arrays(slam.map.to_arrays()), trajectory, TextMap(TextConfig()))
    world.events = slam.events
    for home in (0, 1):
        world.slam.home = home
        world.save(tmp_path / "map.lpmap")
        again = LanguageMap.load(tmp_path / "map.lpmap")
        assert again.slam.home == home
        np.testing.assert_array_equal(again.slam.submaps(), slam.map.submaps())
        assert again.events == slam.events
        assert {type(event.kind) for event in again.events} == {EventKind}
        assert again.trajectory.session == 1
        assert (again.trajectory.frame_count, again.trajectory.tracked_count) == (1, 1)
        for session in (0, 1, None):
            kept, given = (t.trajectory.world_from_camera(t.slam, session) for t in (again, world))
            np.testing.assert_array_equal(kept[0], given[0])
            np.testing.assert_array_equal(kept[1], given[1])
        assert len(again.keyframe_poses()) == int((slam.map.submaps()[slam.map.living_keyframes()] == home).sum())
        np.testing.assert_array_equal(again.cloud(), world.cloud())
    assert world.world_from_keyframe(0) is None, "what is not at home has no pose in the map"


# Made-up maps ------------------------------------------------------------------------------------------------------


def pieces(*sizes: int) -> SlamMap:
    """Sub-maps of so many keyframes, each keyframe with ten points of its own."""
    random = np.random.default_rng(1)
    slam_map = SlamMap(10, SENSOR.scales)
    for size in sizes:
        for number in range(size):
            points = points_ahead(random, 10)
            parent = slam_map.keyframe_count - 1 if number else -1
            add_view(slam_map, np.eye(4), view_of(np.eye(4), points, descriptors_of(random, 10)), parent)
            slam_map.add_points(slam_map.keyframe_count - 1, np.arange(10, dtype=np.int32), points)
    return slam_map


@pytest.mark.parametrize(("sizes", "home"), [((3,), 0), ((2, 5, 4), 1), ((4, 4), 0), ((1, 3, 3), 1), ((1, 1, 9), 2)])
def test_the_largest_submap_is_home_and_the_oldest_of_equals(sizes: tuple[int, ...], home: int) -> None:
    slam_map = pieces(*sizes)
    slam_map.settle()
    assert slam_map.home == home
    at_home = np.repeat(np.arange(len(sizes)), sizes) == home
    assert [slam_map.is_home(k) for k in range(sum(sizes))] == at_home.tolist()
    assert len(slam_map.point_positions()) == 10 * sizes[home]


def test_keyframes_that_are_gone_do_not_count() -> None:
    slam_map = pieces(5, 3)
    for keyframe in (1, 2, 4):
        slam_map.remove_keyframe(keyframe)
    slam_map.settle()
    assert slam_map.home == 1


def test_an_empty_map_settles() -> None:
    slam_map = pieces()
    slam_map.settle()
    assert slam_map.home == 0


def test_turning_one_submap_leaves_the_other_where_it_was() -> None:
    slam_map = pieces(3, 3)
    before = slam_map.to_arrays()
    turned = rigid([1, 2, 3], [0.1, 0.2, 0.3])
    slam_map.transform(turned, submap=1)
    after = slam_map.to_arrays()
    for name in ("camera_from_world", "position", "normal"):
        half = len(before[name]) // 2
        np.testing.assert_array_equal(after[name][:half], before[name][:half])
        assert np.abs(after[name][half:] - before[name][half:]).max() > 0.05
    np.testing.assert_allclose(slam_map.world_from_keyframe(4), turned, atol=1e-12)


# Sessions ----------------------------------------------------------------------------------------------------------


def frame(index: int, keyframe: int, keyframe_from_camera: np.ndarray | None) -> TrackedFrame:
    state = TrackingState.LOST if keyframe_from_camera is None else TrackingState.TRACKING
    return TrackedFrame(index, index / 10, state, keyframe, keyframe_from_camera, None, 9, False)


def test_each_recording_is_a_session_with_times_of_its_own() -> None:
    slam_map = pieces(4)
    slam_map.columns.camera_from_world[3] = inverse_transform(rigid([0, 0, 5], [0, 0, 0]))
    trajectory = Trajectory()
    assert trajectory.begin_session() == 0, "an empty trajectory has all indices free"
    trajectory = Trajectory()
    for index in range(6):
        trajectory.append(frame(index, 0, rigid([index, 0, 0], [0, 0, 0]) if index != 2 else None))
    free = trajectory.begin_session()
    assert free == 6
    # The same times again, by another keyframe.
    trajectory.append(replace(frame(free, 3, rigid([0, 7, 0], [0, 0, 0])), timestamp=0.0))
    trajectory.append(replace(frame(free + 1, 3, None), timestamp=0.1))
    trajectory.append(replace(frame(free + 2, 3, rigid([0, 9, 0], [0, 0, 0])), timestamp=0.2))
    assert (len(trajectory), trajectory.frame_count, trajectory.tracked_count) == (9, 3, 2)
    times, poses = trajectory.world_from_camera(slam_map, 0)
    np.testing.assert_allclose(times, [0.0, 0.1, 0.3, 0.4, 0.5])
    np.testing.assert_allclose(poses[:, :3, 3], [[x, 0, 0] for x in (0, 1, 3, 4, 5)])
    for session in (1, None):
        times, poses = trajectory.world_from_camera(slam_map, session)
        np.testing.assert_allclose(times, [0.0, 0.2])
        np.testing.assert_allclose(poses[:, :3, 3], [[0, 7, 5], [0, 9, 5]])
    assert len(trajectory.world_from_camera(slam_map, 2)[0]) == 0
    again = Trajectory.from_arrays(trajectory.to_arrays())
    assert again.session == 1
    assert again.begin_session() == free + 3
    assert (again.frame_count, again.tracked_count) == (0, 0)


def test_a_corrected_keyframe_takes_the_frames_of_every_session_along() -> None:
    slam_map, trajectory = pieces(3), Trajectory()
    trajectory.append(frame(0, 2, rigid([1, 0, 0], [0, 0, 0])))
    trajectory.begin_session()
    trajectory.append(frame(1, 2, rigid([2, 0, 0], [0, 0, 0])))
    correction = rigid([0.3, -0.1, 0.2], [0, 0.4, 0])
    before = [trajectory.world_from_camera(slam_map, session)[1] for session in (0, 1)]
    slam_map.columns.camera_from_world[2] = slam_map.columns.camera_from_world[2] @ inverse_transform(correction)
    for session in (0, 1):
        _, poses = trajectory.world_from_camera(slam_map, session)
        np.testing.assert_allclose(poses, correction @ before[session], atol=1e-12)
