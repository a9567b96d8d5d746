"""Corners, orientation and binary descriptors of one pyramid level.

FAST-9 corners (Rosten and Drummond 2006) with a threshold that falls where an image cell is empty, spread over the
level by rank within a cell; orientation by the intensity centroid and steered BRIEF (ORB, Rublee et al. 2011).
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.slam.kernels.geometry import median

PATCH_RADIUS = 15
"""Radius in pixels of the disc whose intensity centroid gives a corner its direction."""

BORDER = 19
"""Pixels from the edge of a level within which no corner is taken: a rotated descriptor patch must fit."""

_CIRCLE = np.array(
    [
        (0, -3), (1, -3), (2, -2), (3, -1), (3, 0), (3, 1), (2, 2), (1, 3),
        (0, 3), (-1, 3), (-2, 2), (-3, 1), (-3, 0), (-3, -1), (-2, -2), (-1, -3),
    ],
    dtype=np.int64,
)  # fmt: skip


def _disc_half_widths(radius: int) -> NDArray[np.int64]:
    rows = np.arange(-radius, radius + 1)
    widths: NDArray[np.int64] = np.floor(np.sqrt(radius * radius - rows * rows + radius)).astype(np.int64)
    return widths.clip(max=radius)


_DISC = _disc_half_widths(PATCH_RADIUS)


@njit(cache=True, nogil=True)
def _keep_corners(
    image: NDArray[np.uint8],
    threshold: int,
    scores: NDArray[np.uint8],
    corners: NDArray[np.int32],
    first: int,
    end: int,
) -> int:
    """Of the candidates `corners[first:end]` keep, and score in the image, those that are FAST-9 corners.

    The score is the largest threshold below which a pixel still is one: over all arcs of nine, the most by which the
    whole arc is brighter or darker. Shared parts of arcs are taken once, and candidates go through side by side, so
    that the compiler vectorises over them. Returns the new end.
    """
    difference = np.empty((16, _SIDE_BY_SIDE), np.int16)
    low2, high2 = np.empty_like(difference), np.empty_like(difference)
    low4, high4 = np.empty_like(difference), np.empty_like(difference)
    best = np.empty(_SIDE_BY_SIDE, np.int16)
    kept = first
    for start in range(first, end, _SIDE_BY_SIDE):
        count = min(_SIDE_BY_SIDE, end - start)
        for k in range(count):
            x, y = np.int64(corners[start + k, 0]), np.int64(corners[start + k, 1])
            centre = np.int16(image[y, x])
            for i in range(16):
                difference[i, k] = np.int16(image[y + _CIRCLE[i, 1], x + _CIRCLE[i, 0]]) - centre
        for i in range(16):
            a, b, low, high = difference[i], difference[(i + 1) & 15], low2[i], high2[i]
            for k in range(_SIDE_BY_SIDE):
                low[k], high[k] = min(a[k], b[k]), max(a[k], b[k])
        for i in range(16):
            a, b, low = low2[i], low2[(i + 2) & 15], low4[i]
            c, d, high = high2[i], high2[(i + 2) & 15], high4[i]
            for k in range(_SIDE_BY_SIDE):
                low[k], high[k] = min(a[k], b[k]), max(c[k], d[k])
        best[:] = 0
        for i in range(16):
            a, b, c, d = low4[i], low4[(i + 4) & 15], high4[i], high4[(i + 4) & 15]
            ninth = difference[(i + 8) & 15]
            for k in range(_SIDE_BY_SIDE):
                darkest = min(min(a[k], b[k]), ninth[k])
                brightest = max(max(c[k], d[k]), ninth[k])
                best[k] = max(best[k], max(darkest, -brightest))
        for k in range(count):
            if best[k] > threshold:
                x, y = np.int64(corners[start + k, 0]), np.int64(corners[start + k, 1])
                scores[y, x] = best[k]
                corners[kept, 0], corners[kept, 1] = x, y
                kept += 1
    return kept


_SIDE_BY_SIDE = 64
"""Candidates that are scored together: their differences fit the nearest cache."""


@njit(cache=True, nogil=True)
def _find_corners(
    image: NDArray[np.uint8],
    threshold: int,
    rectangle: tuple[int, int, int, int],
    scores: NDArray[np.uint8],
    corners: NDArray[np.int32],
    count: int,
) -> int:
    """Write the FAST score of every corner in a rectangle and append its x, y to `corners`; returns the new count.

    Any arc of nine on the circle of sixteen holds one of each opposite pair: a vectorised pass over the pairs leaves
    a few per cent of the pixels for the full test. `corners` has room for eight more than the rectangle has pixels.
    """
    x0, x1, y0, y1 = rectangle
    width = x1 - x0
    step, ceiling = np.uint8(threshold), np.uint8(255 - threshold)
    above, below = np.empty(width, np.uint8), np.empty(width, np.uint8)
    # Eight flags are looked at as one word: most words are 0.
    flags = np.zeros(8 * ((width + 7) // 8), np.uint8)
    words = flags.view(np.uint64)
    end = count
    for y in range(y0, y1):
        # Slices that start at zero let the compiler see that no index is negative, and vectorise.
        centre = image[y, x0:x1]
        n, s = image[y - 3, x0:x1], image[y + 3, x0:x1]
        e, w = image[y, x0 + 3 : x1 + 3], image[y, x0 - 3 : x1 - 3]
        ne, sw = image[y - 2, x0 + 2 : x1 + 2], image[y + 2, x0 - 2 : x1 - 2]
        se, nw = image[y + 2, x0 + 2 : x1 + 2], image[y - 2, x0 - 2 : x1 - 2]
        nne, ssw = image[y - 3, x0 + 1 : x1 + 1], image[y + 3, x0 - 1 : x1 - 1]
        ene, wsw = image[y - 1, x0 + 3 : x1 + 3], image[y + 1, x0 - 3 : x1 - 3]
        sse, nnw = image[y + 3, x0 + 1 : x1 + 1], image[y - 3, x0 - 1 : x1 - 1]
        ese, wnw = image[y + 1, x0 + 3 : x1 + 3], image[y - 1, x0 - 3 : x1 - 3]
        for i in range(width):
            above[i] = min(centre[i], ceiling) + step
            below[i] = max(centre[i], step) - step
        for i in range(width):
            h, d = above[i], below[i]
            bright = ((n[i] > h) | (s[i] > h)) & ((e[i] > h) | (w[i] > h))
            bright &= ((ne[i] > h) | (sw[i] > h)) & ((se[i] > h) | (nw[i] > h))
            dark = ((n[i] < d) | (s[i] < d)) & ((e[i] < d) | (w[i] < d))
            dark &= ((ne[i] < d) | (sw[i] < d)) & ((se[i] < d) | (nw[i] < d))
            bright &= ((nne[i] > h) | (ssw[i] > h)) & ((ene[i] > h) | (wsw[i] > h))
            bright &= ((sse[i] > h) | (nnw[i] > h)) & ((ese[i] > h) | (wnw[i] > h))
            dark &= ((nne[i] < d) | (ssw[i] < d)) & ((ene[i] < d) | (wsw[i] < d))
            dark &= ((sse[i] < d) | (nnw[i] < d)) & ((ese[i] < d) | (wnw[i] < d))
            flags[i] = bright | dark
        for k in range(len(words)):
            if words[k] == 0:
                continue
            # Written always and counted where flagged: a branch here is mispredicted more often than it saves.
            for i in range(8 * k, 8 * k + 8):
                corners[end, 0], corners[end, 1] = x0 + i, y
                end += flags[i]
    return int(_keep_corners(image, threshold, scores, corners, count, end))


@njit(cache=True, nogil=True)
def detect_corners(
    image: NDArray[np.uint8],
    high: int,
    low: int,
    cell: int,
    quota: int,
) -> NDArray[np.int32]:
    """FAST corners of one level, at most `quota`, spread over the image.

    The high threshold is used first; a cell that stays empty is searched again with the low one. Of the local maxima
    the best of every spreading cell is taken, then the second best, and so on until the quota is full.

    Args:
        image: (h, w) the level.
        high, low: thresholds in grey values.
        cell: side in pixels of the cells in which the threshold adapts.
        quota: how many corners to keep.

    Returns:
        (n, 2) x, y in pixels of the level.
    """
    height, width = image.shape
    # Of the type of any number: with a literal one, what is called below would be compiled for each kind.
    left, top, count = int(np.int64(BORDER)), int(np.int64(BORDER)), int(np.int64(0))
    right, bottom = width - BORDER, height - BORDER
    if right <= left or bottom <= top:
        return np.empty((0, 2), np.int32)
    scores = np.zeros((height, width), np.uint8)
    corners = np.empty(((right - left) * (bottom - top) + 8, 2), np.int32)
    columns = (right - left + cell - 1) // cell
    occupied = np.empty(columns, np.bool_)
    for y0 in range(top, bottom, cell):
        y1 = min(y0 + cell, bottom)
        before = count
        count = _find_corners(image, high, (left, right, y0, y1), scores, corners, count)
        occupied[:] = False
        for i in range(before, count):
            occupied[(corners[i, 0] - left) // cell] = True
        if low >= high:
            continue
        # Empty neighbours are searched as one: long rows are quick, and a row of one cell costs nearly as much.
        column = 0
        while column < columns:
            first = column
            while column < columns and not occupied[column]:
                column += 1
            if column > first:
                run = (left + first * cell, min(left + column * cell, right), y0, y1)
                count = _find_corners(image, low, run, scores, corners, count)
            column += 1

    maxima = 0
    for i in range(count):
        x, y = corners[i]
        score = scores[y, x]
        # Ties go to the later pixel, so that a plateau keeps one corner.
        if (
            scores[y - 1, x - 1] > score or scores[y - 1, x] > score or scores[y - 1, x + 1] > score
            or scores[y, x - 1] > score or scores[y, x + 1] >= score
            or scores[y + 1, x - 1] >= score or scores[y + 1, x] >= score or scores[y + 1, x + 1] >= score
        ):  # fmt: skip
            continue
        corners[maxima, 0], corners[maxima, 1] = x, y
        maxima += 1
    if maxima <= quota:
        return corners[:maxima].copy()
    return _spread(corners[:maxima], scores, (left, right, top, bottom), quota)


@njit(cache=True, nogil=True)
def _spread(
    corners: NDArray[np.int32], scores: NDArray[np.uint8], bounds: tuple[int, int, int, int], quota: int
) -> NDArray[np.int32]:
    """The `quota` corners that are best by rank within their cell, then by score."""
    left, right, top, bottom = bounds
    side = max(1.0, math.sqrt((right - left) * (bottom - top) / quota))
    columns = int((right - left) / side) + 1
    rows = int((bottom - top) / side) + 1
    count = corners.shape[0]

    # Order by falling score; scores are bytes, so a counting sort does it.
    starts = np.zeros(257, np.int64)
    for i in range(count):
        starts[256 - np.int64(scores[corners[i, 1], corners[i, 0]])] += 1
    for rest in range(1, 257):
        starts[rest] += starts[rest - 1]
    order = np.empty(count, np.int64)
    for i in range(count):
        key = 255 - np.int64(scores[corners[i, 1], corners[i, 0]])
        order[starts[key]] = i
        starts[key] += 1

    taken = np.zeros(columns * rows, np.int64)
    rank = np.empty(count, np.int64)
    per_rank = np.zeros(count + 1, np.int64)
    for k in range(count):
        i = order[k]
        where = int((corners[i, 1] - top) / side) * columns + int((corners[i, 0] - left) / side)
        rank[i] = taken[where]
        taken[where] += 1
        per_rank[rank[i]] += 1
    full, total = 0, 0
    while total + per_rank[full] <= quota:
        total += int(per_rank[full])
        full += 1
    kept = np.empty((quota, 2), np.int32)
    n = 0
    spare = quota - total
    for k in range(count):
        i = order[k]
        if rank[i] < full or (rank[i] == full and spare > 0):
            if rank[i] == full:
                spare -= 1
            kept[n, 0], kept[n, 1] = corners[i, 0], corners[i, 1]
            n += 1
    return kept[:n]


@njit(cache=True, nogil=True)
def orientations(image: NDArray[np.uint8], corners: NDArray[np.int32]) -> NDArray[np.float32]:
    """Direction in radians, [0, 2π), from each corner to the intensity centroid of the disc around it."""
    angles = np.empty(corners.shape[0], np.float32)
    for i in range(corners.shape[0]):
        x, y = np.int64(corners[i, 0]), np.int64(corners[i, 1])
        moment_x, moment_y = 0, 0
        for dy in range(-PATCH_RADIUS, PATCH_RADIUS + 1):
            half = int(_DISC[dy + PATCH_RADIUS])
            row_sum = 0
            row_moment = 0
            for dx in range(-half, half + 1):
                value = int(image[y + dy, x + dx])
                row_sum += value
                row_moment += dx * value
            moment_x += row_moment
            moment_y += dy * row_sum
        angle = math.atan2(float(moment_y), float(moment_x))
        angles[i] = angle if angle >= 0.0 else angle + 2.0 * math.pi
    return angles


@njit(cache=True, nogil=True)
def describe(
    blurred: NDArray[np.uint8],
    corners: NDArray[np.int32],
    angles: NDArray[np.float32],
    steered: NDArray[np.int64],
    descriptors: NDArray[np.uint64],
) -> None:
    """Write the 256-bit steered BRIEF descriptor of each corner.

    Args:
        blurred: (h, w) contiguous, the level after smoothing.
        corners: (n, 2) x, y in pixels of the level.
        angles: (n,) their directions in radians.
        steered: (bins, 512) offsets dy·w + dx of the test pairs, rotated to each of `bins` directions.
        descriptors: (n, 4) output, 64 bits a word.
    """
    flat = blurred.reshape(-1)
    width = blurred.shape[1]
    bins = steered.shape[0]
    step = bins / (2.0 * math.pi)
    for i in range(corners.shape[0]):
        offsets = steered[int(angles[i] * step + 0.5) % bins]
        centre = np.int64(corners[i, 1]) * width + np.int64(corners[i, 0])
        for word in range(4):
            bits = np.uint64(0)
            base = word * 128
            for bit in range(64):
                first = flat[centre + offsets[base + 2 * bit]]
                second = flat[centre + offsets[base + 2 * bit + 1]]
                bits |= np.uint64(first < second) << np.uint64(bit)
            descriptors[i, word] = bits


@njit(cache=True, nogil=True)
def sample_depth(
    depth: NDArray[np.float32],
    pixels: NDArray[np.float32],
    radius: int,
    tolerance: float,
    nearest: float,
    farthest: float,
) -> NDArray[np.float32]:
    """Depth in metres at each raw pixel (n, 2); 0 where it is missing or cannot be trusted.

    The reading at the rounded pixel is taken, without interpolation; where it disagrees with the median of the valid
    readings around it by more than `tolerance` (a share of the depth), the pixel lies on an edge and has no depth.
    """
    height, width = depth.shape
    values = np.empty((2 * radius + 1) * (2 * radius + 1))
    result = np.zeros(pixels.shape[0], np.float32)
    for i in range(pixels.shape[0]):
        x, y = int(pixels[i, 0] + 0.5), int(pixels[i, 1] + 0.5)
        if x < 0 or y < 0 or x >= width or y >= height:
            continue
        centre = depth[y, x]
        if not (nearest <= centre <= farthest):
            continue
        count = 0
        near, far = centre, centre
        for yy in range(max(0, y - radius), min(height, y + radius + 1)):
            for xx in range(max(0, x - radius), min(width, x + radius + 1)):
                value = depth[yy, xx]
                if nearest <= value <= farthest:
                    values[count] = value
                    near, far = min(near, value), max(far, value)
                    count += 1
        if far - near > 2.0 * tolerance * centre and abs(median(values, count) - centre) > tolerance * centre:
            continue
        result[i] = centre
    return result
