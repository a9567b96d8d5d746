"""Frames as messages: ROS 2's, and Foxglove's in JSON (https://docs.foxglove.dev/docs/sdk/schemas)."""

import base64
import json
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from lpslam.camera import PinholeCamera
from lpslam.frames import RgbdFrame
from lpslam.sources.writing.pixels import packed, raw_depth

COLOUR, DEPTH = "/camera/color/image_raw/compressed", "/camera/aligned_depth_to_color/image_raw"
COLOUR_INFO = "/camera/color/camera_info"
_FRAME = "camera_color_optical_frame"
_SECOND = 10**9


class RosMessages:
    """`Messages` of ROS 2.

    Args:
        camera: of the frames.
    """

    profile, encoding, schema_encoding = "ros2", "cdr", "ros2msg"

    def __init__(self, camera: PinholeCamera) -> None:
        self._camera = camera
        self._store = get_typestore(Stores.ROS2_HUMBLE)
        self._kinds = {
            COLOUR_INFO: "sensor_msgs/msg/CameraInfo",
            COLOUR: "sensor_msgs/msg/CompressedImage",
            DEPTH: "sensor_msgs/msg/Image",
        }
        self.schemas = {
            topic: (kind, self._store.generate_msgdef(kind, ros_version=2)[0].encode())
            for topic, kind in self._kinds.items()
        }

    def of(self, frame: RgbdFrame, nanoseconds: int) -> list[tuple[str, bytes]]:
        """See `Messages`."""
        types = self._store.types
        time = types["builtin_interfaces/msg/Time"](nanoseconds // _SECOND, nanoseconds % _SECOND)
        header = types["std_msgs/msg/Header"](time, _FRAME)
        colour = np.frombuffer(packed(".png", frame.rgb[:, :, ::-1]), np.uint8)
        depth = _depth_fields(frame)
        size = depth["height"], depth["width"], depth["encoding"], 0, depth["step"]
        messages = {
            COLOUR_INFO: self._info(header),
            COLOUR: types[self._kinds[COLOUR]](header, "bgr8; png compressed bgr8", colour),
            DEPTH: types[self._kinds[DEPTH]](header, *size, np.frombuffer(depth["data"], np.uint8)),
        }
        return [
            (topic, bytes(self._store.serialize_cdr(message, self._kinds[topic])))
            for topic, message in messages.items()
        ]

    def _info(self, header: Any) -> Any:
        camera, types = self._camera, self._store.types
        region = types["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
        return types["sensor_msgs/msg/CameraInfo"](
            header,
            camera.height,
            camera.width,
            "plumb_bob",
            np.array(camera.distortion),
            camera.matrix.ravel(),
            np.eye(3).ravel(),
            _projection(camera),
            0,
            0,
            region,
        )


TIME = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}
TEXT, NUMBER = {"type": "string"}, {"type": "integer"}
BYTES = {"type": "string", "contentEncoding": "base64"}
NUMBERS = {"type": "array", "items": {"type": "number"}}
SIZE = {"width": NUMBER, "height": NUMBER}
_FOXGLOVE: dict[str, tuple[str, dict[str, Any]]] = {
    COLOUR_INFO: (
        "foxglove.CameraCalibration",
        {**SIZE, "distortion_model": TEXT, "D": NUMBERS, "K": NUMBERS, "R": NUMBERS, "P": NUMBERS},
    ),
    COLOUR: ("foxglove.CompressedImage", {"data": BYTES, "format": TEXT}),
    DEPTH: ("foxglove.RawImage", {**SIZE, "encoding": TEXT, "step": NUMBER, "data": BYTES}),
}


class FoxgloveMessages:
    """`Messages` of Foxglove in JSON: a third larger than those of ROS 2, and every language reads them.

    Args:
        camera: of the frames.
    """

    profile, encoding, schema_encoding = "", "json", "jsonschema"

    def __init__(self, camera: PinholeCamera) -> None:
        self._calibration = calibration_fields(camera)
        self.schemas = {
            topic: (name, json.dumps(json_schema(name, fields)).encode()) for topic, (name, fields) in _FOXGLOVE.items()
        }

    def of(self, frame: RgbdFrame, nanoseconds: int) -> list[tuple[str, bytes]]:
        """See `Messages`."""
        head = {"timestamp": {"sec": nanoseconds // _SECOND, "nsec": nanoseconds % _SECOND}, "frame_id": _FRAME}
        depth = _depth_fields(frame)
        messages: dict[str, dict[str, Any]] = {
            COLOUR_INFO: self._calibration,
            COLOUR: {"data": in_letters(packed(".png", frame.rgb[:, :, ::-1])), "format": "png"},
            DEPTH: {**depth, "data": in_letters(depth["data"])},
        }
        return [(topic, json.dumps({**head, **fields}).encode()) for topic, fields in messages.items()]


def calibration_fields(camera: PinholeCamera) -> dict[str, Any]:
    """The fields of Foxglove's `CameraCalibration`."""
    return {
        "width": camera.width,
        "height": camera.height,
        "distortion_model": "plumb_bob",
        "D": list(camera.distortion),
        "K": camera.matrix.ravel().tolist(),
        "R": np.eye(3).ravel().tolist(),
        "P": _projection(camera).tolist(),
    }


def json_schema(name: str, fields: dict[str, Any]) -> dict[str, Any]:
    """The JSON Schema of one of Foxglove's types, as far as its fields are given."""
    return {"title": name, "type": "object", "properties": {"timestamp": TIME, "frame_id": TEXT, **fields}}


def _depth_fields(frame: RgbdFrame) -> dict[str, Any]:
    """An `Image`'s fields: whole millimetres where they keep every reading, else metres."""
    raw = raw_depth(frame.depth, 1000.0)
    height, width = raw.shape
    return {
        "width": width,
        "height": height,
        "encoding": "16UC1" if raw.dtype == np.uint16 else "32FC1",
        "step": width * raw.itemsize,
        "data": np.ascontiguousarray(raw).tobytes(),
    }


def _projection(camera: PinholeCamera) -> Any:
    return np.column_stack([camera.matrix, np.zeros(3)]).ravel()


def in_letters(data: bytes) -> str:
    """Bytes as JSON holds them: base64."""
    return base64.b64encode(data).decode("ascii")
