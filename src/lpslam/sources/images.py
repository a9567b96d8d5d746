"""Decoding one colour or depth image, with damage detected instead of decoded."""

import io
import stat
import warnings
import zipfile
import zlib
from collections.abc import Collection
from pathlib import Path
from typing import Any, BinaryIO

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from lpslam.errors import LpSlamError, MissingExtraError
from lpslam.sources.depths.encoding import DepthEncoding
from lpslam.sources.inside import Inside, PictureFile

_PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_EXR_TYPES = {"FLOAT": np.float32, "HALF": np.float16, "UINT": np.uint32}
_EXR_SIGNATURE = b"v/1\x01"
_DECODED = frozenset((".npy", ".npz", ".exr"))
"""Files whose size is known when they are decoded."""
_JPEG_START, _JPEG_END = b"\xff\xd8", b"\xff\xd9"
# Some cameras write a few bytes after the end marker.
_JPEG_TAIL = 4096
MOST_PIXELS = 64_000_000
"""More than any depth camera has; what unpacks to more is made to fill the memory."""
_MOST_BYTES = 1 << 30
"""Of an image's file."""
TOO_LARGE = "larger than any camera's pictures"
_OF_SIZE = (MemoryError, OverflowError, RuntimeError, NotImplementedError, TypeError)
"""What a header that states more than there can be, or an archive that is packed in another way, may raise besides."""


class BadImageError(LpSlamError):
    """An image that cannot be used; the message says which and why, in a few words."""


def read_colour(path: PictureFile) -> NDArray[np.uint8]:
    """Read an image as (height, width, 3) uint8 in the order red, green, blue; grey is spread to three channels.

    Raises:
        BadImageError: missing, truncated, or no image.
    """
    # As it is stored: depth, the calibration and the header know nothing of how a viewer turns it.
    return _as_colour(_decode(path, cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION), path.name)


def _as_colour(picture: NDArray[Any], name: str) -> NDArray[np.uint8]:
    """Colour of eight bits, as files of images are decoded to; arrays may have other channels and types."""
    if picture.dtype.kind == "f":
        # Fractions of the brightest, or the same numbers as of eight bits.
        most = float(np.nan_to_num(picture).max()) if picture.size else 0.0
        picture = np.clip(np.nan_to_num(picture) * (255.0 if most <= 1.0 else 1.0), 0, 255).astype(np.uint8)
    elif picture.dtype == np.uint16:
        picture = (picture >> 8).astype(np.uint8)
    if picture.ndim == 2:
        picture = np.repeat(picture[:, :, None], 3, axis=2)
    if picture.ndim != 3 or picture.shape[2] not in (3, 4) or picture.dtype != np.uint8:
        raise BadImageError(f"{name} is no colour image: {picture.shape} of {picture.dtype}")
    return np.ascontiguousarray(picture[:, :, :3])


def read_depth(path: PictureFile, depth_scale: float, encoding: DepthEncoding | None = None) -> NDArray[np.float32]:
    """Read a depth image as (height, width) float32 metres; 0 where there is none, and where its type allows no more.

    Args:
        path: a 16-bit image in raw units, or a floating-point one in raw units.
        depth_scale: raw units in a metre.
        encoding: how its numbers are taken, where they are no such units.

    Raises:
        BadImageError: missing, truncated, or no depth image.
    """
    raw = read_raw(path)
    if encoding is not None:
        raw = encoding.numbers(raw, is_blue_first=not isinstance(path, Inside))
    is_most = raw >= _most_of(raw.dtype)
    if raw.dtype in (np.float64, np.float16, np.int32, np.uint32, np.int16):
        # What is too large for it is no depth.
        with np.errstate(over="ignore"):
            raw = raw.astype(np.float32)
    if raw.ndim != 2 or raw.dtype not in (np.uint16, np.float32):
        channels = 1 if raw.ndim == 2 else raw.shape[2]
        raise BadImageError(f"{path.name} has {channels} channel(s) of {raw.dtype}; depth is one channel of 16 bits")
    depth: NDArray[np.float32] = raw.astype(np.float32)
    if encoding is not None and encoding.numerator is not None:
        depth = encoding.metres(depth)
    else:
        depth *= np.float32(1.0 / depth_scale)
    if raw.dtype == np.float32:
        depth[~(np.isfinite(depth) & (depth > 0))] = 0.0
    depth[is_most] = 0.0
    return depth


def _most_of(kind: np.dtype[Any]) -> float:
    """The largest number of a type, which stands for no depth, or for more than can be told."""
    return float(np.iinfo(kind).max) if kind.kind in "iu" else float(np.finfo(np.float16).max)


def read_raw(path: PictureFile) -> NDArray[Any]:
    """Read an image as it is stored: (height, width) or (height, width, channels), of its own type.

    Raises:
        BadImageError: missing, truncated, or no image.
    """
    return _decode(path, cv2.IMREAD_UNCHANGED)


def _array_in(data: bytes, name: str) -> NDArray[Any]:
    """A picture that numpy has written: of several arrays in a file the first that is one."""
    try:
        found = np.load(io.BytesIO(data), allow_pickle=False)
        if isinstance(found, np.ndarray):
            arrays = iter([found])
        else:
            sizes = {each.filename.removesuffix(".npy"): each.file_size for each in found.zip.infolist()}
            # A few bytes may unpack to gigabytes.
            arrays = (found[key] for key in found.files if sizes.get(key, 0) <= _MOST_BYTES)
        picture = next((np.squeeze(each) for each in arrays if np.squeeze(each).ndim in (2, 3)), None)
    except (OSError, ValueError, EOFError, zlib.error, zipfile.BadZipFile, KeyError, *_OF_SIZE) as error:
        raise BadImageError(f"{name} is no array that numpy can read") from error
    if picture is None or picture.size > MOST_PIXELS or picture.dtype.kind not in "uif":
        raise BadImageError(f"{name} holds no picture")
    return picture


def _of_exr(path: Path) -> NDArray[Any]:
    """The channel of a picture in OpenEXR that holds depth, or its colours."""
    try:
        import OpenEXR
    except ImportError:
        raise MissingExtraError(f"OpenEXR ({path.name})", "exr") from None
    try:
        # The newer interface prints what goes wrong, and gives a part.
        file = OpenEXR.InputFile(str(path))
        header = file.header()
        corners = header["dataWindow"]
        width, height = corners.max.x - corners.min.x + 1, corners.max.y - corners.min.y + 1
        if not 0 < width * height <= MOST_PIXELS:
            raise BadImageError(f"{path.name} is {TOO_LARGE}")
        kinds = {name: _EXR_TYPES[str(each.type)] for name, each in header["channels"].items() if each.xSampling == 1}
        # Of many channels, each as large as the picture, those that are wanted are unpacked.
        channels = {
            name: np.frombuffer(file.channel(name), kinds[name]).reshape(height, width) for name in _wanted(kinds)
        }
        file.close()
    except (RuntimeError, ValueError, OSError, TypeError, KeyError, AttributeError) as error:
        raise BadImageError(f"{path.name} is not an image that can be decoded") from error
    if not channels:
        raise BadImageError(f"{path.name} holds no picture")
    colours = list(channels.values())
    if len(colours) > 1:
        is_grey = all(np.array_equal(colours[0], each) for each in colours[1:])
        return colours[0] if is_grey else np.stack(colours, axis=-1)
    return colours[0].astype(np.float32) if colours[0].dtype.kind != "f" else colours[0]


def _wanted(channels: Collection[str]) -> list[str]:
    """Of a picture's channels the one of depth, or the three of colour; the first where neither is there."""
    depths = sorted(name for name in channels if name.lower().startswith(("z", "depth")))
    if not depths and {"R", "G", "B"} <= set(channels):
        return ["R", "G", "B"]
    return depths[:1] or sorted(channels)[:1]


def image_size(path: PictureFile) -> tuple[int, int] | None:
    """Read width and height from the image's header alone; None where there is no such image."""
    if isinstance(path, Inside):
        return path.holder.size
    try:
        if path.suffix.lower() in _DECODED:
            picture = _decode(path, cv2.IMREAD_UNCHANGED)
            return picture.shape[1], picture.shape[0]
        return _size_in_header(path) if path.is_file() else None
    except (OSError, ValueError, Image.DecompressionBombError, BadImageError):
        return None


def _decode(path: PictureFile, flags: int) -> NDArray[Any]:
    if isinstance(path, Inside):
        return path.holder.picture(path.index)
    try:
        # Lists name any path: a device never ends, and a pipe never begins.
        status = path.stat()
        if not stat.S_ISREG(status.st_mode) or status.st_size > _MOST_BYTES:
            raise BadImageError(f"{path.name} is no file of an image")
        data = path.read_bytes()
    except OSError as error:
        raise BadImageError(f"{path.name} cannot be read ({error.strerror})") from error
    except ValueError as error:
        raise BadImageError(f"{path.name!r} is no name of a file") from error
    if path.suffix.lower() in (".npy", ".npz") and data:
        return _array_in(data, path.name)
    if data.startswith(_EXR_SIGNATURE):
        return _of_exr(path)
    return decoded_image(data, path.name, flags)


def decoded_image(data: bytes, name: str, flags: int) -> NDArray[Any]:
    """The bytes of an image file as OpenCV's flags have it.

    Raises:
        BadImageError: truncated, damaged, or no image.
    """
    defect = image_defect(data)
    if defect:
        raise BadImageError(f"{name} is {defect}")
    try:
        image = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), flags)
    except cv2.error:
        image = None
    if image is None:
        raise BadImageError(f"{name} is not an image that can be decoded")
    return np.asarray(image)


def image_defect(data: bytes) -> str:
    """Say what is wrong with the file's bytes; empty when nothing is seen.

    Decoders fill the missing part of a truncated image with grey or black, some without a word, and a half-black
    depth image is worse than none.
    """
    if not data:
        return "empty"
    if data.startswith(_PNG_SIGNATURE):
        return _png_defect(data)
    if data.startswith(_JPEG_START) and _JPEG_END not in data[-_JPEG_TAIL:]:
        return "truncated"
    try:
        width, height = _size_in_header(io.BytesIO(data))
    except Image.DecompressionBombError:
        return TOO_LARGE
    except (OSError, ValueError):
        # Whether it can be decoded is its decoder's to say.
        return ""
    return TOO_LARGE if width * height > MOST_PIXELS else ""


def _size_in_header(file: Path | BinaryIO) -> tuple[int, int]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", Image.DecompressionBombWarning)
        with Image.open(file) as image:
            width, height = image.size
            return width, height


def _png_defect(data: bytes) -> str:
    view, start = memoryview(data), len(_PNG_SIGNATURE)
    # The header is the first part: its length and name, then width and height.
    if int.from_bytes(view[16:20], "big") * int.from_bytes(view[20:24], "big") > MOST_PIXELS:
        return TOO_LARGE
    while start + 12 <= len(data):
        end = start + 12 + int.from_bytes(view[start : start + 4], "big")
        if end > len(data):
            return "truncated"
        if zlib.crc32(view[start + 4 : end - 4]) != int.from_bytes(view[end - 4 : end], "big"):
            return "damaged (wrong checksum)"
        if data[start + 4 : start + 8] == b"IEND":
            return ""
        start = end
    return "truncated"
