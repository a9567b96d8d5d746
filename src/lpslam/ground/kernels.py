"""Hot loops of the ground: what each reading shows, and what that says of the cells."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.kernel_cache import provide_cache

provide_cache(__file__)

NOTHING, FLOOR, OBSTACLE, DROP = 0, 1, 2, 3
"""What a reading shows: nothing for a robot, ground to walk on, something in the way, ground that is too low."""


@njit(cache=True, nogil=True)
def upness(
    points: NDArray[np.float64], camera: NDArray[np.float64], reach: int, bend: NDArray[np.float64], noise: float
) -> NDArray[np.float64]:
    """(h, w) how far up (0 to 1) the surface at each of (h, w, 3) world points looks; NaN where it is not one surface.

    Args:
        points: NaN where there is none.
        camera: (3,) from which they were seen.
        reach: pixels to the neighbours from which a surface is told.
        bend: (2,) metres, and share of the distance, by which a point of one surface may lie beside the line between
            its neighbours: at an edge of depth it lies far from it, however slantwise a floor is seen.
        noise: 1/metre by which inverse depths stray, so that points of a level surface may lie as far beside it as
            two sigma of that, if this is more.
    """
    height, width, _ = points.shape
    up = np.full((height, width), np.nan)
    for v in range(reach, height - reach):
        for u in range(reach, width - reach):
            x, y, z = points[v, u, 0], points[v, u, 1], points[v, u, 2]
            ax, ay, az = points[v, u - reach, 0], points[v, u - reach, 1], points[v, u - reach, 2]
            bx, by, bz = points[v - reach, u, 0], points[v - reach, u, 1], points[v - reach, u, 2]
            # Along the row and down the column, and from their starts to the point itself.
            cx, cy, cz = points[v, u + reach, 0] - ax, points[v, u + reach, 1] - ay, points[v, u + reach, 2] - az
            dx, dy, dz = points[v + reach, u, 0] - bx, points[v + reach, u, 1] - by, points[v + reach, u, 2] - bz
            nx, ny, nz = cy * dz - cz * dy, cz * dx - cx * dz, cx * dy - cy * dx
            size = math.sqrt(nx * nx + ny * ny + nz * nz)
            away = math.sqrt((x - camera[0]) ** 2 + (y - camera[1]) ** 2 + (z - camera[2]) ** 2)
            # A level surface is seen slantwise, so that depths that stray move its points little off it. The middle of
            # two others strays, too.
            most = max(bend[0] + bend[1] * away, 2.0 * math.sqrt(1.5) * noise * away * (camera[2] - z))
            beside = max(_beside(x - ax, y - ay, z - az, cx, cy, cz), _beside(x - bx, y - by, z - bz, dx, dy, dz))
            if size > 1e-12 and beside < most:
                up[v, u] = abs(nz) / size
    return up


@njit(cache=True, nogil=True)
def _beside(x: float, y: float, z: float, along_x: float, along_y: float, along_z: float) -> float:
    """Metres from a point to a line through the origin; not a number where one of them is not."""
    a, b, c = y * along_z - z * along_y, z * along_x - x * along_z, x * along_y - y * along_x
    length = math.sqrt(along_x * along_x + along_y * along_y + along_z * along_z)
    return math.sqrt(a * a + b * b + c * c) / max(length, 1e-9)


@njit(cache=True, nogil=True)
def classify(
    points: NDArray[np.float64],
    up: NDArray[np.float64],
    camera: NDArray[np.float64],
    floor: float,
    noise: NDArray[np.float64],
    limits: NDArray[np.float64],
) -> NDArray[np.int8]:
    """(h, w) what each reading shows.

    Each column of the image is walked outwards from below the camera: ground goes on where it rises no faster than a
    robot climbs, so a ramp is ground and a kerb is not.

    Args:
        points: (h, w, 3) world, NaN where there is none.
        up: (h, w) of `upness`.
        camera: (3,) world.
        floor: metres, height of the ground below the camera.
        noise: (2,) metres and metres per metre squared: standard deviation of heights by distance.
        limits: obstacle height, robot height, drop, slope, least upness, farthest distance, how far ground climbs
            unseen, and the share by which it follows a reading.
    """
    obstacle, robot, drop, slope, least_up, farthest, unseen_climb, followed = limits
    height, width, _ = points.shape
    shown = np.zeros((height, width), np.int8)
    for u in range(width):
        ground, ground_at = floor, 0.0
        for v in range(height - 1, -1, -1):
            x, y, z = points[v, u]
            if math.isnan(x):
                continue
            away = math.hypot(x - camera[0], y - camera[1])
            distance = math.sqrt(away * away + (z - camera[2]) ** 2)
            if distance > farthest:
                continue
            tolerance = max(obstacle, 3.0 * (noise[0] + noise[1] * distance * distance))
            above = z - ground
            climb = min(slope * max(away - ground_at, 0.0), unseen_climb)
            if up[v, u] >= least_up and abs(above) <= tolerance + climb:
                shown[v, u] = FLOOR
                ground += followed * above
                ground_at = max(away, ground_at)
            elif tolerance < above < robot:
                shown[v, u] = OBSTACLE
            elif above < -(drop + tolerance + climb) and up[v, u] >= least_up:
                shown[v, u] = DROP
        _forget_below(points, camera, u, shown)
    return shown


@njit(cache=True, nogil=True)
def _forget_below(points: NDArray[np.float64], camera: NDArray[np.float64], u: int, shown: NDArray[np.int8]) -> None:
    """Ground of a column that is seen below what hangs over it, as below a table, is none."""
    over = np.inf
    for v in range(shown.shape[0]):
        if shown[v, u] == OBSTACLE or (shown[v, u] == FLOOR and over < np.inf):
            away = math.hypot(points[v, u, 0] - camera[0], points[v, u, 1] - camera[1])
            if shown[v, u] == OBSTACLE:
                over = min(over, away)
            elif away > over:
                shown[v, u] = NOTHING


@njit(cache=True, nogil=True)
def integrate(
    points: NDArray[np.float64],
    shown: NDArray[np.int8],
    camera: NDArray[np.float64],
    ray: NDArray[np.float64],
    grid: NDArray[np.float64],
    stamp: int,
    rates: NDArray[np.float64],
    evidence: NDArray[np.float32],
    heights: NDArray[np.float32],
    tops: NDArray[np.float32],
    touched: NDArray[np.int32],
) -> None:
    """Add what one scan shows to log odds of being occupied, in place; each cell counts once a scan.

    Ground goes on between readings of it that are neighbours in the image. A ray that comes down on a reading shows
    that nothing stood before it as high as it passes: that takes back what walked away, as ground does; only one that
    passes low makes a cell free.

    Args:
        points, shown, camera: as in `classify`.
        ray: metres, the height of the ground below the camera, and how far above it a ray is low, and looks over
            furniture.
        grid: x and y of the corner, and metres a cell.
        stamp: number of the scan, from 1.
        rates: log odds of an obstacle, of ground, of a ray that passes; the most that is believed; least readings.
        evidence: (rows, columns) log odds; NaN where nothing is known.
        heights: (rows, columns) metres of the ground; NaN where none was seen.
        tops: (rows, columns) metres, how high what is in the way was seen to be; NaN where nothing is.
        touched: (rows, columns, 7) scan that last saw something, how many readings of it, and the scans that last saw
            ground, passed, passed low, looked over furniture, and how many did that.
    """
    height, width = shown.shape
    low_x, high_x, low_y, high_y = camera[0], camera[0], camera[1], camera[1]
    for v in range(height):
        for u in range(width):
            what = shown[v, u]
            if what == NOTHING:
                continue
            x, y, z = points[v, u, 0], points[v, u, 1], points[v, u, 2]
            low_x, high_x, low_y, high_y = min(low_x, x), max(high_x, x), min(low_y, y), max(high_y, y)
            _mark(x, y, z, what, stamp, grid, heights, tops, touched)
            if what == FLOOR:
                for dv, du in ((1, 0), (0, 1)):
                    if v + dv < height and u + du < width and shown[v + dv, u + du] == FLOOR:
                        a, b, c = points[v + dv, u + du, 0], points[v + dv, u + du, 1], points[v + dv, u + du, 2]
                        steps = int(max(abs(a - x), abs(b - y)) / grid[2]) + 1
                        for step in range(1, min(steps, 20)):
                            at = step / steps
                            p, q, r = x + at * (a - x), y + at * (b - y), z + at * (c - z)
                            _mark(p, q, r, FLOOR, stamp, grid, heights, tops, touched)
            _pass(x, y, z, camera, ray, stamp, grid, tops, touched)
    top, left = int((low_y - grid[1]) / grid[2]), int((low_x - grid[0]) / grid[2])
    bottom, right = int((high_y - grid[1]) / grid[2]) + 1, int((high_x - grid[0]) / grid[2]) + 1
    _judge(stamp, rates, evidence[top:bottom, left:right], touched[top:bottom, left:right])


@njit(cache=True, nogil=True)
def _mark(
    x: float,
    y: float,
    z: float,
    what: int,
    stamp: int,
    grid: NDArray[np.float64],
    heights: NDArray[np.float32],
    tops: NDArray[np.float32],
    touched: NDArray[np.int32],
) -> None:
    """Note what was seen in the cell at x and y."""
    i, j = int((y - grid[1]) / grid[2]), int((x - grid[0]) / grid[2])
    if i < 0 or j < 0 or i >= touched.shape[0] or j >= touched.shape[1]:
        return
    if what == FLOOR:
        touched[i, j, 2] = stamp
        heights[i, j] = z if math.isnan(heights[i, j]) else heights[i, j] + 0.2 * (z - heights[i, j])
        return
    if touched[i, j, 0] != stamp:
        touched[i, j, 0], touched[i, j, 1] = stamp, 0
    touched[i, j, 1] += 1
    if math.isnan(tops[i, j]) or tops[i, j] < z:
        tops[i, j] = z


@njit(cache=True, nogil=True)
def _pass(
    x: float,
    y: float,
    z: float,
    camera: NDArray[np.float64],
    ray: NDArray[np.float64],
    stamp: int,
    grid: NDArray[np.float64],
    tops: NDArray[np.float32],
    touched: NDArray[np.int32],
) -> None:
    """Note the cells that a ray passes on its way from the camera, all but the last."""
    steps = int(max(abs(x - camera[0]), abs(y - camera[1])) / grid[2])
    row, column = (camera[1] - grid[1]) / grid[2], (camera[0] - grid[0]) / grid[2]
    count = max(steps, 1)
    rows_on, columns_on = (y - camera[1]) / grid[2] / count, (x - camera[0]) / grid[2] / count
    height_on = (z - camera[2]) / count
    for step in range(1, steps - 1):
        i, j = int(row + step * rows_on), int(column + step * columns_on)
        if 0 <= i < touched.shape[0] and 0 <= j < touched.shape[1]:
            height = camera[2] + step * height_on
            if math.isnan(tops[i, j]) or height < tops[i, j]:
                touched[i, j, 3] = stamp
                if height - ray[0] < ray[1]:
                    touched[i, j, 4] = stamp
                if height - ray[0] < ray[2] and touched[i, j, 5] != stamp:
                    touched[i, j, 5] = stamp
                    touched[i, j, 6] += 1


@njit(cache=True, nogil=True)
def _judge(stamp: int, rates: NDArray[np.float64], evidence: NDArray[np.float32], touched: NDArray[np.int32]) -> None:
    """Add to the log odds of every cell that a scan has touched, of the part of the grid that it may have touched."""
    occupied, free, passed, most, least = rates
    for i in range(evidence.shape[0]):
        for j in range(evidence.shape[1]):
            known = not math.isnan(evidence[i, j])
            change = 0.0
            if touched[i, j, 0] == stamp:
                change = occupied * min(touched[i, j, 1] / least, 1.0)
            elif touched[i, j, 2] == stamp or (touched[i, j, 3] == stamp and evidence[i, j] > 0.0):
                change = free
            elif touched[i, j, 4] == stamp:
                change = passed
            if change != 0.0:
                before = evidence[i, j] if known else 0.0
                evidence[i, j] = min(max(before + change, -most), most)
