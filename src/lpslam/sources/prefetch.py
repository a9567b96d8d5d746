"""Decoding ahead in a thread of its own, so that the consumer never waits for the disk."""

import queue
import threading
from collections.abc import Iterator
from dataclasses import dataclass

from lpslam.frames import FrameSource, PassedOn, RgbdFrame


@dataclass(frozen=True, slots=True)
class _End:
    """The last item of the queue: why there are no more frames."""

    error: BaseException | None = None


class Prefetched(PassedOn):
    """A `FrameSource` that reads another one up to `depth` frames ahead.

    An error of the source is raised where the frame would have come. When the consumer stops early, so does the thread.
    Faults are those of up to `depth` frames ahead of what has been consumed.

    Args:
        source: where the frames come from.
        depth: frames held at most.
    """

    def __init__(self, source: FrameSource, depth: int = 8) -> None:
        if depth < 1:
            raise ValueError(f"a queue of {depth} frames can hold none")
        super().__init__(source)
        self._depth = depth

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield the source's frames in order; closing the iterator ends the thread."""
        frames: queue.Queue[RgbdFrame | _End] = queue.Queue(self._depth)
        stopped = threading.Event()
        worker = threading.Thread(
            target=_read_ahead, args=(self.source, frames, stopped), name=f"decode {self.name}", daemon=True
        )
        worker.start()
        try:
            while not isinstance(item := frames.get(), _End):
                yield item
            if item.error is not None:
                raise item.error
        finally:
            stopped.set()
            worker.join(timeout=5.0)


def _read_ahead(source: FrameSource, frames: "queue.Queue[RgbdFrame | _End]", stopped: threading.Event) -> None:
    end = _End()
    iterator = iter(source)
    try:
        for frame in iterator:
            if not _put(frames, frame, stopped):
                break
    except BaseException as error:
        # Whatever it is belongs to the consumer, who would otherwise wait for ever.
        end = _End(error)
    finally:
        close = getattr(iterator, "close", None)
        if close is not None:
            close()
    _put(frames, end, stopped)


def _put(frames: "queue.Queue[RgbdFrame | _End]", item: RgbdFrame | _End, stopped: threading.Event) -> bool:
    """Put the item as soon as there is room; False if the consumer has stopped."""
    while not stopped.is_set():
        try:
            frames.put(item, timeout=0.05)
        except queue.Full:
            continue
        return True
    return False
