"""Reading a camera calibration from YAML or JSON, in any of the forms in which people write one.

Understood: flat keys (fx, fy, cx, cy, width, height, depth_scale, distortion, fps), the same nested under a camera's
name, a matrix K, ROS camera_info, Kalibr's camchain, Open3D's intrinsics, and dotted keys (Camera.fx, Camera1.fx,
DepthMapFactor) under OpenCV's `%YAML:1.0`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.sources.calibrations.azure_raw import states_azure, tree_of_azure
from lpslam.sources.calibrations.depth_units import DEPTH_DISPLACEMENT, DEPTH_SCALE, depth_unit, states_depth_unit
from lpslam.sources.calibrations.distortion import (
    DISTORTION,
    MODEL,
    NOT_SUPPORTED,
    distortion_of,
    refuse_other_projections,
)
from lpslam.sources.calibrations.extrinsics import transform_between
from lpslam.sources.calibrations.forms import read_tree
from lpslam.sources.calibrations.intrinsics import FOCAL, MATRICES, PAIRS, has_intrinsics, intrinsics_of
from lpslam.sources.calibrations.keys import found_in, number_of, numbers_of
from lpslam.sources.registering.displacement import DepthDisplacement, Displacement, StatedRig
from lpslam.sources.yaml_tree import Tree

_WIDTH = ("width", "image_width", "w")
_HEIGHT = ("height", "image_height", "h")
_DEPTH_WIDTH, _DEPTH_HEIGHT = ("dw", "depth_width", "depth_w"), ("dh", "depth_height", "depth_h")
_RESOLUTION = ("resolution", "render_product_resolution", "image_size", "size")
_LARGEST_RATIO, _LARGEST_SHIFT = 10.0, 10_000.0  # of focal lengths, and pixels: beyond it, nothing is in view
_FPS = ("fps", "frame_rate", "framerate", "rate")
_RESIZINGS, _CENTRAL = (2, 3, 4, 1.5), 0.3  # of images; the principal point lies in the middle of the calibration's own
_OFF_MIDDLE = 0.08  # share of a side by which a principal point lies beside the middle, if the size is another
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

    def with_scale(self, depth_scale: float) -> "Calibration":
        """The same with so many raw units in a metre, which are known."""
        kept = tuple(note for note in self.notes if DEPTH_SCALE not in note)
        return replace(self, camera=replace(self.camera, depth_scale=depth_scale), notes=kept, is_scale_assumed=False)

    def note_of(self, depth_size: tuple[int, int] | None) -> tuple[str, ...]:
        """What is assumed of depth images of a size."""
        is_stated = self.displacement is not None or self.depth_camera is not None or depth_size == self.depth_size
        if depth_size is None or is_stated or self.displacement_of(depth_size) is None:
            return ()
        return (f"depth of {depth_size[0]}×{depth_size[1]} is taken to show the same view as colour",)

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
    section, *around = next((scopes for scopes in sections if has_intrinsics(scopes[0])), (tree,))
    # What the camera's own section leaves out may stand around it, or in a section that several cameras share.
    shared = [scopes[0] for scopes in sections if len(scopes) == 2 and not has_intrinsics(scopes[0])]
    scopes = (section, *around, *shared)
    notes: list[str] = []
    refuse_other_projections((section, *around), path)
    stated = _size(scopes, path)
    fx, fy, cx, cy = intrinsics_of(section, stated or image_size, path, notes)
    if _is_by_rows(stated, image_size, (cx, cy)):
        notes.append(f"{path.name} states its size by rows and columns")
        stated = image_size
    if any(scope.get(key) is True for scope in scopes for key in NOT_SUPPORTED):
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
    fps = found_in(scopes, _FPS)
    rate = 30.0 if fps is None else number_of(fps, "fps", path)
    try:
        distortion = distortion_of(scopes, path, (width, height), (fx, fy, cx, cy), notes)
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
    section = next((tree for tree in named if isinstance(tree, dict) and has_intrinsics(tree)), None)
    size = _size((section,), path) if section is not None else None
    if section is None or size is None:
        return None
    try:
        matrix = intrinsics_of(section, size, path, [])
        return PinholeCamera(*size, *matrix, distortion_of((section,), path, size, matrix, []))
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
    return states_azure(tree) or any(has_intrinsics(scopes[0]) for scopes in _sections(tree))


def _scaling(stated: tuple[int, int], images: tuple[int, int] | None, middle: tuple[float, float]) -> float:
    """By how much images are larger than those that a calibration states, where it is for those and for no others."""
    if images is None or not stated[0] or stated == images:
        return 1.0
    across, down = images[0] / stated[0], images[1] / stated[1]
    is_whole = any(abs(across * k - 1) < 1e-9 or abs(across / k - 1) < 1e-9 for k in _RESIZINGS)
    is_own = all(_CENTRAL < at / size < 1 - _CENTRAL for at, size in zip(middle, stated, strict=True))
    return across if across == down and is_whole and is_own else 1.0


def _is_by_rows(stated: tuple[int, int] | None, images: tuple[int, int] | None, middle: tuple[float, float]) -> bool:
    """Whether a size is rows and columns, as MATLAB has it: turned it is the images', and has the principal point."""
    if stated is None or images is None or stated == images or stated[::-1] != images:
        return False
    off = [max(abs(at / side - 0.5) for at, side in zip(middle, size, strict=True)) for size in (images, stated)]
    return off[0] < _OFF_MIDDLE < off[1]


def _misspelt(scopes: tuple[Tree, ...], path: Path) -> list[str]:
    """A note of every key that is nearly one that is understood."""
    understood = _understood()
    words = [word for word in sorted(understood) if len(word) > 3]
    keys = [key for scope in scopes for key in scope if key not in understood and not states_depth_unit(key)]
    near = [(key, get_close_matches(key, words, 1, _NEARLY)) for key in keys]
    return [f"{path.name} states {key}, which is not understood; is it {said[0]}?" for key, said in near if said]


def _understood() -> set[str]:
    keys = (
        *FOCAL.values(),
        *PAIRS.values(),
        (DEPTH_DISPLACEMENT, DEPTH_SCALE),
        _RESOLUTION,
        DISTORTION,
        _FPS,
        _WIDTH,
        _HEIGHT,
        _DEPTH_WIDTH,
        _DEPTH_HEIGHT,
        MATRICES,
    )
    return {key for group in (*keys, MODEL) for key in group}


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


def _size(scopes: tuple[Tree, ...], path: Path) -> tuple[int, int] | None:
    width, height = found_in(scopes, _WIDTH), found_in(scopes, _HEIGHT)
    if width is None or height is None:
        pair = numbers_of(found_in(scopes, _RESOLUTION))
        if pair is None or len(pair) != 2:
            return None
        width, height = pair
    size = number_of(width, "width", path), number_of(height, "height", path)
    for name, value in zip(("width", "height"), size, strict=True):
        if not value.is_integer() or value <= 0:
            raise UserError(f"calibration {path}: {name} is {value:g}; it must be a whole number of pixels")
    return int(size[0]), int(size[1])


def _depth_size(scopes: tuple[Tree, ...], size: tuple[int, int]) -> tuple[int, int] | None:
    """The stated size of depth, where it has the same shape as colour's: such depth shows the same view."""
    width, height = found_in(scopes, _DEPTH_WIDTH), found_in(scopes, _DEPTH_HEIGHT)
    if not isinstance(width, (int, float)) or not isinstance(height, (int, float)) or not 0 < width < size[0]:
        return None
    return (int(width), int(height)) if width * size[1] == height * size[0] else None


def _displacement(scopes: tuple[Tree, ...], path: Path) -> DepthDisplacement | None:
    stated = found_in(scopes, (DEPTH_DISPLACEMENT,))
    if stated is None:
        return None
    of = f"calibration {path}: {DEPTH_DISPLACEMENT}"
    if not isinstance(stated, dict):
        raise UserError(f"{of} must have scale, shift and parallax, as 'lpslam calibrate' writes them")
    scale = number_of(stated.get("scale"), f"scale of {DEPTH_DISPLACEMENT}", path)
    shift, parallax = (numbers_of(stated.get(name)) for name in ("shift", "parallax"))
    if shift is None or parallax is None or len(shift) != 2 or len(parallax) != 2:
        raise UserError(f"{of} needs a shift and a parallax of two numbers each, x and y")
    is_possible = 1 / _LARGEST_RATIO <= scale <= _LARGEST_RATIO
    if not is_possible or not all(abs(number) <= _LARGEST_SHIFT for number in (*shift, *parallax)):
        raise UserError(f"{of} takes depth out of the picture; its scale is near 1, its shifts are pixels")
    return DepthDisplacement(scale, (shift[0], shift[1]), (parallax[0], parallax[1]))


def _depth_scale(tree: Tree, scopes: tuple[Tree, ...], path: Path) -> float | None:
    """Raw units in a metre, or metres in a raw unit where they are below 1, by whichever key says so."""
    found = depth_unit([*scopes, *(each[0] for each in _sections(tree))], tree.get("depth"))
    return None if found is None else number_of(found, DEPTH_SCALE, path)
