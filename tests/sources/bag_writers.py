"""Bags written on the spot with the writers of rosbags, for tests of the readers."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from recordings import HEIGHT, WIDTH, picture, raw_depth
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

COLOUR, DEPTH = "/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw"
COLOUR_INFO, DEPTH_INFO = "/camera/color/camera_info", "/camera/aligned_depth_to_color/camera_info"
FIRST = 1_700_000_000_123_456_789
STEP = 33_333_333
K = (50.0, 0.0, 31.5, 0.0, 51.0, 23.5, 0.0, 0.0, 1.0)
KINDS = ("bag", "db3", "mcap")

Entry = tuple[str, int, Any]


class Types:
    """Messages of one ROS generation."""

    def __init__(self, ros: int) -> None:
        self.ros = ros
        self.store = get_typestore(Stores.ROS1_NOETIC if ros == 1 else Stores.ROS2_HUMBLE)
        if ros == 1:
            text = "geometry_msgs/TransformStamped[] transforms"
            self.store.register(get_types_from_msg(text, "tf2_msgs/msg/TFMessage"))

    def make(self, kind: str, *fields: Any) -> Any:
        return self.store.types[kind](*fields)

    def header(self, stamp: int, frame: str = "camera_color_optical_frame") -> Any:
        time = self.make("builtin_interfaces/msg/Time", stamp // 10**9, stamp % 10**9)
        first = (0,) if self.ros == 1 else ()
        return self.make("std_msgs/msg/Header", *first, time, frame)

    def image(self, stamp: int, pixels: np.ndarray, encoding: str, padding: int = 0, **header: str) -> Any:
        rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(pixels.shape[0], -1)
        rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=7)
        height, width = pixels.shape[:2]
        head = self.header(stamp, **header)
        return self.make("sensor_msgs/msg/Image", head, height, width, encoding, 0, rows.shape[1], rows.ravel())

    def compressed(self, stamp: int, text: str, data: bytes) -> Any:
        return self.make("sensor_msgs/msg/CompressedImage", self.header(stamp), text, np.frombuffer(data, np.uint8))

    def info(
        self,
        stamp: int,
        k: Sequence[float] = K,
        d: Sequence[float] = (),
        model: str = "plumb_bob",
        size: tuple[int, int] = (WIDTH, HEIGHT),
    ) -> Any:
        region = self.make("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
        projection = np.column_stack([np.reshape(k, (3, 3)), np.zeros(3)]).ravel()
        arrays = np.array(d, float), np.array(k, float), np.eye(3).ravel(), projection
        return self.make(
            "sensor_msgs/msg/CameraInfo", self.header(stamp), size[1], size[0], model, *arrays, 0, 0, region
        )


def write(path: Path, entries: Callable[[Types], Sequence[Entry]]) -> Path:
    """Write messages as the suffix says; a folder with one file is unwrapped."""
    types = Types(1 if path.suffix == ".bag" else 2)
    if types.ros == 1:
        with Ros1Writer(path) as writer:
            _fill(writer, types, entries(types))
        return path
    folder = path.with_name(f"{path.stem}_{path.suffix[1:]}")
    plugin = StoragePlugin.MCAP if path.suffix == ".mcap" else StoragePlugin.SQLITE3
    with Ros2Writer(folder, version=9, storage_plugin=plugin) as writer:
        _fill(writer, types, entries(types))
    next(folder.glob(f"*{path.suffix}")).rename(path)
    return path


def _fill(writer: Any, types: Types, entries: Sequence[Entry]) -> None:
    connections: dict[str, Any] = {}
    for topic, logged, message in entries:
        kind = message.__msgtype__
        if topic not in connections:
            connections[topic] = writer.add_connection(topic, kind, typestore=types.store)
        serialise = types.store.serialize_ros1 if types.ros == 1 else types.store.serialize_cdr
        writer.write(connections[topic], logged, bytes(serialise(message, kind)))


def walk(types: Types, frames: int = 6, *, padding: int = 0, depth: bool = True, colour: bool = True) -> list[Entry]:
    """Colour, depth 2 ms later, and calibrations; recorded 40 ms after they were taken."""
    entries: list[Entry] = []
    for i in range(frames):
        stamp = FIRST + i * STEP
        logged = stamp + 40_000_000
        if colour:
            entries.append((COLOUR_INFO, logged, types.info(stamp)))
            entries.append((COLOUR, logged + 1, types.image(stamp, picture(i)[:, :, ::-1], "bgr8", padding)))
        if depth:
            entries.append((DEPTH_INFO, logged + 2, types.info(stamp)))
            entries.append((DEPTH, logged + 3, types.image(stamp + 2_000_000, raw_depth(i), "16UC1", padding)))
    return entries
