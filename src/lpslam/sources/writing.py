"""Recordings written without loss: TUM RGB-D folders, and MCAP with the messages of ROS 2.

Colour is PNG. Depth is 16-bit PNG where that keeps every reading, else 32-bit floating point.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np
import yaml
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.frames import FrameSource, RgbdFrame
from lpslam.sources.images import read_depth

OnProgress = Callable[[int, int], None]
_COLOUR, _DEPTH = "/camera/color/image_raw/compressed", "/camera/aligned_depth_to_color/image_raw"
_COLOUR_INFO = "/camera/color/camera_info"
_FRAME = "camera_color_optical_frame"
_LARGEST = 65535


class _Sink(Protocol):
    def add(self, frame: RgbdFrame) -> None: ...

    def finish(self) -> None: ...

    def close(self) -> None: ...


def written(
    source: FrameSource, output: Path, on_progress: OnProgress = lambda done, of: None, *, keeps_part: bool = False
) -> int:
    """Write every frame of a source; how many there were.

    Args:
        source: the recording.
        output: NAME.mcap, or a folder that is not there or empty.
        on_progress: called with frames written and frames in all.
        keeps_part: whether what was written stays when no more can be, as NAME.partial.mcap: it cannot be had again.

    Raises:
        UserError: the output is there already, or cannot be written; what was begun is removed.
    """
    is_mcap = output.suffix.lower() == ".mcap"
    if output.exists() and (is_mcap or not output.is_dir() or any(output.iterdir())):
        raise UserError(f"{output} is there already and is not overwritten; choose another name")
    count = 0
    part = output.with_name(f".{output.name}.part")
    with _removed_on_failure(part, output, keeps_part):
        sink: _Sink = _McapSink(part, source.camera) if is_mcap else _FolderSink(part, source.camera)
        try:
            for frame in source:
                sink.add(frame)
                count += 1
                on_progress(count, len(source))
            sink.finish()
        finally:
            sink.close()
        if output.is_dir():
            output.rmdir()
        os.replace(part, output)
    return count


@contextmanager
def _removed_on_failure(part: Path, output: Path, keeps_part: bool) -> Iterator[None]:
    try:
        part.parent.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        told = f"{output} cannot be written ({error.strerror or error})"
        if keeps_part and part.exists():
            kept = output.with_name(f"{output.stem}.partial{output.suffix}")
            os.replace(part, kept)
            raise UserError(f"{told}; what was recorded until then is in {kept}") from error
        raise UserError(f"{told}; choose another place") from error
    finally:
        if part.is_dir():
            shutil.rmtree(part, ignore_errors=True)
        else:
            part.unlink(missing_ok=True)


class _FolderSink:
    """A TUM RGB-D folder; stamps keep their nanoseconds."""

    def __init__(self, folder: Path, camera: PinholeCamera) -> None:
        self._folder, self._camera = folder, camera
        self._lists: dict[str, list[str]] = {"rgb": [], "depth": []}
        self._is_in_metres = False
        for name in self._lists:
            (folder / name).mkdir(parents=True)

    def add(self, frame: RgbdFrame) -> None:
        stamp = _stamp(frame.timestamp)
        self._keep("rgb", f"rgb/{stamp}.png", stamp, _packed(".png", frame.rgb[:, :, ::-1]))
        raw = frame.depth if self._is_in_metres else raw_depth(frame.depth, self._camera.depth_scale)
        if raw.dtype == np.float32 and not self._is_in_metres:
            self._change_to_metres()
        suffix = "tiff" if self._is_in_metres else "png"
        self._keep("depth", f"depth/{stamp}.{suffix}", stamp, _packed(f".{suffix}", raw))

    def _keep(self, name: str, file: str, stamp: str, data: bytes) -> None:
        (self._folder / file).write_bytes(data)
        self._lists[name].append(f"{stamp} {file}")

    def _change_to_metres(self) -> None:
        """Readings that no whole number of raw units gives: all depth becomes floating point, also what is written."""
        self._is_in_metres = True
        scale, self._camera = self._camera.depth_scale, replace(self._camera, depth_scale=1.0)
        earlier, self._lists["depth"] = self._lists["depth"], []
        for line in earlier:
            stamp, file = line.split()
            depth = read_depth(self._folder / file, scale)
            (self._folder / file).unlink()
            self._keep("depth", f"depth/{stamp}.tiff", stamp, _packed(".tiff", depth))

    def finish(self) -> None:
        for name, lines in self._lists.items():
            text = "\n".join(["# timestamp filename", *lines]) + "\n"
            (self._folder / f"{name}.txt").write_text(text, encoding="utf-8")
        camera = self._camera
        fields = {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
        tail = {"distortion": list(camera.distortion), "depth_scale": camera.depth_scale, "fps": camera.fps}
        (self._folder / "camera.yaml").write_text(yaml.safe_dump(fields | tail, sort_keys=False), encoding="utf-8")

    def close(self) -> None:
        """Every file is closed already."""


class _McapSink:
    """Compressed colour, depth in millimetres or metres, and the calibration once a second."""

    def __init__(self, path: Path, camera: PinholeCamera) -> None:
        self._camera = camera
        self._store = get_typestore(Stores.ROS2_HUMBLE)
        self._file = path.open("xb")
        # Pictures are compressed already.
        self._writer = Writer(self._file, compression=CompressionType.NONE)
        self._writer.start("ros2", "lpslam")
        kinds = {
            _COLOUR: "sensor_msgs/msg/CompressedImage",
            _DEPTH: "sensor_msgs/msg/Image",
            _COLOUR_INFO: "sensor_msgs/msg/CameraInfo",
        }
        self._kinds = kinds
        self._channels = {}
        for topic, kind in kinds.items():
            text = self._store.generate_msgdef(kind, ros_version=2)[0]
            schema = self._writer.register_schema(kind, "ros2msg", text.encode())
            self._channels[topic] = self._writer.register_channel(topic, "cdr", schema)

    def add(self, frame: RgbdFrame) -> None:
        types = self._store.types
        nanoseconds = int(_stamp(frame.timestamp).replace(".", ""))
        time = types["builtin_interfaces/msg/Time"](nanoseconds // 10**9, nanoseconds % 10**9)
        header = types["std_msgs/msg/Header"](time, _FRAME)
        colour = np.frombuffer(_packed(".png", frame.rgb[:, :, ::-1]), np.uint8)
        self._write(_COLOUR_INFO, nanoseconds, self._info(header))
        self._write(_COLOUR, nanoseconds, types[self._kinds[_COLOUR]](header, "bgr8; png compressed bgr8", colour))
        raw = raw_depth(frame.depth, 1000.0)
        encoding = "16UC1" if raw.dtype == np.uint16 else "32FC1"
        height, width = raw.shape
        step = width * raw.itemsize
        data = np.ascontiguousarray(raw).view(np.uint8).ravel()
        self._write(_DEPTH, nanoseconds, types[self._kinds[_DEPTH]](header, height, width, encoding, 0, step, data))

    def finish(self) -> None:
        self._writer.finish()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        self._file.close()

    def _write(self, topic: str, nanoseconds: int, message: Any) -> None:
        data = bytes(self._store.serialize_cdr(message, self._kinds[topic]))
        self._writer.add_message(self._channels[topic], nanoseconds, data, nanoseconds)

    def _info(self, header: Any) -> Any:
        camera, types = self._camera, self._store.types
        matrix = camera.matrix
        projection = np.column_stack([matrix, np.zeros(3)])
        region = types["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
        return types["sensor_msgs/msg/CameraInfo"](
            header,
            camera.height,
            camera.width,
            "plumb_bob",
            np.array(camera.distortion),
            matrix.ravel(),
            np.eye(3).ravel(),
            projection.ravel(),
            0,
            0,
            region,
        )


def raw_depth(depth: NDArray[np.float32], depth_scale: float) -> NDArray[np.uint16] | NDArray[np.float32]:
    """Depth (h, w) in whole raw units where they give every reading back to the last bit; else as it is, in metres."""
    raw = np.rint(depth.astype(np.float64) * depth_scale)
    if raw.max(initial=0) <= _LARGEST:
        whole = raw.astype(np.uint16)
        if np.array_equal(whole.astype(np.float32) * np.float32(1.0 / depth_scale), depth):
            return whole
    return depth


def _stamp(timestamp: float) -> str:
    return f"{timestamp:.9f}"


def _packed(suffix: str, picture: Any) -> bytes:
    options = [cv2.IMWRITE_PNG_COMPRESSION, 1] if suffix == ".png" else []
    return bytes(cv2.imencode(suffix, np.ascontiguousarray(picture), options)[1].tobytes())
