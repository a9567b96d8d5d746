"""The message types that robots are told and tell, as rosbags knows them, and what they are called in DDS.

What rosbags has not is defined here: vision_msgs 4 (https://github.com/ros-perception/vision_msgs) and the two services
of `interfaces/`. The names in DDS: https://design.ros2.org/articles/topic_and_service_names.html
"""

import functools
from importlib.resources import files
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from lpslam.errors import LpSlamError

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
POSE = "geometry_msgs/msg/PoseStamped"
GRID = "nav_msgs/msg/OccupancyGrid"
PATH = "nav_msgs/msg/Path"
MARKERS = "visualization_msgs/msg/MarkerArray"
DETECTIONS = "vision_msgs/msg/Detection3DArray"
ASK = "lpslam_interfaces/srv/Ask"
GOAL = "lpslam_interfaces/srv/Goal"

_VISION = {
    "vision_msgs/msg/ObjectHypothesis": "string class_id\nfloat64 score",
    "vision_msgs/msg/ObjectHypothesisWithPose": (
        "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose"
    ),
    "vision_msgs/msg/BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size",
    "vision_msgs/msg/Detection3D": (
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\nvision_msgs/BoundingBox3D bbox\n"
        "string id"
    ),
    DETECTIONS: "std_msgs/Header header\nvision_msgs/Detection3D[] detections",
}


class BadBytesError(LpSlamError):
    """Bytes that are no message of their type."""


@functools.cache
def store() -> Typestore:
    """All types, as of ROS 2 Humble; their fields are the same in Iron, Jazzy and Kilted."""
    made = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in _VISION.items():
        made.register(get_types_from_msg(text, name))
    for service in (ASK, GOAL):
        texts = service_definition(service).split("\n---\n")
        for part, text in zip((request_of(service), response_of(service)), texts, strict=True):
            made.register(get_types_from_msg(text, part))
    return made


def request_of(service: str) -> str:
    """The type of a service's requests, by the name that rosbags gives it."""
    return f"{service.replace('/srv/', '/srv/msg/')}_Request"


def response_of(service: str) -> str:
    """The type of a service's responses."""
    return f"{service.replace('/srv/', '/srv/msg/')}_Response"


def service_definition(service: str) -> str:
    """The text of a service's `.srv` file."""
    name = service.rpartition("/")[2]
    return files("lpslam.robots").joinpath("interfaces", f"{name}.srv").read_text(encoding="utf-8")


def made(kind: str, *fields: Any) -> Any:
    """A message of a type, with its fields in order."""
    return store().types[kind](*fields)


def encoded(message: Any) -> bytes:
    """A message's bytes in CDR, with the four of the header before them."""
    return bytes(store().serialize_cdr(message, message.__msgtype__))


def decoded(data: bytes, kind: str) -> Any:
    """The message that bytes in CDR are.

    Raises:
        BadBytesError: they are none of that type.
    """
    try:
        return store().deserialize_cdr(data, kind)
    except Exception as error:
        # Damaged bytes fail in as many ways as there are fields.
        raise BadBytesError(f"{len(data)} bytes are no {kind} ({type(error).__name__})") from error


def type_hash(kind: str) -> str:
    """The hash by which ROS 2 from Iron on tells whether two sides mean the same type (RIHS01)."""
    return store().hash_rihs01(kind)


def dds_type(kind: str) -> str:
    """What a type is called in DDS."""
    package, room, name = kind.replace("/srv/msg/", "/srv/").split("/")
    return f"{package}::{room}::dds_::{name}_"


def dds_topic(topic: str, prefix: str = "rt") -> str:
    """What a topic is called in DDS: `rt` topics, `rq` requests, `rr` replies of services."""
    return f"{prefix}/{topic.lstrip('/')}"
