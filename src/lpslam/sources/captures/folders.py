"""Folders of colour and depth pictures in whatever way somebody has laid them: what is there tells the layout.

Which pictures are colour and which depth their contents tell, their times a list, a file of times or their names, and
what belongs together a list, the times, the numbers or the order. Redwood's and Open3D's color/ and depth/ are such
folders: http://www.open3d.org/docs/release/tutorial/reconstruction_system/capture_your_own_dataset.html
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import PairingConfig
from lpslam.errors import UserError
from lpslam.sources.calibration import Calibration, read_calibration
from lpslam.sources.captures.chunks import times_in_chunks
from lpslam.sources.captures.common import number_of
from lpslam.sources.captures.holders.arrays import times_beside
from lpslam.sources.captures.holders.videos import Video
from lpslam.sources.captures.series import Pictures, Series
from lpslam.sources.captures.stated import calibration_among
from lpslam.sources.captures.tables import Listing, listing_of, times_in_names
from lpslam.sources.depths.encoding import DepthEncoding
from lpslam.sources.depths.stated import stated_disparity, stated_encoding
from lpslam.sources.image_pairs import ImagePair, ImagePairSource, first_image_size, in_depth_pauses, sizes_of
from lpslam.sources.inside import Inside, PictureFile
from lpslam.timestamps import associate, usual_tolerance

_Times = NDArray[np.float64]
Size = tuple[int, int]
_MILLIMETRES = 1000.0


def holds_pictures(folder: Path) -> bool:
    """Whether a folder, or those within it, hold a series of colour and one of depth; or a file of arrays does."""
    pictures = Pictures(folder)
    return pictures.colour is not None and pictures.depth is not None


def open_capture(
    folder: Path,
    camera_file: Path | None,
    max_frames: int | None,
    *,
    nominal: bool,
    pairing: PairingConfig | None = None,
) -> ImagePairSource:
    """Open a folder of pictures; those with times of their own are paired as `pairing` says.

    Raises:
        UserError: there are no pairs, or no calibration, or two that contradict each other.
    """
    pictures = Pictures(folder)
    colour, depth = pictures.colour, pictures.depth
    if colour is None or depth is None:
        missing = "colour" if colour is None else "depth"
        raise UserError(f"{folder}: no two {missing} pictures of one kind lie there; depth has one channel of 16 bits")
    for what, series in (("colour", colour), ("depth", depth)):
        sizes_of(str(folder), what, series.paths)
    # Where how depth lies is still to be found, its size tells nothing.
    size, depth_size = first_image_size(colour.paths), None if nominal else first_image_size(depth.paths)
    listing = listing_of(pictures.texts, [colour.paths, depth.paths])
    calibration = _calibration(folder, camera_file, pictures, (size, depth_size), nominal)
    encoding = _encoding(pictures, depth, calibration.camera.fx)
    pairs, notes, times = _paired(folder, colour, depth, listing, calibration.camera.fps, pairing or PairingConfig())
    if encoding is not None and (encoding.numerator is not None or encoding.scale is not None):
        calibration = calibration.with_scale(encoding.scale or 1.0)
    elif depth.is_float:
        # Fractions are metres; a scale that is stated is that of whole numbers.
        camera = replace(calibration.camera, depth_scale=1.0)
        kept = tuple(note for note in calibration.notes if "depth_scale" not in note)
        calibration = replace(calibration, camera=camera, notes=kept, is_scale_assumed=True)
    return ImagePairSource(
        folder.stem if folder.is_file() else folder.resolve().name,
        calibration.camera,
        pairs,
        notes=(*calibration.notes, *calibration.note_of(depth_size), *pictures.notes, *notes),
        listed_times=times,
        displacement=calibration.displacement_of(depth_size),
        is_along_rays=depth.is_along_rays,
        may_displace=nominal,
        is_scale_assumed=calibration.is_scale_assumed,
        encoding=encoding,
        max_frames=max_frames,
    )


def _encoding(pictures: Pictures, depth: Series, focal: float) -> DepthEncoding | None:
    """How the numbers of depth are taken, as it is stated."""
    name = "/".join(depth.paths[0].parts[-3:])
    if depth.is_disparity:
        return stated_disparity(pictures.texts, focal, name, is_float=depth.is_float)
    return stated_encoding(pictures.texts, name)


def _paired(
    folder: Path, colour: Series, depth: Series, listing: Listing, rate: float, pairing: PairingConfig
) -> tuple[list[ImagePair], list[str], tuple[_Times, _Times] | None]:
    """The pairs, what was assumed of their times, and the times of both where each has its own."""
    colour_times, note = _stamps(colour, listing)
    depth_times, _ = _stamps(depth, listing)
    notes = [*sorted(listing.notes), *([note] if note else [])]
    listed = None
    pauses = np.zeros(len(colour.paths), np.bool_)
    if listing.pairs:
        found = listing.pairs
    elif colour_times is not None and depth_times is not None and _share_a_clock(colour_times, depth_times):
        tolerance = usual_tolerance(colour_times, depth_times, pairing.tolerance_s, pairing.slow_tolerance_s)
        rows, columns = associate(colour_times, depth_times, tolerance)
        found = {colour.paths[row]: depth.paths[column] for row, column in zip(rows, columns, strict=True)}
        listed = np.sort(colour_times), np.sort(depth_times)
        pauses = in_depth_pauses(colour_times, np.sort(colour_times[rows]), pairing.pause_s)
    else:
        found = _by_number(colour.paths, depth.paths)
    if not found:
        raise UserError(
            f"{folder}: nothing says which depth picture belongs to which colour picture; give both the same numbers "
            "or times in their names, or a list with a line for each pair"
        )
    if colour_times is None and depth_times is not None:
        # What belongs together was taken at one time.
        by_depth = dict(zip(depth.paths, depth_times, strict=True))
        kept = [path for path in colour.paths if path in found]
        colour, pauses = replace(colour, paths=tuple(kept)), np.zeros(len(kept), np.bool_)
        colour_times = np.array([by_depth[found[path]] for path in kept])
    if colour_times is None:
        numbers = [number_of(path) for path in colour.paths]
        counted = [index if number is None else number for index, number in enumerate(numbers)]
        rate = (colour.holder.rate if isinstance(colour.holder, Video) else 0.0) or rate
        colour_times = (np.array(counted, np.float64) - min(counted)) / rate
        notes.append(f"its images carry no times: {rate:g} a second are taken")
    pairs = []
    for row, (path, time) in enumerate(zip(colour.paths, colour_times, strict=True)):
        other = found.get(path)
        fault = "" if other is not None or pauses[row] else f"{path.name} has no depth image of its own"
        pairs.append(ImagePair(float(time), path, other, fault))
    return pairs, notes, listed


def _stamps(series: Series, listing: Listing) -> tuple[_Times | None, str]:
    """Seconds of a series (n,), as a list or the names say; None where nothing does."""
    listed = [listing.times.get(path) for path in series.paths]
    if all(time is not None for time in listed):
        return np.array(listed, np.float64), ""
    if series.holder is not None:
        return series.holder.times, ""
    inside = times_beside(series.paths)
    if inside is None:
        inside = times_in_chunks(series.paths)
    return (inside, "") if inside is not None else times_in_names(series.paths)


def _share_a_clock(one: _Times, other: _Times) -> bool:
    """Whether two series overlap in time."""
    return bool(one.min() <= other.max() and other.min() <= one.max())


def _by_number(colours: Sequence[PictureFile], depths: Sequence[PictureFile]) -> dict[PictureFile, PictureFile]:
    """Pictures of equal numbers; of as many without numbers, those in the same place in order."""
    numbers, of_colours = _counted(depths, colours), _counted(colours, depths)
    if None in numbers or len(set(numbers)) < len(numbers):
        return dict(zip(colours, depths, strict=True)) if len(colours) == len(depths) else {}
    by_number = dict(zip(numbers, depths, strict=True))
    return {path: by_number[number] for path, number in zip(colours, of_colours, strict=True) if number in by_number}


def _counted(pictures: Sequence[PictureFile], others: Sequence[PictureFile]) -> list[int | None]:
    """The pictures' numbers: within a video or an array from 0 on, or from 1 where the names of the others begin so."""
    numbers = [number_of(path) for path in pictures]
    if not isinstance(pictures[0], Inside) or isinstance(others[0], Inside) or 0 not in numbers:
        return numbers
    first = min((number_of(path) or 0 for path in others), default=0)
    return [number + 1 if number is not None and first == 1 else number for number in numbers]


def _calibration(
    folder: Path, camera_file: Path | None, pictures: Pictures, sizes: tuple[Size | None, Size | None], nominal: bool
) -> Calibration:
    """The calibration for images of the sizes of colour and of depth."""
    size, depth_size = sizes
    if camera_file is not None:
        return read_calibration(camera_file, image_size=size, default_depth_scale=_MILLIMETRES)
    found = calibration_among(folder, pictures.texts, size, _MILLIMETRES, pictures.trees, depth_size)
    if found is not None:
        return found
    width, height = size or (640, 480)
    if folder.joinpath("color").is_dir() or nominal:
        # Redwood's recordings state none: PrimeSense's factory values, as Open3D takes them too.
        focal, note = 525.0 * width / 640, "no calibration: PrimeSense's focal length 525 at 640 pixels is used"
        middle = (width - 1) / 2, (height - 1) / 2
        camera = PinholeCamera(width, height, focal, focal, *middle, depth_scale=_MILLIMETRES)
        return Calibration(camera, (note,), is_scale_assumed=True)
    raise UserError(f"{folder} has no calibration; give one with --camera FILE, or estimate it with 'lpslam calibrate'")
