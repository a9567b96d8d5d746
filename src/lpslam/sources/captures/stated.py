"""The calibrations that files of a folder state, and whether they agree."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from lpslam.errors import UserError
from lpslam.regular_files import text_of
from lpslam.sources.calibration import Calibration, calibration_of, read_calibration, states_camera
from lpslam.sources.calibrations.depth_units import DEPTH_SCALE
from lpslam.sources.calibrations.depth_words import units_in_words
from lpslam.sources.calibrations.forms import read_tree
from lpslam.sources.yaml_tree import Tree

_CONTRADICTS = 0.02
"""Share by which focal lengths of one camera may differ between two files."""
_IN_WORDS, _LONGEST_IN_WORDS = (".txt", ".md", ".rst", ""), 1 << 16
_LONGEST = 1 << 20
"""Bytes of a file that may be a calibration."""


def calibration_among(
    folder: Path,
    files: Sequence[Path],
    size: tuple[int, int] | None,
    default_depth_scale: float,
    trees: Mapping[Path, Tree] | None = None,
    depth_size: tuple[int, int] | None = None,
) -> Calibration | None:
    """The calibration of the colour camera that files of a folder state; None without.

    Args:
        folder, files: where they lie, and which they are.
        size, default_depth_scale: as `read_calibration` takes them.
        trees: what files of arrays say besides, by file.
        depth_size: width and height of the depth images, for a file that states their camera.

    Raises:
        UserError: two of them contradict each other, or the only ones that are called so cannot be read.
    """
    found = _stated(files, size, default_depth_scale)
    for path, tree in (trees or {}).items():
        if states_camera(tree):
            found[path] = calibration_of(tree, path, size, default_depth_scale)
    _refuse_contradictions(folder, found)
    calibration = next((with_stated_units(each, files) for each in found.values()), None)
    if calibration is None or calibration.depth_camera is not None:
        return calibration
    of_depth = files_that_state([path for path in files if _is_of_depth(path) and path not in found])
    try:
        return replace(calibration, depth_camera=read_calibration(of_depth[0], depth_size).camera)
    except (UserError, IndexError):
        return calibration


def with_stated_units(calibration: Calibration, files: Sequence[Path]) -> Calibration:
    """The calibration with the depth scale that another file states in words, where it states none itself."""
    if not calibration.is_scale_assumed:
        return calibration
    found: dict[float, Path] = {}
    for path in files:
        try:
            is_short = path.suffix.lower() in _IN_WORDS and path.stat().st_size <= _LONGEST_IN_WORDS
            scale = units_in_words(text_of(path)) if is_short else None
        except UserError:
            continue
        if scale is not None:
            found.setdefault(scale, path)
    if len(found) != 1:
        return calibration
    ((scale, path),) = found.items()
    kept = tuple(note for note in calibration.notes if DEPTH_SCALE not in note)
    note = f"{path.name} states the units of depth: {scale:g} in a metre"
    camera = replace(calibration.camera, depth_scale=scale)
    return replace(calibration, camera=camera, notes=(*kept, note), is_scale_assumed=False)


def files_that_state(files: Sequence[Path]) -> list[Path]:
    """Those that state a camera, under whichever form."""
    found: list[Path] = []
    for path in files:
        try:
            if path.stat().st_size <= _LONGEST and states_camera(read_tree(path, None, states_camera)[0]):
                found.append(path)
        except UserError:
            continue
    return found


def _stated(files: Sequence[Path], size: tuple[int, int] | None, default_depth_scale: float) -> dict[Path, Calibration]:
    """By file, those called so first."""
    found: dict[Path, Calibration] = {}
    wrong: UserError | None = None
    for path in sorted(files, key=lambda path: (not _is_called_so(path), len(path.parts), path.name)):
        if path.stat().st_size > _LONGEST:
            continue
        try:
            found[path] = read_calibration(path, image_size=size, default_depth_scale=default_depth_scale)
        except UserError as error:
            wrong = wrong or (error if _is_called_so(path) else None)
    if wrong is not None and not found:
        raise wrong
    of_depth = {path for path in found if _is_of_depth(path)}
    return {path: each for path, each in found.items() if path not in of_depth} or found


def _refuse_contradictions(folder: Path, found: dict[Path, Calibration]) -> None:
    if not found:
        return
    (first, one), *others = found.items()
    for path, other in others:
        focal = abs(one.camera.fx - other.camera.fx) > _CONTRADICTS * one.camera.fx
        stated = not (one.is_scale_assumed or other.is_scale_assumed)
        if focal or (stated and one.camera.depth_scale != other.camera.depth_scale):
            raise UserError(
                f"{folder}: {first.name} and {path.name} contradict each other (fx {one.camera.fx:g}, "
                f"{other.camera.fx:g}; depth_scale {one.camera.depth_scale:g}, {other.camera.depth_scale:g}); "
                "give the right one with --camera FILE"
            )


def _is_of_depth(path: Path) -> bool:
    """Whether a calibration is that of a depth camera, by its name: `depth.yaml`, `intrinsic_depth.txt`."""
    parts = re.split(r"[^a-z]+", path.stem.lower())
    return any(part in ("depth", "ir", "infra", "infrared") for part in parts) and not any(
        word in path.stem.lower() for word in ("color", "colour", "rgb")
    )


def _is_called_so(path: Path) -> bool:
    return any(word in path.stem.lower() for word in ("cam", "calib", "intrinsic"))
