"""Where colour shows what depth shows, when both cameras look the same way from two places: five numbers in pixels."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.sources.registering.registration import DepthRig

Array = NDArray[np.float64]
Size = tuple[int, int]


@dataclass(frozen=True, slots=True)
class DepthDisplacement:
    """What takes a pixel of the depth image to the pixel of the colour image that shows the same place.

    Both are counted from the middle of their image: colour = scale · depth + shift + parallax / z. This holds for two
    pinhole cameras side by side, whatever their focal lengths; a small turn between them is a shift.

    Attributes:
        scale: the colour camera's focal length over the depth camera's, pixels over pixels.
        shift: (x, y) pixels of the colour image.
        parallax: (x, y) pixels of the colour image times metres of depth.
    """

    scale: float
    shift: tuple[float, float]
    parallax: tuple[float, float]

    @classmethod
    def between(cls, depth_size: Size, colour_size: Size) -> "DepthDisplacement":
        """That of registered depth: none, but for images of different sizes (width, height)."""
        return cls(colour_size[0] / depth_size[0], (0.0, 0.0), (0.0, 0.0))

    @property
    def is_none(self) -> bool:
        """Whether both show the same view, in as many pixels or not."""
        return not any((*self.shift, *self.parallax))

    @classmethod
    def of(cls, numbers: Array) -> "DepthDisplacement":
        """From (5,): scale, shift and parallax."""
        a, x, y, px, py = (float(number) for number in numbers)
        return cls(a, (x, y), (px, py))

    @property
    def numbers(self) -> Array:
        """(5,): scale, shift and parallax."""
        return np.array([self.scale, *self.shift, *self.parallax])

    def resized(self, share: float) -> "DepthDisplacement":
        """The same where both images are `share` times as large."""
        (x, y), (px, py) = self.shift, self.parallax
        return DepthDisplacement(self.scale, (x * share, y * share), (px * share, py * share))

    def moved(self, pixels: Array, depths: Array, depth_size: Size, colour_size: Size) -> Array:
        """Colour pixels (n, 2) of depth pixels (n, 2) that read `depths` (n,) metres."""
        from_middle = pixels - _middle(depth_size)
        return _middle(colour_size) + self.scale * from_middle + self.shift + np.outer(1.0 / depths, self.parallax)

    def rig(self, depth_size: Size, colour_size: Size) -> DepthRig:
        """Two cameras of some focal length that are displaced so; readings stay as they are."""
        # The mapping is in pixels: any focal length gives the same one.
        focal = float(colour_size[0])
        middle = _middle(colour_size) + self.shift
        colour = PinholeCamera(*colour_size, focal, focal, float(middle[0]), float(middle[1]))
        within = focal / self.scale
        centre = _middle(depth_size)
        depth = PinholeCamera(*depth_size, within, within, float(centre[0]), float(centre[1]))
        colour_from_depth = np.eye(4)
        colour_from_depth[:2, 3] = np.array(self.parallax) / focal
        return DepthRig(depth, colour, colour_from_depth)


@dataclass(frozen=True, slots=True, eq=False)
class StatedRig:
    """Both cameras as a calibration states them.

    Attributes:
        depth, colour: the cameras.
        colour_from_depth: 4×4, metres.
    """

    depth: PinholeCamera
    colour: PinholeCamera
    colour_from_depth: Array

    def rig(self, depth_size: Size, colour_size: Size) -> DepthRig:
        """The rig of the two cameras; the sizes are theirs."""
        return DepthRig(self.depth, self.colour, self.colour_from_depth)


Displacement = DepthDisplacement | StatedRig
"""How depth lies beside colour."""


def _middle(size: Size) -> Array:
    return (np.array(size, dtype=np.float64) - 1.0) / 2.0
