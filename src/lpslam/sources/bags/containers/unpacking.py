"""Compressed parts of a recording, which may be made to fill the memory: a few bytes that unpack to gigabytes."""

import bz2

LARGEST = 1 << 28
"""Bytes of one part, unpacked; a chunk of a recording has some megabytes, its largest picture a hundred."""
LARGEST_SHARE = 1000
"""How many times its own size a recording may unpack to; pictures of one colour all over reach a few hundred."""


def unpacked(compression: str, data: bytes, size: int) -> bytes:
    """The bytes of a part.

    Args:
        compression: as ROS 1 bags and MCAP name it: none or empty, bz2, lz4, zstd.
        data: what is in the file.
        size: bytes that it says it has; what comes after them is not unpacked.

    Raises:
        ValueError: it has more or fewer, more than any recording, or is compressed in a way that is not known.
    """
    most = min(size, LARGEST)
    if compression in ("", "none"):
        return data
    opened = _DECOMPRESSORS.get(compression)
    if opened is None:
        raise ValueError(f"compression {compression[:20]!r} is not known")
    found = opened(data, most + 1)
    if len(found) > most:
        raise ValueError(f"a part of it unpacks to more than {most / 1e6:.3g} MB")
    if len(found) < most:
        raise ValueError("a compressed part of it is cut off")
    return found


def _bz2(data: bytes, most: int) -> bytes:
    return bz2.BZ2Decompressor().decompress(data, most)


def _lz4(data: bytes, most: int) -> bytes:
    import lz4.frame  # type: ignore[import-untyped]

    found: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data, most)
    return found


def _zstd(data: bytes, most: int) -> bytes:
    import zstandard

    with zstandard.ZstdDecompressor().stream_reader(data) as reader:
        parts, count = [], 0
        while count < most and (part := reader.read(min(most - count, 1 << 22))):
            parts.append(part)
            count += len(part)
    return b"".join(parts)


_DECOMPRESSORS = {"bz2": _bz2, "lz4": _lz4, "zstd": _zstd}
