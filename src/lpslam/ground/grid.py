"""The occupancy grid: what is ground, what stands in the way, and what nobody has seen."""

from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.config import GroundConfig
from lpslam.ground import kernels
from lpslam.ground.floor import depth_noise, floor_levels, floors_below, height_noise, tilt
from lpslam.ground.scans import Pose, Scans
from lpslam.ground.storeys import storeys_of

Array = NDArray[np.float64]

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
"""Values of cells, as in ROS's nav_msgs/OccupancyGrid."""

_BELOW_FLOOR = 0.3
"""Metres by which what hangs on a storey may seem to lie below its floor: maps are not quite level."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Ground seen from above.

    Attributes:
        values: (rows, columns) int8, rows along y: 0 free, 100 occupied, -1 unknown.
        origin: x and y of the corner of cell (0, 0), metres, map frame.
        resolution: metres a cell.
        heights: (rows, columns) metres, of the ground; NaN where none was seen.
        storeys: metres, heights of the storeys of the map, lowest first, where several lie above one another.
        storey: which of these the grid is of.
    """

    values: NDArray[np.int8]
    origin: tuple[float, float]
    resolution: float
    heights: NDArray[np.float32] = field(default_factory=lambda: np.empty((0, 0), np.float32))
    storeys: tuple[float, ...] = ()
    storey: int = 0

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.values.shape[0], self.values.shape[1]

    def cell(self, point: Array) -> tuple[int, int]:
        """Row and column of a point (2 or 3,), metres; it may lie outside."""
        x, y = (np.asarray(point[:2], np.float64) - self.origin) / self.resolution
        return int(np.floor(y)), int(np.floor(x))

    def has(self, cell: tuple[int, int]) -> bool:
        """Whether a cell lies inside."""
        rows, columns = self.shape
        return 0 <= cell[0] < rows and 0 <= cell[1] < columns

    def at(self, point: Array) -> int:
        """The value at a point (2 or 3,), metres; unknown outside."""
        cell = self.cell(point)
        return int(self.values[cell]) if self.has(cell) else UNKNOWN

    def storeys_to(self, height: float) -> int:
        """How many storeys higher than the grid's something is that hangs at a height, metres; 0 where it has one."""
        return int(self.storeys_at(np.array([height]))[0]) - self.storey if self.storeys else 0

    def storeys_at(self, heights: Array) -> NDArray[np.int64]:
        """(n,) on which storeys of the map things are that hang at heights (n,), metres."""
        below = np.searchsorted(np.array(self.storeys), heights + _BELOW_FLOOR, side="right")
        return np.maximum(below - 1, 0).astype(np.int64)

    def middles(self, cells: NDArray[np.int64]) -> Array:
        """(n, 2) metres, of cells (n, 2) row and column."""
        return (np.asarray(cells, np.float64)[:, ::-1] + 0.5) * self.resolution + self.origin


def trinary(values: NDArray[np.int8]) -> NDArray[np.uint8]:
    """(rows, columns) shades as ROS's map_server has them, top row first: 254 free, 0 occupied, 205 unknown."""
    shades = np.full(values.shape, 205, np.uint8)
    shades[values == FREE], shades[values == OCCUPIED] = 254, 0
    return np.ascontiguousarray(shades[::-1])


def build_grid(
    scans: Scans,
    world_from_keyframe: Pose,
    config: GroundConfig,
    walked: Array | None = None,
    height: float | None = None,
) -> Grid | None:
    """The ground as all keyframes saw it, by their present poses.

    Args:
        scans: what was seen.
        world_from_keyframe: 4×4, z up; None for keyframes without a place in the map.
        config: thresholds.
        walked: (n, 3) where the camera was carried; where its keyframes were, without.
        height: metres, at which somebody is on the storey that is wanted, of those that lie above one another; that on
            which the last scan was taken, without.

    Returns:
        The grid, or None where no floor was seen.
    """
    parted = _parted(scans, world_from_keyframe, config)
    if parted is None:
        return None
    told, storeys, of = parted
    own = int(of[-1] if height is None else of[np.abs(told.cameras[:, 2] - height).argmin()])
    return _storey(told.only(np.flatnonzero(of == own)), storeys, own, config, walked)


def build_grids(
    scans: Scans, world_from_keyframe: Pose, config: GroundConfig, walked: Array | None = None
) -> list[Grid]:
    """The ground of every storey, lowest first, of those that lie above one another; none where no floor was seen.

    Args:
        scans, world_from_keyframe, config, walked: as in `build_grid`.
    """
    parted = _parted(scans, world_from_keyframe, config)
    if parted is None:
        return []
    told, storeys, of = parted
    grids = [
        _storey(told.only(np.flatnonzero(of == own)), storeys, own, config, walked) for own in np.unique(of).tolist()
    ]
    return [grid for grid in grids if grid is not None]


@dataclass(frozen=True, slots=True, eq=False)
class _Told:
    """What scans say of the ground.

    Attributes:
        seen: of each, world points (h, w, 3), levelled, and how far up surfaces look (h, w).
        shown: of each, what its readings show (h, w).
        cameras, floors: (n, 3), (n,) where each was taken, and the height of the floor there, levelled.
        rise: (2,) metres a metre along x and y that levelling took off.
    """

    seen: list[tuple[Array, Array]]
    shown: list[NDArray[np.int8]]
    cameras: Array
    floors: Array
    rise: Array

    def ground(self, at: int) -> Array:
        """(m, 3) the readings of a scan that are of the ground."""
        return np.asarray(self.seen[at][0][self.shown[at] == kernels.FLOOR])

    def only(self, kept: NDArray[np.int64]) -> "_Told":
        """Of some scans."""
        seen, shown = [self.seen[at] for at in kept], [self.shown[at] for at in kept]
        return _Told(seen, shown, self.cameras[kept], self.floors[kept], self.rise)


def _parted(
    scans: Scans, world_from_keyframe: Pose, config: GroundConfig
) -> tuple[_Told, Array, NDArray[np.int64]] | None:
    """What scans say of the ground, the heights of storeys, and which of them each scan is of; None without a floor."""
    placed = [(each, pose) for each in scans.keyframes if (pose := world_from_keyframe(each)) is not None]
    told = _told(scans, placed, config)
    return None if told is None else (told, *storeys_of(told.floors, told.ground, config))


def _storey(told: _Told, storeys: Array, own: int, config: GroundConfig, walked: Array | None) -> Grid | None:
    """The grid of one storey by its scans; None where it would be larger than is believed."""
    extent = _extent(told.seen, told.shown, told.cameras, config)
    if extent is None:
        return None
    walked = told.cameras if walked is None else _walked_near(walked, told, config)
    grid = _integrated(told.seen, told.shown, told.cameras, told.floors, walked, extent, config)
    grid.heights[:] += (grid.middles(np.argwhere(grid.values > -2)) @ told.rise).reshape(grid.shape)
    return replace(grid, storeys=tuple(storeys.tolist()) if len(storeys) > 1 else (), storey=own)


def _told(scans: Scans, placed: list[tuple[int, Array]], config: GroundConfig) -> _Told | None:
    """What scans at their poses say of the ground; None where no floor was seen."""
    cameras = np.array([pose[:3, 3] for _, pose in placed])
    if not placed or not np.isfinite(cameras).all():
        return None
    depths = [scans.depth(keyframe) for keyframe, _ in placed]
    stray = depth_noise(depths, config)
    seen = [
        _surfaces(scans.back_projected(depth), pose, stray, config)
        for depth, (_, pose) in zip(depths, placed, strict=True)
    ]
    levelled = _levelled(seen, cameras, stray, config)
    if levelled is None:
        return None
    floors, rise = levelled
    noise = _noise(seen, cameras, floors, config)
    shown = [
        kernels.classify(points, up, at, float(floor), noise, _limits(config, noise))
        for (points, up), at, floor in zip(seen, cameras, floors, strict=True)
    ]
    return _Told(seen, shown, cameras, floors, rise)


def _walked_near(walked: Array, told: _Told, config: GroundConfig) -> Array:
    """Where the camera was carried (n, 3) on the storey of some scans."""
    walked = walked[np.isfinite(walked).all(axis=1)]
    low, high = told.cameras[:, 2].min() - config.height_change, told.cameras[:, 2].max() + config.height_change
    own = walked[:, 2] - walked[:, :2] @ told.rise
    return np.asarray(walked[(own > low) & (own < high)])


def _surfaces(points: Array, pose: Array, stray: float, config: GroundConfig) -> tuple[Array, Array]:
    """World points (h, w, 3) of a scan's points in its camera's frame, and how far up surfaces look there (h, w)."""
    world = np.ascontiguousarray(transform_points(pose, points.reshape(-1, 3)).reshape(points.shape))
    return world, kernels.upness(world, pose[:3, 3], config.surface_reach, np.array(config.surface_bend), stray)


def _levelled(
    seen: list[tuple[Array, Array]], cameras: Array, stray: float, config: GroundConfig
) -> tuple[Array, Array] | None:
    """The floor below each camera, and the rise (2,) that was taken off points and cameras in place; None without."""
    floors = _floors(seen, cameras, stray, config)
    if floors is None:
        return None
    rise = tilt(seen, cameras, floors, config)
    for points, _ in seen:
        points[..., 2] -= points[..., :2] @ rise
    cameras[:, 2] -= cameras[:, :2] @ rise
    floors = _floors(seen, cameras, stray, config)
    return None if floors is None else (floors, rise)


def _floors(seen: list[tuple[Array, Array]], cameras: Array, stray: float, config: GroundConfig) -> Array | None:
    levels = [floor_levels(points, up, at, stray, config) for (points, up), at in zip(seen, cameras, strict=True)]
    return floors_below(cameras, levels, config)


def _noise(seen: list[tuple[Array, Array]], cameras: Array, floors: Array, config: GroundConfig) -> Array:
    above, away = [], []
    for (points, up), at, floor in zip(seen, cameras, floors, strict=True):
        level = (up >= config.least_up) & (np.abs(points[..., 2] - floor) < config.floor_band)
        above.append(points[level][:, 2] - np.median(points[level][:, 2]) if level.any() else np.empty(0))
        away.append(np.linalg.norm(points[level] - at, axis=1))
    return height_noise(np.concatenate(above), np.concatenate(away), config)


def _limits(config: GroundConfig, noise: Array) -> Array:
    """What `classify` is told; no farther is looked than where noise alone looks like something in the way."""
    told = np.sqrt(max(config.floor_band / 3.0 - noise[0], 0.0) / noise[1])
    return np.array([
        config.obstacle_height, config.robot_height, config.drop, np.tan(np.radians(config.steepest)), config.least_up,
        min(config.farthest, max(float(told), config.nearest)), config.unseen_climb, config.followed_share,
    ])  # fmt: skip


def _extent(
    seen: list[tuple[Array, Array]], shown: list[NDArray[np.int8]], cameras: Array, config: GroundConfig
) -> tuple[float, float, int, int] | None:
    """Left, bottom, rows and columns of a grid that holds all; None if it would be larger than is believed."""
    corners = [cameras[:, :2]]
    for (points, _), what in zip(seen, shown, strict=True):
        told = points[what != kernels.NOTHING][:, :2]
        if len(told):
            corners.append(np.array([told.min(axis=0), told.max(axis=0)]))
    every = np.concatenate(corners)
    low = np.floor(every.min(axis=0) / config.resolution) * config.resolution - config.resolution
    columns, rows = (np.ceil((every.max(axis=0) - low) / config.resolution) + 2).astype(int).tolist()
    return (float(low[0]), float(low[1]), rows, columns) if max(rows, columns) <= config.most_cells else None


def _integrated(
    seen: list[tuple[Array, Array]],
    shown: list[NDArray[np.int8]],
    cameras: Array,
    below: Array,
    walked: Array,
    extent: tuple[float, float, int, int],
    config: GroundConfig,
) -> Grid:
    left, bottom, rows, columns = extent
    corner = np.array([left, bottom, config.resolution])
    rates = np.array([
        config.occupied_odds, -config.free_odds_down, -config.passed_odds_down, config.most_odds, config.least_readings
    ])  # fmt: skip
    evidence = np.full((rows, columns), np.nan, np.float32)
    heights, tops = (np.full((rows, columns), np.nan, np.float32) for _ in range(2))
    touched = np.zeros((rows, columns, 7), np.int32)
    for stamp, ((points, _), what, at, floor) in enumerate(zip(seen, shown, cameras, below, strict=True), 1):
        ray = np.array([floor, config.low_ray, config.over_furniture])
        kernels.integrate(points, what, at, ray, corner, stamp, rates, evidence, heights, tops, touched)
    values = np.full((rows, columns), UNKNOWN, np.int8)
    values[evidence <= -config.free_from_down] = FREE
    values[evidence > 0.0] = OCCUPIED
    _open_up(values, touched[..., 6] >= config.looked_over, config)
    _clear_the_way(values, walked, corner, config.trodden)
    return Grid(_filled(values), (left, bottom), config.resolution, heights)


def _open_up(values: NDArray[np.int8], looked_over: NDArray[np.bool_], config: GroundConfig) -> None:
    """What is looked over is free as far from anything as furniture is deep: what stands low stands beside the high.

    Not at the rim of what was seen: a cell there is not seen in full.
    """
    away = cv2.distanceTransform((values != OCCUPIED).astype(np.uint8), cv2.DIST_L2, 5) * config.resolution
    told = (looked_over | (values == FREE)).astype(np.uint8)
    inner = cv2.erode(told, np.ones((3, 3), np.uint8)) > 0
    values[looked_over & inner & (values == UNKNOWN) & (away > config.furniture)] = FREE


def _clear_the_way(values: NDArray[np.int8], walked: Array, corner: Array, trodden_metres: float) -> None:
    """Where the camera was carried is free unless something was seen there."""
    trodden = np.zeros(values.shape, np.uint8)
    for column, row in np.unique(np.floor((walked[:, :2] - corner[:2]) / corner[2]).astype(np.int32), axis=0):
        cv2.circle(trodden, (int(column), int(row)), round(trodden_metres / corner[2]), 1, -1)
    values[(trodden > 0) & (values == UNKNOWN)] = FREE


def _filled(values: NDArray[np.int8]) -> NDArray[np.int8]:
    """Unknown cells among free ones are free: far from the camera readings lie farther apart than cells."""
    kernel = np.ones((3, 3), np.float32)
    for _ in range(2):
        free = cv2.filter2D((values == FREE).astype(np.float32), -1, kernel, borderType=cv2.BORDER_CONSTANT)
        other = cv2.filter2D((values == OCCUPIED).astype(np.float32), -1, kernel, borderType=cv2.BORDER_CONSTANT)
        values = np.where((values == UNKNOWN) & (free >= 5.0) & (other == 0.0), np.int8(FREE), values)
    return values
