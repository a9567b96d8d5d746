"""What the camera makes of an ideal picture: motion blur, exposure, vignetting, noise, and depth as sensors give it."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform

MIN_RANGE, MAX_RANGE = 0.3, 8.0  # metres
NOISE_FLOOR, NOISE_SLOPE = 0.0007, 0.0022  # metres, and metres per square metre: sigma = floor + slope z^2
BASELINE = 0.03  # metres between the depth sensor's two eyes, for the shadows beside near things
MARGIN = 48  # pixels by which the noise fields are larger than the image, to be shifted at random
MAX_TAPS = 33  # samples along the longest motion blur

Picture = NDArray[np.float32]
Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class NoiseFields:
    """Noise drawn once and shifted at random for every frame; each (fields, height + margin, width + margin).

    Attributes:
        white: unit variance, independent pixels (times three channels, the last axis).
        smooth: unit variance, correlated over a pixel or two, as depth errors are.
        clumps: unit variance, correlated over about six pixels: where depth is missing together.
    """

    white: NDArray[np.float32]
    smooth: NDArray[np.float32]
    clumps: NDArray[np.float32]


def draw_noise(rng: np.random.Generator, width: int, height: int) -> NoiseFields:
    """Draw the noise fields for images of a size."""
    shape = (height + MARGIN, width + MARGIN)
    white = 0.8 * rng.standard_normal((2, *shape, 3), dtype=np.float32)
    white += 0.6 * rng.standard_normal((2, *shape, 1), dtype=np.float32)
    return NoiseFields(white, _correlated(rng, 4, shape, 0.7), _correlated(rng, 3, shape, 3.0))


def _correlated(rng: np.random.Generator, count: int, shape: tuple[int, int], sigma: float) -> NDArray[np.float32]:
    fields = [cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), sigma) for _ in range(count)]
    return np.array([field / field.std() for field in fields], np.float32)


def _shifted(rng: np.random.Generator, fields: NDArray[np.float32], width: int, height: int) -> NDArray[np.float32]:
    layer = fields[int(rng.integers(len(fields)))]
    y, x = int(rng.integers(MARGIN)), int(rng.integers(MARGIN))
    return np.asarray(layer[y : y + height, x : x + width])


def expose(
    rng: np.random.Generator,
    colour: NDArray[np.float32],
    gain: float,
    noise: NoiseFields,
    vignette: NDArray[np.float32],
) -> NDArray[np.uint8]:
    """Turn ideal brightness into an 8-bit picture; `gain` is the exposure, more of it brings more noise."""
    height, width = colour.shape[:2]
    return _expose(colour, gain, _shifted(rng, noise.white, width, height), vignette)


@njit(cache=True, nogil=True, fastmath=True)
def _expose(colour: Picture, gain: float, noise: Picture, vignette: Picture) -> NDArray[np.uint8]:
    height, width = vignette.shape
    out = np.empty((height, width, 3), np.uint8)
    for row in range(height):
        for column in range(width):
            factor = gain * vignette[row, column]
            for c in range(3):
                value = colour[row, column, c] * factor
                # A soft shoulder instead of hard clipping, as cameras have.
                if value > 215.0:
                    value = 215.0 + 40.0 * (1.0 - np.exp((215.0 - value) / 40.0))
                value += noise[row, column, c] * (0.9 + 0.06 * np.sqrt(max(value, 0.0))) * (0.6 + 0.4 * gain)
                out[row, column, c] = np.uint8(min(max(value + 0.5, 0.0), 255.0))
    return out


def measure_again(
    rng: np.random.Generator,
    rgb: NDArray[np.uint8],
    depth: NDArray[np.float32],
    noise: NoiseFields,
    share: float,
) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """Put a share of the sensor's noise on top of what is in a measured pair already.

    Args:
        rng: decides the noise.
        rgb: (height, width, 3).
        depth: (height, width) metres, 0 where there is none, which stays so.
        noise: fields for images of this size.
        share: of the sensor's own noise; with 1 the variance doubles.
    """
    height, width = depth.shape
    grain = np.rint(share * 1.6 * _shifted(rng, noise.white, width, height)).astype(np.int16)
    error = _shifted(rng, noise.smooth, width, height) * (NOISE_FLOOR + NOISE_SLOPE * depth * depth)
    colour = cv2.add(rgb.astype(np.int16), grain, dtype=cv2.CV_8U)
    return np.asarray(colour, np.uint8), np.where(depth > 0, depth + np.float32(share) * error, 0).astype(np.float32)


def vignette_of(camera: PinholeCamera, strength: float) -> NDArray[np.float32]:
    """(height, width) brightness factors, 1 in the middle and 1 - strength in the corners."""
    x = (np.arange(camera.width) - camera.cx) / camera.width
    y = (np.arange(camera.height) - camera.cy) / camera.width
    radius2 = x[None, :] ** 2 + y[:, None] ** 2
    return np.asarray(1 - strength * radius2 / radius2.max(), np.float32)


def blur_by_motion(
    colour: NDArray[np.float32],
    depth: NDArray[np.float32],
    camera: PinholeCamera,
    world_from_start: NDArray[np.float64],
    world_from_middle: NDArray[np.float64],
    world_from_end: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Blur every pixel along the way that its point takes over the image while the shutter is open."""
    start = inverse_transform(world_from_start) @ world_from_middle
    end = inverse_transform(world_from_end) @ world_from_middle
    return _blur(colour, depth, start, end, camera.fx, camera.fy, camera.cx, camera.cy)


@njit(cache=True, nogil=True, fastmath=True)
def _blur(
    colour: Picture, depth: Picture, start: Matrix, end: Matrix, fx: float, fy: float, cx: float, cy: float
) -> Picture:
    height, width = depth.shape
    out = np.empty_like(colour)
    for row in range(height):
        ry = (row - cy) / fy
        for column in range(width):
            rx = (column - cx) / fx
            nearness = 1.0 / max(depth[row, column], 0.3)
            z1 = 1.0 / (start[2, 0] * rx + start[2, 1] * ry + start[2, 2] + start[2, 3] * nearness)
            z2 = 1.0 / (end[2, 0] * rx + end[2, 1] * ry + end[2, 2] + end[2, 3] * nearness)
            x1 = start[0, 0] * rx + start[0, 1] * ry + start[0, 2] + start[0, 3] * nearness
            x2 = end[0, 0] * rx + end[0, 1] * ry + end[0, 2] + end[0, 3] * nearness
            y1 = start[1, 0] * rx + start[1, 1] * ry + start[1, 2] + start[1, 3] * nearness
            y2 = end[1, 0] * rx + end[1, 1] * ry + end[1, 2] + end[1, 3] * nearness
            du, dv = fx * (x2 * z2 - x1 * z1), fy * (y2 * z2 - y1 * z1)
            taps = min(MAX_TAPS, int(math.sqrt(du * du + dv * dv)) + 1)
            if taps == 1:
                for c in range(3):
                    out[row, column, c] = colour[row, column, c]
                continue
            red = green = blue = 0.0
            for tap in range(taps):
                share = (tap + 0.5) / taps - 0.5
                u = min(max(column + share * du, 0.0), width - 1.001)
                v = min(max(row + share * dv, 0.0), height - 1.001)
                u0, v0 = int(u), int(v)
                a, b = u - u0, v - v0
                p, q, r, s = (1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b
                upper, lower = colour[v0], colour[v0 + 1]
                red += p * upper[u0, 0] + q * upper[u0 + 1, 0] + r * lower[u0, 0] + s * lower[u0 + 1, 0]
                green += p * upper[u0, 1] + q * upper[u0 + 1, 1] + r * lower[u0, 1] + s * lower[u0 + 1, 1]
                blue += p * upper[u0, 2] + q * upper[u0 + 1, 2] + r * lower[u0, 2] + s * lower[u0 + 1, 2]
            out[row, column, 0], out[row, column, 1], out[row, column, 2] = red / taps, green / taps, blue / taps
    return out


def measure_depth(
    rng: np.random.Generator,
    depth: NDArray[np.float32],
    seen: NDArray[np.int32],
    colour: NDArray[np.float32],
    normals_in_camera: NDArray[np.float64],
    gloss: NDArray[np.float32],
    camera: PinholeCamera,
    noise: NoiseFields,
) -> NDArray[np.float32]:
    """Depth as a sensor measures it: noise by range, ragged edges, shadows, and holes on dark, shiny or grazed faces.

    Args:
        rng: decides the shifts of the noise fields.
        depth: (height, width) exact metres.
        seen: (height, width) face numbers, -1 for none.
        colour: (height, width, 3) brightness on the scale of 0 to 255: dark faces return little light.
        normals_in_camera: (faces, 3) unit vectors.
        gloss: (faces,) 0 to 1.
        camera: calibration.
        noise: the fields.
    """
    height, width = depth.shape
    error, jitter_x, jitter_y = (_shifted(rng, noise.smooth, width, height) for _ in range(3))
    clumps = _shifted(rng, noise.clumps, width, height)
    intrinsics = (camera.fx, camera.fy, camera.cx, camera.cy)
    return _measure(depth, seen, colour, normals_in_camera, gloss, intrinsics, error, jitter_x, jitter_y, clumps)


@njit(cache=True, nogil=True)
def _measure(
    depth: Picture,
    seen: NDArray[np.int32],
    colour: Picture,
    normals: Matrix,
    gloss: Picture,
    intrinsics: tuple[float, float, float, float],
    error: Picture,
    jitter_x: Picture,
    jitter_y: Picture,
    clumps: Picture,
) -> Picture:
    height, width = depth.shape
    fx, fy, cx, cy = intrinsics
    out = np.zeros((height, width), np.float32)
    for row in range(height):
        for column in range(width):
            # Edges are ragged because every pixel measures a patch a little beside itself.
            nearest, farthest = 1e9, 0.0
            for y in range(max(0, row - 1), min(height, row + 2)):
                for x in range(max(0, column - 1), min(width, column + 2)):
                    nearest, farthest = min(nearest, depth[y, x]), max(farthest, depth[y, x])
            z = depth[row, column]
            face = seen[row, column]
            is_edge = farthest > nearest * 1.05
            if is_edge:
                y = min(max(int(row + 0.8 * jitter_y[row, column] + 0.5), 0), height - 1)
                x = min(max(int(column + 0.8 * jitter_x[row, column] + 0.5), 0), width - 1)
                z, face = depth[y, x], seen[y, x]
                if clumps[row, column] > 0.2:
                    continue
            if face < 0 or z < MIN_RANGE or z > MAX_RANGE:
                continue
            # Left of near things the second eye sees nothing.
            hidden = False
            for step in range(1, min(12, width - column - 1, int(fx * BASELINE / MIN_RANGE)) + 1):
                near = depth[row, column + step]
                if near > 0.0 and fx * BASELINE * (1.0 / near - 1.0 / z) > step:
                    hidden = True
                    break
            if hidden:
                continue
            rx, ry = (column - cx) / fx, (row - cy) / fy
            cosine = abs(normals[face, 0] * rx + normals[face, 1] * ry + normals[face, 2]) / np.sqrt(
                rx * rx + ry * ry + 1
            )
            if cosine < 0.18 and clumps[row, column] > (cosine - 0.06) * 18.0 - 0.6:
                continue
            brightness = (colour[row, column, 0] + colour[row, column, 1] + colour[row, column, 2]) / 3.0
            threshold = 2.6 - 1.6 * gloss[face] - (0.9 if brightness < 22.0 else 0.0)
            if clumps[row, column] > threshold:
                continue
            out[row, column] = z + error[row, column] * (NOISE_FLOOR + NOISE_SLOPE * z * z)
    return out
