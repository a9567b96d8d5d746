"""How often something is done."""


class Pace:
    """Says when something is due again, by whatever clock it is asked with."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._next = float("-inf")

    def is_due(self, timestamp: float) -> bool:
        """Whether so many seconds have gone since this was true last."""
        if timestamp < self._next:
            return False
        self._next = timestamp + self._seconds
        return True
