"""A source of frames that lie as pairs of colour and depth images in a folder."""

import logging
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.frames import FrameFault, RgbdFrame
from lpslam.sources.depths.encoding import DepthEncoding
from lpslam.sources.images import BadImageError, image_size, read_colour, read_depth
from lpslam.sources.inside import PictureFile
from lpslam.sources.registering.displacement import Displacement
from lpslam.sources.registering.registration import DepthRegistration

logger = logging.getLogger(__name__)

# So many images tell whether a whole recording has another size than its calibration.
_PROBES = 8


@dataclass(frozen=True, slots=True)
class ImagePair:
    """Where one frame lies.

    Attributes:
        timestamp: seconds.
        colour: the colour image's file.
        depth: the depth image's file; None where the recording has none for this frame, which then comes without depth.
        fault: why the frame cannot be used, where the listing itself shows it; empty otherwise.
    """

    timestamp: float
    colour: PictureFile
    depth: PictureFile | None
    fault: str = ""


class ImagePairSource:
    """A `FrameSource` over listed image files.

    Args:
        name: as in reports.
        camera: the calibration of the colour images, to which depth is registered.
        pairs: the frames; they are put in order of time.
        notes: what was assumed because the recording does not say it; one sentence each.
        listed_times: seconds of all colour and of all depth images, rising, where each kind has times of its own.
        displacement: how depth lies beside colour; it is registered then. Without, it is taken to be registered.
        is_along_rays: depth is the distance from the camera, and not along its axis.
        may_displace: depth may have another size than colour, since how it lies is still to be found.
        is_scale_assumed: nothing states the camera's depth scale.
        encoding: how raw numbers of depth are taken, where they are no multiples of a length.
        max_frames: use only so many frames, from the first.

    Raises:
        UserError: there are no frames, or all colour or all depth images have another size than the camera.
    """

    def __init__(
        self,
        name: str,
        camera: PinholeCamera,
        pairs: Sequence[ImagePair],
        *,
        notes: tuple[str, ...] = (),
        listed_times: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None,
        displacement: Displacement | None = None,
        is_along_rays: bool = False,
        may_displace: bool = False,
        is_scale_assumed: bool = False,
        encoding: DepthEncoding | None = None,
        max_frames: int | None = None,
    ) -> None:
        if max_frames is not None and max_frames < 1:
            raise UserError(f"{name}: the number of frames is limited to {max_frames}; it must be at least 1")
        if not pairs:
            raise UserError(f"{name}: the recording lists no frames")
        self._name = name
        self._camera = camera
        self._pairs = sorted(pairs, key=lambda pair: pair.timestamp)[:max_frames]
        self._faults: list[FrameFault] = []
        self.notes = notes
        self.listed_times = listed_times
        self.displacement = displacement
        self._may_displace = may_displace
        self._along_axis = axis_by_ray(camera) if is_along_rays else None
        self.is_scale_assumed = is_scale_assumed
        self.encoding = encoding
        self._registrations: dict[tuple[int, ...], DepthRegistration] = {}
        _refuse_other_size(name, camera, self._pairs, is_registered=displacement is None and not may_displace)
        for note in notes:
            logger.warning("%s: %s", name, note)

    @property
    def name(self) -> str:
        """The recording's name."""
        return self._name

    @property
    def camera(self) -> PinholeCamera:
        """The calibration shared by all frames."""
        return self._camera

    @property
    def faults(self) -> list[FrameFault]:
        """Frames skipped so far in the running (or last) iteration."""
        return self._faults

    @property
    def is_of_one_size(self) -> bool:
        """Whether depth images have the size of colour images, as far as a few of them tell."""
        depths = sizes_of(self._name, "depth", [pair.depth for pair in self._pairs if pair.depth is not None])
        return not depths or (self._camera.width, self._camera.height) in depths

    @property
    def timestamps(self) -> list[float]:
        """Seconds, of every listed frame, good and bad, in order."""
        return [pair.timestamp for pair in self._pairs]

    def __len__(self) -> int:
        return len(self._pairs)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield the frames that can be decoded.

        Raises:
            UserError: at the end, if not one frame could be used.
        """
        self._faults = faults = []
        for index, pair in enumerate(self._pairs):
            try:
                yield self._read(index, pair)
            except BadImageError as error:
                faults.append(FrameFault(index, pair.timestamp, str(error)))
        if len(faults) == len(self._pairs):
            raise UserError(
                f"{self._name}: none of its {len(faults)} frames can be used; the first: {faults[0].reason}"
            )

    def part(self, start: float | None, end: float | None, max_frames: int | None) -> "ImagePairSource":
        """The frames between `start` and `end` seconds from the first one, or the first of them.

        Raises:
            UserError: there are none.
        """
        first = self._pairs[0].timestamp
        low, high = first + (start or 0.0), first + (np.inf if end is None else end)
        kept = [pair for pair in self._pairs if low <= pair.timestamp <= high]
        if not kept:
            length = self._pairs[-1].timestamp - first
            raise UserError(f"{self._name}: no frame lies between --from and --to; it lasts {length:.1f} s")
        return self._again(self._camera, kept, self.displacement, max_frames)

    def registered(self, displacement: Displacement) -> "ImagePairSource":
        """The same recording, its depth registered by where it was found to lie."""
        return self._again(self._camera, self._pairs, displacement, None)

    def rescaled(self, depth_scale: float) -> "ImagePairSource":
        """The same recording with so many raw depth units in a metre."""
        return self._again(replace(self._camera, depth_scale=depth_scale), self._pairs, self.displacement, None)

    def _again(
        self,
        camera: PinholeCamera,
        pairs: Sequence[ImagePair],
        displacement: Displacement | None,
        max_frames: int | None,
    ) -> "ImagePairSource":
        """Some of the frames, without the notes, which were said."""
        return ImagePairSource(
            self._name,
            camera,
            pairs,
            listed_times=self.listed_times,
            displacement=displacement,
            is_along_rays=self._along_axis is not None,
            may_displace=self._may_displace,
            is_scale_assumed=self.is_scale_assumed,
            encoding=self.encoding,
            max_frames=max_frames,
        )

    def sample_depths(self, count: int) -> list[NDArray[np.float32]]:
        """Depth images (height, width) in metres, spread over the recording; without those that cannot be read."""
        usable = [pair.depth for pair in self._pairs if pair.depth is not None]
        depths = []
        for row in np.unique(np.linspace(0, len(usable) - 1, count).astype(int)) if usable else ():
            try:
                depths.append(read_depth(usable[row], self._camera.depth_scale, self.encoding))
            except BadImageError:
                continue
        return depths

    def sample_frames(self, count: int) -> list[RgbdFrame]:
        """Frames spread over the recording; without those that cannot be used."""
        rows = np.unique(np.linspace(0, len(self._pairs) - 1, count).astype(int)) if count else ()
        return [frame for frame in (self.frame(int(row)) for row in rows) if frame is not None]

    def frame(self, index: int) -> RgbdFrame | None:
        """The frame of a number; None if it cannot be used, or there is none. Leaves no fault behind."""
        if not 0 <= index < len(self._pairs):
            return None
        try:
            return self._read(index, self._pairs[index])
        except BadImageError:
            return None

    def _read(self, index: int, pair: ImagePair) -> RgbdFrame:
        if pair.fault:
            raise BadImageError(pair.fault)
        wanted = (self._camera.height, self._camera.width)
        rgb = read_colour(pair.colour)
        _refuse_size(pair.colour, rgb.shape[:2], wanted)
        if pair.depth is None:
            return RgbdFrame(index, pair.timestamp, rgb, np.zeros(wanted, np.float32))
        depth = read_depth(pair.depth, self._camera.depth_scale, self.encoding)
        if self.displacement is not None:
            depth = self._registered(depth, self.displacement)
        elif not self._may_displace:
            _refuse_size(pair.depth, depth.shape, wanted)
        if self._along_axis is not None:
            depth *= self._along_axis
        return RgbdFrame(index, pair.timestamp, rgb, depth)

    def _registered(self, depth: NDArray[np.float32], displacement: Displacement) -> NDArray[np.float32]:
        if depth.shape not in self._registrations:
            rig = displacement.rig((depth.shape[1], depth.shape[0]), (self._camera.width, self._camera.height))
            self._registrations[depth.shape] = DepthRegistration(rig)
        return self._registrations[depth.shape](depth)


def _refuse_size(path: PictureFile, found: tuple[int, ...], wanted: tuple[int, int]) -> None:
    if found != wanted:
        raise BadImageError(f"{path.name} is {found[1]}×{found[0]}; the camera is {wanted[1]}×{wanted[0]}")


def axis_by_ray(camera: PinholeCamera) -> NDArray[np.float32]:
    """What takes the distance along a pixel's ray to that along the camera's axis: (height, width), at most 1."""
    across = (np.arange(camera.width) - camera.cx) / camera.fx
    down = (np.arange(camera.height) - camera.cy) / camera.fy
    return np.asarray(1.0 / np.sqrt(1.0 + across[None, :] ** 2 + down[:, None] ** 2), np.float32)


def in_depth_pauses(times: NDArray[np.float64], depth_times: NDArray[np.float64], pause: float) -> NDArray[np.bool_]:
    """Which times (n,) lie where there was no depth for `pause` seconds, by rising times (m,) at which there was."""
    after = np.searchsorted(depth_times, times)
    inside = (after > 0) & (after < len(depth_times))
    pauses = np.zeros(len(times), np.bool_)
    pauses[inside] = depth_times[after[inside]] - depth_times[after[inside] - 1] > pause
    return pauses & ~np.isin(times, depth_times)


def first_image_size(paths: Sequence[PictureFile]) -> tuple[int, int] | None:
    """Width and height of the first image whose header can be read; None if none can."""
    return next((size for size in map(image_size, paths[:100]) if size is not None), None)


def _refuse_other_size(name: str, camera: PinholeCamera, pairs: Sequence[ImagePair], *, is_registered: bool) -> None:
    wanted = (camera.width, camera.height)
    colours = sizes_of(name, "colour", [pair.colour for pair in pairs])
    depths = sizes_of(name, "depth", [pair.depth for pair in pairs if pair.depth is not None])
    if is_registered and colours and depths and not colours & depths:
        raise UserError(
            f"{name}: its colour images are {_in_words(colours)}, its depth images {_in_words(depths)}; "
            "register depth to colour, so that both have the same pixels, or let 'lpslam calibrate' find how it lies"
        )
    if colours and wanted not in colours:
        raise UserError(
            f"{name}: its images are {_in_words(colours)}, its calibration is for {wanted[0]}×{wanted[1]}; "
            "give the calibration of these images"
        )


def sizes_of(name: str, what: str, paths: Sequence[PictureFile]) -> set[tuple[int, int]]:
    """Sizes of some of the images, spread over all; of two recordings in one folder a `UserError`.

    Args:
        name: of the recording.
        what: the images are, in a word.
        paths: in order of time.
    """
    rows = np.unique(np.linspace(0, len(paths) - 1, _PROBES).astype(int)) if paths else ()
    sizes = Counter(size for size in (image_size(paths[row]) for row in rows) if size is not None)
    # One alone is damaged.
    often = [size for size, count in sizes.most_common() if count > 1]
    if len(often) > 1:
        raise UserError(
            f"{name}: its {what} images are of two sizes, {_in_words({often[0]})} and {_in_words({often[1]})}: these "
            "are two recordings; put each into a folder of its own, with its calibration"
        )
    return set(sizes)


def _in_words(sizes: set[tuple[int, int]]) -> str:
    width, height = min(sizes)
    return f"{width}×{height}"
