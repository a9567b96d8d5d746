"""The pose on which most observations agree, whatever the others say (Fischler and Bolles 1981)."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Consensus:
    """A pose and who agrees: camera from world (4×4), and the rows (m,) of the observations that it explains."""

    camera_from_world: NDArray[np.float64]
    rows: NDArray[np.int64]


def largest_consensus(
    positions: NDArray[np.float64],
    pixels: NDArray[np.float32],
    intrinsics: NDArray[np.float64],
    trials: int,
    tolerance: float,
) -> Consensus | None:
    """Hypotheses from four random points each; the one with most inliers. The same input gives the same output.

    Args:
        positions: (n, 3) of the points seen, metres, world frame.
        pixels: (n, 2) where they are seen, undistorted.
        intrinsics: fx, fy, cx, cy and more.
        trials: hypotheses at most.
        tolerance: reprojection error of an inlier, pixels.
    """
    if len(positions) < 4:
        return None
    fx, fy, cx, cy = intrinsics[:4]
    found, turn, shift, inliers = cv2.solvePnPRansac(
        positions,
        pixels.astype(np.float64),
        np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]]),
        None,
        iterationsCount=trials,
        reprojectionError=tolerance,
        confidence=0.999,
        flags=cv2.SOLVEPNP_AP3P,
    )
    if not found or inliers is None:
        return None
    camera_from_world = np.eye(4)
    camera_from_world[:3, :3] = cv2.Rodrigues(turn)[0]
    camera_from_world[:3, 3] = shift[:, 0]
    return Consensus(camera_from_world, inliers[:, 0].astype(np.int64))
