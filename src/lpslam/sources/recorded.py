"""What a recording offers beyond a stream of frames: any frame by its number, for a look before it is used."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lpslam.frames import FrameSource, RgbdFrame

Times = NDArray[np.float64]


class RecordedSource(FrameSource, Protocol):
    """A `FrameSource` whose frames are all there."""

    notes: tuple[str, ...]
    listed_times: tuple[Times, Times] | None

    @property
    def timestamps(self) -> Sequence[float]:
        """Seconds, of every listed frame, in order."""
        ...

    def frame(self, index: int) -> RgbdFrame | None:
        """The frame of a number; None if it cannot be used."""
        ...

    def sample_depths(self, count: int) -> list[NDArray[np.float32]]:
        """Depth images (height, width) in metres, spread over the recording."""
        ...
