"""Folders in the layout of the TUM RGB-D benchmark: rgb.txt, depth.txt and the images that they list."""

import re
from pathlib import Path

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.config import PairingConfig
from lpslam.errors import UserError
from lpslam.regular_files import text_of
from lpslam.sources.calibration import Calibration, read_calibration
from lpslam.sources.captures.stated import calibration_among, with_stated_units
from lpslam.sources.clocks import in_seconds
from lpslam.sources.continuity import refuse_clock_set_back
from lpslam.sources.image_pairs import ImagePair, ImagePairSource, first_image_size, in_depth_pauses
from lpslam.timestamps import associate, usual_tolerance

CAMERA_FILES = tuple(
    f"{name}.{ending}"
    for name in ("camera", "calibration", "camera_info", "intrinsics", "intrinsic", "camera_intrinsic")
    for ending in ("yaml", "yml", "json")
)
DEPTH_SCALE = 5000.0
_LISTS = ("rgb.txt", "depth.txt", "groundtruth.txt", "accelerometer.txt", "associations.txt")
_NOMINAL_FOCAL = 0.87  # of the width: 60 degrees across, as most RGB-D cameras have it

# The benchmark's published calibrations of its three Kinects: fx, fy, cx, cy and distortion.
_FREIBURG = {
    "1": ((517.3, 516.5, 318.6, 255.3), (0.2624, -0.9531, -0.0054, 0.0026, 1.1633)),
    "2": ((520.9, 521.0, 325.1, 249.7), (0.2312, -0.7849, -0.0033, -0.0001, 0.9172)),
    "3": ((535.4, 539.2, 320.1, 247.6), (0.0, 0.0, 0.0, 0.0, 0.0)),
}


def looks_like_tum(folder: Path) -> bool:
    """Whether the folder has the lists that a TUM recording has."""
    return (folder / "rgb.txt").is_file() or (folder / "depth.txt").is_file()


def open_tum(
    folder: Path,
    camera_file: Path | None = None,
    max_frames: int | None = None,
    *,
    nominal: bool = False,
    pairing: PairingConfig | None = None,
) -> ImagePairSource:
    """Open a TUM folder.

    Args:
        folder: holds rgb.txt, depth.txt and the images.
        camera_file: a calibration to use instead of the folder's own.
        max_frames: use only so many frames, from the first.
        nominal: where no calibration is known, take that of a usual camera, and say so.
        pairing: seconds between a colour image and its depth image. A colour image without one is skipped, unless
            depth pauses: then it comes without depth, by which the camera is tracked on.

    Raises:
        UserError: a list is missing, empty or malformed, no images belong together, or no calibration is known.
    """
    pairing = pairing or PairingConfig()
    colours, note = _read_list(folder / "rgb.txt")
    depths, depth_note = _read_list(folder / "depth.txt")
    # A repeated timestamp is one moment: its first image takes the depth, the others are faults.
    colour_times, depth_times = _times(colours), _times(depths)
    times, firsts = np.unique(colour_times, return_index=True)
    tolerance = usual_tolerance(times, depth_times, pairing.tolerance_s, pairing.slow_tolerance_s)
    rows, columns = associate(times, depth_times, tolerance)
    if not len(rows):
        raise UserError(
            f"{folder}: no image of rgb.txt has one in depth.txt within {tolerance * 1000:g} ms; "
            f"they begin {abs(depth_times[0] - times[0]):.3f} s apart and must use the same clock; if they do, allow "
            "more with pairing.tolerance_s in a configuration"
        )
    depth_of = dict(zip(firsts[rows].tolist(), columns.tolist(), strict=True))
    pauses = in_depth_pauses(colour_times, times[rows], pairing.pause_s)
    pairs: list[ImagePair] = []
    previous = -np.inf
    for row, (timestamp, path) in enumerate(colours):
        if timestamp == previous:
            pairs.append(ImagePair(timestamp, path, None, f"{path.name} repeats the timestamp {timestamp:.6f}"))
        elif row in depth_of:
            pairs.append(ImagePair(timestamp, path, depths[depth_of[row]][1]))
        elif pauses[row]:
            pairs.append(ImagePair(timestamp, path, None))
        else:
            fault = f"{path.name} has no depth image within {tolerance * 1000:g} ms"
            pairs.append(ImagePair(timestamp, path, None, fault))
        previous = timestamp
    calibration = _find_calibration(folder, camera_file, [path for _, path in colours], nominal)
    # Where how depth lies is still to be found, its size tells nothing.
    depth_size = None if nominal else first_image_size([path for _, path in depths])
    notes = (*calibration.notes, *calibration.note_of(depth_size))
    if depth_note and depth_note != note:
        note = f"{note}; in depth.txt {depth_note}" if note else f"in depth.txt {depth_note}"
    notes = (*notes, note) if note else notes
    return ImagePairSource(
        folder.resolve().name,
        calibration.camera,
        pairs,
        notes=notes,
        listed_times=(colour_times, depth_times),
        displacement=calibration.displacement_of(depth_size),
        may_displace=nominal,
        is_scale_assumed=calibration.is_scale_assumed,
        max_frames=max_frames,
    )


def _find_calibration(folder: Path, camera_file: Path | None, colours: list[Path], nominal: bool) -> Calibration:
    own = [folder / name for name in CAMERA_FILES if (folder / name).is_file()]
    size = first_image_size(colours)
    others = [path for path in sorted(folder.iterdir()) if path.is_file() and path.name not in _LISTS]
    if camera_file is not None or len(own) == 1:
        stated = read_calibration(camera_file or own[0], image_size=size, default_depth_scale=DEPTH_SCALE)
        return with_stated_units(stated, others)
    found = calibration_among(folder, own or others, size, DEPTH_SCALE)
    if found is not None:
        return found
    sensor = re.search(r"(?:freiburg|fr)([123])(?!\d)", folder.resolve().name, re.IGNORECASE)
    if sensor is None and nominal:
        width, height = size or (640, 480)
        focal, note = _NOMINAL_FOCAL * width, f"no {CAMERA_FILES[0]}: depth is taken for {DEPTH_SCALE:g} units a metre"
        middle = ((width - 1) / 2, (height - 1) / 2)
        camera = PinholeCamera(width, height, focal, focal, *middle, depth_scale=DEPTH_SCALE)
        return Calibration(camera, (note,), is_scale_assumed=True)
    if sensor is None:
        raise UserError(
            f"{folder} has no {CAMERA_FILES[0]} and is not named after freiburg1, 2 or 3; "
            "give its calibration with --camera FILE, or estimate it with 'lpslam calibrate'"
        )
    (fx, fy, cx, cy), distortion = _FREIBURG[sensor[1]]
    width, height = size or (640, 480)
    camera = PinholeCamera(width, height, fx, fy, cx, cy, distortion, DEPTH_SCALE)
    note = f"no {CAMERA_FILES[0]}: the calibration of freiburg{sensor[1]} is used, after the folder's name"
    return Calibration(camera, (note,))


def _read_list(path: Path) -> tuple[list[tuple[float, Path]], str]:
    """Read lines `timestamp file`, in order of time, and what was made of the stamps; `#` begins a comment."""
    text = text_of(path, remedy="a TUM folder lists its images there")
    entries: list[tuple[float, Path]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.strip().split(maxsplit=1)
        if not words or words[0].startswith("#"):
            continue
        try:
            timestamp = float(words[0])
        except ValueError:
            timestamp = np.nan
        if len(words) != 2 or not np.isfinite(timestamp):
            raise UserError(f"{path}, line {number}: expected a timestamp and a file name")
        entries.append((timestamp, path.parent / words[1].strip()))
    if not entries:
        raise UserError(f"{path} lists no images; each line is a timestamp and a file name")
    refuse_clock_set_back(_times(entries), [image for _, image in entries], path)
    seconds, note = in_seconds(_times(entries))
    timed = [(float(second), image) for second, (_, image) in zip(seconds, entries, strict=True)]
    return sorted(timed, key=lambda entry: entry[0]), note


def _times(entries: list[tuple[float, Path]]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array([timestamp for timestamp, _ in entries], dtype=np.float64)
