"""How high the ground lies below each keyframe's camera, and how noisy heights are."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lpslam.config import GroundConfig

Array = NDArray[np.float64]

_DAMPED = 3  # steps of height over which counts are averaged at least
_ROUNDS = 4  # of fitting, each with less weight for what lay beside
_ENOUGH = 100_000  # readings from which noise is told: more say nothing new
_OF_A_SCAN = 400  # readings from which the floor's tilt is told


def depth_noise(depths: Sequence[NDArray[np.float32]], config: GroundConfig) -> float:
    """1/metre: standard deviation of inverse depths, from how far readings lie beside the middle of two neighbours.

    A plane's inverse depths lie on a line however it is seen. Edges and what is round are the fewer.

    Args:
        depths: of each scan, (h, w) metres, 0 where there is none.
        config: thresholds.
    """
    reach, told = config.surface_reach, [np.empty(0)]
    step = max(1, sum(each.size for each in depths) // _ENOUGH)
    for depth in depths[::step]:
        inverse = np.where(depth > 0, 1.0 / np.where(depth > 0, depth, 1.0), np.nan)
        for lines in (inverse, inverse.T):
            beside = lines[:, : -2 * reach] + lines[:, 2 * reach :] - 2.0 * lines[:, reach:-reach]
            told.append(np.abs(beside[np.isfinite(beside)]) / np.sqrt(6.0))
    every = np.concatenate(told)
    return 1.4826 * float(np.median(every)) if len(every) else 0.0


def floor_levels(points: Array, up: Array, camera: Array, stray: float, config: GroundConfig) -> Array:
    """Heights (n,) of level surfaces below a camera that may be the floor, lowest first.

    Args:
        points: (h, w, 3) world.
        up: (h, w) how far up surfaces look.
        camera: (3,) world.
        stray: 1/metre by which inverse depths stray; heights are counted over as many steps as they stray by it.
        config: thresholds.
    """
    chosen = (up >= config.least_up) & (points[..., 2] < camera[2] - config.least_camera_height)
    heights, away = points[chosen][:, 2], np.linalg.norm(points[chosen] - camera, axis=1)
    near = away <= config.farthest
    if np.count_nonzero(near) < config.min_floor_readings:
        return np.empty(0)
    heights, away = heights[near], away[near]
    low = heights.min() - 2 * config.floor_step
    bins = ((heights - low) / config.floor_step).astype(np.int64)
    # A reading stands for as much surface as its pixel covers there.
    heights_stray = stray * float(np.median(away * (camera[2] - heights)))
    damped = max(_DAMPED, 2 * int(np.ceil(heights_stray / config.floor_step)) + 1)
    counts = np.convolve(np.bincount(bins, away**2, bins.max() + 3), np.ones(damped) / damped, "same")
    inner = counts[1:-1]
    is_large = inner >= config.floor_share * counts.max()
    peaks = 1 + np.flatnonzero((inner >= counts[:-2]) & (inner > counts[2:]) & is_large)
    return np.asarray([np.median(heights[np.abs(bins - peak) <= damped // 2]) for peak in peaks], np.float64)


def floors_below(cameras: Array, levels: Sequence[Array], config: GroundConfig) -> Array | None:
    """(n,) the height of the floor below each camera; None where too few saw one.

    A camera is carried at much the same height: of several levels the one counts that lies as far below as the floor
    usually does. Where none was seen, it lies as it did before.

    Args:
        cameras: (n, 3) world, in order of time.
        levels: of each, heights (m,) that may be the floor.
        config: thresholds.
    """
    usual = _usual_height([at[2] - heights for at, heights in zip(cameras, levels, strict=True)], config)
    if usual is None:
        return None
    floors = np.full(len(cameras), np.nan)
    for row, heights in enumerate(levels):
        if len(heights):
            off = np.abs(cameras[row, 2] - heights - usual)
            if off.min() <= config.height_change:
                floors[row] = heights[off.argmin()]
    known = np.flatnonzero(np.isfinite(floors))
    if not len(known):
        return None
    nearest = known[np.abs(known[None] - np.arange(len(cameras))[:, None]).argmin(axis=1)]
    return np.asarray(floors[nearest], np.float64)


def tilt(seen: Sequence[tuple[Array, Array]], cameras: Array, floors: Array, config: GroundConfig) -> Array:
    """(2,) metres a metre along x and y by which the floor rises all over the map: maps are not quite level.

    Args:
        seen: of each scan, world points (h, w, 3) and how far up surfaces look (h, w).
        cameras: (n, 3) world.
        floors: (n,) height of the floor below each.
        config: thresholds.
    """
    rows = [np.empty((0, 4))]
    for (points, up), at, floor in zip(seen, cameras, floors, strict=True):
        told = points[(up >= config.least_up) & (np.abs(points[..., 2] - floor) < config.floor_band)]
        if len(told) >= config.min_floor_readings:
            told = told[:: max(1, len(told) // _OF_A_SCAN)]
            noise = config.usual_noise[0] + config.usual_noise[1] * np.square(told - at).sum(axis=1, keepdims=True)
            rows.append(np.hstack([told - np.median(told, axis=0), noise]))
    every = np.concatenate(rows)
    rise: Array = np.zeros(2)
    if len(every) < config.min_floor_readings:
        return rise
    for _ in range(_ROUNDS):
        beside = np.abs(every[:, 2] - every[:, :2] @ rise) / every[:, 3]
        weight = 1.0 / (every[:, 3] * np.maximum(1.0, beside / max(float(np.median(beside)), 1e-9)) ** 0.5)
        rise = np.asarray(
            np.linalg.lstsq(every[:, :2] * weight[:, None], every[:, 2] * weight, rcond=None)[0], np.float64
        )
    steep = float(np.linalg.norm(rise)) / np.tan(np.radians(config.steepest))
    return np.asarray(rise / max(steep, 1.0), np.float64)


def _usual_height(below: Sequence[Array], config: GroundConfig) -> float | None:
    """Metres by which the floor lies below the camera: the deepest level that enough scans show; None without any.

    Counters and tables are seen more often than the floor that they stand on.

    Args:
        below: of each scan, how far below the camera its levels lie.
        config: thresholds.
    """
    depths = np.concatenate([*below, np.empty(0)])
    needed = max(config.min_floor_share * len(below), 1.0)
    for depth in np.sort(depths[depths <= config.most_camera_height])[::-1]:
        near = [each[np.abs(each - depth) <= config.carried_height] for each in below]
        if sum(len(each) > 0 for each in near) >= needed:
            return float(np.median(np.concatenate(near)))
    return None


def height_noise(above: Array, distances: Array, config: GroundConfig) -> Array:
    """(2,) metres and 1/metre: standard deviation of heights as a + b · distance², from readings of the floor.

    Args:
        above: (n,) metres by which readings of the floor lie above it.
        distances: (n,) metres from the camera.
        config: thresholds.
    """
    usual = np.array(config.usual_noise)
    if not len(above):
        return usual
    size = 1.4826 * float(np.median(np.abs(above) / (usual[0] + usual[1] * distances**2)))
    return usual * float(np.clip(size, 0.3, 6.0))
