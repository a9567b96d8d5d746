"""Record3D's `.r3d`: a zip of JPEG colour, LZFSE-compressed depth in metres, and `metadata`.

The layout: https://github.com/marek-simonik/record3d and https://record3d.app/features; depth is 32-bit floating point.
"""

import json
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.errors import MissingExtraError, UserError
from lpslam.sources.captures.common import decoded_colour, enlarged, rising_times
from lpslam.sources.images import BadImageError
from lpslam.sources.listed import ListedSource, Picture

_SIZES = ((192, 256), (256, 192), (480, 640), (640, 480), (360, 640), (640, 360))
_ENCRYPTED = 0x1
"""The flag of members that need a password."""
_LARGEST = 1 << 26
"""Bytes of one member, packed or not; a depth image has a megabyte."""
_LONGEST_MATCH, _LIE = 2359, 16
"""Bytes that one match of LZFSE copies at most, and how much more than `_LARGEST` all of them might be."""
_LONGEST_SIDE = 4096
"""Pixels of a depth image; phones have 640."""
_MALFORMED = (OSError, zipfile.BadZipFile, KeyError, ValueError, OverflowError, TypeError, IndexError, RecursionError,
              NotImplementedError)  # fmt: skip


def open_capture(folder: Path, camera_file: Path | None, max_frames: int | None, *, nominal: bool) -> ListedSource:
    """Open a `.r3d`.

    Raises:
        UserError: it is no such file, or damaged.
        MissingExtraError: LZFSE cannot be unpacked here.
    """
    try:
        import lzfse
    except ImportError:
        raise MissingExtraError("Record3D's depth", "phones") from None
    try:
        archive = zipfile.ZipFile(folder)
        if any(member.flag_bits & _ENCRYPTED for member in archive.infolist()):
            raise UserError(f"{folder} is protected by a password; unpack it and pack it again without (unzip, zip -r)")
        tree: Any = json.loads(_member(archive, "metadata"))
        matrix = [float(value) for value in tree["K"]]
        width, height = int(tree["w"]), int(tree["h"])
        rate = float(tree.get("fps", 60))
        fx, fy, cx, cy = matrix[0], matrix[4], matrix[6], matrix[7]
        camera = PinholeCamera(width, height, fx, fy, cx, cy, fps=rate)
        times = [float(time) for time in tree.get("frameTimestamps", ())]
        depth_size = (int(tree["dh"]), int(tree["dw"])) if "dh" in tree and "dw" in tree else None
        if depth_size is not None and not 0 < min(depth_size) <= max(depth_size) <= _LONGEST_SIDE:
            raise ValueError("no depth image has that size")
    except _MALFORMED as error:
        raise UserError(f"{folder} is no recording of Record3D that can be read ({type(error).__name__})") from error
    names = set(archive.namelist())
    count = sum(name.startswith("rgbd/") and name.endswith(".jpg") for name in names)
    stamps, notes = rising_times(times if len(times) == count else (), count, rate)

    def decode(number: int) -> Picture:
        try:
            rgb = decoded_colour(_member(archive, f"rgbd/{number}.jpg"), f"rgbd/{number}.jpg")
            metres = np.frombuffer(lzfse.decompress(_bounded(_member(archive, f"rgbd/{number}.depth"))), np.float32)
        except (KeyError, zipfile.BadZipFile, ValueError, RuntimeError, OSError, struct.error, lzfse.error) as error:
            raise BadImageError(f"frame {number} cannot be unpacked ({type(error).__name__})") from error
        size = depth_size if depth_size else next((each for each in _SIZES if each[0] * each[1] == len(metres)
                                                   and (each[0] > each[1]) == (height > width)), None)  # fmt: skip
        if size is None or size[0] * size[1] != len(metres):
            raise BadImageError(f"the depth of frame {number} has {len(metres)} readings")
        depth = metres.reshape(size).copy()
        with np.errstate(invalid="ignore"):
            depth[~(np.isfinite(depth) & (depth > 0))] = 0.0
        return rgb, enlarged(depth, (rgb.shape[1], rgb.shape[0]))

    return ListedSource(folder.stem, camera, stamps, decode, notes=notes, max_frames=max_frames)


def _bounded(packed: bytes) -> bytes:
    """LZFSE as it is, if its blocks say that they unpack to what a depth image may have.

    Raises:
        ValueError: they say more, or are no such blocks.
    """
    begin = stated = possible = 0
    while packed[begin : begin + 4] != b"bvx$":
        kind, raw = packed[begin : begin + 4], int.from_bytes(packed[begin + 4 : begin + 8], "little")
        stated += raw
        if kind == b"bvx-":
            begin += 8 + raw
        elif kind == b"bvxn":
            begin += 12 + int.from_bytes(packed[begin + 8 : begin + 12], "little")
        elif kind == b"bvx2":
            first, second, third = struct.unpack_from("<3Q", packed, begin + 8)
            # What the block says of itself is not held to by who unpacks it; this is.
            possible += _LONGEST_MATCH * (first >> 40 & 0xFFFFF)
            begin += (third & 0xFFFFFFFF) + (first >> 20 & 0xFFFFF) + (second >> 40 & 0xFFFFF)
        else:
            raise ValueError("no LZFSE")
        if stated > _LARGEST or possible > _LIE * _LARGEST:
            raise ValueError("it unpacks to more than a depth image")
    return packed


def _member(archive: zipfile.ZipFile, name: str) -> bytes:
    if archive.getinfo(name).file_size > _LARGEST:
        raise zipfile.BadZipFile(f"{name} is too large")
    return archive.read(name)
