"""The calibrations that files of a folder state, and whether they agree."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from lpslam.errors import UserError
from lpslam.sources.calibration import Calibration, calibration_of, read_calibration, states_camera
from lpslam.sources.yaml_tree import Tree

_SUFFIXES = (".yaml", ".yml", ".json", ".txt", ".ini", ".cfg", ".conf", ".xml", ".csv", ".md", ".log", "")
_CONTRADICTS = 0.02
"""Share by which focal lengths of one camera may differ between two files."""
_LONGEST = 1 << 20
"""Bytes of a file that may be a calibration."""


def calibration_among(
    folder: Path,
    files: Sequence[Path],
    size: tuple[int, int] | None,
    default_depth_scale: float,
    trees: Mapping[Path, Tree] | None = None,
) -> Calibration | None:
    """The calibration of the colour camera that files of a folder state; None without.

    Args:
        folder, files: where they lie, and which they are.
        size, default_depth_scale: as `read_calibration` takes them.
        trees: what files of arrays say besides, by file.

    Raises:
        UserError: two of them contradict each other, or the only ones that are called so cannot be read.
    """
    found = _stated(files, size, default_depth_scale)
    for path, tree in (trees or {}).items():
        if states_camera(tree):
            found[path] = calibration_of(tree, path, size, default_depth_scale)
    _refuse_contradictions(folder, found)
    return next(iter(found.values()), None)


def _stated(files: Sequence[Path], size: tuple[int, int] | None, default_depth_scale: float) -> dict[Path, Calibration]:
    """By file, those called so first."""
    found: dict[Path, Calibration] = {}
    wrong: UserError | None = None
    for path in sorted(files, key=lambda path: (not _is_called_so(path), len(path.parts), path.name)):
        if path.suffix.lower() not in _SUFFIXES or path.stat().st_size > _LONGEST:
            continue
        try:
            found[path] = read_calibration(path, image_size=size, default_depth_scale=default_depth_scale)
        except UserError as error:
            wrong = wrong or (error if _is_called_so(path) else None)
    if wrong is not None and not found:
        raise wrong
    of_depth = {path for path in found if path.stem.lower().startswith(("depth", "ir", "infra"))}
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


def _is_called_so(path: Path) -> bool:
    return any(word in path.stem.lower() for word in ("cam", "calib", "intrinsic"))
