"""The points of a room as a page has them: one a small cube, in an order of which every beginning shows all of it.

Eight bytes a point: x, y and z as shares of the room's box in sixteen bits each, and the colour in sixteen (565).
"""

import base64
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.config import PageConfig
from lpslam.ground.scans import Pose, Scans

Array = NDArray[np.float64]

STEPS = 65535
"""Of sixteen bits."""

_SEED = 7  # of the order within a level, so that the same map gives the same page
_ONE_SURFACE = 0.04  # of the depth: how far neighbours of a scan may lie apart on one surface
_PATCH = 3  # powers of two: patches of eight cubes to a side hold many points, and one surface
_STRAY_SHARE, _ROUND = 0.1, 1.0  # percent of points at each end that may be strays; metres around the rest


@dataclass(frozen=True, slots=True, eq=False)
class PackedPoints:
    """Points in an order of which every beginning is spread over the whole room.

    Attributes:
        rows: (n, 4) uint16: x, y, z and colour.
        low, size: (3,) metres, map frame: the box that x, y and z are shares of.
        spacing: metres, how far apart neighbours on a surface usually are.
    """

    rows: NDArray[np.uint16]
    low: Array
    size: Array
    spacing: float

    def __len__(self) -> int:
        return len(self.rows)

    def content(self) -> bytes:
        """As bytes, little-endian: count, low, size and spacing in eight numbers of four bytes, then the rows."""
        head = np.array([len(self), *self.low, *self.size, self.spacing], "<f4")
        return head.tobytes() + self.rows.astype("<u2").tobytes()

    def text(self) -> str:
        """The same as base64."""
        return base64.b64encode(self.content()).decode("ascii")


def filled_cloud(scans: Scans, pose: Pose) -> tuple[Array, NDArray[np.uint8]]:
    """As `Scans.cloud`, with a point between any two neighbours of a scan that lie on one surface."""
    points, colours = [np.empty((0, 3))], [np.empty((0, 3), np.uint8)]
    for keyframe in scans.keyframes:
        world_from_keyframe = pose(keyframe)
        if world_from_keyframe is None:
            continue
        # Points and colours side by side, so that both are halved at once.
        seen = np.concatenate([scans.points(keyframe), scans.colour(keyframe).astype(np.float64)], axis=2)
        for axis in (0, 1):
            seen = _halved(seen, axis)
        known = seen[np.isfinite(seen).all(axis=2)]
        points.append(transform_points(world_from_keyframe, known[:, :3]))
        colours.append(np.round(known[:, 3:]).astype(np.uint8))
    return np.concatenate(points), np.concatenate(colours)


def _halved(seen: Array, axis: int) -> Array:
    """Rows of (h, w, 6) along an axis, with their means between them; NaN where their depths lie apart."""
    seen = np.swapaxes(seen, 0, axis)
    means = (seen[:-1] + seen[1:]) / 2
    means[np.abs(seen[:-1, :, 2] - seen[1:, :, 2]) > _ONE_SURFACE * means[:, :, 2]] = np.nan
    both = np.empty((2 * len(seen) - 1, *seen.shape[1:]))
    both[::2], both[1::2] = seen, means
    return np.swapaxes(both, 0, axis)


def packed_points(points: Array, colours: NDArray[np.uint8], most: int, config: PageConfig) -> PackedPoints:
    """Fuse points and put them in order.

    Args:
        points: (n, 3) metres, map frame.
        colours: (n, 3) red, green, blue.
        most: points at most; where there would be more, the last of the order are left out.
        config: how fine.
    """
    inside = _without_strays(points)
    points, colours = points[inside], colours[inside]
    if not len(points):
        return PackedPoints(np.empty((0, 4), np.uint16), np.zeros(3), np.ones(3), config.cube)
    low = points.min(axis=0)
    cells = np.floor((points - low) / config.cube).astype(np.int64)
    means, shades, cells = _fused(points, colours, cells)
    order = _order(cells)[:most]
    size = np.maximum(points.max(axis=0) - low, 1e-3)
    shares = np.clip(np.round((means[order] - low) / size * STEPS), 0, STEPS).astype(np.uint16)
    return PackedPoints(
        np.column_stack([shares, in_sixteen(shades[order])]), low, size, _spacing(cells[order]) * config.cube
    )


def _spacing(cells: NDArray[np.int64]) -> float:
    """How far apart points on surfaces are, in cubes: the area of the larger cubes they lie in, shared by all."""
    occupied = len(np.unique(cube_keys(cells >> _PATCH)))
    return max(1.0, float(np.sqrt(occupied * 4.0**_PATCH / len(cells))))


def _without_strays(points: Array) -> NDArray[np.bool_]:
    """Which points lie in the room: a single far one would cost all others their precision."""
    if not len(points):
        return np.zeros(0, bool)
    low = np.percentile(points, _STRAY_SHARE, axis=0) - _ROUND
    high = np.percentile(points, 100 - _STRAY_SHARE, axis=0) + _ROUND
    return np.asarray(((points >= low) & (points <= high)).all(axis=1))


def _fused(
    points: Array, colours: NDArray[np.uint8], cells: NDArray[np.int64]
) -> tuple[Array, Array, NDArray[np.int64]]:
    """The mean point and colour of each cell that has points, and the cells."""
    keys = cube_keys(cells)
    _, first, member, counts = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    member = member.ravel()

    def mean(values: NDArray[Any]) -> Array:
        return np.stack([np.bincount(member, values[:, axis]) / counts for axis in range(3)], axis=1)

    return mean(points), mean(colours), cells[first]


def cube_keys(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """One number for each cell; a room has fewer than two million to a side."""
    key: NDArray[np.int64] = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
    return key


def _order(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """First one point of each largest cube, then of each of half the side, and so on; by chance within a level."""
    generator = np.random.default_rng(_SEED)
    chance = generator.permutation(len(cells))
    level = np.full(len(cells), int(cells.max()).bit_length(), np.int64)
    for finer in range(1, int(cells.max()).bit_length() + 1):
        # The first of each cube of this side, in the order of chance, belongs to this level or to a coarser one.
        _, first = np.unique(cube_keys(cells[chance] >> finer), return_index=True)
        level[chance[first]] = int(cells.max()).bit_length() - finer
    # By another chance: of the first one, whatever was seen often comes early.
    return np.lexsort((generator.permutation(len(cells)), level))


def in_sixteen(colours: Array) -> NDArray[np.uint16]:
    """(n, 3) colours of 0 to 255 in five, six and five bits."""
    red, green, blue = (np.round(colours[:, at] / 255 * most).astype(np.uint16) for at, most in enumerate((31, 63, 31)))
    return np.asarray((red << 11) | (green << 5) | blue, np.uint16)
