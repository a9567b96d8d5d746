"""Opening a recording whatever its format, guessed from the path."""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from lpslam.config import CalibrationCheckConfig
from lpslam.errors import UserError
from lpslam.sources.focal_check import doubts_about_focal
from lpslam.sources.followed_pairs import pairs_of
from lpslam.sources.image_pairs import ImagePairSource
from lpslam.sources.plausibility import Doubt, doubts_about_depth, doubts_about_intrinsics, doubts_about_timing
from lpslam.sources.sevenscenes import looks_like_seven_scenes, open_seven_scenes
from lpslam.sources.tum import looks_like_tum, open_tum

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class _Format:
    """A layout of recordings: how it is known, and how it is opened."""

    sign: str
    is_at: Callable[[Path], bool]
    open: "_Open"


class _Open(Protocol):
    """Opens a folder; `nominal` makes do without a calibration."""

    def __call__(
        self, folder: Path, camera_file: Path | None, max_frames: int | None, *, nominal: bool
    ) -> ImagePairSource: ...


_FORMATS = (
    _Format("rgb.txt and depth.txt (TUM RGB-D)", looks_like_tum, open_tum),
    _Format("frame-NNNNNN.color.jpg (7-Scenes)", looks_like_seven_scenes, open_seven_scenes),
)


def open_source(
    path: Path | str,
    camera_file: Path | str | None = None,
    max_frames: int | None = None,
    checks: CalibrationCheckConfig | None = None,
) -> ImagePairSource:
    """Open the recording at `path`; what is doubtful about its calibration is logged as a warning, one line each.

    Args:
        path: a folder in a known layout.
        camera_file: a calibration to use instead of the recording's own.
        max_frames: use only so many frames, from the first.
        checks: when a calibration is doubted; defaults without.

    Raises:
        UserError: nothing is there, the layout is not known, the recording is malformed, or its calibration
            cannot be that of its images.
    """
    source = _opened(path, camera_file, max_frames, nominal=False)
    checks = checks or CalibrationCheckConfig()
    doubts = doubts_about_intrinsics(source.camera, checks)
    if not any(doubt.is_fatal for doubt in doubts):
        pairs = pairs_of(source.frame, source.timestamps, checks.focal)
        doubts += doubts_about_focal(pairs, source.camera, checks.focal)
    _say(source, doubts + _other_doubts(source, checks))
    return source


def open_uncalibrated(
    path: Path | str, max_frames: int | None = None, checks: CalibrationCheckConfig | None = None
) -> ImagePairSource:
    """Open a recording whose intrinsics are to be estimated: what is stated of them, if anything, is not judged.

    Args:
        path: a folder in a known layout.
        max_frames: use only so many frames, from the first.
        checks: when its depth and its times are doubted; defaults without.

    Raises:
        UserError: nothing is there, the layout is not known, the recording is malformed, or its depth is of no room.
    """
    source = _opened(path, None, max_frames, nominal=True)
    _say(source, _other_doubts(source, checks or CalibrationCheckConfig()))
    return source


def _opened(
    path: Path | str, camera_file: Path | str | None, max_frames: int | None, *, nominal: bool
) -> ImagePairSource:
    folder = Path(path)
    if not folder.exists():
        raise UserError(f"{folder} does not exist; give the folder of a recording")
    if not folder.is_dir():
        raise UserError(f"{folder} is a file; give the folder of a recording ({_signs()})")
    try:
        found = next((layout for layout in _FORMATS if layout.is_at(folder)), None)
        if found is None:
            raise UserError(f"{folder} is no recording that is known: looked for {_signs()}{_hint(folder)}")
        calibration = Path(camera_file) if camera_file is not None else None
        return found.open(folder, calibration, max_frames, nominal=nominal)
    except PermissionError as error:
        raise UserError(f"{error.filename or folder} cannot be read ({error.strerror})") from error


def _say(source: ImagePairSource, doubts: list[Doubt]) -> None:
    """What refuses the recording first."""
    for doubt in sorted(doubts, key=lambda doubt: not doubt.is_fatal):
        if doubt.is_fatal:
            raise UserError(f"{source.name}: {doubt.text}")
        logger.warning("%s: %s", source.name, doubt.text)


def _other_doubts(source: ImagePairSource, checks: CalibrationCheckConfig) -> list[Doubt]:
    """About what is stated besides the intrinsics."""
    doubts = doubts_about_depth(source.sample_depths(checks.depth_frames), source.camera, checks)
    if source.listed_times is not None:
        doubts += doubts_about_timing(*source.listed_times, checks)
    return doubts


def _signs() -> str:
    return " or ".join(layout.sign for layout in _FORMATS)


def _hint(folder: Path) -> str:
    """Name a subfolder that is a recording, if there is one: archives often unpack to one folder more."""
    for child in sorted(child for child in folder.iterdir() if child.is_dir())[:100]:
        if any(layout.is_at(child) for layout in _FORMATS):
            return f"; did you mean {child}?"
    return ""
