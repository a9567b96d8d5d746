"""RGB-D frames and where they come from."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera


@dataclass(frozen=True, slots=True, eq=False)
class RgbdFrame:
    """One colour image with its registered depth.

    Attributes:
        index: position in the source's order, counting bad frames; unique within a source.
        timestamp: seconds.
        rgb: (height, width, 3) uint8, in the order red, green, blue.
        depth: (height, width) float32, metres along the optical axis; 0 where there is none.
    """

    index: int
    timestamp: float
    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class FrameFault:
    """A frame that could not be used: skipped, counted and reported, never fatal."""

    index: int
    timestamp: float
    reason: str


@runtime_checkable
class FrameSource(Protocol):
    """Where frames come from. One file a source, behind this protocol.

    Iterating starts from the first frame each time. Frames that cannot be decoded are not yielded; each leaves a
    `FrameFault` in `faults`, which is cleared when an iteration begins.
    """

    @property
    def name(self) -> str:
        """A short human-readable name, as in reports."""
        ...

    @property
    def camera(self) -> PinholeCamera:
        """The calibration shared by all frames of this source."""
        ...

    @property
    def faults(self) -> list[FrameFault]:
        """Frames skipped so far in the running (or last) iteration."""
        ...

    def __len__(self) -> int:
        """Number of frames that the source lists, good and bad."""
        ...

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield the frames in order of time."""
        ...


class PassedOn:
    """What a `FrameSource` that does something with the frames of another one says of itself: what that one says.

    Args:
        source: where the frames come from.
    """

    def __init__(self, source: FrameSource) -> None:
        self.source = source

    @property
    def name(self) -> str:
        """The source's name."""
        return self.source.name

    @property
    def camera(self) -> PinholeCamera:
        """The source's calibration."""
        return self.source.camera

    @property
    def faults(self) -> list[FrameFault]:
        """The source's faults."""
        return self.source.faults

    def __len__(self) -> int:
        return len(self.source)
