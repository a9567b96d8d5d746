"""Opening a recording whatever its format, guessed from the path."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from lpslam.config import CalibrationCheckConfig, PairingConfig
from lpslam.errors import UserError
from lpslam.regular_files import is_regular
from lpslam.sources.bags.topics import TopicChoice
from lpslam.sources.captures.layouts import CAPTURES
from lpslam.sources.continuity import refuse_two_walks
from lpslam.sources.depths.check import refuse_other_encodings
from lpslam.sources.focal_check import doubts_about_focal
from lpslam.sources.followed_pairs import pairs_of
from lpslam.sources.image_pairs import ImagePairSource
from lpslam.sources.live.opening import addresses, is_camera, open_camera
from lpslam.sources.plausibility import (
    Doubt,
    doubts_about_depth,
    doubts_about_intrinsics,
    doubts_about_timing,
    fitting_depth_scale,
)
from lpslam.sources.recorded import RecordedSource
from lpslam.sources.registering.by_contours import find_displacement, looks_displaced
from lpslam.sources.registering.displacement import DepthDisplacement
from lpslam.sources.sevenscenes import looks_like_seven_scenes, open_seven_scenes
from lpslam.sources.tum import looks_like_tum, open_tum
from lpslam.sources.unknown import reason_for
from lpslam.sources.unpacked import ARCHIVES, unpacked

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SourceOptions:
    """What of a recording is used.

    Attributes:
        topics: of a file with topics; found by type without.
        start, end: seconds from its first frame; all of it without.
        pairing: how its colour and depth are paired by time.
    """

    topics: TopicChoice = field(default_factory=TopicChoice)
    start: float | None = None
    end: float | None = None
    pairing: PairingConfig = field(default_factory=PairingConfig)

    @property
    def is_cut(self) -> bool:
        """Whether only a part is used."""
        return self.start is not None or self.end is not None


@dataclass(frozen=True, slots=True)
class Format:
    """A layout of recordings: how it is known, and how it is opened.

    Attributes:
        name: as in `lpslam sources`.
        sign: what is in the path.
        is_at: whether it is there.
    """

    name: str
    sign: str
    is_at: Callable[[Path], bool]
    open: "_Open"


class _Open(Protocol):
    """Opens a recording; `nominal` makes do without a calibration."""

    def __call__(
        self, folder: Path, camera_file: Path | None, max_frames: int | None, *, nominal: bool, pairing: PairingConfig
    ) -> RecordedSource: ...


def _is_bag(path: Path) -> bool:
    from lpslam.sources.bags.containers.opening import looks_like_bag

    return looks_like_bag(path)


def _open_bag(path: Path, camera_file: Path | None, max_frames: int | None, options: SourceOptions) -> RecordedSource:
    from lpslam.sources.bags.containers.opening import open_container
    from lpslam.sources.bags.source import BagSource

    container = open_container(path)
    try:
        source = BagSource(
            container,
            options.topics,
            camera_file,
            start=options.start,
            end=options.end,
            max_frames=max_frames,
            pairing=options.pairing,
        )
    except UserError as error:
        damages = [text for damage in container.damages for text in damage.texts]
        if not damages:
            raise
        raise UserError(f"{error}; {'; '.join(damages)}") from error
    for damage in container.damages:
        damage.say()
    return source


FORMATS = (
    Format("TUM RGB-D", "rgb.txt and depth.txt", looks_like_tum, open_tum),
    Format("7-Scenes", "frame-NNNNNN.color.jpg", looks_like_seven_scenes, open_seven_scenes),
    *(Format(each.name, each.sign, each.is_at, each.open) for each in CAPTURES),
)
_ANY_FOLDER = FORMATS[-1]
"""What is tried last, where no layout is known."""
_MILLIMETRES = 1000.0
_LATEST = 1e11
"""Seconds: 3,000 years, and more than any clock says."""
BAGS = "a ROS bag (.bag, .db3, .mcap)"


def open_source(
    path: Path | str,
    camera_file: Path | str | None = None,
    max_frames: int | None = None,
    checks: CalibrationCheckConfig | None = None,
    options: SourceOptions | None = None,
) -> RecordedSource:
    """Open the recording at `path`; what is doubtful about its calibration is logged as a warning, one line each.

    Args:
        path: a file or folder in a known layout, or a connected camera (`realsense:`).
        camera_file: a calibration to use instead of the recording's own.
        max_frames: use only so many frames, from the first.
        checks: when a calibration is doubted; defaults without.
        options: topics, and which part of it; all of it without.

    Raises:
        UserError: nothing is there, the layout is not known, the recording is malformed, or its calibration
            cannot be that of its images.
    """
    if is_camera(path):
        return _opened_camera(path, camera_file, max_frames, options or SourceOptions())
    checks = checks or CalibrationCheckConfig()
    source = _scaled(_opened(path, camera_file, max_frames, options or SourceOptions(), nominal=False), checks)
    refuse_two_walks(source.name, source.timestamps, source.frame, checks.continuity)
    doubts = doubts_about_intrinsics(source.camera, checks)
    if not any(doubt.is_fatal for doubt in doubts):
        pairs = pairs_of(source.frame, source.timestamps, checks.focal)
        doubts += doubts_about_focal(pairs, source.camera, checks.focal)
    _say(source, doubts + _other_doubts(source, checks) + _doubts_about_registration(source, checks))
    return source


def _opened_camera(
    path: Path | str, camera_file: Path | str | None, max_frames: int | None, options: SourceOptions
) -> RecordedSource:
    if camera_file is not None or options.is_cut or options.topics != TopicChoice():
        raise UserError(f"{path} is a camera, which is calibrated by its maker; --camera and a part are for recordings")
    return open_camera(path, max_frames)


def open_uncalibrated(
    path: Path | str, max_frames: int | None = None, checks: CalibrationCheckConfig | None = None
) -> RecordedSource:
    """Open a recording whose intrinsics are to be estimated: what is stated of them, if anything, is not judged.

    Args:
        path: a folder in a known layout.
        max_frames: use only so many frames, from the first.
        checks: when its depth and its times are doubted; defaults without.

    Raises:
        UserError: nothing is there, the layout is not known, the recording is malformed, or its depth is of no room.
    """
    checks = checks or CalibrationCheckConfig()
    source = _scaled(_opened(path, None, max_frames, SourceOptions(), nominal=True), checks)
    _say(source, _other_doubts(source, checks))
    return source


def _opened(
    path: Path | str,
    camera_file: Path | str | None,
    max_frames: int | None,
    options: SourceOptions,
    *,
    nominal: bool,
) -> RecordedSource:
    place = Path(path)
    calibration = Path(camera_file) if camera_file is not None else None
    _refuse_span(options)
    try:
        if not place.exists():
            if str(path).endswith(":"):
                raise UserError(f"{path} is no camera; there are {addresses()}")
            raise UserError(f"{place} does not exist; give the folder of a recording, or {BAGS}")
        if not place.is_dir() and not is_regular(place):
            raise UserError(f"{place} is a device or a pipe, which cannot be read twice; give a file or a folder")
        found = next((layout for layout in FORMATS if layout.is_at(place)), None)
        is_bag = found in (None, _ANY_FOLDER) and _is_bag(place)
        inner: list[Path] = []
        if found in (None, _ANY_FOLDER) and place.is_dir() and not is_bag:
            inner = _recordings_in(place)
            bags = [] if inner or found is not None else _bags_in(place)
            if len(bags) == 1:
                logger.warning("%s: the recording in it, %s, is opened", place.name, bags[0].name)
                beside = calibration or _calibration_beside(place, bags[0])
                return _opened(bags[0], beside, max_frames, options, nominal=nominal)
            if len(inner) == 1:
                logger.warning("%s: the recording in it, %s, is opened", place.name, inner[0].name)
                beside = calibration or _calibration_beside(place, inner[0])
                return _opened(inner[0], beside, max_frames, options, nominal=nominal)
            # A folder of recordings is none itself.
            found = None if inner else found
        reason = "" if found is not None or is_bag else reason_for(place, inner)
        if reason:
            raise UserError(f"{place} is no recording that is read: {reason}")
        if found is None and (is_bag or (place.is_file() and not place.stat().st_size)):
            return _open_bag(place, calibration, max_frames, options)
        if found is None and place.suffix.lower() in ARCHIVES:
            return _opened(unpacked(place), calibration, max_frames, options, nominal=nominal)
        if found is None and place.is_file():
            raise UserError(f"{place} is a file; give the folder of a recording ({_signs()}), or {BAGS}")
        if found is None:
            looked_for = f"looked for {_signs()}, or {BAGS}; 'lpslam sources' lists all"
            raise UserError(f"{place} is no recording that is known: {looked_for}{_hint(place)}")
        if options.topics != TopicChoice():
            raise UserError(f"{place} has no topics; --color, --depth and --info are for bags")
        if not options.is_cut:
            return found.open(place, calibration, max_frames, nominal=nominal, pairing=options.pairing)
        whole: Any = found.open(place, calibration, None, nominal=nominal, pairing=options.pairing)
        return whole.part(options.start, options.end, max_frames)  # type: ignore[no-any-return]
    except OSError as error:
        raise UserError(f"{error.filename or place} cannot be read ({error.strerror or error})") from error


def _scaled(source: RecordedSource, checks: CalibrationCheckConfig) -> RecordedSource:
    """The recording with the depth scale that its depth tells, where nothing states another that is possible."""
    if not (np.abs(source.timestamps) < _LATEST).all():
        raise UserError(f"{source.name}: its times are of no clock; give seconds, or what can be converted to them")
    if not isinstance(source, ImagePairSource):
        return source
    refuse_other_encodings(source, checks.encoding)
    if not source.is_scale_assumed:
        return _in_millimetres(source, checks)
    depths = source.sample_depths(checks.depth_frames)
    try:
        scale = fitting_depth_scale(depths, source.camera, checks)
    except UserError as error:
        raise UserError(f"{source.name}: {error}") from error
    if scale == source.camera.depth_scale:
        return source
    logger.warning(
        "%s: its depth tells otherwise: %g raw units in a metre are taken; state depth_scale in the calibration",
        source.name,
        scale,
    )
    return source.rescaled(scale)


def _in_millimetres(source: ImagePairSource, checks: CalibrationCheckConfig) -> ImagePairSource:
    """The same, or in millimetres where the stated length of a raw unit is too long for metres and right for those."""
    camera = source.camera
    if camera.depth_scale >= _MILLIMETRES:
        return source
    depths = source.sample_depths(checks.depth_frames)
    smaller = [depth / np.float32(_MILLIMETRES) for depth in depths]
    is_impossible = any(doubt.is_fatal for doubt in doubts_about_depth(depths, camera, checks))
    if not is_impossible or doubts_about_depth(smaller, camera, checks):
        return source
    logger.warning("%s: the stated length of a raw unit of depth is taken as millimetres, not metres", source.name)
    return source.rescaled(_MILLIMETRES * camera.depth_scale)


def _refuse_span(options: SourceOptions) -> None:
    for name, seconds in (("--from", options.start), ("--to", options.end)):
        if seconds is not None and not 0 <= seconds < float("inf"):
            raise UserError(f"{name} is {seconds:g}; it is seconds from the first frame, 0 or more")
    if options.start is not None and options.end is not None and options.end <= options.start:
        raise UserError(f"--to {options.end:g} must come after --from {options.start:g}; both count seconds")


def _say(source: RecordedSource, doubts: list[Doubt]) -> None:
    """What refuses the recording first."""
    for doubt in sorted(doubts, key=lambda doubt: not doubt.is_fatal):
        if doubt.is_fatal:
            raise UserError(f"{source.name}: {doubt.text}")
        logger.warning("%s: %s", source.name, doubt.text)


def _other_doubts(source: RecordedSource, checks: CalibrationCheckConfig) -> list[Doubt]:
    """About what is stated besides the intrinsics."""
    doubts = doubts_about_depth(source.sample_depths(checks.depth_frames), source.camera, checks)
    if source.listed_times is not None:
        doubts += doubts_about_timing(*source.listed_times, checks)
    return doubts


def _doubts_about_registration(source: RecordedSource, checks: CalibrationCheckConfig) -> list[Doubt]:
    """Only of folders, which do not tell: bags say where their cameras stand."""
    if not isinstance(source, ImagePairSource):
        return []
    stated = source.displacement
    if stated is not None and not (isinstance(stated, DepthDisplacement) and stated.is_none):
        return []
    frames = source.sample_frames(checks.registration.frames)
    if not looks_displaced(frames, checks.registration):
        return []
    found = find_displacement(frames, checks.registration)
    if found is None or not found.is_displaced:
        return []
    return [
        Doubt(
            f"depth is not registered to colour: what it shows lies {found.pixels:.0f} pixels beside it; record "
            "aligned depth, or run 'lpslam calibrate' on the recording, and give what it writes with --camera",
            # Of another size, it was taken to show the same view.
            is_fatal=stated is not None,
        )
    ]


def _signs() -> str:
    return " or ".join(f"{layout.sign} ({layout.name})" for layout in FORMATS[:2])


def _hint(folder: Path) -> str:
    """Name a subfolder that is a recording, if there is one."""
    inner = _recordings_in(folder)
    return f"; did you mean {inner[0]}?" if inner else ""


def _recordings_in(folder: Path) -> list[Path]:
    """Subfolders that are recordings in a known layout: archives often unpack to one folder more."""
    children = sorted(child for child in folder.iterdir() if child.is_dir())[:100] if folder.is_dir() else []
    return [child for child in children if any(layout.is_at(child) for layout in FORMATS[:-1]) or _is_bag(child)]


def _bags_in(folder: Path) -> list[Path]:
    """The ROS 1 bags that lie in a folder."""
    return sorted(path for path in folder.glob("*.bag") if is_regular(path))[:100]


def _calibration_beside(folder: Path, inner: Path) -> Path | None:
    """The only file beside a recording that states a camera; None where the recording has one of its own."""
    from lpslam.sources.captures.stated import files_that_state

    texts = [path for path in sorted(folder.iterdir()) if path.is_file() and path != inner]
    stated = files_that_state(texts)
    own = sorted(inner.iterdir()) if inner.is_dir() else []
    if len(stated) != 1 or files_that_state([path for path in own if path.is_file()]):
        return None
    return stated[0]
