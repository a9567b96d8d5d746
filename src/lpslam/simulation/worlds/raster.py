"""A renderer for long recordings: one visibility sample a pixel, and four where faces meet.

Most pixels lie inside one face and are shaded once. Where neighbours see different faces, the pixel is split into four,
and each quarter goes to the nearest face of those around that covers it: smooth edges at one sample's cost.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.simulation.render import Affine, Column, IntColumn, Texels, between, project_faces, scan_faces
from lpslam.simulation.scene import Scene

PROBES = 3  # texture samples along the longer side of a pixel's footprint

Columns = tuple[IntColumn, Column, Column, Texels, IntColumn, Column, IntColumn]


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What an ideal camera sees at one instant.

    Attributes:
        colour: (height, width, 3) float32 on the scale of 0 to 255 before exposure; empty if it was not asked for.
        depth: (height, width) float32, exact metres along the optical axis; 0 where nothing is hit.
        face: (height, width) int32 rows of the scene, -1 where nothing is hit.
    """

    colour: NDArray[np.float32]
    depth: NDArray[np.float32]
    face: NDArray[np.int32]


def view_of(
    scene: Scene, camera: PinholeCamera, world_from_camera: NDArray[np.float64], *, with_colour: bool = True
) -> View:
    """Draw a scene through an undistorted camera; `world_from_camera` is 4×4, of the optical frame."""
    width, height = camera.width, camera.height
    row_of, affine, polygons, counts = project_faces(
        scene.origin, scene.edge_u, scene.edge_v, scene.normal, scene.two_sided, world_from_camera,
        camera.fx, camera.fy, camera.cx, camera.cy, width, height,
    )  # fmt: skip
    inverse_depth = np.empty((height, width), np.float32)
    winner = np.empty((height, width), np.int32)
    scan_faces(affine, polygons, counts, 1, inverse_depth, winner)
    colour = np.zeros((height, width, 3) if with_colour else (0, 0, 3), np.float32)
    if with_colour:
        columns = (
            scene.texture, scene.repeat, scene.emission, scene.texels, scene.levels, scene.light, scene.light_maps,
        )  # fmt: skip
        _colour(winner, row_of, affine, columns, colour)
    depth, face = _resolved(winner, inverse_depth, row_of)
    return View(colour, depth, face)


@njit(cache=True, nogil=True, fastmath=True)
def _resolved(winner: IntColumn, inverse: Column, row_of: IntColumn) -> tuple[Column, NDArray[np.int32]]:
    height, width = winner.shape
    depth = np.zeros((height, width), np.float32)
    face = np.full((height, width), -1, np.int32)
    for row in range(height):
        for column in range(width):
            k = winner[row, column]
            if k >= 0 and inverse[row, column] > 1e-4:
                depth[row, column] = 1.0 / inverse[row, column]
                face[row, column] = row_of[k]
    return depth, face


@njit(cache=True, nogil=True, fastmath=True)
def _colour(winner: IntColumn, row_of: IntColumn, affine: Affine, columns: Columns, colour: Column) -> None:
    height, width = winner.shape
    around = np.empty(5, np.int64)
    for row in range(height):
        above, below = max(row - 1, 0), min(row + 1, height - 1)
        begun = 0  # of the run of pixels that lie within one face
        for column in range(width):
            left, right = max(column - 1, 0), min(column + 1, width - 1)
            k = winner[row, column]
            around[0], around[1], around[2] = k, winner[row, left], winner[row, right]
            around[3], around[4] = winner[above, column], winner[below, column]
            if k == around[1] and k == around[2] and k == around[3] and k == around[4]:
                if column == width - 1 and k >= 0:
                    _add_run(k, row, begun, width - begun, 0.0, 0.0, 1.0, row_of, affine, columns, colour)
                continue
            if column > begun and winner[row, begun] >= 0:
                _add_run(winner[row, begun], row, begun, column - begun, 0.0, 0.0, 1.0, row_of, affine, columns, colour)
            begun = column + 1
            for quarter in range(4):
                dx, dy = -0.25 + 0.5 * (quarter % 2), -0.25 + 0.5 * (quarter // 2)
                best = _nearest(around, column + dx, row + dy, affine)
                if best >= 0:
                    _add_run(best, row, column, 1, dx, dy, 0.25, row_of, affine, columns, colour)


@njit(cache=True, nogil=True, fastmath=True)
def _nearest(around: IntColumn, x: float, y: float, affine: Affine) -> int:
    """Of some faces the nearest that covers a point; the first one where none does, which closes cracks."""
    best, nearest = -1, 0.0
    for each in range(5):
        k = around[each]
        if k < 0:
            continue
        inverse = affine[k, 0, 0] * x + affine[k, 0, 1] * y + affine[k, 0, 2]
        if inverse <= nearest:
            continue
        u = affine[k, 1, 0] * x + affine[k, 1, 1] * y + affine[k, 1, 2]
        v = affine[k, 2, 0] * x + affine[k, 2, 1] * y + affine[k, 2, 2]
        if u >= 0.0 and v >= 0.0 and u <= inverse and v <= inverse:
            best, nearest = k, inverse
    return best if best >= 0 else around[0]


@njit(cache=True, nogil=True, fastmath=True)
def _add_run(
    k: int,
    row: int,
    first: int,
    count: int,
    dx: float,
    dy: float,
    weight: float,
    row_of: IntColumn,
    affine: Affine,
    columns: Columns,
    colour: Column,
) -> None:
    """Add `weight` times the k-th face's colour, filtered texture times light, to a run of pixels."""
    texture, repeat, emission, texels, levels, light, light_maps = columns
    i = row_of[k]
    y = row + dy
    w_x, w_0 = affine[k, 0, 0], affine[k, 0, 1] * y + affine[k, 0, 2]
    a_x, a_0 = affine[k, 1, 0], affine[k, 1, 1] * y + affine[k, 1, 2]
    b_x, b_0 = affine[k, 2, 0], affine[k, 2, 1] * y + affine[k, 2, 2]
    w_y, a_y, b_y = affine[k, 0, 1], affine[k, 1, 1], affine[k, 2, 1]
    t, tiled = texture[i], repeat[i, 0] > 1.001 or repeat[i, 1] > 1.001
    repeat_u, repeat_v = float(repeat[i, 0]), float(repeat[i, 1])
    size_u, size_v = repeat_u * levels[t, 0, 1], repeat_v * levels[t, 0, 2]
    top = levels.shape[1] - 1
    glow = float(emission[i])
    base, map_width, map_height = light_maps[i, 0], light_maps[i, 1], light_maps[i, 2]
    lane = np.uint64(0x1FFFFF)
    for column in range(first, first + count):
        x = column + dx
        z = 1.0 / (w_x * x + w_0)
        a, b = (a_x * x + a_0) * z, (b_x * x + b_0) * z
        # The pixel's footprint in texels of the finest level: derivatives of a and b along x and y.
        sx_u, sx_v = (a_x - a * w_x) * z * size_u, (b_x - b * w_x) * z * size_v
        sy_u, sy_v = (a_y - a * w_y) * z * size_u, (b_y - b * w_y) * z * size_v
        major, minor = sx_u * sx_u + sx_v * sx_v, sy_u * sy_u + sy_v * sy_v
        level, probes = 0, 1
        if major > 1.0 or minor > 1.0:
            if minor > major:
                sx_u, sx_v, major, minor = sy_u, sy_v, minor, major
            minor = max(minor, major / (PROBES * PROBES), 1.0)
            if major > 2.25 * minor:
                probes = 2 if major < 6.25 * minor else PROBES
            # Powers of two by comparison: a logarithm for every pixel would cost more than the texture.
            reach = 2.0
            while minor > reach and level < top:
                level += 1
                reach *= 4.0
        start, width, height = levels[t, level, 0], levels[t, level, 1], levels[t, level, 2]
        total = np.uint64(0)
        for probe in range(probes):
            u, v = a * repeat_u, b * repeat_v
            if probes > 1:
                offset = (probe + 0.5) / probes - 0.5
                u += sx_u * offset / levels[t, 0, 1]
                v += sx_v * offset / levels[t, 0, 2]
            if tiled:
                u -= math.floor(u)
                v -= math.floor(v)
            u = min(max(u * width - 0.5, 0.0), width - 1.001)
            v = min(max(v * height - 0.5, 0.0), height - 1.001)
            total += between(texels, start, width, u, v)
        factor = glow
        if factor == 0.0:
            u, v = min(max(a, 0.0), 1.0) * (map_width - 1), min(max(b, 0.0), 1.0) * (map_height - 1)
            left, above = min(np.int64(u), map_width - 2), min(np.int64(v), map_height - 2)
            right, below = u - left, v - above
            at = base + above * map_width + left
            upper = light[at] * (1 - right) + light[at + 1] * right
            lower = light[at + map_width] * (1 - right) + light[at + map_width + 1] * right
            factor = upper * (1 - below) + lower * below
        factor *= weight / (probes * 256)
        colour[row, column, 0] += (total & lane) * factor
        colour[row, column, 1] += ((total >> np.uint64(21)) & lane) * factor
        colour[row, column, 2] += (total >> np.uint64(42)) * factor
