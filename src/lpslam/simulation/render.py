"""The renderer: visibility of planar faces, then shading, then the exact depth.

Under a pinhole camera the inverse depth of a plane, and its texture coordinates times the inverse depth, are affine in
the pixel. So each face is three affine functions, clipped to a convex polygon and scanned; the nearest wins.
Visibility is found at 2x2 samples a pixel, colour once a pixel and face: smooth edges at little more than one
sample's cost.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.simulation.scene import Scene

NEAR = 0.05  # metres; nothing nearer is drawn
MAX_PROBES = 8  # texture samples along the longer side of a pixel's footprint

Affine = NDArray[np.float64]


@njit(cache=True, nogil=True)
def project_faces(origin, edge_u, edge_v, normal, two_sided, world_from_camera, fx, fy, cx, cy, width, height):
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
def scan_faces(affine, polygons, counts, samples, inverse_depth, winner):
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


@njit(cache=True, nogil=True)
def _shade(k, x, y, face, affine, texture, repeat, emission, texels, levels, light, light_maps, out):
    """Add nothing, set `out` to the colour of face row k at pixel (x, y)."""
    i = face[k]
    z = 1.0 / (affine[k, 0, 0] * x + affine[k, 0, 1] * y + affine[k, 0, 2])
    a = (affine[k, 1, 0] * x + affine[k, 1, 1] * y + affine[k, 1, 2]) * z
    b = (affine[k, 2, 0] * x + affine[k, 2, 1] * y + affine[k, 2, 2]) * z
    t = texture[i]
    size_u, size_v = repeat[i, 0] * levels[t, 0, 1], repeat[i, 1] * levels[t, 0, 2]
    # Footprint of the pixel in texels of the finest level: derivatives of a and b over x and y.
    sx_u, sx_v = (
        (affine[k, 1, 0] - a * affine[k, 0, 0]) * z * size_u,
        (affine[k, 2, 0] - b * affine[k, 0, 0]) * z * size_v,
    )
    sy_u, sy_v = (
        (affine[k, 1, 1] - a * affine[k, 0, 1]) * z * size_u,
        (affine[k, 2, 1] - b * affine[k, 0, 1]) * z * size_v,
    )
    along_x, along_y = math.sqrt(sx_u * sx_u + sx_v * sx_v), math.sqrt(sy_u * sy_u + sy_v * sy_v)
    step_u, step_v, major, minor = sx_u, sx_v, along_x, along_y
    if along_y > along_x:
        step_u, step_v, major, minor = sy_u, sy_v, along_y, along_x
    minor = max(minor, major / MAX_PROBES, 1e-6)
    probes = max(1, min(MAX_PROBES, math.ceil(major / minor - 0.25))) if major > 1.0 else 1
    level = 0
    if minor > 1.0:
        level = min(levels.shape[1] - 1, int(math.log2(minor) + 0.5))
    start, width, height = levels[t, level, 0], levels[t, level, 1], levels[t, level, 2]
    tiled = repeat[i, 0] > 1.001 or repeat[i, 1] > 1.001
    red = green = blue = 0.0
    for probe in range(probes):
        offset = (probe + 0.5) / probes - 0.5
        u = (a + step_u * offset / size_u) * repeat[i, 0]
        v = (b + step_v * offset / size_v) * repeat[i, 1]
        if tiled:
            u -= math.floor(u)
            v -= math.floor(v)
        u, v = u * width - 0.5, v * height - 0.5
        u0, v0 = math.floor(u), math.floor(v)
        du, dv = u - u0, v - v0
        u1, v1 = u0 + 1, v0 + 1
        if tiled:
            u0, u1, v0, v1 = u0 % width, u1 % width, v0 % height, v1 % height
        else:
            u0, u1 = min(max(u0, 0), width - 1), min(max(u1, 0), width - 1)
            v0, v1 = min(max(v0, 0), height - 1), min(max(v1, 0), height - 1)
        p, q, r, s = start + v0 * width + u0, start + v0 * width + u1, start + v1 * width + u0, start + v1 * width + u1
        wp, wq, wr, ws = (1 - du) * (1 - dv), du * (1 - dv), (1 - du) * dv, du * dv
        red += wp * texels[p, 0] + wq * texels[q, 0] + wr * texels[r, 0] + ws * texels[s, 0]
        green += wp * texels[p, 1] + wq * texels[q, 1] + wr * texels[r, 1] + ws * texels[s, 1]
        blue += wp * texels[p, 2] + wq * texels[q, 2] + wr * texels[r, 2] + ws * texels[s, 2]
    factor = emission[i]
    if factor == 0.0:
        first, map_width, map_height = light_maps[i, 0], light_maps[i, 1], light_maps[i, 2]
        u = min(max(a, 0.0), 1.0) * (map_width - 1)
        v = min(max(b, 0.0), 1.0) * (map_height - 1)
        u0, v0 = min(int(u), map_width - 2), min(int(v), map_height - 2)
        du, dv = u - u0, v - v0
        p = first + v0 * map_width + u0
        upper = light[p] * (1 - du) + light[p + 1] * du
        lower = light[p + map_width] * (1 - du) + light[p + map_width + 1] * du
        factor = upper * (1 - dv) + lower * dv
    factor /= probes
    out[0], out[1], out[2] = red * factor, green * factor, blue * factor


@njit(cache=True, nogil=True)
def shade_image(
    winner, face, affine, texture, repeat, emission, texels, levels, light, light_maps, colour, depth, seen
):
    """Colour (height, width, 3), exact depth and face number of every pixel from the 2x2 visibility samples."""
    height, width = depth.shape
    out = np.empty(3)
    for row in range(height):
        for column in range(width):
            k = winner[2 * row, 2 * column]
            k1, k2, k3 = (
                winner[2 * row, 2 * column + 1],
                winner[2 * row + 1, 2 * column],
                winner[2 * row + 1, 2 * column + 1],
            )
            if k == k1 and k == k2 and k == k3:
                if k < 0:
                    colour[row, column, :] = 0.0
                    depth[row, column] = 0.0
                    seen[row, column] = -1
                    continue
                _shade(k, column, row, face, affine, texture, repeat, emission, texels, levels, light, light_maps, out)
                for c in range(3):
                    colour[row, column, c] = out[c]
            else:
                colour[row, column, :] = 0.0
                for sample in range(4):
                    dy, dx = sample // 2, sample % 2
                    w = winner[2 * row + dy, 2 * column + dx]
                    if w >= 0:
                        x, y = column + dx * 0.5 - 0.25, row + dy * 0.5 - 0.25
                        _shade(w, x, y, face, affine, texture, repeat, emission, texels, levels, light, light_maps, out)
                        for c in range(3):
                            colour[row, column, c] += 0.25 * out[c]
            if k < 0:
                depth[row, column] = 0.0
                seen[row, column] = -1
            else:
                inverse = affine[k, 0, 0] * column + affine[k, 0, 1] * row + affine[k, 0, 2]
                depth[row, column] = 1.0 / inverse if inverse > 1e-6 else 0.0
                seen[row, column] = face[k]


def render(
    scene: Scene, camera: PinholeCamera, world_from_camera: NDArray[np.float64]
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int32]]:
    """Draw the scene as an ideal camera sees it at one instant.

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
    shade_image(
        winner, face, affine, scene.texture, scene.repeat, scene.emission, scene.texels, scene.levels, scene.light,
        scene.light_maps, colour, depth, seen,
    )  # fmt: skip
    return colour, depth, seen
