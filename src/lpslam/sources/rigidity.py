"""Which focal length makes two views of a recording rigid: what the camera sees does not bend when it turns.

Matched pixels with depth are lifted by a focal length. With the right one, a rigid motion takes the points of one view
to those of the other. A wrong one squeezes the room along the optical axis, which a turn of the camera shows: what was
squeezed along one line of sight is now squeezed along another. A pure shift shows nothing, whatever the focal length.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ALIGNMENTS = 4  # rounds of closed-form alignment, each trusting those more that agreed in the last
_STEPS = 6  # Gauss-Newton steps on pixels and depth; from an alignment three or four suffice
_CUT = 9.0  # squared error, in variances, of which half counts: three standard deviations
_NEAREST = 0.05  # metres; what comes nearer than this, or behind the camera, is kept there


@dataclass(frozen=True, slots=True, eq=False)
class ViewPair:
    """The same n places in two views.

    Attributes:
        pixels, other_pixels: (n, 2) u, v in the first and in the other view.
        depth, other_depth: (n,) metres; above 0 in the first view, 0 in the other one where there is none.
    """

    pixels: Array
    depth: Array
    other_pixels: Array
    other_depth: Array


@dataclass(frozen=True, slots=True)
class MeasuringNoise:
    """Standard deviations: of a pixel, and of a depth z in metres as constant + quadratic · z²."""

    pixel: float
    depth: float
    depth_quadratic: float


def bending(pairs: Sequence[ViewPair], centre: tuple[float, float], focals: Array, noise: MeasuringNoise) -> Array:
    """How badly the best rigid motion explains each pair, for each focal length.

    Args:
        pairs: p of them.
        centre: the principal point, pixels.
        focals: (f,) pixels.
        noise: of the measurements.

    Returns:
        (p, f) mean robust squared errors in variances: about 1 to 2 for a rigid pair, at most 9 (Geman-McClure).
    """
    columns = _stacked(pairs)
    return np.stack([_bending_at(columns, centre, float(focal), noise) for focal in focals], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class _Columns:
    """Pairs of up to n places side by side: pixels (p, n, 2), depths and which of them exist (p, n)."""

    pixels: Array
    depth: Array
    other_pixels: Array
    other_depth: Array
    exists: Array
    has_other_depth: Array


def _stacked(pairs: Sequence[ViewPair]) -> _Columns:
    count = max(len(pair.depth) for pair in pairs)

    def padded(values: Array, fill: float) -> Array:
        gap = [(0, count - len(values))] + [(0, 0)] * (values.ndim - 1)
        return np.pad(values, gap, constant_values=fill)

    exists = np.stack([padded(np.ones(len(pair.depth)), 0.0) for pair in pairs])
    other_depth = np.stack([padded(pair.other_depth, 0.0) for pair in pairs])
    has_other = ((other_depth > 0) & (exists > 0)).astype(np.float64)
    return _Columns(
        pixels=np.stack([padded(pair.pixels, 0.0) for pair in pairs]),
        depth=np.stack([padded(pair.depth, 1.0) for pair in pairs]),
        other_pixels=np.stack([padded(pair.other_pixels, 0.0) for pair in pairs]),
        other_depth=np.where(has_other > 0, other_depth, 1.0),
        exists=exists,
        has_other_depth=has_other,
    )


def _bending_at(columns: _Columns, centre: tuple[float, float], focal: float, noise: MeasuringNoise) -> Array:
    points = _lifted(columns.pixels, columns.depth, centre, focal)
    others = _lifted(columns.other_pixels, columns.other_depth, centre, focal)
    rotation, shift = _aligned(points, others, columns.has_other_depth, noise)
    observed = columns.other_pixels - centre
    inverse = 1.0 / columns.other_depth
    spread = (noise.depth + noise.depth_quadratic * columns.other_depth**2) * inverse**2
    # Both views' depths stray.
    weight = columns.has_other_depth / (2.0 * spread**2)
    squared = np.empty_like(columns.depth)
    for step in range(_STEPS + 1):
        moved = points @ rotation.transpose(0, 2, 1) + shift[:, None]
        z = np.maximum(moved[..., 2], _NEAREST)
        x, y, w = moved[..., 0], moved[..., 1], 1.0 / z
        errors = np.stack([observed[..., 0] - focal * x * w, observed[..., 1] - focal * y * w, inverse - w], axis=-1)
        weights = np.stack([columns.exists / noise.pixel**2, columns.exists / noise.pixel**2, weight], axis=-1)
        squared = (errors**2 * weights).sum(axis=-1)
        if step == _STEPS:
            break
        trust = (_CUT / (_CUT + squared)) ** 2
        rotation, shift = _improved(rotation, shift, x, y, w, focal, errors, weights * trust[..., None])
    robust = squared * _CUT / (squared + _CUT)
    return np.asarray((robust * columns.exists).sum(axis=1) / columns.exists.sum(axis=1))


def _lifted(pixels: Array, depth: Array, centre: tuple[float, float], focal: float) -> Array:
    return np.concatenate([(pixels - centre) / focal, np.ones((*depth.shape, 1))], axis=-1) * depth[..., None]


def _aligned(points: Array, others: Array, exists: Array, noise: MeasuringNoise) -> tuple[Array, Array]:
    """Rigid motions (p, 3, 3), (p, 3) that take points nearest to others (Umeyama 1991), trusting those that agree."""
    z = others[..., 2]
    variance = 2.0 * (noise.depth + noise.depth_quadratic * z**2) ** 2
    base = exists / variance
    weights = base
    rotation, shift = np.eye(3)[None], np.zeros((len(points), 3))
    for _ in range(_ALIGNMENTS):
        total = weights.sum(axis=1)[:, None] + 1e-12
        centre = (weights[..., None] * points).sum(axis=1) / total
        other_centre = (weights[..., None] * others).sum(axis=1) / total
        covariance = np.einsum("pn,pni,pnj->pij", weights, others - other_centre[:, None], points - centre[:, None])
        u, _, vt = np.linalg.svd(covariance)
        u[..., 2] *= np.sign(np.linalg.det(u) * np.linalg.det(vt))[:, None]
        rotation = u @ vt
        shift = other_centre - np.einsum("pij,pj->pi", rotation, centre)
        off = ((others - points @ rotation.transpose(0, 2, 1) - shift[:, None]) ** 2).sum(axis=-1) / variance
        weights = base * (_CUT / (_CUT + off)) ** 2
    return rotation, shift


def _improved(
    rotation: Array, shift: Array, x: Array, y: Array, w: Array, focal: float, errors: Array, weights: Array
) -> tuple[Array, Array]:
    """One Gauss-Newton step: the motions turned and shifted a little in the other view's frame."""
    zero = np.zeros_like(x)
    a, b = x * w, y * w
    # Derivatives of u, v and 1/z by a shift (x, y, z) and a turn about x, y, z of the moved point.
    rows = [
        [focal * w, zero, -focal * a * w, -focal * a * b, focal * (1 + a * a), -focal * b],
        [zero, focal * w, -focal * b * w, -focal * (1 + b * b), focal * a * b, focal * a],
        [zero, zero, -w * w, -w * b, w * a, zero],
    ]
    jacobian = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    weighted = jacobian * weights[..., None]
    hessian = np.einsum("pnia,pnib->pab", weighted, jacobian)
    gradient = np.einsum("pnia,pni->pa", weighted, errors)
    hessian += 1e-6 * np.eye(6) * np.trace(hessian, axis1=1, axis2=2)[:, None, None] / 6 + 1e-9 * np.eye(6)
    step = np.linalg.solve(hessian, gradient[..., None])[..., 0]
    turn = _rotations(step[:, 3:])
    return turn @ rotation, np.einsum("pij,pj->pi", turn, shift) + step[:, :3]


def _rotations(turns: Array) -> Array:
    """(p, 3, 3) rotations of rotation vectors (p, 3), radians (Rodrigues)."""
    angle = np.linalg.norm(turns, axis=1)[:, None, None]
    cross = np.zeros((len(turns), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -turns[:, 2], turns[:, 1], -turns[:, 0]
    cross -= cross.transpose(0, 2, 1)
    turned = np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * (cross @ cross)
    return np.asarray(np.eye(3) + turned)
