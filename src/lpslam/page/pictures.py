"""The room from above as a picture: what was seen of it, on the ground that is free."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.ground.grid import FREE, OCCUPIED, Grid

Array = NDArray[np.float64]

_FINEST, _MOST_PIXELS = 0.02, 2400  # metres a pixel of the picture, and pixels to a side at most
_FREE_COLOUR, _OCCUPIED_COLOUR = (90, 150, 110, 45), (100, 108, 120, 255)


@dataclass(frozen=True, slots=True)
class RoomPicture:
    """A room from above.

    Attributes:
        png: the picture; what nobody has seen is transparent.
        extent: its left, bottom, right and top in metres, map frame.
    """

    png: bytes
    extent: tuple[float, float, float, float]


def picture_of(cloud: Array, colours: NDArray[np.uint8], grid: Grid | None) -> RoomPicture | None:
    """The picture of (n, 3) points, lowest first, in their colours, on the ground; None without points."""
    if not len(cloud):
        return None
    low, high = np.percentile(cloud[:, :2], 0.5, axis=0) - 0.5, np.percentile(cloud[:, :2], 99.5, axis=0) + 0.5
    pixel = max(_FINEST, float((high - low).max()) / _MOST_PIXELS)
    columns, rows = np.maximum(np.ceil((high - low) / pixel), 1).astype(int)
    image = np.zeros((rows, columns, 4), np.uint8)
    if grid is not None:
        _paint_ground(image, grid, low, pixel)
    at = np.floor((cloud[:, :2] - low) / pixel).astype(int)
    seen = ((at >= 0) & (at < [columns, rows])).all(axis=1)
    for dy, dx in ((0, 0), (0, 1), (1, 0), (1, 1)):
        v, u = np.minimum(at[seen, 1] + dy, rows - 1), np.minimum(at[seen, 0] + dx, columns - 1)
        image[v, u, :3], image[v, u, 3] = colours[seen], 255
    _, png = cv2.imencode(".png", cv2.cvtColor(image[::-1], cv2.COLOR_RGBA2BGRA), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    extent = (float(low[0]), float(low[1]), float(low[0] + columns * pixel), float(low[1] + rows * pixel))
    return RoomPicture(png.tobytes(), extent)


def _paint_ground(image: NDArray[np.uint8], grid: Grid, low: Array, pixel: float) -> None:
    """Paint free ground and what is in the way into an image (rows, columns, 4) whose first row is the lowest."""
    row, column = (
        np.floor((low[axis] + (np.arange(image.shape[1 - axis]) + 0.5) * pixel - grid.origin[axis]) / grid.resolution)
        for axis in (1, 0)
    )
    inside = np.outer((row >= 0) & (row < grid.shape[0]), (column >= 0) & (column < grid.shape[1]))
    rows, columns = row.clip(0, grid.shape[0] - 1).astype(int), column.clip(0, grid.shape[1] - 1).astype(int)
    values = grid.values[rows[:, None], columns]
    image[inside & (values == FREE)] = _FREE_COLOUR
    image[inside & (values == OCCUPIED)] = _OCCUPIED_COLOUR
