"""ScanNet's `.sens`: a header with the calibrations, then frame after frame, colour in JPEG and depth in zlib.

The layout: https://github.com/ScanNet/ScanNet/tree/master/SensReader (version 4, little-endian).
"""

import struct
import zlib
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform
from lpslam.errors import UserError
from lpslam.sources.bags.containers.container import Damage
from lpslam.sources.captures.common import decoded_colour, rising_times
from lpslam.sources.images import BadImageError
from lpslam.sources.listed import ListedSource, Picture
from lpslam.sources.registering.registration import DepthRegistration, DepthRig

_VERSION, _JPEG, _ZLIB, _RAW = 4, 2, 1, 0
_POSE, _HEADER = 64, 96
"""Bytes of a frame before its images: a pose, two times and two lengths."""
_LARGEST = 1 << 27
"""Bytes of one image, packed or not."""


def open_capture(folder: Path, camera_file: Path | None, max_frames: int | None, *, nominal: bool) -> ListedSource:
    """Open a `.sens`; depth is registered to colour by the two calibrations of its header.

    Raises:
        UserError: it is no such file, or of a kind that is not known.
    """
    try:
        with folder.open("rb") as file:
            colour, depth, colour_from_depth = _cameras(file, folder)
            offsets = _offsets(file, folder)
    except (struct.error, OverflowError, MemoryError) as error:
        raise UserError(f"{folder} ends within its header; copy it again") from error
    size = (depth.height, depth.width)

    def decode(number: int) -> Picture:
        begin, colour_length, depth_length, _ = offsets[number]
        with folder.open("rb") as file:
            file.seek(begin)
            rgb = decoded_colour(file.read(colour_length), f"frame {number}")
            packed = file.read(depth_length)
        try:
            raw = np.frombuffer(zlib.decompressobj().decompress(packed, 2 * size[0] * size[1]), "<u2").reshape(size)
        except (zlib.error, ValueError) as error:
            raise BadImageError(f"the depth of frame {number} is damaged") from error
        return rgb, raw.astype(np.float32) * np.float32(1 / depth.depth_scale)

    stamps, notes = rising_times([entry[3] / 1e6 for entry in offsets], len(offsets))
    register = DepthRegistration(DepthRig(depth, colour, colour_from_depth))
    return ListedSource(folder.stem, colour, stamps, decode, register=register, notes=notes, max_frames=max_frames)


def _cameras(file: BinaryIO, path: Path) -> tuple[PinholeCamera, PinholeCamera, NDArray[np.float64]]:
    (version,) = struct.unpack("<I", file.read(4))
    if version != _VERSION:
        raise UserError(f"{path} is of version {version} of ScanNet's .sens; version {_VERSION} is known")
    (length,) = struct.unpack("<Q", file.read(8))
    if length > path.stat().st_size:
        raise UserError(f"{path} ends within its header; copy it again")
    file.seek(length, 1)
    colour_k, colour_pose, depth_k, depth_pose = (
        np.array(struct.unpack("<16f", file.read(64)), np.float64).reshape(4, 4) for _ in range(4)
    )
    colour_kind, depth_kind = struct.unpack("<ii", file.read(8))
    if (colour_kind, depth_kind) != (_JPEG, _ZLIB):
        raise UserError(
            f"{path} is compressed as {colour_kind}, {depth_kind}; JPEG ({_JPEG}) and zlib ({_ZLIB}) are known"
        )
    width, height, depth_width, depth_height = struct.unpack("<4I", file.read(16))
    if max(3 * width * height, 2 * depth_width * depth_height) > _LARGEST:
        raise UserError(f"{path} states images of {width}×{height} and {depth_width}×{depth_height}; copy it again")
    (shift,) = struct.unpack("<f", file.read(4))
    colour = PinholeCamera(width, height, *_focal(colour_k), depth_scale=shift)
    depth = PinholeCamera(depth_width, depth_height, *_focal(depth_k), depth_scale=shift)
    # Each extrinsic takes its camera's points to the sensor's frame; zeros mean that it is not known.
    known = [pose if abs(np.linalg.det(pose[:3, :3]) - 1) < 0.01 else np.eye(4) for pose in (colour_pose, depth_pose)]
    return colour, depth, np.asarray(inverse_transform(known[0]) @ known[1])


def _focal(k: NDArray[np.float64]) -> tuple[float, float, float, float]:
    return float(k[0, 0]), float(k[1, 1]), float(k[0, 2]), float(k[1, 2])


def _offsets(file: BinaryIO, path: Path) -> list[tuple[int, int, int, int]]:
    """Where each frame's images begin, their lengths, and when it was taken, microseconds; as far as the file goes."""
    size = path.stat().st_size
    (count,) = struct.unpack("<Q", file.read(8))
    found: list[tuple[int, int, int, int]] = []
    for _ in range(min(count, size // _HEADER)):
        head = file.read(_HEADER)
        # A hole of zeros is where a copy broke off.
        if len(head) < _HEADER or not any(head):
            break
        taken, _, colour_length, depth_length = struct.unpack_from("<4Q", head, _POSE)
        begin = file.tell()
        if max(colour_length, depth_length) > _LARGEST or begin + colour_length + depth_length > size:
            break
        found.append((begin, colour_length, depth_length, taken))
        file.seek(begin + colour_length + depth_length)
    if len(found) < count:
        damage = Damage(path)
        damage.note(f"it states {count} frames and holds {len(found)}")
        damage.say()
    return found
