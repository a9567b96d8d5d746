"""Focal lengths and principal point, however they are stated: numbers, pairs, a matrix, a view, an aperture."""

from pathlib import Path

import numpy as np

from lpslam.errors import UserError
from lpslam.sources.calibrations.keys import found_in, number_of, numbers_of
from lpslam.sources.yaml_tree import Tree

MATRICES = ("k", "camera_matrix", "intrinsic_matrix", "intrinsics", "intrinsic", "matrix")
FOCAL = {
    "fx": ("fx", "f_x", "fl_x", "fu", "focal_x", "focal_length_x"),
    "fy": ("fy", "f_y", "fl_y", "fv", "focal_y", "focal_length_y"),
    "cx": ("cx", "c_x", "ppx", "pu", "principal_point_x"),
    "cy": ("cy", "c_y", "ppy", "pv", "principal_point_y"),
}
PAIRS = {
    ("fx", "fy"): ("focal_length", "focal_lengths", "focal", "f"),
    ("cx", "cy"): ("principal_point", "principal", "center", "centre", "pp", "c"),
}
_APERTURES = ("camera_aperture", "horizontal_aperture", "sensor_width", "sensor_width_mm", "sensor_size")
_LENGTHS = ("camera_focal_length", "focal_length_mm", "focal_length", "focal")
_VIEW = ("fov", "view", "hfov", "vfov", "dfov")


def has_intrinsics(section: Tree) -> bool:
    """Whether a mapping states focal lengths itself."""
    names = (*(key for keys in FOCAL.values() for key in keys), *PAIRS[("fx", "fy")])
    return any(key in section for key in names) or any(found(section) for found in (matrix_in, _views, _in_aperture))


def intrinsics_of(
    section: Tree, size: tuple[int, int] | None, path: Path, notes: list[str]
) -> tuple[float, float, float, float]:
    """Pixels fx, fy, cx, cy that a mapping states; what is assumed is added to the notes.

    Raises:
        UserError: one of them is missing, or no number.
    """
    matrix = matrix_in(section)
    if matrix is not None:
        if len(matrix) == 4:
            return matrix[0], matrix[1], matrix[2], matrix[3]
        if len(matrix) == 9:
            # Open3D writes its matrix column by column.
            cx, cy = (matrix[6], matrix[7]) if matrix[2] == matrix[5] == 0.0 else (matrix[2], matrix[5])
            return matrix[0], matrix[4], cx, cy
        raise UserError(
            f"calibration {path}: the intrinsics have {len(matrix)} numbers; they must be 4 or a 3×3 matrix"
        )
    values: list[float] = []
    paired, views = _paired(section), _views(section) or _in_aperture(section)
    if views and size is not None:
        if found_in((section, paired), FOCAL["fx"]) is None or _in_aperture(section):
            paired |= _of_views(views, size, path)
        if all(found_in((section, paired), FOCAL[name]) is None for name in ("cx", "cy")):
            notes.append(f"{path.name} states no principal point: the image's middle is taken")
            paired |= {"cx": (size[0] - 1) / 2, "cy": (size[1] - 1) / 2}
    for name, keys in FOCAL.items():
        value = found_in((section, paired), keys)
        if value is None:
            raise UserError(f"calibration {path}: {name} is missing; it needs fx, fy, cx and cy in pixels")
        values.append(number_of(value, name, path))
    return values[0], values[1], values[2], values[3]


def _views(section: Tree) -> dict[str, object]:
    """Fields of view by h, v or d: across, down or from corner to corner."""
    found: dict[str, object] = {}
    for key, value in section.items():
        words = key.replace("-", "_").split("_")
        if not any(word in _VIEW for word in (*words, words[0][1:])) or isinstance(value, (dict, list)):
            continue
        way = "d" if key.startswith("d") else "v" if key.startswith(("v", "y")) or words[-1] in ("v", "y") else "h"
        found[way] = value
    return found


def _in_aperture(section: Tree) -> dict[str, object]:
    """Fields of view of a focal length and a sensor's sides that are stated in millimetres, as renderers have them."""
    focal, sides = found_in((section,), _LENGTHS), found_in((section,), _APERTURES)
    lengths = [each for each in (numbers_of(sides) if isinstance(sides, list) else [sides]) or [] if each is not None]
    try:
        angles = [2 * float(np.degrees(np.arctan(float(str(side)) / 2 / float(str(focal))))) for side in lengths[:2]]
    except (ValueError, ZeroDivisionError):
        return {}
    return dict(zip(("h", "v"), angles, strict=False))


def _of_views(views: dict[str, object], size: tuple[int, int], path: Path) -> Tree:
    """Focal lengths that fields of view in degrees make of an image's size; pixels are square where one is missing."""
    lengths = {"h": float(size[0]), "v": float(size[1]), "d": float(np.hypot(*size))}
    focal = {}
    for way, value in views.items():
        angle = number_of(str(value).lower().replace("deg", "").replace("rees", "").strip(" °"), "field of view", path)
        if not 0 < angle < 180:
            raise UserError(f"calibration {path}: a field of view is {angle:g}; it must be degrees between 0 and 180")
        focal[way] = lengths[way] / 2 / float(np.tan(np.radians(angle / 2)))
    across = focal.get("h", focal.get("d", focal.get("v")))
    return {"fx": across, "fy": focal.get("v", across)}


def _paired(section: Tree) -> Tree:
    """What is stated of both axes under one key: as two numbers, by x and y, or one focal length for both."""
    values: Tree = {}
    for names, keys in PAIRS.items():
        value = found_in((section,), keys)
        if isinstance(value, dict):
            values |= {name: value.get(name[1], value.get(name)) for name in names}
        elif isinstance(value, list) and len(value) == 2:
            values |= dict(zip(names, value, strict=True))
        elif not isinstance(value, list) and names[0] == "fx":
            values |= dict.fromkeys(names, value)
    return values


def matrix_in(section: Tree) -> list[float] | None:
    """The numbers of a camera's matrix."""
    value = found_in((section,), MATRICES)
    return None if value is None else numbers_of(value)
