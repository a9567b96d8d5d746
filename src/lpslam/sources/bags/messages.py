"""Messages decoded: the standard types of ROS 1 and ROS 2, and Foxglove's in JSON, with one set of names.

Only types that are known here are decoded, by definitions of their own: a recording's own definitions are not needed.
"""

import base64
import functools
import json
from types import SimpleNamespace
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from lpslam.errors import LpSlamError
from lpslam.sources.bags.containers.container import Encoding, Message

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
EXTRINSICS = ("realsense2_camera_msgs/msg/Extrinsics", "realsense2_camera/msg/Extrinsics")
_FOXGLOVE = {
    "foxglove.RawImage": IMAGE,
    "foxglove.CompressedImage": COMPRESSED,
    "foxglove.CameraCalibration": CAMERA_INFO,
}
_NEEDED = {
    IMAGE: ("width", "height", "encoding", "step", "data"),
    COMPRESSED: ("format", "data"),
    CAMERA_INFO: ("width", "height", "distortion_model", "D", "K"),
}
_JSON_TYPES: dict[str, type] = {
    **dict.fromkeys(("width", "height", "step"), int),
    **dict.fromkeys(("encoding", "format", "distortion_model", "data"), str),
    **dict.fromkeys("DK", list),
}
_DEFINITIONS = {
    # rosbags has the second one for ROS 2 only.
    "tf/msg/tfMessage": "geometry_msgs/TransformStamped[] transforms",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "realsense_msgs/msg/StreamInfo": "uint32 fps\nstring encoding\nbool is_recommended",
}


_LARGEST_NUMBER = 1 << 31
"""Of pixels and bytes, as ROS's fields hold them."""


class BadMessageError(LpSlamError):
    """A message that cannot be decoded; says why in a few words."""


def known_type(kind: str) -> str:
    """The type as it is called here: Foxglove's types by what they are in ROS."""
    return _FOXGLOVE.get(kind, kind)


def decoded(message: Message) -> Any:
    """The message as an object with the fields of its ROS type.

    Raises:
        BadMessageError: it is empty, cut off, or of a type or encoding that is not known.
    """
    kind, encoding = message.topic.type, message.topic.encoding
    if not message.data:
        raise BadMessageError(f"a message of {message.topic.name} is empty")
    try:
        if encoding is Encoding.CDR:
            return _store(Stores.ROS2_HUMBLE).deserialize_cdr(message.data, _standard(kind))
        if encoding is Encoding.ROS1:
            return _ros1(message, kind)
        if encoding is Encoding.JSON:
            return _from_json(kind, json.loads(message.data))
    except Exception as error:
        # Damaged bytes fail in as many ways as there are fields.
        raise BadMessageError(
            f"a message of {message.topic.name} cannot be decoded ({type(error).__name__})"
        ) from error
    raise BadMessageError(f"{message.topic.name} is in an encoding that is not known; record it as ROS messages")


def stamp_of(message: Any) -> int:
    """Nanoseconds of the message's header; 0 where it has none."""
    stamp = message.header.stamp if hasattr(message, "header") else message.stamp
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def _ros1(message: Message, kind: str) -> Any:
    store = _store(Stores.ROS1_NOETIC)
    try:
        return store.deserialize_ros1(message.data, _standard(kind))
    except Exception:
        # RealSense's older recorder leaves four bytes behind every image.
        if kind != IMAGE or len(message.data) < 4:
            raise
        return store.deserialize_ros1(message.data[:-4], kind)


def _standard(kind: str) -> str:
    return "tf/msg/tfMessage" if kind == "tf/msg/tfMessage" else kind


@functools.cache
def _store(which: Stores) -> Typestore:
    store = get_typestore(which)
    types: dict[str, Any] = {}
    for name, text in _DEFINITIONS.items():
        types.update(get_types_from_msg(text, name))
    for name in EXTRINSICS:
        types.update(get_types_from_msg("float64[9] rotation\nfloat64[3] translation", name))
    store.register({name: fields for name, fields in types.items() if name not in store.types})
    return store


def _from_json(kind: str, tree: Any) -> Any:
    """Foxglove's fields under ROS's names; what others rely on is of the type that they rely on."""
    stamp = tree.get("timestamp") or {}
    header = SimpleNamespace(
        stamp=SimpleNamespace(sec=int(stamp.get("sec", 0)), nanosec=int(stamp.get("nsec", 0))),
        frame_id=str(tree.get("frame_id", "")),
    )
    fields = {key: value for key, value in tree.items() if isinstance(key, str)}
    for name in _NEEDED.get(known_type(kind), ()):
        value = fields[name]
        if not isinstance(value, _JSON_TYPES[name]) or (isinstance(value, int) and abs(value) > _LARGEST_NUMBER):
            raise TypeError(name)
    if "data" in fields:
        fields["data"] = np.frombuffer(base64.b64decode(fields["data"], validate=True), np.uint8)
    return SimpleNamespace(**{"is_bigendian": 0, **fields, "header": header})
