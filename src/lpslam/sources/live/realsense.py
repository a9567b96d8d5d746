"""Intel RealSense cameras by the maker's library (extra `realsense`).

Depth is registered by our own code, so that holes stay holes. What needs a camera in the hand (USB, exposure, the
makers' presets) could not be tried; pictures, times, registration and coming back were, on the maker's software device.
"""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import MissingExtraError, UserError
from lpslam.sources.bags.lenses import camera_of
from lpslam.sources.live.driver import Shot, UnpluggedError
from lpslam.sources.registering.registration import DepthRegistration, DepthRig

_SIZE, _RATE = (640, 480), 30
"""Pixels and frames a second, or what the camera has next to it: text needs pixels, tracking needs frames."""
_MODELS = {"brown_conrady": "brown conrady", "modified_brown_conrady": "brown conrady", "none": ""}


def library() -> Any:
    """The maker's library.

    Raises:
        MissingExtraError: it is not installed.
        UserError: it cannot be loaded.
    """
    try:
        import pyrealsense2
    except ModuleNotFoundError:
        raise MissingExtraError("a RealSense camera", "realsense") from None
    except ImportError as error:
        remedy = "; install it (Debian, Ubuntu: apt install libusb-1.0-0)" if "libusb" in str(error) else ""
        raise UserError(f"RealSense's library cannot be loaded ({error}){remedy}") from error
    return pyrealsense2


def connected() -> list[Any]:
    """The cameras that are plugged in."""
    return list(library().context().query_devices())


class RealsenseDriver:
    """A `Driver` of one camera.

    Args:
        serial: of the camera; the first one without.

    Raises:
        MissingExtraError: the library is not installed.
        UserError: no camera is there, it is another one's, or it has no colour or no depth.
    """

    def __init__(self, serial: str = "") -> None:
        self._rs = library()
        self._serial = serial
        try:
            device = self._device()
        except UnpluggedError as error:
            raise UserError(f"{error}; see 'lsusb', and the maker's udev rules if it is listed there") from error
        self.name = _said_of(self._rs, device)
        self._serial = serial or _info(self._rs, device, "serial_number")
        self._sensors: list[Any] = []
        self._profiles = self._chosen(device)
        depth, colour = self._profiles
        self._units = self._depth_units(device)
        self.camera = self._camera(colour)
        pose = depth[1].get_extrinsics_to(colour[1])
        colour_from_depth = np.eye(4)
        # The maker keeps rotations column by column.
        colour_from_depth[:3, :3] = np.reshape(pose.rotation, (3, 3)).T
        colour_from_depth[:3, 3] = pose.translation
        self._register = DepthRegistration(DepthRig(self._camera(depth), self.camera, colour_from_depth))
        self._syncer: Any = None
        self._device_used: Any = device

    def start(self) -> None:
        """See `Driver`."""
        device = self._device_used or self._device()
        self._device_used = None
        if self._syncer is not None:
            self._profiles = self._chosen(device)
        self._syncer = self._rs.syncer()
        self._sensors = []
        try:
            for sensor, profile in self._profiles:
                self._prepare(sensor)
                sensor.open(profile)
                self._sensors.append(sensor)
                sensor.start(self._syncer)
        except RuntimeError as error:
            self.stop()
            raise UnpluggedError(f"it cannot be opened ({error}); does another program use it?") from error

    def wait(self, seconds: float) -> Shot | None:
        """See `Driver`."""
        is_there, frames = self._syncer.try_wait_for_frames(round(1000 * seconds))
        if not is_there:
            if not any(_info(self._rs, each, "serial_number") == self._serial for each in connected()):
                raise UnpluggedError("it is not there any more")
            return None
        colour, depth = frames.get_color_frame(), frames.get_depth_frame()
        if not colour or not depth:
            return None
        # The frames' memory is the library's and used again.
        rgb = np.array(colour.get_data(), np.uint8)
        return Shot(colour.get_frame_number(), colour.get_timestamp() / 1000.0, rgb, np.array(depth.get_data()))

    def registered(self, depth: NDArray[Any]) -> NDArray[np.float32]:
        """See `Driver`."""
        return self._register(depth.astype(np.float32) * np.float32(self._units))

    def stop(self) -> None:
        """See `Driver`."""
        for sensor in self._sensors:
            for end in (sensor.stop, sensor.close):
                try:
                    end()
                except RuntimeError:
                    # It is unplugged.
                    continue
        self._sensors = []

    def _device(self) -> Any:
        devices = connected()
        serials = [_info(self._rs, device, "serial_number") for device in devices]
        if not devices:
            raise UnpluggedError("no RealSense camera is connected")
        if self._serial and self._serial not in serials:
            raise UnpluggedError(f"no RealSense camera {self._serial} is connected, but {', '.join(serials)}")
        return devices[serials.index(self._serial)] if self._serial else devices[0]

    def _chosen(self, device: Any) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """Sensor and stream of depth and of colour."""
        rs = self._rs
        found = []
        for stream, form in ((rs.stream.depth, rs.format.z16), (rs.stream.color, rs.format.rgb8)):
            streams = [
                (sensor, profile.as_video_stream_profile())
                for sensor in device.query_sensors()
                for profile in sensor.get_stream_profiles()
                if profile.stream_type() == stream and profile.format() == form
            ]
            if not streams:
                raise UserError(f"{self.name} gives no {stream.name}; a camera with colour and depth is needed")
            found.append(min(streams, key=lambda each: _unlike(each[1])))
        return found[0], found[1]

    def _prepare(self, sensor: Any) -> None:
        """Dots on, for walls without texture; sure depths rather than many; as many frames in the dark."""
        option = self._rs.option
        wishes: list[tuple[Any, float]] = [(option.emitter_enabled, 1.0), (option.auto_exposure_priority, 0.0)]
        preset = getattr(getattr(self._rs, "rs400_visual_preset", None), "high_accuracy", None)
        if preset is not None and sensor.is_depth_sensor():
            wishes.append((option.visual_preset, float(int(preset))))
        for name, value in wishes:
            try:
                if sensor.supports(name) and not sensor.is_option_read_only(name):
                    sensor.set_option(name, value)
            except RuntimeError:
                # A camera that refuses works with what it has.
                continue

    def _depth_units(self, device: Any) -> float:
        units = self._rs.option.depth_units
        for sensor in device.query_sensors():
            if sensor.supports(units):
                # A 32-bit number: 0.001 comes as 0.0010000000474974513.
                return float(f"{sensor.get_option(units):.6g}")
        return 0.001

    def _camera(self, chosen: tuple[Any, Any]) -> PinholeCamera:
        profile = chosen[1]
        lens = profile.get_intrinsics()
        model = _MODELS.get(lens.model.name, lens.model.name.replace("_", " "))
        info = SimpleNamespace(
            width=lens.width,
            height=lens.height,
            k=[lens.fx, 0, lens.ppx, 0, lens.fy, lens.ppy, 0, 0, 1],
            d=list(lens.coeffs),
            distortion_model=model,
        )
        camera = camera_of(info, f"{self.name} ({profile.stream_name()})", is_rectified=False)
        return replace(camera, fps=float(profile.fps()))


def _unlike(profile: Any) -> tuple[float, float]:
    """How far a stream is from what is wanted."""
    pixels = abs(profile.width() - _SIZE[0]) + abs(profile.height() - _SIZE[1])
    return float(pixels), float(abs(profile.fps() - _RATE))


def _info(rs: Any, device: Any, name: str) -> str:
    key = getattr(rs.camera_info, name)
    return str(device.get_info(key)) if device.supports(key) else ""


def _said_of(rs: Any, device: Any) -> str:
    words = [_info(rs, device, "name") or "RealSense", _info(rs, device, "serial_number")]
    return " ".join(word for word in words if word)
