"""Bundle adjustment in which the lens is free: poses, points and ten numbers that agree best with all observations.

Levenberg-Marquardt; points are eliminated (Schur complement), and what is left, poses and lens, is solved for directly.
The first view holds the frame; depth holds the scale.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve
from scipy.sparse import bsr_array, coo_array, csr_array

from lpslam.calibration.lens import NAMES, NEAREST, by_small_turn, project
from lpslam.slam.kernels.geometry import move

Array = NDArray[np.float64]

_LENS = len(NAMES)
_HUBER_PIXEL = 2.448
"""Standard deviations from which a pixel counts less: 95 % of a circular normal distribution lies within."""

_HUBER_DEPTH = 1.960
"""The same of a depth, on a line."""

_CONVERGED = 1e-5
"""Share of the cost by which a step must lower it for another one to be worth while."""


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """What was seen; n rows.

    Attributes:
        view, point: (n,) which view saw which point.
        pixels: (n, 2) raw u, v.
        drag: (n, 2) pixels a second; see `lens.project`.
        inverse_depth: (n,) 1/m; 0 where there is none.
        pixel_sigma: (n,) pixels.
        depth_sigma: (n,) 1/m, of the inverse depth; 1 where there is none.
    """

    view: NDArray[np.int64]
    point: NDArray[np.int64]
    pixels: Array
    drag: Array
    inverse_depth: Array
    pixel_sigma: Array
    depth_sigma: Array

    def where(self, chosen: NDArray[np.bool_]) -> "Observations":
        """Some of the rows."""
        return Observations(*(getattr(self, each.name)[chosen] for each in fields(self)))

    def scaled(self, pixel: float, depth: float) -> "Observations":
        """The same with other standard deviations, by these factors."""
        return replace(self, pixel_sigma=self.pixel_sigma * pixel, depth_sigma=self.depth_sigma * depth)


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """What is estimated: lens (10,), camera_from_world (v, 4, 4) and points (p, 3) of the world, metres."""

    lens: Array
    camera_from_world: Array
    points: Array


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """What is known of a lens beforehand: the numbers expected (10,), and their standard deviations (10,); 0 is fixed.

    Attributes:
        aspect_sigma: standard deviation of fx / fy around 1.
    """

    mean: Array
    sigma: Array
    aspect_sigma: float


def errors(seen: Observations, state: State) -> tuple[Array, Array]:
    """Whitened errors: pixels (n, 2), and inverse depths (n,), 0 where there is none."""
    moved = _in_cameras(seen, state)
    pixel = (seen.pixels - project(moved, state.lens, seen.drag).pixels) / seen.pixel_sigma[:, None]
    depth = (seen.inverse_depth - 1.0 / np.maximum(moved[:, 2], NEAREST)) / seen.depth_sigma
    return pixel, np.where(seen.inverse_depth > 0, depth, 0.0)


def adjust(seen: Observations, start: State, prior: Prior, steps: int) -> State:
    """Lower the robust (Huber) cost of all observations and of the prior.

    Args:
        seen: every point in it at least twice.
        start: first guess.
        prior: of the lens.
        steps: at most.
    """
    state, cost, damping = start, _cost(seen, start, prior), 1e-4
    free = _free_columns(len(start.camera_from_world), prior)
    for _ in range(steps):
        system = _System.at(seen, state, prior)
        for _ in range(8):
            proposed = _moved(state, *system.step(free, damping))
            new_cost = _cost(seen, proposed, prior)
            if new_cost < cost:
                break
            damping *= 10.0
        else:
            break
        gained, state, cost = cost - new_cost, proposed, new_cost
        damping = max(damping * 0.1, 1e-9)
        if gained < _CONVERGED * cost:
            break
    return state


def lens_covariance(seen: Observations, state: State, prior: Prior) -> Array:
    """(10, 10) covariance of the lens for observations as exact as their sigmas say; zero where it is fixed."""
    free = _free_columns(len(state.camera_from_world), prior)
    return _System.at(seen, state, prior).lens_covariance(free)


def _free_columns(views: int, prior: Prior) -> NDArray[np.int64]:
    """Poses but the first, and what the prior leaves free of the lens."""
    return np.concatenate([np.arange(6, 6 * views), 6 * views + np.flatnonzero(prior.sigma > 0)])


def _in_cameras(seen: Observations, state: State) -> Array:
    poses = state.camera_from_world[seen.view]
    return np.asarray(np.einsum("nij,nj->ni", poses[:, :3, :3], state.points[seen.point]) + poses[:, :3, 3])


def _cost(seen: Observations, state: State, prior: Prior) -> float:
    pixel, depth = errors(seen, state)
    by_prior = _prior_errors(state.lens, prior)[0]
    robust = _huber(np.linalg.norm(pixel, axis=1), _HUBER_PIXEL).sum() + _huber(np.abs(depth), _HUBER_DEPTH).sum()
    return float(robust + (by_prior**2).sum())


def _huber(error: Array, bend: float) -> Array:
    return np.where(error <= bend, error**2, 2.0 * bend * error - bend**2)


def _prior_errors(lens: Array, prior: Prior) -> tuple[Array, Array]:
    """Whitened errors (11,) of a lens against what is known of it, and their derivatives (11, 10)."""
    off, slope = np.zeros(_LENS + 1), np.zeros((_LENS + 1, _LENS))
    known = np.flatnonzero(prior.sigma > 0)
    off[known] = (prior.mean[known] - lens[known]) / prior.sigma[known]
    slope[known, known] = 1.0 / prior.sigma[known]
    off[_LENS] = -np.log(lens[0] / lens[1]) / prior.aspect_sigma
    slope[_LENS, :2] = np.array([1.0 / lens[0], -1.0 / lens[1]]) / prior.aspect_sigma
    return off, slope


@dataclass(frozen=True, slots=True, eq=False)
class _System:
    """Normal equations: poses and lens (a, a), points (p, 3, 3), between them (a, 3 p), and the right sides."""

    hessian: Array
    points: Array
    cross: csr_array
    right: Array
    points_right: Array

    @classmethod
    def at(cls, seen: Observations, state: State, prior: Prior) -> "_System":
        """Linearise at a state, with the weights of Huber's cost."""
        views, points = len(state.camera_from_world), len(state.points)
        by_frame, by_point, right = _linearised(seen, state)
        count = len(seen.view)
        rows = np.arange(3 * count).reshape(count, 3, 1)
        lens_columns = np.broadcast_to(6 * views + np.arange(_LENS), (count, _LENS))
        columns = np.concatenate([6 * seen.view[:, None] + np.arange(6), lens_columns], axis=1)
        frames = _sparse(by_frame, rows, columns, 6 * views + _LENS)
        structure = _sparse(by_point, rows, 3 * seen.point[:, None] + np.arange(3), 3 * points)
        blocks = np.zeros((points, 9))
        products = (by_point.transpose(0, 2, 1) @ by_point).reshape(count, 9)
        for k in range(9):
            blocks[:, k] = np.bincount(seen.point, products[:, k], points)
        hessian, off = (frames.T @ frames).toarray(), frames.T @ right.ravel()
        by_prior, slope = _prior_errors(state.lens, prior)
        hessian[-_LENS:, -_LENS:] += slope.T @ slope
        off[-_LENS:] += slope.T @ by_prior
        cross = csr_array(frames.T @ structure)
        return cls(hessian, blocks.reshape(-1, 3, 3), cross, off, structure.T @ right.ravel())

    def step(self, free: NDArray[np.int64], damping: float) -> tuple[Array, Array]:
        """What poses and lens (a,), and points (p, 3), should move by."""
        diagonal = np.einsum("pii->pi", self.points)
        damped = self.points + damping * diagonal[:, :, None] * np.eye(3) + 1e-9 * np.eye(3)
        reduced, right, inverse = self._reduced(free, damped)
        scale = np.sqrt(np.maximum(np.diag(self.hessian)[free], 1e-12))
        reduced = reduced / np.outer(scale, scale) + damping * np.eye(len(free))
        move_frames = np.zeros(len(self.hessian))
        move_frames[free] = solve(reduced, right / scale, assume_a="pos") / scale
        left = (self.points_right - self.cross.T @ move_frames).reshape(-1, 3)
        return move_frames, np.einsum("pij,pj->pi", inverse, left)

    def lens_covariance(self, free: NDArray[np.int64]) -> Array:
        """(10, 10); zero where the lens is fixed."""
        reduced, _, _ = self._reduced(free, self.points + 1e-9 * np.eye(3))
        lens = np.flatnonzero(free >= len(self.hessian) - _LENS)
        scale = np.sqrt(np.maximum(np.diag(reduced), 1e-12))
        scaled = reduced / np.outer(scale, scale) + 1e-12 * np.eye(len(free))
        inverse = np.linalg.inv(scaled) / np.outer(scale, scale)
        covariance = np.zeros((_LENS, _LENS))
        numbers = free[lens] - (len(self.hessian) - _LENS)
        covariance[np.ix_(numbers, numbers)] = inverse[np.ix_(lens, lens)]
        return covariance

    def _reduced(self, free: NDArray[np.int64], points: Array) -> tuple[Array, Array, Array]:
        """The system without points, its right side, and the points' inverse blocks."""
        inverse = np.linalg.inv(points)
        count = len(points)
        blocks = bsr_array((inverse, np.arange(count), np.arange(count + 1)), shape=(3 * count, 3 * count))
        cross = self.cross[free]
        shared = cross @ csr_array(blocks)
        reduced = np.asarray(self.hessian[np.ix_(free, free)] - (shared @ cross.T).toarray())
        return reduced, np.asarray(self.right[free] - shared @ self.points_right), np.asarray(inverse)


def _linearised(seen: Observations, state: State) -> tuple[Array, Array, Array]:
    """Weighted derivatives by pose and lens (n, 3, 16) and by point (n, 3, 3), and weighted errors (n, 3)."""
    moved = _in_cameras(seen, state)
    projected = project(moved, state.lens, seen.drag)
    w = 1.0 / np.maximum(moved[:, 2], NEAREST)
    count = len(moved)
    by_moved = np.zeros((count, 3, 3))
    by_moved[:, :2], by_moved[:, 2, 2] = projected.by_point, -w * w
    off = np.column_stack([seen.pixels - projected.pixels, seen.inverse_depth - w])
    weights = np.column_stack([1.0 / seen.pixel_sigma, 1.0 / seen.pixel_sigma, 1.0 / seen.depth_sigma])
    weights[:, 2] *= seen.inverse_depth > 0
    whitened = np.abs(off * weights)
    weights[:, :2] *= np.sqrt(_HUBER_PIXEL / np.maximum(np.linalg.norm(whitened[:, :2], axis=1), _HUBER_PIXEL))[:, None]
    weights[:, 2] *= np.sqrt(_HUBER_DEPTH / np.maximum(whitened[:, 2], _HUBER_DEPTH))
    by_frame = np.zeros((count, 3, 6 + _LENS))
    by_frame[:, :, :3], by_frame[:, :, 3:6] = by_moved, by_moved @ by_small_turn(moved)
    by_frame[:, :2, 6:] = projected.by_lens
    by_point = by_moved @ state.camera_from_world[seen.view][:, :3, :3]
    return by_frame * weights[..., None], by_point * weights[..., None], off * weights


def _sparse(blocks: Array, rows: NDArray[np.int64], columns: NDArray[np.int64], width: int) -> csr_array:
    """Blocks (n, 3, k), each three rows of a matrix, at columns (n, k)."""
    shape = blocks.shape
    where = (np.broadcast_to(rows, shape).ravel(), np.broadcast_to(columns[:, None], shape).ravel())
    return csr_array(coo_array((blocks.ravel(), where), shape=(3 * shape[0], width)))


def _moved(state: State, frames: Array, points: Array) -> State:
    poses = state.camera_from_world.copy()
    for pose, twist in zip(poses, frames[:-_LENS].reshape(-1, 6), strict=True):
        move(pose, twist)
    lens = state.lens + frames[-_LENS:]
    # A step never takes the focal length beyond half or twice: the model is not straight so far.
    lens[:2] = np.clip(lens[:2], state.lens[:2] / 2.0, state.lens[:2] * 2.0)
    return State(lens, poses, state.points + points)
