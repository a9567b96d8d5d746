"""A source over frames that are listed and decoded one by one, whatever they lie in."""

import logging
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.frames import FrameFault, RgbdFrame
from lpslam.sources.images import BadImageError

logger = logging.getLogger(__name__)

Picture = tuple[NDArray[np.uint8], NDArray[np.float32]]


class Decode(Protocol):
    """Gives colour (height, width, 3) and depth (h, w) in metres of the frame of a number, or a `BadImageError`."""

    def __call__(self, number: int) -> Picture:
        """The frame of a number."""
        ...


class ListedSource:
    """A `FrameSource` over frames that a function decodes.

    Args:
        name: as in reports.
        camera: the calibration of the colour images.
        times: seconds of every frame, rising.
        decode: gives a frame's colour and depth.
        register: puts depth into the pixels of the camera; depth has them already without.
        notes: what was assumed, one sentence each.
        max_frames: use only so many frames, from the first.
        first: the number of the first frame, as `decode` counts.

    Raises:
        UserError: there are no frames.
    """

    def __init__(
        self,
        name: str,
        camera: PinholeCamera,
        times: Sequence[float],
        decode: Decode,
        *,
        register: Callable[[NDArray[np.float32]], NDArray[np.float32]] | None = None,
        notes: tuple[str, ...] = (),
        max_frames: int | None = None,
        first: int = 0,
    ) -> None:
        if max_frames is not None and max_frames < 1:
            raise UserError(f"{name}: the number of frames is limited to {max_frames}; it must be at least 1")
        if not len(times):
            raise UserError(f"{name}: the recording lists no frames")
        self.name, self.camera = name, camera
        self.timestamps: list[float] = [float(time) for time in times][:max_frames]
        self.faults: list[FrameFault] = []
        self.notes = notes
        self.listed_times: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
        self._decode, self._register, self._first = decode, register, first
        for note in notes:
            logger.warning("%s: %s", name, note)

    def __len__(self) -> int:
        return len(self.timestamps)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield the frames that can be decoded.

        Raises:
            UserError: at the end, if not one frame could be used.
        """
        self.faults = faults = []
        for index in range(len(self)):
            try:
                yield self._read(index)
            except BadImageError as error:
                faults.append(FrameFault(index, self.timestamps[index], str(error)))
        if len(faults) == len(self):
            raise UserError(f"{self.name}: none of its {len(faults)} frames can be used; the first: {faults[0].reason}")

    def part(self, start: float | None, end: float | None, max_frames: int | None) -> "ListedSource":
        """The frames between `start` and `end` seconds from the first one, or the first of them.

        Raises:
            UserError: there are none.
        """
        times = np.array(self.timestamps) - self.timestamps[0]
        rows = np.flatnonzero((times >= (start or 0.0)) & (times <= (np.inf if end is None else end)))
        if not len(rows):
            raise UserError(f"{self.name}: no frame lies between --from and --to; it lasts {times[-1]:.1f} s")
        kept = self.timestamps[int(rows[0]) : int(rows[-1]) + 1]
        return ListedSource(
            self.name,
            self.camera,
            kept,
            self._decode,
            register=self._register,
            max_frames=max_frames,
            first=self._first + int(rows[0]),
        )

    def frame(self, index: int) -> RgbdFrame | None:
        """The frame of a number; None if it cannot be used, or there is none. Leaves no fault behind."""
        try:
            return self._read(index) if 0 <= index < len(self) else None
        except BadImageError:
            return None

    def sample_depths(self, count: int) -> list[NDArray[np.float32]]:
        """Depth images (height, width) in metres, spread over the recording; without those that cannot be read."""
        rows = np.unique(np.linspace(0, len(self) - 1, count).astype(int))
        frames = (self.frame(int(row)) for row in rows)
        return [frame.depth for frame in frames if frame is not None]

    def _read(self, index: int) -> RgbdFrame:
        rgb, depth = self._decode(self._first + index)
        wanted = (self.camera.height, self.camera.width)
        if self._register is not None:
            depth = self._register(depth)
        for what, found in (("colour", rgb.shape[:2]), ("depth", depth.shape)):
            if found != wanted:
                raise BadImageError(f"its {what} is {found[1]}×{found[0]}; the camera is {wanted[1]}×{wanted[0]}")
        return RgbdFrame(index, self.timestamps[index], rgb, depth)
