"""What a session tells, once each: landmarks that are new or have another name, events, readings."""

import threading
from collections import deque
from collections.abc import Callable, Iterable

from lpslam.slam.state import SlamEvent
from lpslam.text.types import FrameReading, Landmark

Landmarks = tuple[Landmark, ...]
Events = tuple[SlamEvent, ...]


class News:
    """Collects what is new in whatever thread finds it, until it is taken.

    Args:
        on_landmark: called by `tell` for every new or renamed landmark.
        on_event: the same for events.

    Attributes:
        readings: that nobody took yet; the newest.
    """

    def __init__(self, on_landmark: Callable[[Landmark], None], on_event: Callable[[SlamEvent], None]) -> None:
        self.readings: deque[FrameReading] = deque(maxlen=_MOST_READINGS)
        self._on_landmark, self._on_event = on_landmark, on_event
        self._lock = threading.Lock()
        self._changed: dict[int, tuple[Landmark, bool]] = {}
        self._told: dict[int, str] = {}
        self._events_told = 0

    def begin(self, known: Iterable[Landmark]) -> None:
        """These are no news."""
        self._told = {mark.id: mark.name for mark in known}

    def note(self, marks: Iterable[Landmark]) -> None:
        """Find out which landmarks, of all, are new or have another name."""
        with self._lock:
            for mark in marks:
                if self._told.get(mark.id) != mark.name:
                    is_new = mark.id not in self._told or self._changed.get(mark.id, (mark, False))[1]
                    self._changed[mark.id] = (mark, is_new)
                    self._told[mark.id] = mark.name

    def take(self, events: list[SlamEvent]) -> tuple[Landmarks, Landmarks, Events, tuple[FrameReading, ...]]:
        """New landmarks, renamed ones, events of all that there were, and readings, each if nobody was told yet."""
        if not self._changed and not self.readings and len(events) == self._events_told:
            return (), (), (), ()
        return (*self._take_landmarks(), self._take_events(events), self._take_readings())

    def tell(self, new: Landmarks, renamed: Landmarks, events: Events) -> None:
        """Call whoever wants to hear of it."""
        for mark in (*new, *renamed):
            self._on_landmark(mark)
        for event in events:
            self._on_event(event)

    def _take_landmarks(self) -> tuple[Landmarks, Landmarks]:
        if not self._changed:
            return (), ()
        with self._lock:
            changed, self._changed = self._changed, {}
        new = tuple(mark for mark, is_new in changed.values() if is_new)
        return new, tuple(mark for mark, is_new in changed.values() if not is_new)

    def _take_events(self, events: list[SlamEvent]) -> Events:
        if len(events) == self._events_told:
            return ()
        fresh = tuple(events[self._events_told :])
        self._events_told += len(fresh)
        return fresh

    def _take_readings(self) -> tuple[FrameReading, ...]:
        fresh = []
        while self.readings:
            fresh.append(self.readings.popleft())
        return tuple(fresh)


_MOST_READINGS = 16
"""Readings that wait for a step; more come only where nobody steps any more."""
