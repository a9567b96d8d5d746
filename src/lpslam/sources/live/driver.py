"""What a maker's driver must offer to be a source of frames."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import LpSlamError


class UnpluggedError(LpSlamError):
    """The camera is gone; says so in a few words."""


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A colour picture and its depth as the camera gives them.

    Attributes:
        number: of the colour picture, counted by the camera.
        timestamp: seconds, by the camera's clock.
        rgb: (height, width, 3), in the order red, green, blue.
        depth: (h, w), metres, in the depth camera's pixels; 0 where there is none.
    """

    number: int
    timestamp: float
    rgb: NDArray[np.uint8]
    depth: NDArray[Any]


class Driver(Protocol):
    """A connected camera."""

    name: str
    camera: PinholeCamera

    def start(self) -> None:
        """Begin to deliver; also again after it was unplugged.

        Raises:
            UnpluggedError: it is not there (yet).
        """
        ...

    def wait(self, seconds: float) -> Shot | None:
        """The next picture, None where none comes in time.

        Raises:
            UnpluggedError: it is gone.
        """
        ...

    def registered(self, depth: NDArray[Any]) -> NDArray[np.float32]:
        """A shot's depth in the pixels of its colour, metres."""
        ...

    def stop(self) -> None:
        """Deliver no more."""
        ...
