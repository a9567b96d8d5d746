"""Azure Kinect's `.mkv`, as k4arecorder and Open3D write it: tracks COLOR and DEPTH, and an attached calibration.

The layout: https://learn.microsoft.com/previous-versions/azure/kinect-dk/record-file-format; how the calibration's
units become pixels: https://github.com/microsoft/Azure-Kinect-Sensor-SDK (MIT). Depth is 16-bit, big-endian, in
millimetres. Unpacked by PyAV (extra `azure`).
"""

import json
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import MissingExtraError, UserError
from lpslam.sources.bags.containers.container import Damage
from lpslam.sources.bags.lenses import camera_of
from lpslam.sources.calibrations.azure_raw import azure_lens
from lpslam.sources.captures.common import decoded_colour, rising_times
from lpslam.sources.images import BadImageError
from lpslam.sources.listed import ListedSource, Picture
from lpslam.sources.registering.registration import DepthRegistration, DepthRig
from lpslam.timestamps import associate

_TOLERANCE = 0.017
"""Seconds between colour and its depth: half of what lies between frames."""
_MILLIMETRES = 1000.0
_MOST_KEPT = 256
"""Packets between a colour picture and its depth; two tracks have some sixty in a second."""
_MALFORMED = (ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError)


@dataclass(frozen=True, slots=True)
class _Pair:
    """Times of a colour picture and of its depth, in the tracks' units."""

    colour: int
    depth: int


def open_capture(folder: Path, camera_file: Path | None, max_frames: int | None, *, nominal: bool) -> ListedSource:
    """Open a `.mkv`; depth is registered to colour by the attached calibration.

    Raises:
        UserError: it is no such recording, or damaged.
        MissingExtraError: PyAV is not there.
    """
    video = _Video(folder)
    calibration = video.calibration()
    colour, depth, colour_from_depth = _cameras(calibration, video.colour_size, video.depth_size, folder)
    pairs, seconds = video.pairs()
    stamps, notes = rising_times(seconds, len(pairs))
    register = DepthRegistration(DepthRig(depth, colour, colour_from_depth))

    def decode(number: int) -> Picture:
        rgb, raw = video.pictures(pairs[number])
        return rgb, raw.astype(np.float32) * np.float32(1 / _MILLIMETRES)

    return ListedSource(folder.stem, colour, stamps, decode, register=register, notes=notes, max_frames=max_frames)


class _Video:
    """The tracks of a file, read in order; a step back seeks."""

    def __init__(self, path: Path) -> None:
        try:
            import av
        except ImportError:
            raise MissingExtraError("Azure Kinect's .mkv", "azure") from None
        self._av, self._path = av, path
        self._errors = (av.error.FFmpegError, OSError, ValueError, ArithmeticError, AttributeError)
        self._lock = threading.Lock()
        try:
            # Another format might lead to other files, or to addresses.
            self._file = av.open(str(path), format="matroska")
        except self._errors as error:
            raise UserError(f"{path} is no video that can be read ({type(error).__name__})") from error
        tracks = {str(track.metadata.get("title", "")).upper(): track for track in self._file.streams.video}
        if "COLOR" not in tracks or "DEPTH" not in tracks:
            raise UserError(f"{path} has no tracks COLOR and DEPTH; it is no recording of an Azure Kinect")
        self._colour, self._depth = tracks["COLOR"], tracks["DEPTH"]
        try:
            self.colour_size = self._colour.width, self._colour.height
            self.depth_size = self._depth.width, self._depth.height
        except AttributeError:
            raise UserError(f"{path}: a track is of a kind that cannot be decoded; copy it again") from None
        self._packets: Iterator[Any] = iter(())
        self._kept: dict[tuple[int, int], Any] = {}

    def calibration(self) -> Any:
        """The attached calibration."""
        try:
            attached = [bytes(getattr(each, "data", None) or b"") for each in self._file.streams]
            return json.loads(next(data for data in attached if data.lstrip().startswith(b"{")).split(b"\0")[0])
        except (StopIteration, *_MALFORMED):
            raise UserError(f"{self._path} has no calibration attached; record it with k4arecorder or Open3D") from None

    def pairs(self) -> tuple[list[_Pair], list[float]]:
        """What belongs together, and seconds of the colour pictures; packets are counted, not decoded."""
        times: dict[int, list[int]] = {self._colour.index: [], self._depth.index: []}
        try:
            for packet in self._demuxed(0):
                times[packet.stream.index].append(packet.pts)
        except self._errors as error:
            damage = Damage(self._path)
            damage.note(f"it is cut off or damaged ({type(error).__name__})")
            damage.say()
        units = _seconds(self._colour), _seconds(self._depth)
        colour, depth = times[self._colour.index], times[self._depth.index]
        rows, columns = associate(np.array(colour) * units[0], np.array(depth) * units[1], _TOLERANCE)
        if not len(rows):
            raise UserError(f"{self._path}: no colour picture has depth within {1000 * _TOLERANCE:.0f} ms")
        pairs = [_Pair(colour[row], depth[column]) for row, column in zip(rows, columns, strict=True)]
        return pairs, [pair.colour * units[0] for pair in pairs]

    def pictures(self, pair: _Pair) -> tuple[NDArray[np.uint8], NDArray[np.uint16]]:
        """Colour (height, width, 3) and raw depth (h, w).

        Raises:
            BadImageError: one of them cannot be read.
        """
        wanted = (self._colour.index, pair.colour), (self._depth.index, pair.depth)
        with self._lock:
            try:
                colour, depth = self._found(wanted)
                rgb = self._decoded(colour)
            except self._errors as error:
                raise BadImageError(f"a picture cannot be read ({type(error).__name__})") from error
        width, height = self.depth_size
        data = bytes(depth)
        if len(data) < 2 * width * height:
            raise BadImageError(f"a depth picture has {len(data)} bytes; {width}×{height} need {2 * width * height}")
        raw = np.frombuffer(data, ">u2", width * height).reshape(height, width)
        return rgb, raw.astype(np.uint16)

    def _found(self, wanted: tuple[tuple[int, int], tuple[int, int]]) -> tuple[Any, Any]:
        first = min(pts for _, pts in wanted)
        if not self._is_reached(wanted):
            # The first call, or a step back, or far ahead.
            self._packets, self._kept = self._demuxed(first), {}
            if not self._is_reached(wanted):
                raise BadImageError("a picture is not where it was")
        found = self._kept[wanted[0]], self._kept[wanted[1]]
        self._kept = {key: packet for key, packet in self._kept.items() if key[1] > first}
        return found

    def _is_reached(self, wanted: tuple[tuple[int, int], tuple[int, int]]) -> bool:
        """Whether reading on, a second beyond them at most, finds both packets."""
        last = max(pts for _, pts in wanted) + round(1 / _seconds(self._colour))
        while not all(key in self._kept for key in wanted):
            packet = next(self._packets, None)
            if packet is None or packet.pts > last or len(self._kept) > _MOST_KEPT:
                return False
            self._kept[packet.stream.index, packet.pts] = packet
        return True

    def _demuxed(self, begin: int) -> Iterator[Any]:
        """Packets of both tracks from a time on, as they lie in the file."""
        self._file.seek(max(begin - 1, 0), stream=self._colour, backward=True, any_frame=False)
        for packet in self._file.demux(self._colour, self._depth):
            if packet.pts is not None and packet.size:
                yield packet

    def _decoded(self, packet: Any) -> NDArray[np.uint8]:
        if self._colour.codec_context.name == "mjpeg":
            return decoded_colour(bytes(packet), "a colour picture")
        frames = packet.decode()
        if not frames:
            raise BadImageError("a colour picture cannot be decoded")
        return np.asarray(frames[0].to_ndarray(format="rgb24"), np.uint8)


def _seconds(track: Any) -> float:
    """A track's unit of time."""
    return float(track.time_base)


def _cameras(
    tree: Any, colour_size: tuple[int, int], depth_size: tuple[int, int], path: Path
) -> tuple[PinholeCamera, PinholeCamera, NDArray[np.float64]]:
    """Both cameras, and 4×4 colour_from_depth in metres."""
    try:
        by_place = {str(each["Location"]): each for each in tree["CalibrationInformation"]["Cameras"]}
        colour = by_place["CALIBRATION_CameraLocationPV0"]
        depth = by_place["CALIBRATION_CameraLocationD0"]
        poses = [_pose(each) for each in (colour, depth)]
        lenses = [
            _lens(each, size, is_depth=each is depth) for each, size in ((colour, colour_size), (depth, depth_size))
        ]
    except _MALFORMED as error:
        raise UserError(f"{path}: its calibration cannot be read ({type(error).__name__})") from error
    cameras = [
        camera_of(lens, f"{path}: {name}", is_rectified=False)
        for lens, name in zip(lenses, ("the colour camera", "the depth camera"), strict=True)
    ]
    return cameras[0], cameras[1], np.asarray(poses[0] @ np.linalg.inv(poses[1]))


def _lens(camera: Any, size: tuple[int, int], *, is_depth: bool) -> Any:
    """A `CameraInfo` of the camera's mode."""
    (fx, fy, cx, cy), terms = azure_lens(camera["Intrinsics"]["ModelParameters"], size, is_depth=is_depth)
    return SimpleNamespace(
        width=size[0],
        height=size[1],
        k=[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        d=terms,
        distortion_model="rational_polynomial",
    )


def _pose(camera: Any) -> NDArray[np.float64]:
    """4×4, from the rig's frame to the camera's; metres."""
    pose = np.eye(4)
    pose[:3, :3] = np.reshape([float(value) for value in camera["Rt"]["Rotation"]], (3, 3))
    pose[:3, 3] = [float(value) for value in camera["Rt"]["Translation"]]
    if not np.isfinite(pose).all() or not np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-3):
        raise ValueError("no rotation")
    return pose
