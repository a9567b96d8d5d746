"""How often each client may come: a bucket of tokens that fills steadily."""

import time
from collections import OrderedDict
from collections.abc import Callable


class Rates:
    """Buckets by client.

    Args:
        rate: that a bucket gains a second.
        burst: that it holds.
        clients: whose buckets are kept; the one that was silent longest goes first.
        clock: seconds.
    """

    def __init__(self, rate: float, burst: float, clients: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._rate, self._burst, self._clients, self._clock = rate, max(burst, 1.0), clients, clock
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()

    def wait(self, client: str, cost: float = 1.0) -> float:
        """Take from a client's bucket.

        Returns:
            Seconds until it may come again; 0 where it may now.
        """
        now = self._clock()
        level, seen = self._buckets.pop(client, (self._burst, now))
        level = min(self._burst, level + (now - seen) * self._rate)
        is_free = level >= min(cost, self._burst)
        self._buckets[client] = (level - cost if is_free else level, now)
        if len(self._buckets) > self._clients:
            self._buckets.popitem(last=False)
        return 0.0 if is_free else (cost - level) / self._rate

    def level(self, client: str) -> float:
        """What a client's bucket holds."""
        level, seen = self._buckets.get(client, (self._burst, self._clock()))
        return min(self._burst, level + (self._clock() - seen) * self._rate)
