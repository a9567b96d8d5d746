"""The renderer: visibility of planar faces, then shading, then the exact depth.

Under a pinhole camera the inverse depth of a plane, and its texture coordinates times the inverse depth, are affine in
the pixel. So each face is three affine functions, clipped to a convex polygon and scanned; the nearest wins.
Visibility is found at 2x2 samples a pixel, colour once a pixel and face: smooth edges at little more than one
sample's cost.
"""

import math
from dataclasses import replace

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.simulation.scene import Scene

NEAR = 0.05  # metres; nothing nearer is drawn
MAX_PROBES = 8  # texture samples along the longer side of a pixel's footprint

Affine = NDArray[np.float64]
Column = NDArray[np.float32]
IntColumn = NDArray[np.int64] | NDArray[np.int32]
Texels = NDArray[np.uint32]


@njit(cache=True, nogil=True)
def project_faces(
    origin: Affine,
    edge_u: Affine,
    edge_v: Affine,
    normal: Affine,
    two_sided: NDArray[np.bool_],
    world_from_camera: Affine,
    fx: float,
    fy: float,
    cx: float,
    cy: float,
    width: int,
    height: int,
) -> tuple[IntColumn, Affine, Affine, IntColumn]:
    """Affine coefficients and screen polygons of the faces in view.

    Returns:
        (k,) face numbers, (k, 3, 3) coefficients of 1/z, a/z, b/z over (u, v, 1) in pixels, (k, 8, 2) polygon corners,
        (k,) corner counts.
    """
    n = origin.shape[0]
    faces = np.empty(n, np.int64)
    affine = np.empty((n, 3, 3))
    polygons = np.empty((n, 8, 2))
    counts = np.empty(n, np.int64)
    rotation = world_from_camera[:3, :3].T.copy()
    eye = world_from_camera[:3, 3]
    kept = 0
    corners = np.empty((4, 3))
    clipped = np.empty((8, 3))
    for i in range(n):
        facing = 0.0
        for j in range(3):
            facing += normal[i, j] * (eye[j] - origin[i, j])
        if abs(facing) < 1e-4 or (facing < 0 and not two_sided[i]):
            continue
        o = rotation @ (origin[i] - eye)
        u = rotation @ edge_u[i]
        v = rotation @ edge_v[i]
        for j in range(3):
            corners[0, j] = o[j]
            corners[1, j] = o[j] + u[j]
            corners[2, j] = o[j] + u[j] + v[j]
            corners[3, j] = o[j] + v[j]
        count = 0
        for c in range(4):
            d = (c + 1) % 4
            inside_c, inside_d = corners[c, 2] >= NEAR, corners[d, 2] >= NEAR
            if inside_c:
                clipped[count] = corners[c]
                count += 1
            if inside_c != inside_d:
                share = (NEAR - corners[c, 2]) / (corners[d, 2] - corners[c, 2])
                clipped[count] = corners[c] + share * (corners[d] - corners[c])
                count += 1
        if count < 3:
            continue
        low_x, high_x, low_y, high_y = 1e9, -1e9, 1e9, -1e9
        for c in range(count):
            x = fx * clipped[c, 0] / clipped[c, 2] + cx
            y = fy * clipped[c, 1] / clipped[c, 2] + cy
            polygons[kept, c, 0], polygons[kept, c, 1] = x, y
            low_x, high_x, low_y, high_y = min(low_x, x), max(high_x, x), min(low_y, y), max(high_y, y)
        if high_x < -1 or low_x > width or high_y < -1 or low_y > height:
            continue
        n_c = rotation @ normal[i]
        distance = n_c[0] * o[0] + n_c[1] * o[1] + n_c[2] * o[2]
        # a = u*.(X - o) with the dual vectors u*, v* of the edges, right for parallelograms too.
        uu, vv = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
        uv = u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
        det = uu * vv - uv * uv
        dual_u = (vv * u - uv * v) / det
        dual_v = (uu * v - uv * u) / det
        shift_u = dual_u[0] * o[0] + dual_u[1] * o[1] + dual_u[2] * o[2]
        shift_v = dual_v[0] * o[0] + dual_v[1] * o[1] + dual_v[2] * o[2]
        for row in range(3):
            for j in range(3):
                inverse = n_c[j] / distance
                value = inverse
                if row == 1:
                    value = dual_u[j] - shift_u * inverse
                elif row == 2:
                    value = dual_v[j] - shift_v * inverse
                affine[kept, row, j] = value
            # From rays (x, y, 1) to pixels.
            p, q, r = affine[kept, row, 0] / fx, affine[kept, row, 1] / fy, affine[kept, row, 2]
            affine[kept, row, 0], affine[kept, row, 1], affine[kept, row, 2] = p, q, r - p * cx - q * cy
        faces[kept], counts[kept] = i, count
        kept += 1
    return faces[:kept], affine[:kept], polygons[:kept], counts[:kept]


@njit(cache=True, nogil=True)
def scan_faces(
    affine: Affine, polygons: Affine, counts: IntColumn, samples: int, inverse_depth: Column, winner: IntColumn
) -> None:
    """Fill `winner` (rows into `affine`, -1 for none) and `inverse_depth` at samples x samples points a pixel."""
    height, width = winner.shape
    inverse_depth[:] = 0.0
    winner[:] = -1
    for k in range(affine.shape[0]):
        count = counts[k]
        low, high = 1e9, -1e9
        for c in range(count):
            y = (polygons[k, c, 1] + 0.5) * samples - 0.5
            low, high = min(low, y), max(high, y)
        first, last = max(0, math.ceil(low)), min(height - 1, math.floor(high))
        a, b, c0 = affine[k, 0, 0], affine[k, 0, 1], affine[k, 0, 2]
        for row in range(first, last + 1):
            left, right = 1e9, -1e9
            for c in range(count):
                d = (c + 1) % count
                x1, y1 = (polygons[k, c, 0] + 0.5) * samples - 0.5, (polygons[k, c, 1] + 0.5) * samples - 0.5
                x2, y2 = (polygons[k, d, 0] + 0.5) * samples - 0.5, (polygons[k, d, 1] + 0.5) * samples - 0.5
                if (y1 <= row and y2 >= row) or (y2 <= row and y1 >= row):
                    if abs(y2 - y1) < 1e-9:
                        left, right = min(left, x1, x2), max(right, x1, x2)
                    else:
                        x = x1 + (row - y1) / (y2 - y1) * (x2 - x1)
                        left, right = min(left, x), max(right, x)
            if right < left:
                continue
            start, stop = max(0, math.ceil(left)), min(width - 1, math.floor(right))
            base = b * ((row + 0.5) / samples - 0.5) + c0
            for column in range(start, stop + 1):
                value = a * ((column + 0.5) / samples - 0.5) + base
                if value > inverse_depth[row, column]:
                    inverse_depth[row, column] = value
                    winner[row, column] = k


@njit(cache=True, nogil=True, inline="always")
def spread(texel: np.uint32) -> np.uint64:
    """Move the three bytes of a texel 21 bits apart, so that one product weighs all of them."""
    value = np.uint64(texel)
    low, middle, high = np.uint64(0xFF), np.uint64(0xFF00), np.uint64(0xFF0000)
    return (value & low) | ((value & middle) << np.uint64(13)) | ((value & high) << np.uint64(26))


@njit(cache=True, nogil=True, fastmath=True, inline="always")
def between(texels: Texels, start: int, width: int, u: float, v: float) -> np.uint64:
    """256 times the colour at a place in a picture, `spread`, from the four texels around it.

    Args:
        texels: of all pictures.
        start, width: where the picture begins, and its row's length.
        u, v: column and row, inside the picture.
    """
    u0, v0 = np.int64(u), np.int64(v)
    du, dv = np.int64((u - u0) * 16.0 + 0.5), np.int64((v - v0) * 16.0 + 0.5)
    p = np.uint64(start + v0 * width + u0)
    r = p + np.uint64(width)
    one = np.uint64(1)
    # Weights in sixteenths: the sum of all probes fits the 21 bits that each colour has.
    upper = spread(texels[p]) * np.uint64((16 - du) * (16 - dv)) + spread(texels[p + one]) * np.uint64(du * (16 - dv))
    lower = spread(texels[r]) * np.uint64((16 - du) * dv) + spread(texels[r + one]) * np.uint64(du * dv)
    return upper + lower


@njit(cache=True, nogil=True, fastmath=True)
def _shade(
    k: np.int64,
    x: float,
    y: float,
    face: IntColumn,
    affine: Affine,
    columns: tuple[IntColumn, Column, Column, Texels, IntColumn, Column, IntColumn],
) -> tuple[float, float, float]:
    """Colour of the k-th face in view at pixel (x, y): filtered texture times light."""
    texture, repeat, emission, texels, levels, light, light_maps = columns
    i = face[k]
    z = 1.0 / (affine[k, 0, 0] * x + affine[k, 0, 1] * y + affine[k, 0, 2])
    a = (affine[k, 1, 0] * x + affine[k, 1, 1] * y + affine[k, 1, 2]) * z
    b = (affine[k, 2, 0] * x + affine[k, 2, 1] * y + affine[k, 2, 2]) * z
    t = texture[i]
    repeat_u, repeat_v = repeat[i, 0], repeat[i, 1]
    size_u, size_v = repeat_u * levels[t, 0, 1], repeat_v * levels[t, 0, 2]
    # The pixel's footprint in texels of the finest level: derivatives of a and b along x and y.
    sx_u, sx_v = (
        (affine[k, 1, 0] - a * affine[k, 0, 0]) * z * size_u,
        (affine[k, 2, 0] - b * affine[k, 0, 0]) * z * size_v,
    )
    sy_u, sy_v = (
        (affine[k, 1, 1] - a * affine[k, 0, 1]) * z * size_u,
        (affine[k, 2, 1] - b * affine[k, 0, 1]) * z * size_v,
    )
    step_u, step_v = sx_u, sx_v
    major, minor = sx_u * sx_u + sx_v * sx_v, sy_u * sy_u + sy_v * sy_v
    if minor > major:
        step_u, step_v, major, minor = sy_u, sy_v, minor, major
    level, probes = 0, 1
    if major > 1.0:
        major, minor = math.sqrt(major), math.sqrt(minor)
        minor = max(minor, major / MAX_PROBES, 1.0)
        probes = int(major / minor + 0.5)
        # Powers of two by comparison: a logarithm for every pixel would cost more than the texture.
        reach = 1.41421356
        while minor > reach and level < levels.shape[1] - 1:
            level += 1
            reach *= 2.0
    start, width, height = levels[t, level, 0], levels[t, level, 1], levels[t, level, 2]
    tiled = repeat_u > 1.001 or repeat_v > 1.001
    total = np.uint64(0)
    for probe in range(probes):
        offset = (probe + 0.5) / probes - 0.5
        u = (a + step_u * offset / size_u) * repeat_u
        v = (b + step_v * offset / size_v) * repeat_v
        if tiled:
            u -= math.floor(u)
            v -= math.floor(v)
        u = min(max(u * width - 0.5, 0.0), width - 1.001)
        v = min(max(v * height - 0.5, 0.0), height - 1.001)
        total += between(texels, start, width, u, v)
    factor = float(emission[i])
    if factor == 0.0:
        first, map_width, map_height = light_maps[i, 0], light_maps[i, 1], light_maps[i, 2]
        u = min(max(a, 0.0), 1.0) * (map_width - 1)
        v = min(max(b, 0.0), 1.0) * (map_height - 1)
        column, row = min(int(u), map_width - 2), min(int(v), map_height - 2)
        right, below = u - column, v - row
        at = first + row * map_width + column
        upper = light[at] * (1 - right) + light[at + 1] * right
        lower = light[at + map_width] * (1 - right) + light[at + map_width + 1] * right
        factor = upper * (1 - below) + lower * below
    factor /= probes * 256
    lane = np.uint64(0x1FFFFF)
    red, green, blue = total & lane, (total >> np.uint64(21)) & lane, total >> np.uint64(42)
    return red * factor, green * factor, blue * factor


@njit(cache=True, nogil=True, fastmath=True)
def shade_image(
    winner: IntColumn,
    face: IntColumn,
    affine: Affine,
    columns: tuple[IntColumn, Column, Column, Texels, IntColumn, Column, IntColumn],
    colour: Column,
    depth: Column,
    seen: IntColumn,
) -> None:
    """Colour (height, width, 3), exact depth and face number of every pixel from the 2x2 visibility samples."""
    height, width = depth.shape
    for row in range(height):
        for column in range(width):
            k = winner[2 * row, 2 * column]
            k1 = winner[2 * row, 2 * column + 1]
            k2 = winner[2 * row + 1, 2 * column]
            k3 = winner[2 * row + 1, 2 * column + 1]
            red = green = blue = 0.0
            if k == k1 and k == k2 and k == k3:
                if k >= 0:
                    red, green, blue = _shade(k, column, row, face, affine, columns)
            else:
                for sample in range(4):
                    dy, dx = sample // 2, sample % 2
                    w = winner[2 * row + dy, 2 * column + dx]
                    if w >= 0:
                        more = _shade(w, column + dx * 0.5 - 0.25, row + dy * 0.5 - 0.25, face, affine, columns)
                        red += 0.25 * more[0]
                        green += 0.25 * more[1]
                        blue += 0.25 * more[2]
            colour[row, column, 0], colour[row, column, 1], colour[row, column, 2] = red, green, blue
            depth[row, column], seen[row, column] = 0.0, -1
            if k >= 0:
                inverse = affine[k, 0, 0] * column + affine[k, 0, 1] * row + affine[k, 0, 2]
                depth[row, column] = 1.0 / inverse if inverse > 1e-6 else 0.0
                seen[row, column] = face[k]


def render(
    scene: Scene, camera: PinholeCamera, world_from_camera: NDArray[np.float64], mirror_floor: float = 0.0
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int32]]:
    """Draw the scene as an ideal camera sees it at one instant.

    Args:
        scene: what is drawn.
        camera: calibration, undistorted.
        world_from_camera: 4×4 pose of the optical frame.
        mirror_floor: 0 for a matt floor at z = 0, up to about 0.4 for a polished one.

    Returns:
        (height, width, 3) float32 colour on the scale of 0 to 255 before exposure, (height, width) float32 exact depth
        in metres (0 where nothing is hit), (height, width) int32 face numbers (-1 where nothing is hit).
    """
    width, height = camera.width, camera.height
    face, affine, polygons, counts = project_faces(
        scene.origin, scene.edge_u, scene.edge_v, scene.normal, scene.two_sided, world_from_camera,
        camera.fx, camera.fy, camera.cx, camera.cy, width, height,
    )  # fmt: skip
    inverse_depth = np.empty((2 * height, 2 * width), np.float32)
    winner = np.empty((2 * height, 2 * width), np.int32)
    scan_faces(affine, polygons, counts, 2, inverse_depth, winner)
    colour = np.empty((height, width, 3), np.float32)
    depth = np.empty((height, width), np.float32)
    seen = np.empty((height, width), np.int32)
    columns = (
        scene.texture, scene.repeat, scene.emission, scene.texels, scene.levels, scene.light, scene.light_maps,
    )  # fmt: skip
    shade_image(winner, face, affine, columns, colour, depth, seen)
    if mirror_floor > 0.0:
        _reflect(scene, camera, world_from_camera, mirror_floor, colour, depth, seen)
    return colour, depth, seen


def _reflect(
    scene: Scene,
    camera: PinholeCamera,
    world_from_camera: NDArray[np.float64],
    strength: float,
    colour: Column,
    depth: Column,
    seen: NDArray[np.int32],
) -> None:
    """Add to the floor what stands on it, upside down: a small blurred picture of the scene mirrored at z = 0."""
    shrink = 4
    small = PinholeCamera(
        camera.width // shrink, camera.height // shrink, camera.fx / shrink, camera.fy / shrink,
        (camera.cx + 0.5) / shrink - 0.5, (camera.cy + 0.5) / shrink - 0.5,
    )  # fmt: skip
    flip = np.array([1.0, 1.0, -1.0])
    origin, edge_u, edge_v, normal = (each * flip for each in (scene.origin, scene.edge_u, scene.edge_v, scene.normal))
    mirrored = replace(scene, origin=origin, edge_u=edge_u, edge_v=edge_v, normal=normal)
    picture, _, _ = render(mirrored, small, world_from_camera)
    picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), 1.2), np.float32)
    large = np.asarray(cv2.resize(picture, (camera.width, camera.height), interpolation=cv2.INTER_LINEAR), np.float32)
    is_floor = (scene.normal[:, 2] > 0.99) & (np.abs(scene.origin[:, 2]) < 1e-6)
    _mix(colour, large, depth, seen, is_floor, strength, float(world_from_camera[2, 3]))


@njit(cache=True, nogil=True, fastmath=True)
def _mix(
    colour: Column,
    mirrored: Column,
    depth: Column,
    seen: NDArray[np.int32],
    is_floor: NDArray[np.bool_],
    strength: float,
    eye_height: float,
) -> None:
    height, width = depth.shape
    for row in range(height):
        for column in range(width):
            if seen[row, column] >= 0 and is_floor[seen[row, column]]:
                # Schlick's law: polished stone mirrors most where it is grazed.
                cosine = min(1.0, eye_height / max(depth[row, column], 0.1))
                share = strength * (0.25 + 0.75 * (1.0 - cosine) ** 3)
                for c in range(3):
                    colour[row, column, c] += share * (mirrored[row, column, c] - 0.35 * colour[row, column, c])
