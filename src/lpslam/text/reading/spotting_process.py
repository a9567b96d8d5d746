"""Finding and reading text in a process of its own.

Beside live tracking, a reader that shares the interpreter makes tracking wait whenever it holds the lock and is itself
waiting for a core; a process of its own shares nothing but the cores.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lpslam.config import SpottingConfig
from lpslam.errors import UserError
from lpslam.isolated import can_start, python_command
from lpslam.priority import READING, yield_to_others
from lpslam.text.reading.boxes import Boxes
from lpslam.text.reading.spotting import PaddleSpotter
from lpslam.text.types import Recognition

_SERVE = "from lpslam.text.reading.spotting_process import serve_parent; serve_parent()"
"""What the other process runs."""

_PATIENCE = 2.0
"""Seconds that the process is given to end by itself."""

_MOST_STARTS = 3
"""Times that the process is started before it is given up: it may die of every image."""

_PROVEN = 100
"""Answers after which a process counts as sound, and may be started as often again."""


class SpottingProcess:
    """A `TextSpotter` whose networks run in another process; use it in a `with` block.

    A process that dies is started again for the next image.

    Attributes:
        seconds_elsewhere: of processor time that the processes have read for.

    Raises:
        UserError: on entering, where the models or the engine are not installed.
    """

    def __init__(self, config: SpottingConfig) -> None:
        self._config = config
        self._process: subprocess.Popen[bytes] | None = None
        self._channel: Connection | None = None
        self._starts = self._answers = 0
        # Whoever reads may be at it in a thread of its own while the block is left.
        self._holding, self._is_left = threading.Lock(), False
        self.seconds_elsewhere = 0.0

    @staticmethod
    def is_possible() -> bool:
        """Whether this system can hand a channel to another Python."""
        return os.name == "posix" and can_start()

    def __enter__(self) -> Self:
        self._is_left = False
        self._start()
        return self

    def __exit__(self, *_: object) -> None:
        self._is_left = True
        self._end()

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[Boxes, NDArray[np.float64]]:
        """See `TextSpotter`."""
        boxes, scores = self._asked("detect", rgb, ())
        return boxes, scores

    def recognise(self, rgb: NDArray[np.uint8], boxes: Boxes) -> list[Recognition]:
        """See `TextSpotter`."""
        return list(self._asked("recognise", rgb, (boxes,)))

    def _asked(self, what: str, rgb: NDArray[np.uint8], more: Sequence[Any]) -> Any:
        if self._channel is None:
            self._start()
        channel = self._channel
        if channel is None:
            raise RuntimeError("reading has ended")
        try:
            channel.send((what, rgb.shape, more))
            channel.send_bytes(np.ascontiguousarray(rgb).reshape(-1).data)
            answer, seconds = channel.recv()
        except (EOFError, OSError) as error:
            self._end()
            raise RuntimeError("the process that reads text ended") from error
        self.seconds_elsewhere += seconds
        self._answers += 1
        if self._answers >= _PROVEN:
            self._starts = 1
        if isinstance(answer, Exception):
            raise answer
        return answer

    def _start(self) -> None:
        if self._starts == _MOST_STARTS:
            raise RuntimeError(f"the process that reads text ended {_MOST_STARTS} times")
        with self._holding:
            # Nobody would end a process that starts once the block is left.
            if self._is_left:
                raise RuntimeError("reading has ended")
            self._starts, self._answers = self._starts + 1, 0
            channel, other = Pipe()
            self._channel = channel
            with other:
                self._process = subprocess.Popen(
                    python_command(_SERVE, str(other.fileno())),
                    pass_fds=[other.fileno()],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                )
        try:
            channel.send(self._config)
            answer = channel.recv()
        except (EOFError, OSError) as error:
            self._end()
            raise RuntimeError("the process that reads text did not start") from error
        except BaseException:
            # Broken off while it starts: a block that is not entered is not left either.
            self._end()
            raise
        if isinstance(answer, Exception):
            self._end()
            raise answer

    def _end(self) -> None:
        with self._holding:
            channel, process = self._channel, self._process
            self._channel = self._process = None
        if channel is not None:
            channel.close()
        if process is not None:
            with suppress(subprocess.TimeoutExpired):
                process.wait(_PATIENCE)
            process.kill()
            process.wait()


def serve(channel: Connection) -> None:
    """Answer what the parent asks until it closes its end."""
    config: SpottingConfig = channel.recv()
    try:
        spotter = PaddleSpotter(config)
    except UserError as error:
        channel.send(error)
        return
    channel.send(None)
    ways: dict[str, Callable[..., Any]] = {"detect": spotter.detect, "recognise": spotter.recognise}
    while True:
        what, shape, more = channel.recv()
        rgb = np.frombuffer(channel.recv_bytes(), np.uint8).reshape(shape)
        started = time.process_time()
        answer: Any
        # The parent counts what goes wrong and goes on with the next image.
        try:
            answer = ways[what](rgb, *more)
        except Exception as error:
            answer = RuntimeError(repr(error))
        channel.send((answer, time.process_time() - started))


def serve_parent() -> None:
    """Serve on the channel whose number is this process's argument."""
    # The terminal's interrupt goes to every process; the parent decides when reading ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    yield_to_others(READING)
    with Connection(int(sys.argv[1])) as channel, suppress(EOFError, OSError):
        serve(channel)
