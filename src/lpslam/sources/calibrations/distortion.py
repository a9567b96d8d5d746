"""Terms of a lens, however they are stated, as k1, k2, p1, p2, k3."""

from pathlib import Path

import numpy as np

from lpslam.errors import UserError
from lpslam.sources.calibrations.keys import found_in, number_of, numbers_of
from lpslam.sources.registering.lens_fit import WORTH_SAYING, five_of
from lpslam.sources.yaml_tree import Tree

DISTORTION = (
    "distortion",
    "distortion_coefficients",
    "distortion_coeffs",
    "dist_coeffs",
    "distortion_coeff",
    "coeffs",
    "dist",
    "d",
)
_KINDS = ("radial", "tangential")
MODEL = ("distortion_model", "distortion_type", "camera_model", "model", "type")
NOT_SUPPORTED = ("equi", "fisheye", "kannala", "omni", "fov", "eucm", "double_sphere", "ds-", "mei")


def distortion_of(
    scopes: tuple[Tree, ...],
    path: Path,
    size: tuple[int, int],
    matrix: tuple[float, float, float, float],
    notes: list[str],
) -> tuple[float, float, float, float, float]:
    """The terms that the mappings state, nearest first; what stands for another lens model is added to the notes.

    Raises:
        UserError: they are no numbers, or of a lens that no pinhole with five terms can stand for.
    """
    value = found_in(scopes, DISTORTION)
    names = ("k1", "k2", "p1", "p2", "k3")
    listed = next((scope for scope in (value, *scopes) if isinstance(scope, dict) and "k1" in scope), None)
    parted = _terms_by_kind(value)
    if parted is not None:
        coefficients = parted
    elif listed is not None:
        coefficients = [number_of(listed.get(name) or 0.0, name, path) for name in (*names, "k4", "k5", "k6")]
    elif value is None or isinstance(value, str) or value is False:
        coefficients = []
    else:
        numbers = numbers_of(value)
        if numbers is None:
            raise UserError(f"calibration {path}: distortion is {value!r}; it must be a list: k1, k2, p1, p2, k3")
        coefficients = numbers
    if any(coefficients):
        models = [str(scope[key]).lower() for scope in scopes for key in MODEL if key in scope]
        of_others = (model for model in models if model.startswith(NOT_SUPPORTED) or "fisheye" in model)
        model = next(of_others, None)
        if model is not None:
            raise UserError(f"calibration {path}: the model {model} is not supported; rectify the images to a pinhole")
        if "inverse" in " ".join(models) or any(coefficients[5:]):
            return _of_another_model(coefficients, " ".join(models), path, size, matrix, notes)
    padded = [*coefficients[:5], 0.0, 0.0, 0.0, 0.0, 0.0]
    if not np.isfinite(padded).all():
        raise UserError(f"calibration {path}: distortion must be finite numbers: k1, k2, p1, p2, k3")
    return padded[0], padded[1], padded[2], padded[3], padded[4]


def _of_another_model(
    coefficients: list[float],
    models: str,
    path: Path,
    size: tuple[int, int],
    matrix: tuple[float, float, float, float],
    notes: list[str],
) -> tuple[float, float, float, float, float]:
    """The five terms that come nearest to RealSense's inverse model, or to one with eight terms."""
    name = "inverse brown conrady" if "inverse" in models else "rational_polynomial"
    if any(coefficients[8:]) or not np.isfinite(coefficients).all():
        raise UserError(
            f"calibration {path}: distortion has {len(coefficients)} terms; k1, k2, p1, p2, k3 to k6 can be used"
        )
    five, off = five_of(name, coefficients[:8], size, matrix, f"calibration {path}")
    if off > WORTH_SAYING:
        notes.append(f"{path.name}: its lens model is used as k1, k2, p1, p2, k3, off by {off:.2f} pixels")
    return five


def _terms_by_kind(value: object) -> list[float] | None:
    """k1, k2, p1, p2, k3 of radial and tangential terms."""
    radial, tangential = (numbers_of(value.get(kind)) for kind in _KINDS) if isinstance(value, dict) else (None, None)
    if radial is None:
        return None
    k1, k2, *rest = [*radial, 0.0, 0.0]
    return [k1, k2, *[*(tangential or []), 0.0, 0.0][:2], *rest[: max(len(radial) - 2, 0)]]
