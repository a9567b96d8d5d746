"""Terms of a lens, however they are stated, as k1, k2, p1, p2, k3."""

import re
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
    "dist_coeff",
    "dist_coefs",
    "lens_distortion",
    "distortion_params",
    "distortion_parameters",
    "distortion_coeff",
    "coeffs",
    "dist",
    "d",
)
_KINDS = ("radial", "tangential")
MODEL = (
    "distortion_model",
    "distortion_type",
    "camera_model",
    "camera_type",
    "lens_model",
    "lens_type",
    "projection",
    "projection_model",
    "projection_type",
    "model",
    "type",
)
NOT_SUPPORTED = ("equi", "fisheye", "kannala", "omni", "fov", "eucm", "double_sphere", "ds-", "mei")
_OF_DISTORTION = ("distortion_model", "distortion_type")
_NO_PINHOLES = re.compile(
    r"(?:ds|kb\d?|e?ucm|mei|scaramuzza|ocam\w*|omni\w*|fov|cylind\w*|spher\w*|panoram\w*|double_?sphere|kannala\w*|"
    r"equirect\w*|equidist\w*|unified\w*|(?:\w+_)?fisheye\w*)(?:[-_ ].*)?"
)
_OF_OTHER_LENSES = ("xi", "alpha", "beta", "omega", "mirror_parameters", "poly_parameters", "inv_poly_parameters")
"""Numbers that a projection has that is no pinhole's."""


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
    if isinstance(value, dict) and "parameters" in value:
        # As aslam's tools and SVO have it: a type, and its numbers as a matrix.
        scopes, value = (value, *scopes), value["parameters"]
        value = None if isinstance(value, dict) and value.get("data") in ([], None) else value
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


def refuse_other_projections(scopes: tuple[Tree, ...], path: Path) -> None:
    """Raise a `UserError` where the mappings, nearest first, state a camera that is no pinhole, whatever its terms."""
    for scope in scopes:
        for key in MODEL:
            model = str(scope.get(key, "")).lower().strip()
            if key not in _OF_DISTORTION and _NO_PINHOLES.fullmatch(model):
                raise UserError(
                    f"calibration {path}: the camera model {model[:40]} is no pinhole and is not supported; "
                    "rectify the images and depth to a pinhole"
                )
    own = next((name for name in _OF_OTHER_LENSES if scopes and _is_stated(scopes[0].get(name))), None)
    if own is not None:
        raise UserError(
            f"calibration {path}: {own} is a number of a lens model that is no pinhole and is not supported; "
            "rectify the images and depth to a pinhole"
        )


def _is_stated(value: object) -> bool:
    """Whether it is a number or some, and not nought."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    numbers = [float(str(value))] if is_number else numbers_of(value)
    return any(numbers or ())


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
