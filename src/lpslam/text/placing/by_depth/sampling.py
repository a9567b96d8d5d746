"""Depths and points inside quadrilaterals of an image, and the plane that they lie on."""

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import PlacementConfig
from lpslam.text.placing.views import sides_of, unit
from lpslam.text.reading.boxes import along_the_lines, letter_heights

Array = NDArray[np.float64]


def depths_inside(
    quadrilateral: Array, depth: NDArray[np.float32], config: PlacementConfig
) -> tuple[Array, Array, int]:
    """Pixels (n, 2) and depths (n,) inside, thinned evenly, and how many pixels were looked at."""
    height, width = depth.shape
    low = np.clip(np.floor(quadrilateral.min(axis=0)), 0, [width - 1, height - 1]).astype(int)
    high = np.clip(np.ceil(quadrilateral.max(axis=0)), 0, [width - 1, height - 1]).astype(int)
    mask = np.zeros(high[::-1] - low[::-1] + 1, np.uint8)
    cv2.fillConvexPoly(mask, np.round(quadrilateral - low).astype(np.int32), 1)
    rows, columns = np.nonzero(mask)
    step = -(-len(rows) // config.samples)
    rows, columns = rows[::step] + low[1], columns[::step] + low[0]
    values = depth[rows, columns].astype(np.float64)
    usable = np.isfinite(values) & (values >= config.min_depth) & (values <= config.max_depth)
    return np.column_stack([columns, rows])[usable].astype(np.float64), values[usable], len(values)


def points_inside(
    quadrilateral: Array, points: Array, camera: PinholeCamera, config: PlacementConfig
) -> tuple[Array, Array]:
    """Of points (n, 3) in the camera's frame those seen inside: their rays (m, 3) and depths (m,)."""
    points = points[(points[:, 2] >= config.min_depth) & (points[:, 2] <= config.max_depth)]
    quadrilateral = camera.undistort(quadrilateral)
    sides = np.roll(quadrilateral, -1, axis=0) - quadrilateral
    offsets = camera.project(points)[:, None] - quadrilateral
    inside = (sides[:, 0] * offsets[..., 1] - sides[:, 1] * offsets[..., 0] > 0.0).all(axis=1)
    depths = points[inside, 2]
    return points[inside] / depths[:, None], depths


def grown(box: Array, share: float) -> Array:
    """The box (4, 2) with so large a share of its letters' height added on every side."""
    along, across = map(unit, sides_of(box))
    outwards = np.array([-along - across, along - across, along + across, across - along])
    return np.asarray(box + share * float(letter_heights(box[None])[0]) * outwards, dtype=np.float64)


def covered_share(box: Array, pixels: Array, area: int, config: PlacementConfig) -> float:
    """Share of a text's length along which its box has depth at pixels (n, 2), of so many that were looked at.

    Of a text beyond the sensor's reach, whoever walks by has all the depth: on a few letters, and not on the rest.
    """
    line = along_the_lines(box[None])[0]
    along, _ = sides_of(line)
    length = float(np.linalg.norm(along))
    parts = max(_FEWEST_PARTS, round(_PARTS_OF_A_LETTER * length / max(float(letter_heights(box[None])[0]), 1.0)))
    at = (pixels - line.mean(axis=0)) @ unit(along) / (config.inner_share * length) + 0.5
    counts = np.bincount(np.clip((at * parts).astype(int), 0, parts - 1), minlength=parts)
    return float(np.mean(counts >= max(1.0, config.min_depth_share * area / parts)))


_PARTS_OF_A_LETTER = 3
"""Of a text's length, in the height of a letter: each has depth or not."""

_FEWEST_PARTS = 8
"""Of a short word."""


def fit_inverse_depth_plane(
    rays: Array, inverse_depths: Array, config: PlacementConfig
) -> tuple[Array, NDArray[np.bool_]]:
    """Fit a plane robustly to points seen along rays.

    On a plane the inverse depth is linear in the ray (x/z, y/z, 1), and there the error of a stereo or
    structured-light sensor, which grows with depth squared, is the same everywhere: plain least squares is then right.

    Args:
        rays: (n, 3) with third component 1.
        inverse_depths: (n,) 1/m.
        config: band, trials.

    Returns:
        (3,) coefficients c with inverse depth = rays @ c, and which points (n,) lie on the plane.
    """
    # A fixed seed: the same picture gives the same map.
    triples = np.random.default_rng(0).integers(0, len(rays), (config.trials, 3))
    systems = rays[triples]
    solvable = np.abs(np.linalg.det(systems)) > 1e-9
    candidates = np.zeros((0, 3))
    if solvable.any():
        candidates = np.linalg.solve(systems[solvable], inverse_depths[triples[solvable]][:, :, None])[:, :, 0]
    flat = np.array([[0.0, 0.0, float(np.median(inverse_depths))]])
    candidates = np.vstack([flat, candidates])
    residuals = np.abs(inverse_depths - candidates @ rays.T)
    coefficients = candidates[(residuals < config.inverse_depth_band).sum(axis=1).argmax()]
    for _ in range(3):
        inliers = np.abs(inverse_depths - rays @ coefficients) < config.inverse_depth_band
        if inliers.sum() < 3:
            break
        coefficients = np.linalg.lstsq(rays[inliers], inverse_depths[inliers], rcond=None)[0]
    return coefficients, np.abs(inverse_depths - rays @ coefficients) < config.inverse_depth_band
