"""What RealSense's own recorders write: depth units, capture times and extrinsics, on topics of their own.

Both forms are read: `.bag` (librealsense up to 2.56) and `.db3` (2.57 and later), without the vendor's library.
"""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.sources.bags.containers.container import Container, Message
from lpslam.sources.bags.messages import BadMessageError, decoded
from lpslam.sources.bags.topics import first_of
from lpslam.sources.bags.transforms import rigid

_SENSOR = re.compile(r"(/device_\d+/sensor_\d+)/([A-Za-z]+_\d+)/")
_STRING = "std_msgs/msg/String"


def is_realsense(topic: str) -> bool:
    """Whether the topic is one of the vendor's own recorders."""
    return _SENSOR.match(topic) is not None


def depth_scale_of(container: Container, depth: str) -> float | None:
    """Raw depth units in a metre, as the sensor states them; None where it does not."""
    match = _SENSOR.match(depth)
    if match is None:
        return None
    value = _first(container, f"{match[1]}/option/Depth_Units/value")
    try:
        units = float(value.data)
    except (AttributeError, ValueError, TypeError):
        return None
    # Kept as a 32-bit number: 0.001 comes back as 0.0010000000474974513.
    return float(f"{1 / units:.6g}") if 1e-6 < units < 1 else None


def colour_from_depth_of(container: Container, colour: str, depth: str) -> NDArray[np.float64] | None:
    """The 4×4 transform between the two cameras; None where the file has none."""
    poses = [_stream_from_reference(container, name) for name in (colour, depth)]
    if poses[0] is None or poses[1] is None:
        return None
    return np.asarray(poses[0] @ inverse_transform(poses[1]))


def capture_times(container: Container, names: tuple[str, str]) -> dict[str, str]:
    """Topics that tell when pictures were taken, to the topics of the pictures; empty where headers tell it."""
    topics = {topic.name: topic for topic in container.topics}
    found = {}
    for name in names:
        match = _SENSOR.match(name)
        metadata = f"{match[0]}image/metadata" if match else ""
        if metadata in topics and topics[metadata].type == _STRING:
            found[metadata] = name
    return found if len(found) == len(names) else {}


def with_capture_times(messages: Iterator[Message], metadata: dict[str, str]) -> Iterator[tuple[Message, int | None]]:
    """Pictures with the nanoseconds at which they were taken, from the message that was recorded along with each."""
    waiting: dict[str, Message] = {}
    for message in messages:
        picture = metadata.get(message.topic.name)
        if picture is None:
            if message.topic.name in waiting:
                yield waiting.pop(message.topic.name), None
            waiting[message.topic.name] = message
        elif picture in waiting and waiting[picture].logged == message.logged:
            yield waiting.pop(picture), _taken(message)
    for message in waiting.values():
        yield message, None


def _taken(message: Message) -> int | None:
    try:
        fields = _fields(decoded(message).data)
        return round(float(fields["timestamp"]) * 1e6)
    except (BadMessageError, KeyError, ValueError, OverflowError):
        return None


def _stream_from_reference(container: Container, picture: str) -> NDArray[np.float64] | None:
    match = _SENSOR.match(picture)
    if match is None:
        return None
    name = next((topic.name for topic in container.topics if topic.name.startswith(f"{match[0]}tf/")), "")
    value = _first(container, name)
    if value is None:
        return None
    if not hasattr(value, "data"):
        return rigid(value) if hasattr(value, "rotation") else None
    try:
        fields = _fields(value.data)
        # librealsense keeps rotations column by column.
        rotation = np.array([float(word) for word in fields["rotation"].split(",")]).reshape(3, 3).T
        pose = np.eye(4)
        pose[:3, :3] = rotation
        pose[:3, 3] = [float(word) for word in fields["translation"].split(",")]
    except (KeyError, ValueError):
        return None
    is_rigid = np.isfinite(pose).all() and np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-3)
    return pose if is_rigid else None


def _first(container: Container, name: str) -> Any:
    topic = next((topic for topic in container.topics if topic.name == name), None)
    return None if topic is None else first_of(container, topic)


def _fields(text: str) -> dict[str, str]:
    return {key: value for key, _, value in (part.partition("=") for part in str(text).split(";"))}
