"""Files of messages that were compressed as a whole, as ROS 2 does file by file: unpacked until the process ends."""

import bz2
import gzip
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import IO, Protocol

from lpslam.errors import UserError
from lpslam.sources.bags.containers.unpacking import LARGEST_SHARE
from lpslam.sources.unpacked_once import unpacked_once

ENDINGS = (".zstd", ".zst", ".gz", ".bz2")
_BLOCK = 1 << 22


class _Readable(Protocol):
    def read(self, size: int) -> bytes: ...


def is_compressed(begin: bytes) -> bool:
    """Whether a file that begins so can be unpacked here."""
    return _opening(begin) is not None


def unpacked_whole(path: Path, begin: bytes) -> Path:
    """The file that another one holds; it lies unpacked until the process ends.

    Args:
        path: of the compressed file.
        begin: its first bytes.

    Raises:
        UserError: it is cut off or damaged, or unpacks to more than any recording or than the disk has room for.
    """
    name = path.stem if path.suffix.lower() in ENDINGS else path.name
    return unpacked_once(path, lambda folder, room: _unpack(path, begin, folder / name, room)) / name


def _unpack(path: Path, begin: bytes, inner: Path, room: int) -> None:
    opening = _opening(begin)
    if opening is None:
        raise UserError(f"{path} is compressed in a way that is not known; unpack it first")
    most = min(room, LARGEST_SHARE * path.stat().st_size)
    try:
        with path.open("rb") as packed, inner.open("wb") as target:
            source, count = opening(packed), 0
            while part := source.read(_BLOCK):
                count += len(part)
                if count > most:
                    raise UserError(f"{path} unpacks to more than {most / 1e6:.3g} MB; unpack it first, if it is right")
                target.write(part)
    except (OSError, EOFError, ValueError, zlib.error) as error:
        raise UserError(f"{path} cannot be unpacked ({error}); copy it again, or unpack it first") from error


def _opening(begin: bytes) -> Callable[[IO[bytes]], _Readable] | None:
    if begin.startswith(b"\x28\xb5\x2f\xfd"):
        return _Zstd
    if begin.startswith(b"\x1f\x8b"):
        return lambda file: gzip.GzipFile(fileobj=file)
    return (lambda file: bz2.BZ2File(file)) if begin.startswith(b"BZh") else None


class _Zstd:
    """What Zstandard compressed, in one frame or several; damage is an `OSError`, as of the others."""

    def __init__(self, file: IO[bytes]) -> None:
        import zstandard

        self._reader = zstandard.ZstdDecompressor().stream_reader(file, read_across_frames=True)
        self._error = zstandard.ZstdError

    def read(self, size: int) -> bytes:
        try:
            return self._reader.read(size)
        except self._error as error:
            raise OSError(str(error)) from error
