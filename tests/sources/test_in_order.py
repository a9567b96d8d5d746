from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.camera import PinholeCamera
from lpslam.config import TimesConfig
from lpslam.errors import UserError
from lpslam.frames import FrameFault, FrameSource, RgbdFrame
from lpslam.sources.in_order import InOrder
from lpslam.sources.prefetch import Prefetched

CAMERA = PinholeCamera(4, 3, 4.0, 4.0, 1.5, 1.0)


class Listed:
    """Frames with the given times; None is one that cannot be decoded."""

    name, camera = "listed", CAMERA

    def __init__(
        self,
        times: list[float | None],
        shapes: dict[int, tuple[int, int]] | None = None,
        shown: dict[int, int] | None = None,
    ) -> None:
        self._times, self._shapes, self._shown = times, shapes or {}, shown or {}
        self.faults: list[FrameFault] = []

    def __len__(self) -> int:
        return len(self._times)

    def __iter__(self) -> Iterator[RgbdFrame]:
        self.faults = []
        for index, time in enumerate(self._times):
            if time is None:
                self.faults.append(FrameFault(index, 0.0, "damaged"))
                continue
            shape = self._shapes.get(index, (3, 4))
            rgb = np.full((3, 4, 3), self._shown.get(index, index), np.uint8)
            rgb[0, 0, 0] += 1
            yield RgbdFrame(index, time, rgb, np.ones(shape, np.float32))


def test_frames_that_come_late_or_twice_are_faults_beside_the_sources_own() -> None:
    source = InOrder(Listed([0.0, 0.1, 0.3, 0.2, None, 0.3, float("nan"), float("inf"), 0.4]))
    assert isinstance(source, FrameSource)
    for _ in range(2):
        assert [frame.index for frame in source] == [0, 1, 2, 8]
        assert len(source) == 9
        assert [(fault.index, fault.reason) for fault in source.faults] == [
            (3, "it comes 0.100 s too late: a frame of 0.300000 s was there before"),
            (4, "damaged"),
            (5, "it repeats the time 0.300000 s of the frame before"),
            (6, "its time is nan"),
            (7, "its time is inf"),
        ]
    assert (source.name, source.camera) == ("listed", CAMERA)


@pytest.mark.parametrize("where", [0, 1, 3, 4, 5])
def test_one_time_far_ahead_is_one_fault_and_not_the_end(where: int) -> None:
    times: list[float | None] = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5]
    times[where] = 1e6
    source = InOrder(Listed(times))
    assert [frame.index for frame in source] == [number for number in range(6) if number != where]
    assert [fault.index for fault in source.faults] == [where]
    told = "ahead of the frame after it" if where < 5 else "none follows that confirms it"
    assert told in source.faults[0].reason


def test_pauses_are_no_leaps() -> None:
    source = InOrder(Listed([5.0, 5.1, 100.0, 100.1, float("nan"), 200.0, 300.0, 305.0]))
    assert [frame.index for frame in source] == [0, 1, 2, 3, 5, 6, 7]
    assert [fault.index for fault in source.faults] == [4]


@pytest.mark.parametrize("wrong", [(1e6, 1e9), (1e9, 1e6), (1e6, 50.0)])
def test_two_wrong_times_in_a_row_cost_two_frames(wrong: tuple[float, float]) -> None:
    source = InOrder(Listed([0.0, 0.1, 0.2, *wrong, 0.5, 0.6, 0.7]))
    assert [frame.index for frame in source] == [0, 1, 2, 5, 6, 7]
    assert [fault.index for fault in source.faults] == [3, 4]


def test_what_counts_as_a_leap_and_as_hanging_is_configured() -> None:
    times: list[float | None] = [0.0, 0.1, 0.2, 6.0, 0.3, 0.4]
    used = [frame.index for frame in InOrder(Listed(times), TimesConfig(recorded_leap_s=10.0))]
    assert used == [0, 1, 2, 3]
    assert [frame.index for frame in InOrder(Listed(times[:3], shown={2: 1}), TimesConfig(repeats=0))] == [0, 1]
    last = InOrder(Listed([0.0, 0.1, 0.2, 6.0]), TimesConfig(last_leap_s=5.0))
    assert [frame.index for frame in last] == [0, 1, 2]


def test_a_late_frame_tells_nothing_of_one_that_leaps() -> None:
    source = InOrder(Listed([0.0, 0.1, 0.2, 1e6, 0.1, 0.3, 0.4]))
    assert [frame.index for frame in source] == [0, 1, 2, 5, 6]
    assert sorted(fault.index for fault in source.faults) == [3, 4]


@given(st.lists(st.floats(0.02, 0.5), min_size=5, max_size=40), st.data())
def test_any_single_time_may_be_wrong_by_any_amount(steps: list[float], data: st.DataObject) -> None:
    """One frame is lost, and those that it came after: at most what lies within a second."""
    times: list[float | None] = list(np.cumsum(steps))
    where = data.draw(st.integers(0, len(times) - 1))
    times[where] = data.draw(st.floats(-1e12, 1e12))
    used = [frame.index for frame in InOrder(Listed(times))]
    near = sum(time is not None and abs(time - (times[where] or 0.0)) <= 1.0 for time in times)
    assert len(used) >= len(times) - max(near, 1)


def test_a_misshapen_frame_is_a_fault() -> None:
    source = InOrder(Listed([0.0, 0.1, 0.2], {1: (6, 8)}))
    assert [frame.index for frame in source] == [0, 2]
    assert [fault.reason for fault in source.faults] == ["its depth is 8×6; the camera is 4×3"]


def test_a_picture_that_is_repeated_again_and_again_is_a_camera_that_hangs() -> None:
    source = InOrder(Listed([0.0, 0.1, 0.2, 0.3, 0.4, 0.5], shown={2: 1, 3: 1, 4: 1}))
    assert [frame.index for frame in source] == [0, 1, 2, 5]
    assert [fault.reason for fault in source.faults] == [
        f"its colour repeats the frames before, byte for byte, {times} times: the camera hangs" for times in (2, 3)
    ]


def test_a_picture_that_is_repeated_once_in_a_while_is_of_a_camera_that_is_slow() -> None:
    """One frame in six of a real recording."""
    source = InOrder(InOrder(Listed([0.1 * n for n in range(12)], shown={3: 2, 6: 5, 8: 7, 11: 10})))
    assert [frame.index for frame in source] == list(range(12))
    assert source.faults == []


@pytest.mark.parametrize("colour", [(0, 0, 0), (200, 0, 0)])
def test_a_covered_lens_is_not_held_to_hang(colour: tuple[int, int, int]) -> None:
    class Black(Listed):
        def __iter__(self) -> Iterator[RgbdFrame]:
            for frame in super().__iter__():
                yield replace(frame, rgb=np.zeros_like(frame.rgb) + np.array(colour, np.uint8))

    assert len(list(InOrder(Black([0.0, 0.1, 0.2])))) == 3


def test_good_frames_pass_untouched_and_prefetched_alike() -> None:
    times: list[float | None] = [0.0, 0.1, 0.2]
    assert [frame.timestamp for frame in Prefetched(InOrder(Listed(times)))] == times
    assert InOrder(Listed(times)).faults == []


def test_no_usable_frame_is_one_line() -> None:
    with pytest.raises(UserError, match="listed: none of its 2 frames can be used; the first: its time is nan"):
        list(InOrder(Listed([float("nan"), float("nan")])))
    assert list(InOrder(Listed([]))) == []
