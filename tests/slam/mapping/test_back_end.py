"""Mapping and loop closing in step and beside tracking, with mappers that are slow, that hang and that fail."""

import threading
import time
from collections.abc import Callable
from typing import cast

import pytest

from lpslam.slam.mapping.back_end import Beside, InStep
from lpslam.slam.mapping.local_mapping import LocalMapper


class Mapper:
    """Keeps the keyframes it got, in order; works on each for `seconds` in slices, less when told to hurry."""

    def __init__(self, seconds: float = 0.0, fail_at: int | None = None) -> None:
        self.seconds, self.fail_at = seconds, fail_at
        self.done: list[int] = []
        self.threads: set[str] = set()
        self.hurried = 0
        self.began = threading.Event()
        self._stop = False

    def process(self, keyframe: int) -> None:
        self._stop = False
        self.began.set()
        self.threads.add(threading.current_thread().name)
        if keyframe == self.fail_at:
            raise ArithmeticError(f"keyframe {keyframe} is singular")
        until = time.monotonic() + self.seconds
        while time.monotonic() < until and not self._stop:
            time.sleep(0.002)
        self.done.append(keyframe)

    def hurry(self) -> None:
        self.hurried += 1
        self._stop = True


def local_mapper(mapper: Mapper) -> LocalMapper:
    return cast("LocalMapper", mapper)


def ignore(*_: object) -> None:
    """For loop closers that find nothing and interruptions that are not needed."""


def beside(
    mapper: Mapper, close_loops: Callable[[int], None] = ignore, interrupt: Callable[[], None] = ignore
) -> Beside:
    return Beside(local_mapper(mapper), close_loops, interrupt)


def wait_for(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 5
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.002)
    assert condition()


def seconds_of(work: Callable[[], None]) -> float:
    started = time.monotonic()
    work()
    return time.monotonic() - started


def test_in_step_a_keyframe_is_mapped_and_then_looked_up_before_take_returns() -> None:
    mapper, closed = Mapper(), list[tuple[int, list[int]]]()
    back_end = InStep(local_mapper(mapper), lambda keyframe: closed.append((keyframe, mapper.done.copy())))
    for keyframe in (0, 1, 2):
        back_end.take(keyframe)
        assert closed[-1] == (keyframe, list(range(keyframe + 1)))
    assert mapper.threads == {threading.current_thread().name}
    back_end.finish()


def test_in_step_an_error_is_the_callers() -> None:
    with pytest.raises(ArithmeticError, match="keyframe 1"):
        InStep(local_mapper(Mapper(fail_at=1)), ignore).take(1)


def test_beside_the_order_is_kept_and_nothing_is_left_out() -> None:
    mapper, closed = Mapper(0.004), list[tuple[int, int]]()
    back_end = beside(mapper, lambda keyframe: closed.append((keyframe, len(mapper.done))))
    for keyframe in range(60):
        back_end.take(keyframe)
    back_end.finish()
    assert mapper.done == list(range(60))
    assert [keyframe for keyframe, _ in closed] == list(range(60))
    assert all(mapped > keyframe for keyframe, mapped in closed), "loops are looked for in what has been mapped"
    assert mapper.threads == {"local mapping"}


def test_beside_take_does_not_wait() -> None:
    mapper = Mapper(0.5)
    back_end = beside(mapper)
    assert seconds_of(lambda: [back_end.take(keyframe) for keyframe in range(4)] and None) < 0.25
    assert mapper.hurried > 0, "an adjustment ends early when another keyframe waits behind it"
    back_end.finish()


def test_an_adjustment_is_left_in_peace_while_nothing_waits() -> None:
    mapper = Mapper(0.1)
    back_end = beside(mapper)
    back_end.take(0)
    wait_for(lambda: mapper.done == [0])
    assert mapper.hurried == 0
    back_end.finish()


def test_finish_abandons_what_takes_too_long_within_two_seconds() -> None:
    mapper = Mapper(1000.0)
    back_end = beside(mapper)
    for keyframe in range(5):
        back_end.take(keyframe)
    # Taking hurries the first ones; only the last is left to work for long.
    assert seconds_of(back_end.finish) < 2.0
    left = mapper.done.copy()
    time.sleep(0.1)
    assert mapper.done == left, "nothing of the map is touched any more"
    assert not [thread for thread in threading.enumerate() if thread.name in ("local mapping", "loop closing")]


def test_finish_interrupts_a_loop_correction_that_takes_too_long() -> None:
    stop, corrected = threading.Event(), list[int]()

    def correct(keyframe: int) -> None:
        stop.wait(60)
        corrected.append(keyframe)

    back_end = beside(Mapper(), correct, stop.set)
    for keyframe in range(3):
        back_end.take(keyframe)
    assert seconds_of(back_end.finish) < 2.0
    assert corrected == [0], "the queue behind it is abandoned"


def test_finish_returns_even_if_mapping_never_listens() -> None:
    released = threading.Event()

    class Deaf(Mapper):
        def process(self, keyframe: int) -> None:
            released.wait(60)

    back_end = beside(Deaf())
    back_end.take(0)
    took = seconds_of(back_end.finish)
    released.set()
    assert took < 2.5


def test_an_error_in_mapping_is_raised_by_the_next_take_and_by_finish() -> None:
    back_end = beside(Mapper(fail_at=2))
    for keyframe in range(3):
        back_end.take(keyframe)
    with pytest.raises(ArithmeticError, match="keyframe 2 is singular"):
        wait_for_error(back_end)
    with pytest.raises(ArithmeticError, match="keyframe 2 is singular"):
        back_end.finish()


def test_an_error_in_loop_closing_is_raised_by_the_next_take_and_by_finish() -> None:
    def fail(keyframe: int) -> None:
        raise ArithmeticError(f"loop {keyframe} cannot be closed")

    back_end = beside(Mapper(), fail)
    back_end.take(0)
    with pytest.raises(ArithmeticError, match="loop 0"):
        wait_for_error(back_end)
    with pytest.raises(ArithmeticError, match="loop 0"):
        back_end.finish()
    assert not [thread for thread in threading.enumerate() if thread.name == "local mapping"]


def wait_for_error(back_end: Beside) -> None:
    """Take keyframes until one is refused; none must be swallowed for long."""
    for keyframe in range(3, 2500):
        back_end.take(keyframe)
        time.sleep(0.002)


def test_beside_is_idle_when_nothing_waits_and_nothing_is_mapped() -> None:
    mapper = Mapper(seconds=0.2)
    back_end = beside(mapper)
    assert back_end.is_idle
    back_end.take(0)
    assert not back_end.is_idle
    assert mapper.began.wait(5)
    assert not back_end.is_idle, "it is still being mapped"
    wait_for(lambda: back_end.is_idle)
    back_end.finish()
    assert mapper.done == [0]
    assert back_end.abandoned == 0


def test_what_finish_leaves_unmapped_is_counted() -> None:
    mapper = Mapper(seconds=0.8)
    back_end = beside(mapper)
    for keyframe in range(6):
        back_end.take(keyframe)
    back_end.finish()
    assert back_end.abandoned == 6 - len(mapper.done) > 0
