"""The pose of a view in which things of known places are seen, by these and by keypoints around them.

Two ends of signs and one keypoint make a pose (perspective-three-point). Each keypoint that looks like a point around
the signs is tried; what looks the same at other places is never asked.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.slam.advice import Anchor

_Matrix = NDArray[np.float64]


def anchored_pose(
    anchor: Anchor,
    positions: _Matrix,
    pixels: NDArray[np.float32],
    intrinsics: _Matrix,
    tolerance: float,
    least: int,
) -> tuple[_Matrix, NDArray[np.intp]] | None:
    """The pose that most matches around an anchor agree with.

    Args:
        anchor: what is seen.
        positions: (n, 3) of points around it, metres, world frame.
        pixels: (n, 2) where they may be seen, undistorted.
        intrinsics: fx, fy, cx, cy and more.
        tolerance: pixels.
        least: matches that must agree.

    Returns:
        Camera from world (4×4), and the rows of the matches that agree; None where no pose explains so many.
    """
    fx, fy, cx, cy = intrinsics[:4]
    camera = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    corners, seen = anchor.corners.reshape(-1, 3), anchor.pixels(intrinsics).reshape(-1, 2)
    left_right, seen_left_right = _ends(anchor.corners), _ends(anchor.pixels(intrinsics))
    apart = np.linalg.norm(seen_left_right[:, None] - seen_left_right[None], axis=2)
    widest = list(np.unravel_index(int(apart.argmax()), apart.shape))
    ends, seen_ends = left_right[widest], seen_left_right[widest]
    best: tuple[_Matrix, NDArray[np.intp]] | None = None
    best_cost = np.inf
    for position, pixel in zip(positions, pixels.astype(np.float64), strict=True):
        known, at = np.vstack([ends, position]), np.vstack([seen_ends, pixel])
        for turn, shift in zip(*cv2.solveP3P(known, at, camera, None, flags=cv2.SOLVEPNP_AP3P)[1:], strict=True):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0], shift[:, 0]
            if not np.isfinite(pose).all() or not (_off(pose, corners, seen, camera) < tolerance).all():
                continue
            off = _off(pose, positions, pixels, camera)
            rows, cost = np.flatnonzero(off < tolerance), float(np.minimum(off, tolerance).sum())
            if len(rows) >= least and cost < best_cost:
                best, best_cost = (pose, rows), cost
    return best


def _ends(corners: _Matrix) -> _Matrix:
    """(2n, …) the middles of the left and right ends of signs (n, 4, …)."""
    return np.concatenate([(corners[:, 0] + corners[:, 3]) / 2, (corners[:, 1] + corners[:, 2]) / 2])


def _off(pose: _Matrix, points: _Matrix, pixels: NDArray[np.floating], camera: _Matrix) -> _Matrix:
    """(n,) pixels between where points are seen from a pose and where they were seen; infinite behind the camera."""
    local = points @ pose[:3, :3].T + pose[:3, 3]
    ahead = np.where(local[:, 2] > 0, local[:, 2], np.inf)
    at = local[:, :2] / ahead[:, None] * (camera[0, 0], camera[1, 1]) + camera[:2, 2]
    off: _Matrix = np.where(local[:, 2] > 0, np.linalg.norm(at - pixels, axis=1), np.inf)
    return off
