import numpy as np
import pytest
from loop_scenes import KEYFRAMES_A_ROUND, Walk, World, around
from slam_scenes import check_graph, pose_error, rigid

from lpslam.camera import inverse_transform
from lpslam.slam.advice import KeyframeMap, Recalled
from lpslam.slam.integrity import refuse_broken_columns
from lpslam.slam.places.loop_closing import LoopEvent
from lpslam.slam.state import EventKind

DRIFT = 0.003


def walk_round(walk: Walk, rounds: float = 1.2) -> list[LoopEvent]:
    """Walk around and look for loops at every keyframe."""
    angles = np.arange(int(rounds * KEYFRAMES_A_ROUND)) * 2 * np.pi / KEYFRAMES_A_ROUND
    events = [walk.closer.process(walk.step(around(angle))) for angle in angles]
    return [event for event in events if event is not None]


def world(seed: int = 0) -> World:
    return World.of(np.random.default_rng(seed))


def assert_sound(walk: Walk) -> None:
    check_graph(walk.map)
    refuse_broken_columns(walk.map.to_arrays())


def test_a_loop_is_closed_and_the_drift_goes() -> None:
    open_walk = Walk(world(), 1, DRIFT)
    open_walk.closer.process = lambda keyframe: None  # type: ignore[method-assign]
    walk_round(open_walk)
    walk = Walk(world(), 1, DRIFT)
    events = walk_round(walk)
    assert [event.kind for event in events] == [EventKind.LOOP]
    event = events[0]
    assert event.keyframe >= KEYFRAMES_A_ROUND - 2
    assert abs(event.keyframe - KEYFRAMES_A_ROUND - event.candidate) <= 4, "the place is another one"
    assert event.inliers >= 50
    assert open_walk.errors()[event.keyframe] > 0.05
    # The correction that is told is the drift that there was.
    assert event.metres == pytest.approx(open_walk.errors()[event.keyframe], abs=0.02)
    assert walk.errors()[event.keyframe] < 0.01
    assert walk.errors()[: event.keyframe].max() < 0.5 * open_walk.errors().max()
    assert walk.map.loop_edges
    assert_sound(walk)


def test_the_seam_is_sewn() -> None:
    walk = Walk(world(), 2, DRIFT)
    (event,) = walk_round(walk)
    # Both sides look at the same wall: a third of what either sees must be the same points now.
    assert event.candidate in walk.map.covisible(event.keyframe, 100)
    for keyframe in (event.keyframe - 1, event.keyframe - 2):
        assert (walk.map.covisible(keyframe, 60) < 10).any(), f"keyframe {keyframe} sees no points of the old side"


def test_the_first_keyframe_holds_the_frame() -> None:
    walk = Walk(world(), 3, DRIFT)
    walk_round(walk)
    np.testing.assert_array_equal(walk.map.camera_from_world(0), walk.truth[0])


def test_the_same_walk_gives_the_same_map_to_the_bit() -> None:
    one, other = (Walk(world(), 4, DRIFT) for _ in range(2))
    assert walk_round(one) == walk_round(other)
    second = other.map.to_arrays()
    for name, array in one.map.to_arrays().items():
        np.testing.assert_array_equal(array, second[name], err_msg=name)


@pytest.mark.parametrize("seed", range(3))
def test_a_wall_that_looks_the_same_elsewhere_closes_nothing(seed: int) -> None:
    twins = world(seed).with_twin_sector(at=0.5, twin=3.5, width=1.8)
    walk = Walk(twins, seed, DRIFT)
    assert walk_round(walk, rounds=0.9) == []
    assert walk.closer.counts.rejected["more than drift"] > 0, "the twins were never mistaken: the test tests nothing"
    assert not walk.map.loop_edges


def test_a_true_loop_is_closed_beside_twins() -> None:
    walk = Walk(world(5).with_twin_sector(at=0.5, twin=3.5, width=1.8), 5, DRIFT)
    events = walk_round(walk)
    assert len(events) == 1
    assert walk.errors()[events[0].keyframe] < 0.015


class _Guide:
    """Proposes the keyframe one round before, and vetoes on demand."""

    def __init__(self, veto: str | None) -> None:
        self.veto = veto

    def propose(self, keyframes: KeyframeMap, keyframe: int) -> list[Recalled]:
        return [Recalled(each) for each in (keyframe - KEYFRAMES_A_ROUND, -5, 10_000)]

    def vetoes(
        self, keyframes: KeyframeMap, keyframe: int, candidate: int, camera_from_world: np.ndarray
    ) -> str | None:
        return self.veto


def test_a_veto_is_final() -> None:
    walk = Walk(world(), 1, DRIFT, _Guide("the signs there say something else"))
    assert walk_round(walk) == []
    assert walk.closer.counts.rejected["the signs there say something else"] > 0


def test_a_proposal_is_enough_where_looks_say_nothing() -> None:
    walk = Walk(world(), 1, DRIFT, _Guide(None))
    # Nothing looks like anything: every view scores nought but for itself.
    walk.places.query_keyframe = (  # type: ignore[method-assign]
        lambda keyframe, eligible=None: np.zeros(keyframe + 1, np.float32)
    )
    events = walk_round(walk)
    assert len(events) == 1
    assert events[0].keyframe - events[0].candidate == KEYFRAMES_A_ROUND


class _Told(_Guide):
    """Says where the camera is, off by a little, among places that all look alike."""

    def __init__(self, walk: "Walk | None" = None, off: float = 0.05) -> None:
        super().__init__(None)
        self.walk, self.off = walk, off

    def propose(self, keyframes: KeyframeMap, keyframe: int) -> list[Recalled]:
        old = keyframe - KEYFRAMES_A_ROUND
        if old < 0 or self.walk is None:
            return []
        relative = self.walk.truth[keyframe] @ inverse_transform(self.walk.truth[old])
        guess = rigid([self.off, 0.0, 0.0], [0, 0, 0]) @ relative @ self.walk.map.camera_from_world(old)
        return [Recalled(old, guess)]


@pytest.mark.parametrize("is_told", [True, False])
def test_where_everything_looks_alike_a_loop_closes_where_something_else_tells_it(is_told: bool) -> None:
    guide = _Told()
    walk = Walk(world(), 1, DRIFT, guide)
    guide.walk = walk if is_told else None
    walk.closer._locator._agrees = lambda features, alike, pose: np.zeros(len(alike.keypoints), np.bool_)  # type: ignore[method-assign]
    events = walk_round(walk)
    assert len(events) == int(is_told)
    if is_told:
        assert walk.errors()[events[0].keyframe] < 0.015


def test_interrupted_nothing_is_changed() -> None:
    walk = Walk(world(), 1, DRIFT)
    walk.closer.interrupt()
    assert walk_round(walk) == []
    assert not walk.map.loop_edges
    assert walk.map.version == 0


@pytest.mark.parametrize("home", [0, 1])
def test_submaps_are_merged_in_the_frame_of_home(home: int) -> None:
    walk = Walk(world(), 6, 0.0003)
    walk.map.home = home
    angles = np.arange(30) * 2 * np.pi / KEYFRAMES_A_ROUND
    events = [walk.closer.process(walk.step(around(angle))) for angle in angles]
    # Carried elsewhere, the camera wakes up where nothing is known, and walks back into what is.
    moved = rigid([5, 1, -2], [0.4, -1.0, 0.3])
    back = [around(-angle) for angle in np.arange(18, -8, -1) * 2 * np.pi / KEYFRAMES_A_ROUND]
    new_root = walk.step(back[0], anew_at=back[0] @ moved)
    events.append(walk.closer.process(new_root))
    assert not walk.map.is_home(new_root) or home == 1
    before = walk.map.camera_from_world(0 if home == 0 else new_root).copy()
    events += [walk.closer.process(walk.step(pose)) for pose in back[1:]]
    merges = [event for event in events if event is not None and event.kind is EventKind.MERGE]
    assert len(merges) == 1
    assert set(walk.map.submaps().tolist()) == {home}
    assert walk.map.home == home
    np.testing.assert_allclose(walk.map.camera_from_world(0 if home == 0 else new_root), before, atol=0.01)
    frame_from_true = walk.map.world_from_keyframe(0) @ walk.truth[0]
    for keyframe, true in enumerate(walk.truth):
        metres, radians = pose_error(walk.map.camera_from_world(keyframe) @ frame_from_true, true)
        assert metres < 0.03, f"keyframe {keyframe}"
        assert radians < 0.02
    assert walk.map.parents()[new_root] >= 0
    assert (walk.map.parents() < 0).sum() == 1
    assert_sound(walk)


def test_removed_keyframes_leave_the_index() -> None:
    walk = Walk(world(), 7, DRIFT)
    for angle in np.arange(6) * 0.15:
        walk.closer.process(walk.step(around(angle)))
    walk.map.remove_keyframe(2)
    walk.closer.process(walk.step(around(1.0)))
    assert 2 not in walk.places
    assert len(walk.places) == 6
    assert walk.closer.process(2) is None


def test_texts_seen_from_a_removed_keyframe_follow_the_loop() -> None:
    walk = Walk(world(), 8, DRIFT)
    angles = np.arange(int(1.3 * KEYFRAMES_A_ROUND)) * 2 * np.pi / KEYFRAMES_A_ROUND
    for angle in angles[:36]:
        walk.closer.process(walk.step(around(angle)))
    walk.map.remove_keyframe(30)
    relative = walk.map.camera_from_world(30) @ walk.map.world_from_keyframe(29)
    for angle in angles[36:]:
        walk.closer.process(walk.step(around(angle)))
    assert walk.map.loop_edges
    after = walk.map.camera_from_world(30) @ inverse_transform(walk.map.camera_from_world(29))
    np.testing.assert_allclose(after, relative, atol=1e-9)
    assert_sound(walk)


def test_parts_that_saw_the_same_place_are_joined_when_the_recording_ends() -> None:
    """No keyframe found the other part when it was new: then only the end can join them."""
    walk = Walk(world(), 6, 0.0003)
    for angle in np.arange(30) * 2 * np.pi / KEYFRAMES_A_ROUND:
        walk.closer.process(walk.step(around(angle)))
    moved = rigid([5, 1, -2], [0.4, -1.0, 0.3])
    back = [around(-angle) for angle in np.arange(4, -8, -1) * 2 * np.pi / KEYFRAMES_A_ROUND]
    for number, pose in enumerate(back):
        keyframe = walk.step(pose, anew_at=pose @ moved if number == 0 else None)
        walk.closer._index(keyframe)
    assert len(set(walk.map.submaps().tolist())) == 2
    assert [event.kind for event in walk.closer.join_parts()] == [EventKind.MERGE]
    assert len(set(walk.map.submaps().tolist())) == 1
    assert walk.closer.join_parts() == []
    frame_from_true = walk.map.world_from_keyframe(0) @ walk.truth[0]
    for keyframe, true in enumerate(walk.truth):
        metres, _ = pose_error(walk.map.camera_from_world(keyframe) @ frame_from_true, true)
        assert metres < 0.03, f"keyframe {keyframe}"
    assert_sound(walk)


def test_parts_that_share_nothing_stay_apart() -> None:
    walk = Walk(world(), 6, 0.0003)
    for angle in np.arange(8) * 2 * np.pi / KEYFRAMES_A_ROUND:
        walk.closer.process(walk.step(around(angle)))
    far = [around(angle) for angle in np.arange(20, 28) * 2 * np.pi / KEYFRAMES_A_ROUND]
    for number, pose in enumerate(far):
        walk.closer._index(walk.step(pose, anew_at=pose if number == 0 else None))
    assert walk.closer.join_parts() == []
    assert len(set(walk.map.submaps().tolist())) == 2
