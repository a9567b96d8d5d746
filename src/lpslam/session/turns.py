"""One frame at a time: who comes while another is taken is told, and not kept waiting."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from lpslam.errors import UserError


class Turns:
    """Lets one thread in at a time; the context of a step.

    Raises:
        UserError: on entering, another thread has the turn, or this one.
    """

    def __init__(self) -> None:
        self._lock, self._holder = threading.Lock(), 0

    def __enter__(self) -> None:
        if not self._lock.acquire(blocking=False):
            raise UserError("a frame is being taken: step from one thread at a time, and not from a callback")
        self._holder = threading.get_ident()

    def __exit__(self, *raised: object) -> None:
        self._holder = 0
        self._lock.release()

    @contextmanager
    def end(self) -> Iterator[None]:
        """Wait for the turn.

        Raises:
            UserError: this thread has it.
        """
        if self._holder == threading.get_ident():
            raise UserError("a frame is being taken: close the session when its step is done, not from a callback")
        with self._lock:
            yield
