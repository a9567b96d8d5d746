"""Pictures of messages: colour as (height, width, 3) red, green, blue; depth in raw units or metres.

Rows are as long as `step` says. The header of `compressedDepth`: https://github.com/ros-perception/image_transport_plugins
"""

import struct
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.sources.bags.rvl import decode_rvl
from lpslam.sources.images import MOST_PIXELS, BadImageError, image_defect

DEPTH_ENCODINGS = ("16UC1", "mono16", "Z16", "32FC1")
_PIXELS: dict[str, tuple[str, int, int | None]] = {
    # dtype, channels, and OpenCV's conversion to red, green, blue
    "rgb8": ("u1", 3, None),
    "8UC3": ("u1", 3, cv2.COLOR_BGR2RGB),
    "bgr8": ("u1", 3, cv2.COLOR_BGR2RGB),
    "rgba8": ("u1", 4, cv2.COLOR_RGBA2RGB),
    "bgra8": ("u1", 4, cv2.COLOR_BGRA2RGB),
    "8UC4": ("u1", 4, cv2.COLOR_BGRA2RGB),
    "mono8": ("u1", 1, cv2.COLOR_GRAY2RGB),
    "8UC1": ("u1", 1, cv2.COLOR_GRAY2RGB),
    "yuv422": ("u1", 2, cv2.COLOR_YUV2RGB_UYVY),
    "uyvy": ("u1", 2, cv2.COLOR_YUV2RGB_UYVY),
    "yuv422_yuy2": ("u1", 2, cv2.COLOR_YUV2RGB_YUY2),
    "yuyv": ("u1", 2, cv2.COLOR_YUV2RGB_YUY2),
    "bayer_rggb8": ("u1", 1, cv2.COLOR_BayerRGGB2RGB),
    "bayer_bggr8": ("u1", 1, cv2.COLOR_BayerBGGR2RGB),
    "bayer_gbrg8": ("u1", 1, cv2.COLOR_BayerGBRG2RGB),
    "bayer_grbg8": ("u1", 1, cv2.COLOR_BayerGRBG2RGB),
}
_DEPTHS = {"16UC1": "u2", "mono16": "u2", "Z16": "u2", "32FC1": "f4"}
_DEPTH_HEADER = 12


def encoding_of(message: Any) -> str:
    """How the message's pixels are stored: an encoding of `Image`, or what a compressed picture says of itself."""
    if hasattr(message, "format"):
        text = str(message.format)
        return "compressedDepth" if "compressedDepth" in text or _is_wrapped(message.data) else "compressed"
    return str(message.encoding)


def colour_of(message: Any) -> NDArray[np.uint8]:
    """The colour picture of an `Image` or a `CompressedImage`.

    Raises:
        BadImageError: it is cut off, damaged, or in an encoding that is no colour.
    """
    if hasattr(message, "format"):
        data = bytes(memoryview(message.data))
        defect = image_defect(data)
        if defect:
            raise BadImageError(f"a colour picture is {defect}")
        return np.asarray(_unpacked(data, cv2.IMREAD_COLOR_RGB), np.uint8)
    encoding = str(message.encoding)
    known = _PIXELS.get(encoding) or _PIXELS.get(encoding.lower())
    if known is None:
        raise BadImageError(f"colour pictures in {encoding[:40]!r} are not known; record rgb8, bgr8 or compressed ones")
    dtype, channels, conversion = known
    pixels = _rows(message, dtype, channels)
    if conversion is None:
        return np.ascontiguousarray(pixels)
    return np.asarray(cv2.cvtColor(np.ascontiguousarray(pixels), conversion), np.uint8)


def depth_of(message: Any) -> NDArray[np.uint16] | NDArray[np.float32]:
    """The depth picture of an `Image` or a `compressedDepth`: uint16 in raw units, or float32 in metres.

    Raises:
        BadImageError: it is cut off, damaged, or in an encoding that is no depth.
    """
    if not hasattr(message, "format"):
        encoding = str(message.encoding)
        if encoding not in _DEPTHS:
            raise BadImageError(f"depth in {encoding[:40]!r} is not known; it is 16UC1 (millimetres) or 32FC1 (metres)")
        return np.ascontiguousarray(_rows(message, _DEPTHS[encoding], 1))
    data = bytes(memoryview(message.data))
    if _is_wrapped(message.data):
        return _compressed_depth(str(message.format), data)
    return _raw_depth(data)


def in_metres(raw: NDArray[np.uint16] | NDArray[np.float32], depth_scale: float) -> NDArray[np.float32]:
    """Depth (h, w) in metres, 0 where there is none; `depth_scale` raw units in a metre, for whole numbers only."""
    if raw.dtype == np.float32:
        depth = np.array(raw, np.float32)
        with np.errstate(invalid="ignore"):
            depth[~(np.isfinite(depth) & (depth > 0))] = 0.0
        return depth
    scaled: NDArray[np.float32] = raw.astype(np.float32)
    scaled *= np.float32(1.0 / depth_scale)
    return scaled


def _rows(message: Any, dtype: str, channels: int) -> Any:
    """The pixels (height, width[, channels]), of rows that may be longer than their pixels."""
    height, width, step = int(message.height), int(message.width), int(message.step)
    order = ">" if message.is_bigendian and dtype != "u1" else "<"
    kind = np.dtype(order + dtype)
    length = width * channels * kind.itemsize
    if not (height > 0 and width > 0 and height * width <= MOST_PIXELS):
        raise BadImageError(f"a picture of {width:.6g}×{height:.6g} pixels")
    step = step or length
    data = np.frombuffer(memoryview(message.data), np.uint8)
    if step < length or len(data) < step * (height - 1) + length:
        raise BadImageError(
            f"a picture has {len(data)} bytes; {width}×{height} of {message.encoding} need {step * height}"
        )
    rows = np.lib.stride_tricks.as_strided(data, (height, length), (step, 1), writeable=False)
    pixels = (
        np.ascontiguousarray(rows).view(kind).reshape((height, width, channels) if channels > 1 else (height, width))
    )
    return pixels if pixels.dtype.isnative else pixels.astype(kind.newbyteorder("="))


def _is_wrapped(data: Any) -> bool:
    """Whether twelve bytes of `compressedDepth` come before the picture."""
    begin = bytes(memoryview(data)[: _DEPTH_HEADER + 4])
    return len(begin) > _DEPTH_HEADER and not begin.startswith((b"\x89PNG", b"\xff\xd8", b"RIFF", b"II*\0", b"MM\0*"))


def _compressed_depth(text: str, data: bytes) -> NDArray[np.uint16] | NDArray[np.float32]:
    _, near, far = struct.unpack_from("<iff", data)
    body = data[_DEPTH_HEADER:]
    raw = _rvl(body) if "rvl" in text.lower() or not body.startswith(b"\x89PNG") else _raw_depth(body)
    if not text.startswith("32FC1") or raw.dtype == np.float32:
        return raw
    # Metres are kept as near / (raw - far): fine nearby, coarse far away.
    metres = np.zeros(raw.shape, np.float32)
    held = raw > 0
    with np.errstate(divide="ignore"):
        metres[held] = np.float32(near) / (raw[held].astype(np.float32) - np.float32(far))
    return metres


def _rvl(body: bytes) -> NDArray[np.uint16]:
    if len(body) < 8:
        raise BadImageError("a depth picture is truncated")
    width, height = struct.unpack_from("<ii", body)
    if not (height > 0 and width > 0 and height * width <= MOST_PIXELS):
        raise BadImageError(f"a depth picture of {width}×{height} pixels")
    words = np.frombuffer(body, "<u4", (len(body) - 8) // 4, 8).astype(np.uint32)
    pixels = np.zeros(width * height, np.uint16)
    if not decode_rvl(words, pixels):
        raise BadImageError("a depth picture is damaged (RVL)")
    return pixels.reshape(height, width)


def _raw_depth(data: bytes) -> NDArray[np.uint16] | NDArray[np.float32]:
    defect = image_defect(data)
    if defect:
        raise BadImageError(f"a depth picture is {defect}")
    raw = _unpacked(data, cv2.IMREAD_UNCHANGED)
    if raw.ndim != 2 or raw.dtype not in (np.uint16, np.float32):
        raise BadImageError(
            f"a depth picture has {1 if raw.ndim == 2 else raw.shape[2]} channel(s) of {raw.dtype}; "
            "depth is one channel of 16 bits"
        )
    return raw  # type: ignore[no-any-return]


def _unpacked(data: bytes, flags: int) -> Any:
    try:
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), flags) if data else None
    except cv2.error:
        picture = None
    if picture is None:
        raise BadImageError("a picture cannot be decoded")
    return picture
