"""Reading a camera calibration from YAML or JSON, in any of the forms in which people write one.

Understood: flat keys (fx, fy, cx, cy, width, height, depth_scale, distortion, fps), the same nested under a camera's
name, a matrix K, ROS camera_info, Kalibr's camchain, Open3D's intrinsics, and dotted keys (Camera.fx, Camera1.fx,
DepthMapFactor) under OpenCV's `%YAML:1.0`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.sources.calibrations.azure_raw import states_azure, tree_of_azure
from lpslam.sources.calibrations.depth_units import DEPTH_DISPLACEMENT, DEPTH_SCALE, depth_unit, states_depth_unit
from lpslam.sources.calibrations.extrinsics import transform_between
from lpslam.sources.calibrations.forms import read_tree
from lpslam.sources.registering.displacement import DepthDisplacement, Displacement, StatedRig
from lpslam.sources.registering.lens_fit import WORTH_SAYING, five_of
from lpslam.sources.yaml_tree import Tree

_MATRICES = ("k", "camera_matrix", "intrinsic_matrix", "intrinsics", "intrinsic", "matrix")
_FOCAL = {
    "fx": ("fx", "f_x", "fl_x", "fu", "focal_x", "focal_length_x"),
    "fy": ("fy", "f_y", "fl_y", "fv", "focal_y", "focal_length_y"),
    "cx": ("cx", "c_x", "ppx", "pu", "principal_point_x"),
    "cy": ("cy", "c_y", "ppy", "pv", "principal_point_y"),
}
_PAIRS = {
    ("fx", "fy"): ("focal_length", "focal_lengths", "focal", "f"),
    ("cx", "cy"): ("principal_point", "principal", "center", "centre", "pp", "c"),
}
_WIDTH = ("width", "image_width", "w")
_HEIGHT = ("height", "image_height", "h")
_DEPTH_WIDTH, _DEPTH_HEIGHT = ("dw", "depth_width", "depth_w"), ("dh", "depth_height", "depth_h")
_RESOLUTION = ("resolution", "render_product_resolution", "image_size", "size")
_DISTORTION = (
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
_DISTORTION_MODEL = ("distortion_model", "distortion_type", "camera_model", "model", "type")
_LARGEST_RATIO, _LARGEST_SHIFT = 10.0, 10_000.0  # of focal lengths, and pixels: beyond it, nothing is in view
_FPS = ("fps", "frame_rate", "framerate", "rate")
_MODELS_NOT_SUPPORTED = ("equi", "fisheye", "kannala", "omni", "fov", "eucm", "double_sphere", "ds-", "mei")
_APERTURES = ("camera_aperture", "horizontal_aperture", "sensor_width", "sensor_width_mm", "sensor_size", "aperture")
_LENGTHS = ("camera_focal_length", "focal_length_mm", "focal_length", "focal")
_VIEW = ("fov", "view", "hfov", "vfov", "dfov")
_RESIZINGS, _CENTRAL = (2, 3, 4, 1.5), 0.3  # of images; the principal point lies in the middle of the calibration's own
_SAME_VIEW = 0.01  # share of the width by which the numbers of two cameras of one view may differ
_NEARLY = 0.85  # share of letters in common, of words that are one mistyped
# Sections are tried in this order of what their names begin with; all others come between.
_PREFERRED, _DEFERRED = ("camera", "cam0", "rgb", "color", "colour", "left"), ("depth", "ir", "infra", "imu", "right")


@dataclass(frozen=True, slots=True)
class Calibration:
    """A camera and what was made of the words about it.

    Attributes:
        notes: what had to be assumed, one sentence each.
        displacement: how depth lies beside colour, if not on it.
        is_scale_assumed: whether no depth scale is stated.
        depth_size: width and height of depth that shows the same view in fewer pixels, where that is stated.
        depth_camera: the camera of depth, where one is stated beside that of colour.
        colour_from_depth: 4×4 metres between them, where that is stated.
    """

    camera: PinholeCamera
    notes: tuple[str, ...]
    displacement: DepthDisplacement | None = None
    is_scale_assumed: bool = False
    depth_size: tuple[int, int] | None = None
    depth_camera: PinholeCamera | None = None
    colour_from_depth: NDArray[np.float64] | None = None

    def displacement_of(self, depth_size: tuple[int, int] | None) -> Displacement | None:
        """How depth images of a size lie beside colour, as far as it is stated; None where they lie on it."""
        camera, depth = self.camera, self.depth_camera
        size = camera.width, camera.height
        if self.displacement is not None or depth_size is None:
            return self.displacement
        if depth is None or (depth.width, depth.height) != depth_size:
            # Fewer pixels of the same shape, and no other camera stated: phones' depth is such.
            times = size[0] / depth_size[0]
            is_whole = times.is_integer() and times > 1 and size[1] == times * depth_size[1]
            is_same_view = depth_size == self.depth_size or (depth is None and is_whole)
        else:
            share = depth.width / camera.width
            ours = np.array([camera.fx, camera.fy, camera.cx, camera.cy]) * share
            theirs = np.array([depth.fx, depth.fy, depth.cx, depth.cy])
            is_same_view = bool(np.abs(ours - theirs).max() <= _SAME_VIEW * depth.width)
            if not is_same_view and self.colour_from_depth is not None:
                return StatedRig(depth, camera, self.colour_from_depth)
        return DepthDisplacement.between(depth_size, size) if is_same_view and depth_size != size else None


def read_calibration(
    path: Path, image_size: tuple[int, int] | None = None, default_depth_scale: float = 1000.0
) -> Calibration:
    """Read a calibration file.

    Args:
        path: the file, in any of the forms of `calibrations`.
        image_size: width and height of the images in pixels, used where the file states none.
        default_depth_scale: raw depth units in a metre, used where the file states none.

    Raises:
        UserError: the file cannot be read, or a value is missing, ill-typed or not supported; names key and file.
    """
    tree, is_worded = read_tree(path, image_size, states_camera)
    calibration = calibration_of(tree, path, image_size, default_depth_scale)
    if not is_worded:
        return calibration
    return replace(calibration, notes=(f"{path.name} is read from its words", *calibration.notes))


def calibration_of(
    tree: Tree, path: Path, image_size: tuple[int, int] | None = None, default_depth_scale: float = 1000.0
) -> Calibration:
    """The calibration that a tree of lower-case keys states; arguments and errors as of `read_calibration`."""
    tree = tree_of_azure(tree, image_size) or tree
    sections = list(_sections(tree))
    section, *around = next((scopes for scopes in sections if _has_intrinsics(scopes[0])), (tree,))
    # What the camera's own section leaves out may stand around it, or in a section that several cameras share.
    shared = [scopes[0] for scopes in sections if len(scopes) == 2 and not _has_intrinsics(scopes[0])]
    scopes = (section, *around, *shared)
    notes: list[str] = []
    stated = _size(scopes, path)
    fx, fy, cx, cy = _intrinsics(section, stated or image_size, path, notes)
    if any(scope.get(key) is True for scope in scopes for key in _MODELS_NOT_SUPPORTED):
        raise UserError(f"calibration {path}: a fisheye lens is not supported; rectify the images to a pinhole")
    notes += _misspelt(scopes, path)
    width, height = stated or image_size or (0, 0)
    share = _scaling((width, height), image_size, (cx, cy))
    if share != 1.0 and image_size is not None:
        notes.append(f"{path.name} is for {width}×{height} and is scaled to {image_size[0]}×{image_size[1]}")
        fx, fy, cx, cy = fx * share, fy * share, (cx + 0.5) * share - 0.5, (cy + 0.5) * share - 0.5
        width, height = image_size
    if not width:
        raise UserError(f"calibration {path}: width is missing; add width and height in pixels")
    scale, is_scale_assumed = _units(tree, scopes, path, default_depth_scale, notes)
    fps = _find(scopes, _FPS)
    rate = 30.0 if fps is None else _number(fps, "fps", path)
    try:
        distortion = _distortion(scopes, path, (width, height), (fx, fy, cx, cy), notes)
        camera = PinholeCamera(width, height, fx, fy, cx, cy, distortion, scale, rate)
    except UserError as error:
        raise error if str(path) in str(error) else UserError(f"{path}: {error}") from error
    displacement = _displacement(scopes, path)
    if displacement is not None and share != 1.0:
        displacement = displacement.resized(share)
    return Calibration(
        camera,
        tuple(notes),
        displacement,
        is_scale_assumed,
        _depth_size(scopes, (width, height)),
        _depth_camera(sections, section, path),
        transform_between(each[0] for each in sections),
    )


def _depth_camera(sections: list[tuple[Tree, ...]], colour: Tree, path: Path) -> PinholeCamera | None:
    """The camera of a section that is called depth, where it is stated whole."""
    trees = [scopes[0] for scopes in sections]
    named = [
        tree for around in trees for name, tree in around.items() if name.startswith("depth") and tree is not colour
    ]
    section = next((tree for tree in named if isinstance(tree, dict) and _has_intrinsics(tree)), None)
    size = _size((section,), path) if section is not None else None
    if section is None or size is None:
        return None
    try:
        matrix = _intrinsics(section, size, path, [])
        return PinholeCamera(*size, *matrix, _distortion((section,), path, size, matrix, []))
    except UserError:
        # Colour's own is what counts.
        return None


def _units(tree: Tree, scopes: tuple[Tree, ...], path: Path, default: float, notes: list[str]) -> tuple[float, bool]:
    """Raw units of depth in a metre, and whether they are assumed."""
    scale = _depth_scale(tree, scopes, path)
    if scale is None:
        notes.append(f"{path.name} states no depth_scale: {default:g} raw units in a metre are assumed")
        return default, True
    if scale < 1:
        notes.append(f"{path.name} states depth_scale {scale:g}, taken as metres in a raw unit")
        scale = 1 / scale if scale > 0 else scale
    return scale, False


def states_camera(tree: Tree) -> bool:
    """Whether a tree of keys states focal lengths, or a field of view."""
    return states_azure(tree) or any(_has_intrinsics(scopes[0]) for scopes in _sections(tree))


def _scaling(stated: tuple[int, int], images: tuple[int, int] | None, middle: tuple[float, float]) -> float:
    """By how much images are larger than those that a calibration states, where it is for those and for no others."""
    if images is None or not stated[0] or stated == images:
        return 1.0
    across, down = images[0] / stated[0], images[1] / stated[1]
    is_whole = any(abs(across * k - 1) < 1e-9 or abs(across / k - 1) < 1e-9 for k in _RESIZINGS)
    is_own = all(_CENTRAL < at / size < 1 - _CENTRAL for at, size in zip(middle, stated, strict=True))
    return across if across == down and is_whole and is_own else 1.0


def _misspelt(scopes: tuple[Tree, ...], path: Path) -> list[str]:
    """A note of every key that is nearly one that is understood."""
    understood = _understood()
    words = [word for word in sorted(understood) if len(word) > 3]
    keys = [key for scope in scopes for key in scope if key not in understood and not states_depth_unit(key)]
    near = [(key, get_close_matches(key, words, 1, _NEARLY)) for key in keys]
    return [f"{path.name} states {key}, which is not understood; is it {said[0]}?" for key, said in near if said]


def _understood() -> set[str]:
    keys = (
        *_FOCAL.values(),
        *_PAIRS.values(),
        (DEPTH_DISPLACEMENT, DEPTH_SCALE),
        _RESOLUTION,
        _DISTORTION,
        _FPS,
        _WIDTH,
        _HEIGHT,
        _DEPTH_WIDTH,
        _DEPTH_HEIGHT,
        _MATRICES,
    )
    return {key for group in (*keys, _DISTORTION_MODEL) for key in group}


def _sections(tree: Tree, around: tuple[Tree, ...] = ()) -> Iterator[tuple[Tree, ...]]:
    """Every mapping of the tree with those around it, nearest first: the root, then by what its name promises."""
    scopes = (tree, *around)
    yield scopes
    children = [(name, child) for name, child in tree.items() if isinstance(child, dict)]
    for _, child in sorted(children, key=lambda item: _rank(item[0])):
        yield from _sections(child, scopes)


def _rank(name: str) -> int:
    if name.startswith(_PREFERRED):
        return 0
    return 2 if name.startswith(_DEFERRED) else 1


def _has_intrinsics(section: Tree) -> bool:
    names = (*(key for keys in _FOCAL.values() for key in keys), *_PAIRS[("fx", "fy")])
    return any(key in section for key in names) or any(found(section) for found in (_matrix, _views, _in_aperture))


def _intrinsics(
    section: Tree, size: tuple[int, int] | None, path: Path, notes: list[str]
) -> tuple[float, float, float, float]:
    matrix = _matrix(section)
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
        if _find((section, paired), _FOCAL["fx"]) is None or _in_aperture(section):
            paired |= _of_views(views, size, path)
        if all(_find((section, paired), _FOCAL[name]) is None for name in ("cx", "cy")):
            notes.append(f"{path.name} states no principal point: the image's middle is taken")
            paired |= {"cx": (size[0] - 1) / 2, "cy": (size[1] - 1) / 2}
    for name, keys in _FOCAL.items():
        value = _find((section, paired), keys)
        if value is None:
            raise UserError(f"calibration {path}: {name} is missing; it needs fx, fy, cx and cy in pixels")
        values.append(_number(value, name, path))
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
    focal, sides = _find((section,), _LENGTHS), _find((section,), _APERTURES)
    lengths = [each for each in (_numbers(sides) if isinstance(sides, list) else [sides]) or [] if each is not None]
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
        angle = _number(str(value).lower().replace("deg", "").replace("rees", "").strip(" °"), "field of view", path)
        if not 0 < angle < 180:
            raise UserError(f"calibration {path}: a field of view is {angle:g}; it must be degrees between 0 and 180")
        focal[way] = lengths[way] / 2 / float(np.tan(np.radians(angle / 2)))
    across = focal.get("h", focal.get("d", focal.get("v")))
    return {"fx": across, "fy": focal.get("v", across)}


def _paired(section: Tree) -> Tree:
    """What is stated of both axes under one key: as two numbers, by x and y, or one focal length for both."""
    values: Tree = {}
    for names, keys in _PAIRS.items():
        value = _find((section,), keys)
        if isinstance(value, dict):
            values |= {name: value.get(name[1], value.get(name)) for name in names}
        elif isinstance(value, list) and len(value) == 2:
            values |= dict(zip(names, value, strict=True))
        elif not isinstance(value, list) and names[0] == "fx":
            values |= dict.fromkeys(names, value)
    return values


def _matrix(section: Tree) -> list[float] | None:
    value = _find((section,), _MATRICES)
    return None if value is None else _numbers(value)


def _size(scopes: tuple[Tree, ...], path: Path) -> tuple[int, int] | None:
    width, height = _find(scopes, _WIDTH), _find(scopes, _HEIGHT)
    if width is None or height is None:
        pair = _numbers(_find(scopes, _RESOLUTION))
        if pair is None or len(pair) != 2:
            return None
        width, height = pair
    size = _number(width, "width", path), _number(height, "height", path)
    for name, value in zip(("width", "height"), size, strict=True):
        if not value.is_integer() or value <= 0:
            raise UserError(f"calibration {path}: {name} is {value:g}; it must be a whole number of pixels")
    return int(size[0]), int(size[1])


def _depth_size(scopes: tuple[Tree, ...], size: tuple[int, int]) -> tuple[int, int] | None:
    """The stated size of depth, where it has the same shape as colour's: such depth shows the same view."""
    width, height = _find(scopes, _DEPTH_WIDTH), _find(scopes, _DEPTH_HEIGHT)
    if not isinstance(width, (int, float)) or not isinstance(height, (int, float)) or not 0 < width < size[0]:
        return None
    return (int(width), int(height)) if width * size[1] == height * size[0] else None


def _distortion(
    scopes: tuple[Tree, ...],
    path: Path,
    size: tuple[int, int],
    matrix: tuple[float, float, float, float],
    notes: list[str],
) -> tuple[float, float, float, float, float]:
    value = _find(scopes, _DISTORTION)
    names = ("k1", "k2", "p1", "p2", "k3")
    listed = next((scope for scope in (value, *scopes) if isinstance(scope, dict) and "k1" in scope), None)
    parted = _terms_by_kind(value)
    if parted is not None:
        coefficients = parted
    elif listed is not None:
        coefficients = [_number(listed.get(name) or 0.0, name, path) for name in (*names, "k4", "k5", "k6")]
    elif value is None or isinstance(value, str) or value is False:
        coefficients = []
    else:
        numbers = _numbers(value)
        if numbers is None:
            raise UserError(f"calibration {path}: distortion is {value!r}; it must be a list: k1, k2, p1, p2, k3")
        coefficients = numbers
    if any(coefficients):
        models = [str(scope[key]).lower() for scope in scopes for key in _DISTORTION_MODEL if key in scope]
        of_others = (model for model in models if model.startswith(_MODELS_NOT_SUPPORTED) or "fisheye" in model)
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
    radial, tangential = (_numbers(value.get(kind)) for kind in _KINDS) if isinstance(value, dict) else (None, None)
    if radial is None:
        return None
    k1, k2, *rest = [*radial, 0.0, 0.0]
    return [k1, k2, *[*(tangential or []), 0.0, 0.0][:2], *rest[: max(len(radial) - 2, 0)]]


def _displacement(scopes: tuple[Tree, ...], path: Path) -> DepthDisplacement | None:
    stated = _find(scopes, (DEPTH_DISPLACEMENT,))
    if stated is None:
        return None
    of = f"calibration {path}: {DEPTH_DISPLACEMENT}"
    if not isinstance(stated, dict):
        raise UserError(f"{of} must have scale, shift and parallax, as 'lpslam calibrate' writes them")
    scale = _number(stated.get("scale"), f"scale of {DEPTH_DISPLACEMENT}", path)
    shift, parallax = (_numbers(stated.get(name)) for name in ("shift", "parallax"))
    if shift is None or parallax is None or len(shift) != 2 or len(parallax) != 2:
        raise UserError(f"{of} needs a shift and a parallax of two numbers each, x and y")
    is_possible = 1 / _LARGEST_RATIO <= scale <= _LARGEST_RATIO
    if not is_possible or not all(abs(number) <= _LARGEST_SHIFT for number in (*shift, *parallax)):
        raise UserError(f"{of} takes depth out of the picture; its scale is near 1, its shifts are pixels")
    return DepthDisplacement(scale, (shift[0], shift[1]), (parallax[0], parallax[1]))


def _depth_scale(tree: Tree, scopes: tuple[Tree, ...], path: Path) -> float | None:
    """Raw units in a metre, or metres in a raw unit where they are below 1, by whichever key says so."""
    found = depth_unit([*scopes, *(each[0] for each in _sections(tree))], tree.get("depth"))
    return None if found is None else _number(found, DEPTH_SCALE, path)


def _find(scopes: tuple[Tree, ...], keys: tuple[str, ...]) -> Any:
    """The first value under any of the keys, scope by scope; None where there is none."""
    for scope in scopes:
        for key in keys:
            if scope.get(key) is not None:
                return scope[key]
    return None


def _number(value: object, name: str, path: Path) -> float:
    try:
        if isinstance(value, bool):
            raise ValueError
        return float(str(value))
    except ValueError as error:
        raise UserError(f"calibration {path}: {name} is {value!r}; it must be a number") from error


def _numbers(value: object) -> list[float] | None:
    """The numbers of a flat or nested list, or of ROS's and OpenCV's {rows, cols, data}; None if there is no list."""
    if isinstance(value, dict):
        value = value.get("data")
    if not isinstance(value, list):
        return None
    flat = [item for row in value for item in (row if isinstance(row, list) else [row])]
    try:
        return [float(str(item)) for item in flat]
    except ValueError:
        return None
