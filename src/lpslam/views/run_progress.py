"""What the terminal shows while a run goes on, and how Ctrl-C ends it without losing the map."""

import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from lpslam.views.printed import write_line

if TYPE_CHECKING:
    from lpslam.pipeline import Progress as RunState
    from lpslam.slam.state import TrackedFrame

_COMPILED_AFTER = 3.0
"""Seconds: loading kernels from the cache is quicker, compiling them is slower."""


_LINE_EVERY = 10.0
"""Seconds between two lines where there is no terminal."""


class RunProgress:
    """A bar with frames a second, tracking state, keyframes and landmarks; on standard error, only in a terminal.

    Args:
        total: frames that will come; 0 where that is not known.

    Attributes:
        first_untracked: the first frame without a pose, which says why; None while there is none.
    """

    def __init__(self, total: int, quiet: bool = False) -> None:
        self._bar = Progress(
            TextColumn("{task.fields[state]}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            disable=quiet or not sys.stderr.isatty(),
        )
        self._task = self._bar.add_task("frames", total=total or None, state="starting", rate="")
        self.first_untracked: TrackedFrame | None = None
        self._total = total
        # A pipe gets a line now and then in place of the bar.
        self._next_line = time.monotonic() + _LINE_EVERY if self._bar.disable and not quiet else math.inf

    def update(self, progress: "RunState") -> None:
        """Show where the run stands."""
        frame, first = progress.frame, self.first_untracked
        # A frame that was coasted over may have a pose in the end; one that is lost has none.
        if (first is None and frame.is_coasted) or ((first is None or first.is_coasted) and not frame.is_tracked):
            self.first_untracked = frame
        if (now := time.monotonic()) >= self._next_line:
            self._next_line = now + _LINE_EVERY
            of = f" of {self._total}" if self._total else ""
            line = f"{progress.frames}{of} frames{_dropped(progress)}, {progress.keyframes} keyframes"
            write_line(f"lpslam: {line}, {progress.landmarks} texts, {frame.state}")
        self._bar.update(
            self._task,
            completed=progress.frames,
            state=progress.frame.state,
            rate=f"{progress.frames_per_second:.1f} frames/s{_dropped(progress)}, {progress.keyframes} keyframes, "
            f"{progress.landmarks} landmarks",
        )

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()


def _dropped(progress: "RunState") -> str:
    return f", {progress.dropped} dropped" if progress.dropped else ""


class InterruptFlag:
    """Turns the first Ctrl-C (or a polite kill) into a flag; the second one acts as ever.

    What whoever started the process lets be ignored stays ignored: a shell's Ctrl-C is not for what runs behind it.
    """

    def __init__(self) -> None:
        self._flag = threading.Event()
        self._handlers: dict[int, object] = {}
        self.is_set = self._flag.is_set

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._flag.set()
        self._restore()

    def _restore(self) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, handler)  # type: ignore[arg-type]

    def __enter__(self) -> Self:
        for number in (signal.SIGINT, signal.SIGTERM):
            if signal.getsignal(number) is not signal.SIG_IGN:
                self._handlers[number] = signal.signal(number, self._note)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._restore()


def prepare() -> None:
    """Give OpenCV one thread and have every kernel compiled, saying so when it takes long."""
    import cv2

    from lpslam.kernel_cache import is_kept
    from lpslam.slam.warm_up import warm_up

    is_compiling = False

    def announce(line: str) -> None:
        nonlocal is_compiling
        is_compiling = True
        # Where kernels cannot be kept, that was said, and what it costs.
        if is_kept():
            write_line(f"lpslam: {line}")

    cv2.setNumThreads(1)
    seconds = warm_up(announce)
    # Loading them may take as long where the machine is busy.
    if is_compiling and seconds > _COMPILED_AFTER:
        announce(f"kernels compiled in {seconds:.0f} s and kept for the next start")


@contextmanager
def counting(first_state: str, quiet: bool = False) -> Iterator[Callable[[int, int], None]]:
    """A bar for work that reports (done, total); a line now and then where there is no terminal."""
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        disable=quiet or not sys.stderr.isatty(),
    )
    next_line = time.monotonic() + _LINE_EVERY if bar.disable and not quiet else math.inf

    def update(done: int, total: int) -> None:
        nonlocal next_line
        if (now := time.monotonic()) >= next_line:
            next_line = now + _LINE_EVERY
            write_line(f"lpslam: {first_state}, {done}{f' of {total}' if total else ''} frames")
        bar.update(task, completed=done, total=total or None, description="frames")

    with bar:
        task = bar.add_task(first_state, total=None)
        yield update


@contextmanager
def saying_what_is_compiled() -> Iterator[None]:
    """Say so, once, if kernels are compiled meanwhile: the first time takes seconds."""
    from numba.core import event

    from lpslam.slam.warm_up import FirstCompiled

    with event.install_listener("numba:compile", FirstCompiled(lambda line: write_line(f"lpslam: {line}"))):
        yield
