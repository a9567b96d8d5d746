"""Times that leap ahead, which the frame after them confirms or not."""

import math
from typing import Generic, TypeVar

Item = TypeVar("Item")


class Leaps(Generic[Item]):
    """Holds back what leaps ahead in time until the next one tells whether its time was true.

    One corrupt stamp would else make everything after it come too late. A time that leaps is true if the next one
    follows it about as closely; so after a pause one frame waits for the next, and a slow camera's are not held.

    Args:
        seconds: a frame that lies farther ahead of the one before waits, ...
        slower: ... unless it does by no more than so many times the gap before.
        latest: the time before the first; without, the first waits too.

    Attributes:
        held: what waits, with its time.
    """

    def __init__(self, seconds: float, slower: float, latest: float = -math.inf) -> None:
        self._seconds = seconds
        self._slower = slower
        self._latest = latest
        self._gap = 0.0
        self.held: tuple[float, Item] | None = None

    @property
    def ahead(self) -> float:
        """Seconds by which what is held lies ahead of what was before it."""
        return self.held[0] - self._latest if self.held is not None else 0.0

    def take(self, time: float, item: Item) -> tuple[list[Item], Item | None]:
        """What may be used now, in order, and what was held and turned out to have a wrong time.

        Args:
            time: finite, seconds.
            item: is given back at once if it comes late, whatever is held: it tells nothing of that.
        """
        if time <= self._latest:
            return [item], None
        if self.held is None and time - self._latest <= self._seconds:
            self._pass(time)
            return [item], None
        ready: list[Item] = []
        wrong: Item | None = None
        if self.held is not None:
            held_time, held = self.held
            if -self._seconds <= time - held_time <= max(self._seconds, self._slower * self.ahead):
                ready.append(held)
                self._pass(held_time)
            else:
                wrong = held
            self.held = None
        if time - self._latest > max(self._seconds, self._slower * self._gap):
            self.held = time, item
        else:
            ready.append(item)
            self._pass(time)
        return ready, wrong

    def _pass(self, time: float) -> None:
        if time > self._latest:
            self._gap = time - self._latest if math.isfinite(self._latest) else 0.0
            self._latest = time
