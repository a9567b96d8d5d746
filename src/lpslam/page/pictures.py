"""The room from above as a picture of a page."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.ground.grid import Grid
from lpslam.ground.raster import room_image

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RoomPicture:
    """A room from above.

    Attributes:
        png: the picture; what nobody has seen is transparent.
        extent: its left, bottom, right and top in metres, map frame.
    """

    png: bytes
    extent: tuple[float, float, float, float]


def picture_of(cloud: Array, colours: NDArray[np.uint8], grid: Grid | None, compression: int = 9) -> RoomPicture | None:
    """The picture of (n, 3) points, lowest first, in their colours, on the ground; None without points."""
    image = room_image(cloud, colours, grid)
    if image is None:
        return None
    bgra = cv2.cvtColor(image.rgba, cv2.COLOR_RGBA2BGRA)
    _, png = cv2.imencode(".png", bgra, [cv2.IMWRITE_PNG_COMPRESSION, compression])
    left, right, bottom, top = image.extent
    return RoomPicture(png.tobytes(), (left, bottom, right, top))
