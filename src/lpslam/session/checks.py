"""What is wrong with the arrays of a frame, said with the remedy; what can be mended without loss is mended."""

import math
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError


def checked_colour(rgb: object, camera: PinholeCamera) -> NDArray[np.uint8]:
    """The colour image as the map takes it.

    Args:
        rgb: should be (height, width, 3) uint8, in the order red, green, blue. That the order is blue, green, red
            cannot be seen from the numbers.
        camera: whose size it must have.

    Raises:
        UserError: it is something else.
    """
    if not isinstance(rgb, np.ndarray):
        raise UserError(f"the colour image is a {type(rgb).__name__}; give a numpy array: numpy.asarray(image)")
    if rgb.ndim == 2 or (rgb.ndim == 3 and rgb.shape[2] == 1):
        raise UserError("the colour image is grey; give three channels: cv2.cvtColor(image, cv2.COLOR_GRAY2RGB)")
    if rgb.ndim == 3 and rgb.shape[2] == 4:
        raise UserError(
            "the colour image has four channels; give red, green, blue: cv2.cvtColor(image, cv2.COLOR_RGBA2RGB), or"
            " COLOR_BGRA2RGB"
        )
    if rgb.ndim != 3 or rgb.shape[2] != 3:
        raise UserError(f"the colour image has shape {rgb.shape}; give (height, width, 3)")
    if rgb.dtype != np.uint8:
        raise UserError(
            f"the colour image is {rgb.dtype}; give uint8 from 0 to 255: (255 * image).astype(numpy.uint8) if it goes"
            " from 0 to 1"
        )
    _refuse_other_size("colour image", rgb.shape[:2], camera)
    return np.ascontiguousarray(rgb)


def checked_depth(depth: object, camera: PinholeCamera) -> NDArray[np.float32]:
    """The depth image as the map takes it: what is not finite or negative is no depth, 0.

    Args:
        depth: should be (height, width) float32 or float64, metres along the optical axis.
        camera: whose size it must have.

    Raises:
        UserError: it is something else.
    """
    if type(depth) is not np.ndarray and isinstance(depth, np.ma.MaskedArray):
        depth = depth.filled(0)
    if not isinstance(depth, np.ndarray):
        raise UserError(f"the depth image is a {type(depth).__name__}; give a numpy array: numpy.asarray(image)")
    if depth.ndim != 2:
        raise UserError(f"the depth image has shape {depth.shape}; give (height, width)")
    if depth.dtype.kind != "f":
        raise UserError(
            f"the depth image is {depth.dtype}; give metres: depth.astype(numpy.float32) / {camera.depth_scale:g} if"
            f" {camera.depth_scale:g} units are a metre"
        )
    _refuse_other_size("depth image", depth.shape, camera)
    metres = _single_precision(depth)
    # Bit patterns of floats from 0 up to infinity are in order, and those of all else are above: one pass tells.
    if metres.view(np.uint32).max() >= _INFINITE_BITS:
        metres = np.where(np.isfinite(metres) & (metres > 0.0), metres, np.float32(0.0))
    return metres


def refuse_no_camera(camera: object) -> None:
    """Raise a `UserError` unless a camera is one."""
    if not isinstance(camera, PinholeCamera):
        raise UserError(f"the camera is a {type(camera).__name__}; give lpslam.PinholeCamera(width, height, fx, fy, …)")


def refuse_no_metres(depth: NDArray[np.float32]) -> None:
    """Raise a `UserError` if a depth image of the camera's size says that everything is hundreds of metres away."""
    seen = depth[::8, ::8]
    seen = seen[seen > 0.0]
    if len(seen) and (middle := float(np.median(seen))) > _FAR:
        raise UserError(
            f"half of the depth image is farther than {middle:.0f} m; give metres: depth / 1000 if it is in millimetres"
        )


def checked_time(timestamp: object, latest: float, taken: int) -> float:
    """The time of a frame, seconds.

    Args:
        timestamp: should be a number.
        latest: of the frame before.
        taken: frames before this one.

    Raises:
        UserError: it is something else, not finite, or not later than the latest before it.
    """
    seconds = timestamp if type(timestamp) is float else _as_float(timestamp)
    if not math.isfinite(seconds):
        said = f"{timestamp}" if isinstance(timestamp, float) else f"a {type(timestamp).__name__}"
        raise UserError(f"the time of the frame is {said}; give seconds, as a finite float")
    if seconds <= latest and taken == 1:
        raise UserError(
            f"the time of the frame is {seconds:.6f} s, not later than {latest:.6f} s of the first frame; give the"
            " frames in order, or open another session if the first one's time was wrong: nothing is mapped yet"
        )
    if seconds <= latest:
        raise UserError(
            f"the time of the frame is {seconds:.6f} s, not later than {latest:.6f} s of the frame before it; give"
            " the frames in order, with the time at which the camera took each"
        )
    return seconds


def _single_precision(depth: NDArray[np.floating]) -> NDArray[np.float32]:
    if depth.dtype == np.float32:
        return np.ascontiguousarray(depth)
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(depth, dtype=np.float32)


def _as_float(number: object) -> float:
    """A real number as a float; not a number if it is something else."""
    try:
        return float(number) if isinstance(number, Real) else math.nan
    except OverflowError:
        return math.inf


def _refuse_other_size(kind: str, shape: tuple[int, ...], camera: PinholeCamera) -> None:
    if shape != (camera.height, camera.width):
        raise UserError(
            f"the {kind} is {shape[1]}×{shape[0]}; the camera is {camera.width}×{camera.height}: give the calibration"
            " of these images, and depth that is registered to the colour"
        )


_INFINITE_BITS = 0x7F800000
"""Of infinity, as a single-precision float."""

_FAR = 100.0
"""Metres: the half of what a depth camera sees is nearer, on any sensor that is sold."""
