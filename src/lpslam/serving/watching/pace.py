"""How often something may be done that costs processor time."""

import time
from types import TracebackType


class Pace:
    """Lets something be done at most every so many seconds, and at most for a share of one core.

    Do it in a `with` block, which measures the thread's processor time.

    Args:
        least: seconds between two times.
        share: of the time that goes by, 0 to 1.
    """

    def __init__(self, least: float, share: float) -> None:
        self._least, self._share = least, share
        self._began = self._next = 0.0

    def is_due(self, *, hurried: bool = True) -> bool:
        """Whether it may be done now; without hurry it waits five times as long."""
        now = time.monotonic()
        return now >= self._next + (0.0 if hurried else 4.0 * self._least)

    def __enter__(self) -> None:
        self._began = time.thread_time()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        spent = time.thread_time() - self._began
        self._next = time.monotonic() + max(self._least, spent / self._share)
