"""A map that grows one frame at a time."""

import asyncio
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lpslam
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.mapfile.language_map import LanguageMap
from lpslam.session import listeners
from lpslam.sources.open import open_source
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.spotting_process import SpottingProcess

FRAMES = 30


@pytest.fixture(scope="module")
def camera(walk: Path) -> lpslam.PinholeCamera:
    return open_source(walk).camera


@pytest.fixture(scope="module")
def frames(walk: Path) -> list[RgbdFrame]:
    """Decoded once, and not to be written to."""
    decoded = list(open_source(walk, max_frames=FRAMES))
    for frame in decoded:
        frame.rgb.flags.writeable = frame.depth.flags.writeable = False
    return decoded


@pytest.fixture
def session(camera: lpslam.PinholeCamera) -> Iterator[lpslam.Session]:
    opened = lpslam.Session(camera, text=False)
    yield opened
    opened.close()


def names(world: LanguageMap) -> list[tuple[int, str]]:
    return [(mark.id, mark.name) for mark in world.landmarks()]


@pytest.mark.slow
def test_frame_by_frame_is_the_map_of_a_run(camera: lpslam.PinholeCamera, frames: list[RgbdFrame], begun: Path) -> None:
    told: dict[int, str] = {}
    events = []
    marks: list[lpslam.Landmark] = []
    before = LanguageMap.load(begun)
    with lpslam.Session(camera, on_landmark=marks.append, on_event=events.append) as session:
        for frame in frames[: len(before.trajectory)]:
            step = session.step(frame.rgb, frame.depth, frame.timestamp)
            told |= {mark.id: mark.name for mark in (*step.new_landmarks, *step.renamed_landmarks)}
            assert told == {mark.id: mark.name for mark in marks}
            assert step.pose is not None
            assert session.pose is step.pose
        world = session.close()
    assert np.array_equal(world.frame_poses().world_from_camera, before.frame_poses().world_from_camera)
    assert names(world) == names(before) != []
    assert told, "landmarks are told of as they come"
    # What only the last sightings tell is told at the end.
    assert {mark.id: mark.name for mark in marks}.items() >= {mark.id: mark.name for mark in world.landmarks()}.items()
    assert events == world.events != []


@pytest.mark.slow
@pytest.mark.parametrize("live", [False, True])
def test_it_answers_from_another_thread_while_it_maps(
    camera: lpslam.PinholeCamera, frames: list[RgbdFrame], live: bool
) -> None:
    failures: list[BaseException] = []
    snapshots: list[LanguageMap] = []
    over = threading.Event()
    with lpslam.Session(camera, sequential=False, live=live) as session:

        def asking() -> None:
            try:
                while not over.wait(0.05):
                    session.ask("Where can I eat pizza?")
                    snapshots.append(session.snapshot())
            except BaseException as error:
                failures.append(error)

        thread = threading.Thread(target=asking)
        thread.start()
        for frame in frames[:14]:
            session.step(frame.rgb, frame.depth, frame.timestamp)
        over.set()
        thread.join()
    assert not failures
    assert snapshots
    assert len(session.close().trajectory) == 14


def test_a_live_session_looks_again_before_its_reader_ends_unless_in_a_hurry(
    camera: lpslam.PinholeCamera, frames: list[RgbdFrame], monkeypatch: pytest.MonkeyPatch
) -> None:
    readers: list[bool] = []
    monkeypatch.setattr(SpottingProcess, "_end", lambda self: readers.append(False))
    monkeypatch.setattr(SpottingProcess, "_start", lambda self: readers.append(True))
    monkeypatch.setattr(TextMapper, "wants", lambda self, frame, tracked: False)
    monkeypatch.setattr(TextMapper, "look_again", lambda self, poses: looked.append(readers[-1]))
    for hurry, expected in ((False, [True]), (True, [])):
        looked: list[bool] = []
        session = lpslam.Session(camera, live=True)
        session.step(frames[0].rgb, frames[0].depth, frames[0].timestamp)
        session.close(hurry=hurry)
        assert looked == expected
        assert readers[-1] is False


def test_a_snapshot_stays_as_it_was(session: lpslam.Session, frames: list[RgbdFrame], tmp_path: Path) -> None:
    for frame in frames[:10]:
        session.step(frame.rgb, frame.depth, frame.timestamp)
    snapshot = session.snapshot()
    poses = snapshot.frame_poses().world_from_camera.copy()
    for frame in frames[10:20]:
        session.step(frame.rgb, frame.depth, frame.timestamp)
    assert len(session.close().trajectory) == 20
    assert np.array_equal(snapshot.frame_poses().world_from_camera, poses)
    snapshot.save(tmp_path / "ten.lpmap")
    assert len(LanguageMap.load(tmp_path / "ten.lpmap").trajectory) == 10
    assert len(session.snapshot().trajectory) == 20


def _changed(frame: RgbdFrame, **changes: Any) -> tuple[Any, Any, float]:
    given = {"rgb": frame.rgb, "depth": frame.depth, "timestamp": frame.timestamp, **changes}
    return given["rgb"], given["depth"], given["timestamp"]


@pytest.mark.parametrize(
    ("wrong", "remedy"),
    [
        ({"rgb": lambda rgb: rgb[..., 0]}, "grey; give three channels: cv2.cvtColor"),
        ({"rgb": lambda rgb: rgb[..., :1]}, "grey; give three channels"),
        ({"rgb": lambda rgb: np.dstack([rgb, rgb[..., :1]])}, "four channels; give red, green, blue"),
        ({"rgb": lambda rgb: rgb / 255.0}, "float64; give uint8 from 0 to 255"),
        ({"rgb": lambda rgb: rgb[::2]}, "colour image is 640×240; the camera is 640×480"),
        ({"rgb": lambda rgb: rgb.transpose(2, 0, 1)}, r"has shape \(3, 480, 640\); give \(height, width, 3\)"),
        ({"rgb": lambda rgb: rgb.tolist()}, "is a list; give a numpy array"),
        ({"depth": lambda depth: (depth * 5000).astype(np.uint16)}, "uint16; give metres: depth.astype"),
        ({"depth": lambda depth: depth * 1000}, "give metres: depth / 1000"),
        ({"depth": lambda depth: depth[:, ::2]}, "depth image is 320×480"),
        ({"depth": lambda depth: depth[..., None]}, r"shape \(480, 640, 1\); give \(height, width\)"),
        ({"depth": lambda depth: None}, "is a NoneType"),
        ({"timestamp": lambda timestamp: np.nan}, "time of the frame is nan; give seconds"),
    ],
)
def test_a_frame_that_is_none_is_told_with_the_remedy(
    session: lpslam.Session, frames: list[RgbdFrame], wrong: dict[str, Callable[[Any], Any]], remedy: str
) -> None:
    ((name, change),) = wrong.items()
    with pytest.raises(lpslam.UserError, match=remedy):
        session.step(*_changed(frames[0], **{name: change(getattr(frames[0], name))}))
    assert session.frames == 0
    session.step(*_changed(frames[0]))


def test_a_clock_that_goes_backwards_is_told_and_the_session_goes_on(
    session: lpslam.Session, frames: list[RgbdFrame]
) -> None:
    session.step(*_changed(frames[1]))
    for frame in (frames[0], frames[1]):
        with pytest.raises(lpslam.UserError, match="give the frames in order"):
            session.step(*_changed(frame))
    assert session.step(*_changed(frames[2])).index == 1


def test_depth_that_is_not_finite_is_no_depth(session: lpslam.Session, frames: list[RgbdFrame]) -> None:
    depth = frames[0].depth.astype(np.float64)
    depth[depth == 0] = np.nan
    depth[0, :3] = np.inf, -np.inf, -1.0
    assert session.step(*_changed(frames[0], depth=depth)).pose is not None
    assert session.step(*_changed(frames[1])).pose is not None


def test_a_closed_session_takes_nothing(session: lpslam.Session, frames: list[RgbdFrame]) -> None:
    session.step(*_changed(frames[0]))
    assert session.close() is session.close()
    with pytest.raises(lpslam.UserError, match="closed: it takes no more frames"):
        session.step(*_changed(frames[1]))


def test_an_error_ends_its_threads_and_leaves_no_map(camera: lpslam.PinholeCamera, frames: list[RgbdFrame]) -> None:
    before = threading.active_count()
    session = lpslam.Session(camera, live=True, text=False)

    def fail() -> None:
        with session:
            session.step(*_changed(frames[0]))
            raise RuntimeError("power")

    with pytest.raises(RuntimeError, match="power"):
        fail()
    assert threading.active_count() == before
    with pytest.raises(lpslam.UserError, match="given up after an error"):
        session.close()


def test_steps_are_iterated_over_in_an_event_loop(session: lpslam.Session, frames: list[RgbdFrame]) -> None:
    def feed() -> None:
        for frame in frames[:5]:
            session.step(*_changed(frame))
        session.close()

    async def follow() -> list[int]:
        steps = aiter(session)
        feeding = asyncio.get_running_loop().run_in_executor(None, feed)
        seen = [step.index async for step in steps]
        await feeding
        return seen + [step.index async for step in session]

    assert asyncio.run(follow()) == [0, 1, 2, 3, 4]


def test_a_map_is_continued(camera: lpslam.PinholeCamera, world: LanguageMap, frames: list[RgbdFrame]) -> None:
    count, known = len(world.trajectory), world.landmarks()
    with lpslam.Session(camera, base=world, text=False) as session:
        later = [session.step(f.rgb, f.depth, f.timestamp + 1000.0) for f in frames[:5]]
    assert later[0].index >= count
    assert len(session.close().trajectory) == count + 5
    assert {mark.id for mark in session.landmarks()} >= {mark.id for mark in known}


@pytest.mark.parametrize(
    "timestamp", [None, "now", np.array([1.0]), np.array([1.0, 2.0]), 1j, np.datetime64("2024-01-01"), 10**400, [1]]
)
def test_a_time_that_is_no_number_is_told(session: lpslam.Session, frames: list[RgbdFrame], timestamp: object) -> None:
    with pytest.raises(UserError, match="give seconds"):
        session.step(frames[0].rgb, frames[0].depth, timestamp)  # type: ignore[arg-type]
    assert session.step(frames[0].rgb, frames[0].depth, 0).timestamp == 0.0
    assert session.frames == 1


def steps_at(session: lpslam.Session, frames: list[RgbdFrame], times: list[float]) -> list[lpslam.Step]:
    return [session.step(frame.rgb, frame.depth, time) for frame, time in zip(frames[: len(times)], times, strict=True)]


@pytest.mark.parametrize("wrong", [1e9, 100.0])
def test_one_time_far_ahead_costs_one_frame(session: lpslam.Session, frames: list[RgbdFrame], wrong: float) -> None:
    steps = steps_at(session, frames, [0.0, 0.1, wrong, 0.3, 0.4])
    assert [step.pose is not None for step in steps] == [True, True, False, True, True]
    assert "it waits for the next one to confirm that" in steps[2].reason
    assert [step.index for step in steps] == [0, 1, 2, 2, 3]
    world = session.close()
    assert world.frame_poses().timestamps.tolist() == [0.0, 0.1, 0.3, 0.4]
    assert world.statistics["run"]["frames_skipped"] == 1


def test_a_pause_costs_nothing(session: lpslam.Session, frames: list[RgbdFrame]) -> None:
    heard: list[lpslam.Step] = []
    session._listeners.tell = heard.append  # type: ignore[method-assign]
    steps = steps_at(session, frames, [0.0, 0.1, 7200.0, 7200.1, 7200.2])
    assert [step.pose is not None for step in steps] == [True, True, False, True, True]
    assert [step.index for step in heard] == [0, 1, 2, 3, 4]
    assert session.close().frame_poses().timestamps.tolist() == [0.0, 0.1, 7200.0, 7200.1, 7200.2]


def test_a_slow_camera_waits_once(session: lpslam.Session, frames: list[RgbdFrame]) -> None:
    steps = steps_at(session, frames, [0.0, 30.0, 61.0, 89.0, 120.0])
    assert [step.pose is not None for step in steps] == [True, False, True, True, True]


def test_a_first_time_that_is_wrong_is_told_with_the_remedy(session: lpslam.Session, frames: list[RgbdFrame]) -> None:
    session.step(frames[0].rgb, frames[0].depth, 1e9)
    with pytest.raises(UserError, match="open another session if the first one's time was wrong"):
        session.step(frames[1].rgb, frames[1].depth, 0.1)


def test_a_closed_session_lets_no_frame_wait(session: lpslam.Session, frames: list[RgbdFrame]) -> None:
    session.step(frames[0].rgb, frames[0].depth, 0.0)
    session.close()
    with pytest.raises(UserError, match="the session is closed"):
        session.step(frames[1].rgb, frames[1].depth, 1e9)


def test_depth_that_is_masked_or_beyond_single_precision_is_no_depth(
    session: lpslam.Session, frames: list[RgbdFrame]
) -> None:
    shape = frames[0].depth.shape
    for number, depth in enumerate((np.ma.masked_array(np.full(shape, 2.0), mask=True), np.full(shape, 1e300))):
        session.step(frames[0].rgb, depth, float(number))
    assert session.keyframes == 0


def test_two_threads_do_not_step_at_once(camera: lpslam.PinholeCamera, frames: list[RgbdFrame]) -> None:
    session = lpslam.Session(camera, text=False)
    taken: list[bool] = []
    refused: list[bool] = []

    def steps() -> None:
        for frame in frames:
            before = len(taken)
            with suppress(UserError):
                session.step(frame.rgb, frame.depth, time.perf_counter())
                taken.append(True)
            refused.append(len(taken) == before)

    threads = [threading.Thread(target=steps) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert any(refused)
    assert session.frames == len(taken) == session.close().trajectory.tracked_count


def test_a_callback_can_neither_step_nor_close(camera: lpslam.PinholeCamera, frames: list[RgbdFrame]) -> None:
    refused: list[str] = []

    def again(_: object) -> None:
        for attempt in (lambda: session.step(frames[0].rgb, frames[0].depth, 1e6), session.close):
            with pytest.raises(UserError, match="a frame is being taken") as caught:
                attempt()
            refused.append(str(caught.value))

    session = lpslam.Session(camera, text=False, on_event=again)
    for number, frame in enumerate([*frames[:3], *[replace(frames[0], rgb=frames[0].rgb * 0)] * 40]):
        session.step(frame.rgb, frame.depth if number < 3 else frame.depth * 0, number / 15)
    assert refused
    assert session.close().trajectory.tracked_count >= 3


def test_who_dropped_the_iterator_or_does_not_keep_up_fills_no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listeners, "_MOST_WAITING", 5)

    async def listening() -> list[int]:
        told = listeners.Listeners()
        slow = told.listen()
        dropped = [told.listen() for _ in range(3)]
        assert len(told._iterators) == 4
        dropped.clear()
        assert len(told._iterators) == 1
        for number in range(20):
            told.tell(number)  # type: ignore[arg-type]
        told.tell(None)
        await asyncio.sleep(0)
        return [step async for step in slow]  # type: ignore[misc]

    assert asyncio.run(listening()) == [16, 17, 18, 19]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"width": "a"}, "width is a"),
        ({"width": 160.5}, "no size in whole pixels"),
        ({"width": 10**400}, "width is 1"),
        ({"width": 10**9, "height": 10**9}, "more than any camera has"),
        ({"fx": None}, "fx is None"),
        ({"fx": 1e300}, "which no camera has"),
        ({"cx": -1e300}, "cx is -1e"),
        ({"depth_scale": 1e-300}, "which no camera has"),
        ({"distortion": ("a", 0, 0, 0, 0)}, "distortion is"),
    ],
)
def test_a_camera_that_cannot_be_is_told(camera: lpslam.PinholeCamera, change: dict[str, Any], said: str) -> None:
    with pytest.raises(UserError, match=said):
        replace(camera, **change)


def test_what_is_no_camera_is_told() -> None:
    with pytest.raises(UserError, match="the camera is a NoneType"):
        lpslam.Session(None)  # type: ignore[arg-type]
