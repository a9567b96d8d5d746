"""The room from above as a picture of a page."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import RoomConfig
from lpslam.ground.grid import FREE, OCCUPIED, Grid
from lpslam.ground.raster import room_image

Array = NDArray[np.float64]

_FREE_COLOUR, _OCCUPIED_COLOUR = (90, 150, 110, 60), (100, 108, 120, 150)


@dataclass(frozen=True, slots=True)
class RoomPicture:
    """A room from above.

    Attributes:
        png: the picture; what nobody has seen is transparent.
        extent: its left, bottom, right and top in metres, map frame.
    """

    png: bytes
    extent: tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class GroundPicture:
    """Ground to walk on and what stands in the way, from above.

    Attributes:
        png: a pixel a cell; what is not known is transparent.
        extent: its left, bottom, right and top in metres, map frame.
        height: metres, of the ground, where most of it lies.
    """

    png: bytes
    extent: tuple[float, float, float, float]
    height: float


def ground_picture(grid: Grid) -> GroundPicture | None:
    """The picture of a grid; None where nothing of it is ground."""
    known = grid.heights[np.isfinite(grid.heights)]
    if not len(known):
        return None
    image = np.zeros((*grid.shape, 4), np.uint8)
    image[grid.values == FREE], image[grid.values == OCCUPIED] = _FREE_COLOUR, _OCCUPIED_COLOUR
    _, png = cv2.imencode(".png", cv2.cvtColor(image[::-1], cv2.COLOR_RGBA2BGRA), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    (left, bottom), (rows, columns) = grid.origin, grid.shape
    extent = left, bottom, left + columns * grid.resolution, bottom + rows * grid.resolution
    return GroundPicture(png.tobytes(), extent, float(np.median(known)))


def picture_of(
    cloud: Array,
    colours: NDArray[np.uint8],
    grid: Grid | None,
    config: RoomConfig | None = None,
    *,
    compression: int = 9,
    finest: float | None = None,
) -> RoomPicture | None:
    """The picture of (n, 3) points, lowest first, in their colours, on the ground; None without points.

    Args:
        cloud: metres, map frame.
        colours: red, green, blue.
        grid: the ground, if it is to be below them.
        config: thresholds; the defaults without.
        compression: of PNG, 0 to 9: the more, the smaller and the later.
        finest: metres a pixel at least; as configured, without.
    """
    image = room_image(cloud, colours, grid, config, finest=finest)
    if image is None:
        return None
    bgra = cv2.cvtColor(image.rgba, cv2.COLOR_RGBA2BGRA)
    _, png = cv2.imencode(".png", bgra, [cv2.IMWRITE_PNG_COMPRESSION, compression])
    left, right, bottom, top = image.extent
    return RoomPicture(png.tobytes(), (left, bottom, right, top))
