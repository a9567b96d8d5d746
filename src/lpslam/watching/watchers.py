"""Watchers of a run. They see frames and steps, and change nothing: where one fails, mapping goes on without it."""

from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Protocol, Self

from lpslam.frames import RgbdFrame
from lpslam.mapfile.language_map import LanguageMap
from lpslam.session.session import Session
from lpslam.session.step import Step


class Watcher(Protocol):
    """Somebody who writes down what a run does."""

    name: str

    def take(self, frame: RgbdFrame, step: Step, session: Session) -> None:
        """A frame, what it brought, and the session, which may be asked."""
        ...

    def finish(self, world: LanguageMap) -> None:
        """The map that the run made."""
        ...

    def close(self) -> None:
        """Make whole what was written so far; also after an error."""
        ...


class Watchers:
    """Hands a run on to some watchers; one that fails is left out from then on.

    Args:
        watchers: some, perhaps none.
        say: called with a line for each that fails.
    """

    def __init__(self, watchers: Sequence[Watcher], say: Callable[[str], None]) -> None:
        self._watchers, self._say = list(watchers), say

    def take(self, frame: RgbdFrame, step: Step, session: Session) -> None:
        """See `Watcher`."""
        self._each(lambda watcher: watcher.take(frame, step, session))

    def finish(self, world: LanguageMap) -> None:
        """See `Watcher`."""
        self._each(lambda watcher: watcher.finish(world))

    def _each(self, call: Callable[[Watcher], None]) -> None:
        for watcher in list(self._watchers):
            try:
                call(watcher)
            except Exception as error:  # a picture of the run is worth less than the run
                self._watchers.remove(watcher)
                reason = error.strerror if isinstance(error, OSError) else None
                self._say(f"{watcher.name} ends here, mapping goes on: {reason or repr(error)}")
                self._close(watcher)

    def _close(self, watcher: Watcher) -> None:
        try:
            watcher.close()
        except Exception as error:
            self._say(f"{watcher.name} is not whole: {error}")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for watcher in self._watchers:
            self._close(watcher)
        self._watchers.clear()


class Taken:
    """When the latest frames were taken: what is read beside tracking is of frames before the one at hand."""

    def __init__(self) -> None:
        self._times: dict[int, float] = {}

    def note(self, index: int, timestamp: float) -> None:
        """A frame."""
        self._times[index] = timestamp
        if len(self._times) > _KEPT:
            del self._times[next(iter(self._times))]

    def of(self, index: int, otherwise: float) -> float:
        """When a frame was taken; `otherwise` where that is forgotten."""
        return self._times.get(index, otherwise)


_KEPT = 300
"""Frames: reading is never ten seconds behind."""
