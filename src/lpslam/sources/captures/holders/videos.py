"""Videos: colour of eight bits a channel, or depth of sixteen, decoded in order."""

import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.errors import MissingExtraError, UserError
from lpslam.sources.images import MOST_PIXELS, BadImageError
from lpslam.sources.inside import refuse_many

SUFFIXES = frozenset((".mp4", ".mov", ".m4v", ".avi", ".mkv", ".webm"))
_BOXES = (b"ftyp", b"moov", b"mdat", b"free", b"skip", b"wide", b"pnot")
"""What an MP4 may begin with, behind four bytes."""
_FORMATS = {b"\x1aE\xdf\xa3": "matroska", b"RIFF": "avi"}
"""What other videos begin with."""
_MOST_RATE = 1000.0
"""Frames a second that a video may state."""


class _InOrder(ABC):
    """Pictures that are decoded one after the other; who steps back begins anew."""

    def __init__(self, path: Path, size: tuple[int, int], count: int, rate: float) -> None:
        self.path, self.size, self._count = path, size, count
        self.rate = rate if 0 < rate <= _MOST_RATE else 0.0
        self.times: NDArray[np.float64] | None = None
        self._frames: Iterator[tuple[int, NDArray[Any]]] = iter(())
        self._next = -1
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return self._count

    def picture(self, index: int) -> NDArray[Any]:
        """See `Holder`."""
        with self._lock:
            if self._next < 0 or not self._next <= index <= self._next + self._near:
                self._frames, self._next = self._decoded(index), index
            for found, picture in self._frames:
                self._next = found + 1
                if found == index:
                    return picture
        raise BadImageError(f"the video ends before frame {index}")

    @property
    @abstractmethod
    def _near(self) -> float:
        """Frames that are decoded for nothing rather than sought."""

    @abstractmethod
    def _decoded(self, first: int) -> Iterator[tuple[int, NDArray[Any]]]:
        """Numbers and pictures, from that of a number on or from before it."""


class Video(_InOrder):
    """A video of colour as a holder of pictures.

    Attributes:
        rate: frames a second; 0 where it states none that can be.

    Raises:
        UserError: it is no video that can be decoded.
    """

    _near = 30  # a video is sought slowly

    def __init__(self, path: Path) -> None:
        format_of(path)
        reader = cv2.VideoCapture(str(path))
        size = int(reader.get(cv2.CAP_PROP_FRAME_WIDTH)), int(reader.get(cv2.CAP_PROP_FRAME_HEIGHT))
        count, rate = int(reader.get(cv2.CAP_PROP_FRAME_COUNT)), float(reader.get(cv2.CAP_PROP_FPS))
        reader.release()
        if min(*size, count) <= 0 or size[0] * size[1] > MOST_PIXELS:
            raise UserError(f"{path} is no video that can be decoded")
        refuse_many(path, count)
        super().__init__(path, size, count, rate)

    def _decoded(self, first: int) -> Iterator[tuple[int, NDArray[np.uint8]]]:
        reader = cv2.VideoCapture(str(self.path))
        try:
            if first:
                reader.set(cv2.CAP_PROP_POS_FRAMES, first)
            number = first
            while True:
                ok, picture = reader.read()
                if not ok:
                    return
                yield number, np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)
                number += 1
        finally:
            reader.release()


class DeepVideo(_InOrder):
    """A video of one channel of sixteen bits, as FFV1 keeps depth; unpacked by PyAV (extra `video`).

    Raises:
        UserError: its pictures have eight bits, which hold no depth, or it cannot be decoded.
        MissingExtraError: PyAV is not there.
    """

    _near = math.inf  # it is not sought

    def __init__(self, path: Path) -> None:
        container = format_of(path)
        try:
            import av
        except ImportError:
            raise MissingExtraError("depth in a video", "video") from None
        self._open: Callable[[], Any] = lambda: av.open(str(path), format=container)
        self._errors = (av.error.FFmpegError, OSError, ValueError, ArithmeticError, AttributeError)
        try:
            with self._open() as file:
                track = file.streams.video[0]
                kind, size = str(track.format.name), (int(track.width), int(track.height))
                count = sum(1 for packet in file.demux(track) if packet.size)
                rate = float(track.average_rate or 0.0)
        except (*self._errors, IndexError) as error:
            raise UserError(f"{path} is no video that can be decoded ({type(error).__name__})") from error
        if not kind.startswith(("gray16", "gray12", "gray10")):
            raise UserError(f"{path} is called depth, and its pictures are {kind}: depth has one channel of 16 bits")
        super().__init__(path, size, count, rate)

    def _decoded(self, first: int) -> Iterator[tuple[int, NDArray[np.uint16]]]:
        try:
            with self._open() as file:
                for number, frame in enumerate(file.decode(video=0)):
                    yield number, np.asarray(frame.to_ndarray(format="gray16le"), np.uint16)
        except self._errors as error:
            raise BadImageError(f"the video cannot be decoded ({type(error).__name__})") from error


def format_of(path: Path) -> str:
    """The container that a file's first bytes tell.

    Raises:
        UserError: another one: what else a decoder takes may lead to other files, or to addresses.
    """
    with path.open("rb") as file:
        begin = file.read(8)
    if begin[4:] in _BOXES:
        return "mov"
    if begin[:4] in _FORMATS:
        return _FORMATS[begin[:4]]
    raise UserError(f"{path} is no video of a kind that is read (MP4, Matroska, AVI); copy it again")
