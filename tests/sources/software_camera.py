"""A RealSense of software: the maker's own library delivers what a test feeds it."""

import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

rs = pytest.importorskip("pyrealsense2", exc_type=ImportError)

WIDTH, HEIGHT = 320, 240
DEPTH_LENS = (190.0, 191.0, 158.0, 121.0)
COLOUR_LENS = (300.0, 301.0, 162.0, 118.0)
TURN = 0.02
"""Radians about y between the two cameras."""
SHIFT = (0.015, -0.002, 0.001)


class SoftwareCamera:
    """A device with depth and colour, fed by hand.

    Args:
        depth_lens, colour_lens: fx, fy, cx, cy, pixels.
        size: width and height of both.
        is_apart: whether the cameras stand `SHIFT` and `TURN` apart.
    """

    def __init__(
        self,
        depth_lens: tuple[float, ...] = DEPTH_LENS,
        colour_lens: tuple[float, ...] = COLOUR_LENS,
        size: tuple[int, int] = (WIDTH, HEIGHT),
        is_apart: bool = True,
        units: float = 0.001,
    ) -> None:
        self.device = rs.software_device()
        self.device.register_info(rs.camera_info.name, "Software D400")
        self.device.register_info(rs.camera_info.serial_number, "0042")
        self.units = units
        self._sensors = self.device.add_sensor("Stereo Module"), self.device.add_sensor("RGB Camera")
        depth = self._stream(rs.stream.depth, rs.format.z16, 2, 0, depth_lens, size)
        colour = self._stream(rs.stream.color, rs.format.rgb8, 3, 1, colour_lens, size)
        self.profiles = self._sensors[0].add_video_stream(depth), self._sensors[1].add_video_stream(colour)
        self._sensors[0].add_read_only_option(rs.option.depth_units, units)
        pose = rs.extrinsics()
        cosine, sine = (np.cos(TURN), np.sin(TURN)) if is_apart else (1.0, 0.0)
        self.rotation = np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]])
        pose.rotation = list(self.rotation.T.ravel())
        pose.translation = list(SHIFT if is_apart else (0.0, 0.0, 0.0))
        self.profiles[0].register_extrinsics_to(self.profiles[1], pose)
        self.device.create_matcher(rs.matchers.default)

    def feed(self, number: int, milliseconds: float, rgb: np.ndarray, raw: np.ndarray) -> None:
        """One picture of each kind."""
        for sensor, profile, pixels in zip(self._sensors, self.profiles, (raw, rgb), strict=True):
            frame = rs.software_video_frame()
            frame.pixels = np.ascontiguousarray(pixels).view(np.uint8).reshape(-1)
            frame.bpp = pixels.itemsize * (pixels.shape[2] if pixels.ndim == 3 else 1)
            frame.stride = pixels.shape[1] * frame.bpp
            frame.timestamp, frame.frame_number = milliseconds, number
            frame.domain = rs.timestamp_domain.hardware_clock
            frame.profile = profile.as_video_stream_profile()
            if pixels is raw:
                frame.depth_units = self.units
            sensor.on_video_frame(frame)

    @staticmethod
    def _stream(kind: Any, form: Any, bpp: int, uid: int, lens: tuple[float, ...], size: tuple[int, int]) -> Any:
        stream = rs.video_stream()
        stream.type, stream.index, stream.uid = kind, 0, uid
        (stream.width, stream.height), stream.fps = size, 30
        stream.bpp, stream.fmt = bpp, form
        intrinsics = rs.intrinsics()
        intrinsics.width, intrinsics.height = size
        intrinsics.fx, intrinsics.fy, intrinsics.ppx, intrinsics.ppy = lens
        intrinsics.model, intrinsics.coeffs = rs.distortion.brown_conrady, [0.0] * 5
        stream.intrinsics = intrinsics
        return stream


class Feeding:
    """Feeds a camera from a thread of its own while the block lasts."""

    def __init__(self, camera: SoftwareCamera, picture: Callable[[int], Any], seconds: float = 1 / 30) -> None:
        self._stopped = threading.Event()

        def run() -> None:
            number = 0
            while not self._stopped.wait(seconds):
                camera.feed(number, 1000 * number / 30, *picture(number))
                number += 1

        self._thread = threading.Thread(target=run, daemon=True)

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._stopped.set()
        self._thread.join()
        time.sleep(0.05)
