"""A room from above as an image: what was seen of it, cell by cell, without the gaps between single readings."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import RoomConfig
from lpslam.ground.grid import FREE, OCCUPIED, Grid

Array = NDArray[np.float64]

_FREE_COLOUR, _OCCUPIED_COLOUR = (90, 150, 110, 45), (100, 108, 120, 255)


@dataclass(frozen=True, slots=True, eq=False)
class RoomImage:
    """A room from above.

    Attributes:
        rgba: (rows, columns, 4), the row of the largest y first; what nobody has seen is transparent.
        extent: its left, right, bottom and top in metres, map frame.
    """

    rgba: NDArray[np.uint8]
    extent: tuple[float, float, float, float]


def room_image(
    cloud: Array,
    colours: NDArray[np.uint8],
    grid: Grid | None,
    config: RoomConfig | None = None,
    *,
    finest: float | None = None,
) -> RoomImage | None:
    """Draw (n, 3) points, lowest first, in their colours, over the ground; None without points.

    A cell is `finest` metres (as configured, without), or larger where the room is large.
    """
    if not len(cloud):
        return None
    config = config or RoomConfig()
    low = np.percentile(cloud[:, :2], config.stray_percent, axis=0) - config.around
    high = np.percentile(cloud[:, :2], 100 - config.stray_percent, axis=0) + config.around
    cell = max(finest or config.finest, float((high - low).max()) / config.most_pixels)
    columns, rows = np.maximum(np.ceil((high - low) / cell), 1).astype(int)
    at = np.floor((cloud[:, :2] - low) / cell).astype(int)
    inside = ((at >= 0) & (at < [columns, rows])).all(axis=1)
    gap = max(1, round(config.gap / cell))
    numbers = at[inside, 1] * columns + at[inside, 0]
    seen, mean = _cells(numbers, cloud[inside, 2], colours[inside], (rows, columns), gap, config.top)
    image = np.zeros((rows, columns, 4), np.uint8)
    if grid is not None:
        _paint_ground(image, grid, low, cell)
    _paint_room(image, seen, mean, gap, config.alone)
    extent = (float(low[0]), float(low[0] + columns * cell), float(low[1]), float(low[1] + rows * cell))
    return RoomImage(np.ascontiguousarray(image[::-1]), extent)


def _cells(
    cells: NDArray[np.int64], heights: Array, colours: NDArray[np.uint8], shape: tuple[int, int], gap: int, top: float
) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
    """Which cells were seen, and the mean colour of what lies highest in each."""
    count = shape[0] * shape[1]
    highest = np.full(count, -np.inf)
    # The points come lowest first: the highest is written last.
    highest[cells] = heights
    shown = heights > highest[cells] - top
    number = np.bincount(cells[shown], minlength=count)
    sums = [np.bincount(cells[shown], colours[shown, channel], count) for channel in range(3)]
    mean = np.stack(sums, axis=1) / np.maximum(number, 1)[:, None]
    seen, height = (number > 0).reshape(shape), highest.reshape(shape)
    # What is seen between the readings of something above it lies below that, and is not seen from above.
    least = float(height[seen].min(initial=0.0)) - 1.0
    surface = cv2.morphologyEx(np.where(seen, height, least).astype(np.float32), cv2.MORPH_CLOSE, _reach(gap))
    return seen & (height > surface - top), mean.reshape(*shape, 3).astype(np.float32)


def _reach(gap: int) -> NDArray[np.uint8]:
    """The cells over which a surface goes on."""
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * gap + 1, 2 * gap + 1)), np.uint8)


def _paint_room(
    image: NDArray[np.uint8], seen: NDArray[np.bool_], mean: NDArray[np.float32], gap: int, least: int
) -> None:
    """Paint what was seen, and what lies between readings of one surface in the colours around it.

    Patches of fewer than `least` cells are left out.
    """
    closed = cv2.morphologyEx(np.pad(seen.astype(np.uint8), gap), cv2.MORPH_CLOSE, _reach(gap))[gap:-gap, gap:-gap]
    _, patches, facts, _ = cv2.connectedComponentsWithStats(closed, connectivity=8)
    alone = facts[:, cv2.CC_STAT_AREA] < least
    shown = (closed > 0) & ~alone[patches]
    weight = seen.astype(np.float32)
    around = cv2.GaussianBlur(weight, (0, 0), gap / 2)
    blurred = cv2.GaussianBlur(mean * weight[..., None], (0, 0), gap / 2) / np.maximum(around, 1e-6)[..., None]
    colour = np.where(seen[..., None], mean, blurred)
    image[shown, :3] = np.clip(colour[shown], 0, 255).astype(np.uint8)
    image[shown, 3] = 255


def _paint_ground(image: NDArray[np.uint8], grid: Grid, low: Array, cell: float) -> None:
    """Paint free ground and what is in the way into an image (rows, columns, 4) whose first row is the lowest."""
    row, column = (
        np.floor((low[axis] + (np.arange(image.shape[1 - axis]) + 0.5) * cell - grid.origin[axis]) / grid.resolution)
        for axis in (1, 0)
    )
    inside = np.outer((row >= 0) & (row < grid.shape[0]), (column >= 0) & (column < grid.shape[1]))
    rows, columns = row.clip(0, grid.shape[0] - 1).astype(int), column.clip(0, grid.shape[1] - 1).astype(int)
    values = grid.values[rows[:, None], columns]
    image[inside & (values == FREE)] = _FREE_COLOUR
    image[inside & (values == OCCUPIED)] = _OCCUPIED_COLOUR
