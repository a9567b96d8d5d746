"""How the camera has moved since the frame before, from corners followed by flow, near and far, mapped or not."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import SurfaceConfig, TurningConfig
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.tracking.surfaces import LEAST_SECONDS

_Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Glance:
    """What turns are found from: grey values (h, w) of a picture made smaller, and its whole depth in metres."""

    gray: NDArray[np.uint8]
    depth: NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Moved:
    """A motion (4×4, now from before), and whether its step is told as well as its turn."""

    motion: _Matrix
    is_step_told: bool


class Turning:
    """Finds the motion between two pictures from corners.

    Most of what moves in a picture between two frames is the camera's turn: it is known from any corners, while the
    step needs their depth, and is taken from the motion as far as they do not tell it. Pictures are made smaller: what
    blur and noise leave of them is coarse.

    Args:
        camera: of the pictures.
        config, guess: thresholds, and how sure guesses are.
    """

    def __init__(self, camera: PinholeCamera, config: TurningConfig, guess: SurfaceConfig) -> None:
        self._camera = camera
        self._config = config
        self._guess = guess
        self._shrink = max(camera.width / config.width, 1.0)
        self._size = (round(camera.width / self._shrink), round(camera.height / self._shrink))
        self._focal = 0.5 * (camera.fx + camera.fy) / self._shrink

    def glance(self, gray: NDArray[np.uint8], depth: NDArray[np.float32]) -> Glance:
        """A picture as turns are found from it, of grey values and depth (h, w)."""
        return Glance(np.asarray(cv2.resize(gray, self._size, interpolation=cv2.INTER_AREA), np.uint8), depth)

    def told(self, before: Glance, now: Glance, guess: _Matrix, seconds: float) -> Moved | None:
        """The motion that corners tell; None if they tell none.

        Args:
            before, now: the two pictures.
            guess: 4×4, the motion as it is expected.
            seconds: for which the motion has been guessed.
        """
        config = self._config
        corners = self._followed(before, now, guess)
        if corners is None:
            return None
        rays, inverse_depth, seen = corners
        sigma = self._guess.guess_speed * max(seconds, LEAST_SECONDS)
        turn = _turn_between(rays, inverse_depth[:, None] * guess[:3, 3], _unit(seen), guess[:3, :3], self._focal)
        motion, residuals, information = _refined(
            rays, inverse_depth, seen[:, :2], turn, guess[:3, 3], sigma, self._focal, self._guess.nearest
        )
        if np.count_nonzero(residuals < config.pixels) < max(config.agreement * len(rays), config.min_corners):
            return None
        firmest = (sigma * self._guess.told_share) ** -2
        return Moved(motion, bool(np.linalg.eigvalsh(information)[0] > firmest))

    def _followed(self, before: Glance, now: Glance, guess: _Matrix) -> tuple[_Matrix, _Matrix, _Matrix] | None:
        """Corners of the one picture, rays (n, 3) with z = 1 and inverse depths (n,), and rays (n, 3) of the other."""
        config = self._config
        distance = config.corner_distance * self._size[0]
        found: Any = cv2.goodFeaturesToTrack(before.gray, config.corners, config.corner_quality, distance)
        if found is None:
            return None
        pixels = found.reshape(-1, 2).astype(np.float32)
        rays, inverse_depth = self._rays(pixels), self._inverse_depth(before, pixels)
        ahead = rays @ guess[:3, :3].T + inverse_depth[:, None] * guess[:3, 3]
        ahead[:, 2] = np.maximum(ahead[:, 2], self._guess.nearest)
        start = self._smaller(self._camera.distort(self._camera.project(ahead))).astype(np.float32)
        in_image = ((start >= 0) & (start < np.array(self._size))).all(axis=1)
        pixels, start = pixels[in_image], start[in_image]
        rays, inverse_depth = rays[in_image], inverse_depth[in_image]
        if len(pixels) < config.min_corners:
            return None
        moved, found_there = self._flow(before.gray, now.gray, pixels, start)
        # A blank picture is agreed with everywhere; nothing of it leads back.
        back, found_back = self._flow(now.gray, before.gray, moved, pixels)
        ok = found_there & found_back & (np.linalg.norm(back - pixels, axis=1) < config.pixels)
        if np.count_nonzero(ok) < config.min_corners:
            return None
        return rays[ok], inverse_depth[ok], self._rays(moved[ok])

    def _flow(
        self, before: NDArray[np.uint8], now: NDArray[np.uint8], pixels: NDArray[np.float32], start: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """Where pixels (n, 2) of one picture are in another, sought from `start` (n, 2), and whether that is said."""
        moved, status, _ = cv2.calcOpticalFlowPyrLK(
            before,
            now,
            pixels,
            start.copy(),
            winSize=(self._config.window, self._config.window),
            maxLevel=self._config.levels,
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )
        return moved.reshape(-1, 2).astype(np.float32), status.reshape(-1) == 1

    def _smaller(self, raw: _Matrix) -> _Matrix:
        """Pixels (n, 2) of the camera in the smaller picture."""
        small: _Matrix = (raw + 0.5) / self._shrink - 0.5
        return small

    def _rays(self, small: NDArray[np.float32]) -> _Matrix:
        """(n, 3) with z = 1 through pixels (n, 2) of the smaller picture."""
        raw = (small.astype(np.float64) + 0.5) * self._shrink - 0.5
        return np.asarray(self._camera.back_project(self._camera.undistort(raw), np.ones(len(raw))), np.float64)

    def _inverse_depth(self, glance: Glance, small: NDArray[np.float32]) -> _Matrix:
        """(n,) 1/m at pixels (n, 2) of the smaller picture; what has no depth is taken for far away."""
        raw = np.rint((small + 0.5) * self._shrink - 0.5).astype(np.int64)
        height, width = glance.depth.shape
        depth = glance.depth[np.clip(raw[:, 1], 0, height - 1), np.clip(raw[:, 0], 0, width - 1)].astype(np.float64)
        nearest = self._guess.nearest
        return np.where((depth > nearest) & np.isfinite(depth), 1.0 / np.maximum(depth, nearest), 0.0)


def _turn_between(rays: _Matrix, shift: _Matrix, seen: _Matrix, turn: _Matrix, focal: float) -> _Matrix:
    """Rotation (3×3) that best takes `rays` (n, 3), then shifted (n, 3), to unit vectors (n, 3).

    Weighted Procrustes (Kabsch 1976) with weights after Cauchy whose scale shrinks, so that no start is too far off.
    """
    for scale in _SCALES:
        ahead = _unit(rays @ turn.T + shift)
        weights = 1.0 / (1.0 + (focal * np.linalg.norm(ahead - seen, axis=1) / scale) ** 2)
        left, _, right = np.linalg.svd((weights[:, None] * seen).T @ ahead)
        turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right @ turn
    return turn


def _refined(
    rays: _Matrix,
    inverse_depth: _Matrix,
    seen: _Matrix,
    turn: _Matrix,
    step: _Matrix,
    sigma: float,
    focal: float,
    nearest: float,
) -> tuple[_Matrix, _Matrix, _Matrix]:
    """Gauss-Newton over turn and step, from the turn (3×3) and a guess of the step (3,) that is good to sigma metres.

    Args:
        rays: (n, 3) with z = 1 of corners before.
        inverse_depth: (n,) of them, 1/m.
        seen: (n, 2) where they are now, on the plane z = 1.
        focal: pixels; residuals are taken for a pixel's.
        nearest: metres ahead at which what is nearer, or behind, is taken to be.

    Returns:
        The motion (4×4), residuals (n,) in pixels, and what the corners alone tell of the step (3×3, 1/m²).
    """
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = turn, step
    for scale in (*_FINE_SCALES, None):
        ahead = rays @ motion[:3, :3].T + inverse_depth[:, None] * motion[:3, 3]
        z = np.maximum(ahead[:, 2], nearest)
        off = focal * (ahead[:, :2] / z[:, None] - seen)
        residuals = np.linalg.norm(off, axis=1)
        if scale is None:
            break
        weights = 1.0 / (1.0 + (residuals / scale) ** 2)
        along = np.zeros((len(z), 2, 3))
        along[:, 0, 0] = along[:, 1, 1] = focal / z
        along[:, :, 2] = -focal * ahead[:, :2] / (z * z)[:, None]
        turned = np.cross(ahead[:, None, :], along)
        jacobian = np.concatenate([along * inverse_depth[:, None, None], turned], axis=2)
        hessian = np.einsum("n,nij,nik->jk", weights, jacobian, jacobian)
        gradient = np.einsum("n,nij,ni->j", weights, jacobian, off)
        # What corners tell of the step when the turn is free.
        across = hessian[:3, 3:] @ np.linalg.pinv(hessian[3:, 3:]) @ hessian[3:, :3]
        information = hessian[:3, :3] - across
        hessian[:3, :3] += np.eye(3) / sigma**2
        gradient[:3] += (motion[:3, 3] - step) / sigma**2
        change = -np.linalg.solve(hessian + 1e-9 * np.eye(6), gradient)
        motion[:3, :3] = exponential(np.concatenate([np.zeros(3), change[3:]]))[:3, :3] @ motion[:3, :3]
        motion[:3, 3] += change[:3]
    return motion, residuals, information


def _unit(vectors: _Matrix) -> _Matrix:
    directions: _Matrix = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return directions


_SCALES = (64.0, 32.0, 16.0, 8.0, 4.0, 2.0, 1.0, 1.0)
"""Pixels: from as far as a turn may be from what was expected, down to the noise of flow."""

_FINE_SCALES = (4.0, 4.0, 2.0, 2.0, 1.0, 1.0, 1.0)
"""Pixels: the same, once the turn is about right."""
