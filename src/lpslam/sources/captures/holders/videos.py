"""Videos: colour of eight bits a channel, or depth of sixteen, decoded in order."""

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.errors import MissingExtraError, UserError
from lpslam.sources.images import MOST_PIXELS, BadImageError

SUFFIXES = frozenset((".mp4", ".mov", ".m4v", ".avi", ".mkv", ".webm"))
_BOXES = (b"ftyp", b"moov", b"mdat", b"free", b"skip", b"wide", b"pnot")
"""What an MP4 may begin with, behind four bytes."""
_FORMATS = {b"\x1aE\xdf\xa3": "matroska", b"RIFF": "avi"}
"""What other videos begin with."""
_NEAR = 30
"""Frames that are decoded for nothing rather than sought: a video is sought slowly."""
_MOST_RATE = 1000.0


class Video:
    """A video of colour as a holder of pictures; in order without seeking.

    Raises:
        UserError: it is no video that can be decoded.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        format_of(path)
        reader = cv2.VideoCapture(str(path))
        self.size = int(reader.get(cv2.CAP_PROP_FRAME_WIDTH)), int(reader.get(cv2.CAP_PROP_FRAME_HEIGHT))
        self._count, self.rate = int(reader.get(cv2.CAP_PROP_FRAME_COUNT)), float(reader.get(cv2.CAP_PROP_FPS))
        reader.release()
        if min(*self.size, self._count) <= 0 or self.size[0] * self.size[1] > MOST_PIXELS:
            raise UserError(f"{path} is no video that can be decoded")
        self.times: NDArray[np.float64] | None = None
        self._frames: Iterator[tuple[int, NDArray[np.uint8]]] = iter(())
        self._next = -1
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return self._count

    def picture(self, index: int) -> NDArray[np.uint8]:
        """See `Holder`."""
        with self._lock:
            return self._found(index)

    def _found(self, index: int) -> NDArray[np.uint8]:
        if self._next < 0 or not self._next <= index <= self._next + _NEAR:
            self._frames, self._next = self._decoded(index), index
        for found, picture in self._frames:
            self._next = found + 1
            if found == index:
                return picture
        raise BadImageError(f"the video ends before frame {index}")

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


class DeepVideo:
    """A video of one channel of sixteen bits, as FFV1 keeps depth; unpacked by PyAV (extra `video`).

    Raises:
        UserError: its pictures have eight bits, which hold no depth, or it cannot be decoded.
        MissingExtraError: PyAV is not there.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
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
                kind, self.size = str(track.format.name), (int(track.width), int(track.height))
                self._count = sum(1 for packet in file.demux(track) if packet.size)
                self.rate = float(track.average_rate or 0.0)
        except (*self._errors, IndexError) as error:
            raise UserError(f"{path} is no video that can be decoded ({type(error).__name__})") from error
        if not kind.startswith(("gray16", "gray12", "gray10")):
            raise UserError(f"{path} is called depth, and its pictures are {kind}: depth has one channel of 16 bits")
        self.times: NDArray[np.float64] | None = None
        self._frames: Iterator[tuple[int, Any]] = iter(())
        self._next = -1
        self._lock = threading.Lock()

    def __len__(self) -> int:
        return self._count

    def picture(self, index: int) -> NDArray[np.uint16]:
        """See `Holder`."""
        with self._lock:
            return self._found(index)

    def _found(self, index: int) -> NDArray[np.uint16]:
        if not 0 <= self._next <= index:
            self._frames, self._next = self._decoded(), 0
        try:
            for found, frame in self._frames:
                self._next = found + 1
                if found == index:
                    return np.asarray(frame.to_ndarray(format="gray16le"), np.uint16)
        except self._errors as error:
            raise BadImageError(f"frame {index} of the video cannot be decoded ({type(error).__name__})") from error
        raise BadImageError(f"the video ends before frame {index}")

    def _decoded(self) -> Iterator[tuple[int, Any]]:
        with self._open() as file:
            yield from enumerate(file.decode(video=0))


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
