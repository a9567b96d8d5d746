"""Other lens models in the five numbers of Brown and Conrady, and by how many pixels they differ then."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError

Array = NDArray[np.float64]
Five = tuple[float, float, float, float, float]
Matrix = tuple[float, float, float, float]
_SAMPLES = 40
_REPLACED = 0.5
"""Pixels by which five numbers may differ from a lens model with more, anywhere in the image."""
WORTH_SAYING = 0.01
"""Pixels by which they differ without a word."""
_NAMES_OF_FIVE = ("plumb_bob", "brown conrady", "modified brown conrady", "")
_NO_PINHOLE = ("equidistant", "fisheye", "kannala", "thin_prism", "omni", "f-theta", "ftheta", "kb4")


def five_of(model: str, d: Sequence[float], size: tuple[int, int], matrix: Matrix, name: str) -> tuple[Five, float]:
    """The five numbers that stand for a lens model.

    Args:
        model: as ROS and librealsense name it, in lower case.
        d: its numbers.
        size: width and height, pixels.
        matrix: fx, fy, cx, cy, pixels.
        name: whose it is, for complaints.

    Returns:
        The five, and by how many pixels they differ from the model at most.

    Raises:
        UserError: they cannot stand for it, or the model is not known.
    """
    if not any(d):
        return (0.0, 0.0, 0.0, 0.0, 0.0), 0.0
    if model.startswith(_NO_PINHOLE):
        raise UserError(
            f"{name}: the lens model {model} is not a pinhole's; record rectified pictures (image_proc), "
            "or give their calibration with --camera FILE"
        )
    padded = [*d, *[0.0] * 8][: max(len(d), 8)]
    if model == "inverse brown conrady":
        five, off = fitted_inverse(padded, size, matrix)
    elif any(padded[5:8]) and not any(padded[8:]):
        five, off = fitted_rational(padded, size, matrix)
    elif model in _NAMES_OF_FIVE or model == "rational_polynomial":
        five, off = (padded[0], padded[1], padded[2], padded[3], padded[4]), float(any(padded[5:]))
    else:
        raise UserError(f"{name}: the lens model {model[:40]!r} is not known; record rectified pictures")
    if not off <= _REPLACED:
        raise UserError(
            f"{name}: k1, k2, p1, p2, k3 cannot stand for the lens model {model[:40]} (off by {off:.2g} pixels); "
            "record rectified pictures (image_proc)"
        )
    return five, off


@np.errstate(all="ignore")
def fitted_rational(k: Sequence[float], size: tuple[int, int], focal: Matrix) -> tuple[Five, float]:
    """Fit k1, k2, p1, p2, k3 to OpenCV's rational model.

    Args:
        k: k1, k2, p1, p2, k3, k4, k5, k6.
        size: width and height, pixels.
        focal: fx, fy, cx, cy, pixels.

    Returns:
        The five, and the largest difference within the image, pixels.
    """
    k1, k2, p1, p2, k3, k4, k5, k6 = (float(value) for value in k[:8])

    def distorted(points: Array) -> Array:
        x, y = points.T
        r2 = x * x + y * y
        radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        return np.column_stack(
            [
                x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
            ]
        )

    raw = _raw_rays(size, focal)
    return _fitted(_inverted(distorted, raw), raw, focal)


@np.errstate(all="ignore")
def fitted_inverse(k: Sequence[float], size: tuple[int, int], focal: Matrix) -> tuple[Five, float]:
    """Fit k1, k2, p1, p2, k3 to the same model run backwards, from raw rays to ideal ones, as RealSense states it.

    Args:
        k: k1, k2, p1, p2, k3.
        size: width and height, pixels.
        focal: fx, fy, cx, cy, pixels.

    Returns:
        The five, and the largest difference within the image, pixels.
    """
    k1, k2, p1, p2, k3 = (float(value) for value in k[:5])
    raw = _raw_rays(size, focal)
    x, y = raw.T
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    ideal = np.column_stack(
        [x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y * y)]
    )
    return _fitted(ideal, raw, focal)


def _raw_rays(size: tuple[int, int], focal: Matrix) -> Array:
    fx, fy, cx, cy = focal
    u, v = np.meshgrid(np.linspace(0, size[0] - 1, _SAMPLES), np.linspace(0, size[1] - 1, _SAMPLES))
    return np.column_stack([(u.ravel() - cx) / fx, (v.ravel() - cy) / fy])


def _inverted(distorted: Callable[[Array], Array], raw: Array) -> Array:
    """The ideal rays of raw ones, by fixed-point steps as in OpenCV, until they stand still."""
    ideal = raw.copy()
    for _ in range(100):
        step = raw - distorted(ideal)
        ideal += step
        if not np.isfinite(ideal).all() or np.abs(step).max() < 1e-10:
            break
    return ideal


def _fitted(ideal: Array, raw: Array, focal: Matrix) -> tuple[Five, float]:
    """The model is linear in its five numbers."""
    x, y = ideal.T
    r2 = x * x + y * y
    across = np.column_stack([x * r2, x * r2**2, 2 * x * y, r2 + 2 * x * x, x * r2**3])
    down = np.column_stack([y * r2, y * r2**2, r2 + 2 * y * y, 2 * x * y, y * r2**3])
    system = np.vstack([across, down])
    offset = (raw - ideal).T.ravel()
    if not np.isfinite(system).all() or not np.isfinite(offset).all():
        return (0.0, 0.0, 0.0, 0.0, 0.0), np.inf
    terms = np.linalg.lstsq(system, offset, rcond=None)[0]
    off = (system @ terms - offset).reshape(2, -1) * np.array([[focal[0]], [focal[1]]])
    five = tuple(float(term) for term in terms)
    return five, float(np.linalg.norm(off, axis=0).max())  # type: ignore[return-value]
