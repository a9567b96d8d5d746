"""Colour and depth paired as they come, within a bounded buffer."""

from bisect import insort
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from lpslam.config import PairingConfig
from lpslam.timestamps import associate, usual_tolerance

Payload = TypeVar("Payload")


@dataclass(frozen=True, slots=True)
class Stamped(Generic[Payload]):
    """A picture that is not decoded yet.

    Attributes:
        timestamp: seconds.
        is_depth: whether it is depth; else colour.
        payload: what it is decoded from.
    """

    timestamp: float
    is_depth: bool
    payload: Payload


@dataclass(frozen=True, slots=True)
class Paired(Generic[Payload]):
    """A colour picture with its depth.

    Attributes:
        timestamp: seconds, the colour picture's.
        colour: its payload.
        depth: that of its depth; None where there is none.
        fault: why it cannot be used; empty otherwise.
    """

    timestamp: float
    colour: Payload
    depth: Payload | None
    fault: str = ""


def paired(pictures: Iterable[Stamped[Payload]], config: PairingConfig) -> Iterator[Paired[Payload]]:
    """Pair pictures by time, each depth at most once, the closest first, and give the colour pictures in order.

    A colour picture without depth is a fault, unless depth pauses: then it comes without.

    Args:
        pictures: of both kinds, roughly in order.
        config: how far apart in time the two of a pair may be, and how many wait.
    """
    pause, buffer = config.pause_s, config.buffer
    tolerance = config.tolerance_s
    colours: list[Stamped[Payload]] = []
    depths: list[Stamped[Payload]] = []
    unpaired: list[Stamped[Payload]] = []
    last_paired, last_time = -np.inf, -np.inf
    seen: tuple[deque[float], deque[float]] = (deque(maxlen=buffer), deque(maxlen=buffer))

    def decide() -> Iterator[Paired[Payload]]:
        """Settle the earliest colour picture."""
        nonlocal last_paired, last_time
        colour_times, depth_times = (np.array([each.timestamp for each in kind]) for kind in (colours, depths))
        rows, columns = associate(colour_times, depth_times, tolerance)
        colour = colours.pop(0)
        if colour.timestamp == last_time:
            yield Paired(colour.timestamp, colour.payload, None, f"it repeats the timestamp {colour.timestamp:.6f}")
            return
        last_time = colour.timestamp
        if len(rows) and rows[0] == 0:
            is_pause = colour.timestamp - last_paired > pause
            yield from (_alone(each, is_pause, tolerance) for each in unpaired)
            unpaired.clear()
            last_paired = colour.timestamp
            yield Paired(colour.timestamp, colour.payload, depths.pop(int(columns[0])).payload)
        else:
            unpaired.append(colour)
            if colour.timestamp - last_paired > pause and last_paired > -np.inf:
                yield from (_alone(each, True, tolerance) for each in unpaired)
                unpaired.clear()
            elif len(unpaired) > buffer:
                yield _alone(unpaired.pop(0), False, tolerance)
        # Depth that no colour picture to come can be near to.
        while depths and depths[0].timestamp < colour.timestamp - tolerance:
            depths.pop(0)

    for picture in pictures:
        seen[picture.is_depth].append(picture.timestamp)
        colour_times, depth_times = (np.array(each) for each in seen)
        tolerance = usual_tolerance(colour_times, depth_times, config.tolerance_s, config.slow_tolerance_s)
        insort(depths if picture.is_depth else colours, picture, key=lambda each: each.timestamp)
        while colours and _is_settled(colours, depths, tolerance, buffer):
            yield from decide()
        if len(depths) > buffer:
            depths.pop(0)
    while colours:
        yield from decide()
    yield from (_alone(each, False, tolerance) for each in unpaired)


def _is_settled(colours: list[Stamped[Payload]], depths: list[Stamped[Payload]], tolerance: float, buffer: int) -> bool:
    """Whether nothing that may still come can change what the earliest colour picture is paired with."""
    if len(colours) > buffer:
        return True
    due = colours[0].timestamp + 2 * tolerance
    return colours[-1].timestamp > due and bool(depths) and depths[-1].timestamp > due


def _alone(colour: Stamped[Payload], is_pause: bool, tolerance: float) -> Paired[Payload]:
    fault = "" if is_pause else f"it has no depth image within {1000 * tolerance:g} ms"
    return Paired(colour.timestamp, colour.payload, None, fault)
