"""lpslam's messages over rclpy: bytes in, bytes out; what they mean is lpslam's own code, with or without ROS."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message

from lpslam.robots import types

_DEPTH = 10


class RclpyBus:
    """A `lpslam.robots.bus.Bus` over a node.

    Args:
        node: whose publishers, subscriptions and services they are.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        # Pictures come in order; a question may take long and must not hold them up.
        self._pictures, self._services = MutuallyExclusiveCallbackGroup(), ReentrantCallbackGroup()

    def publisher(self, topic: str, kind: str, *, latched: bool = False) -> Callable[[Any], None]:
        """See `Bus`."""
        made = self._node.create_publisher(ros_class(kind), topic, _quality(latched, True))
        return lambda message: made.publish(types.encoded(message))

    def subscribe(
        self,
        topic: str,
        kind: str,
        on_bytes: Callable[[bytes], None],
        *,
        latched: bool = False,
        reliable: bool = False,
    ) -> None:
        """See `Bus`."""
        quality = _quality(latched, reliable or latched)
        self._node.create_subscription(
            ros_class(kind), topic, on_bytes, quality, callback_group=self._pictures, raw=True
        )

    def serve(self, name: str, service: str, respond: Callable[[Any], Any]) -> None:
        """See `Bus`."""
        kind = ros_class(service)

        def answer(request: Any, _: Any) -> Any:
            asked = types.decoded(serialize_message(request), types.request_of(service))
            return deserialize_message(types.encoded(respond(asked)), kind.Response)

        self._node.create_service(kind, name, answer, callback_group=self._services)

    def close(self) -> None:
        """See `Bus`; the node takes its own down."""


def ros_class(kind: str) -> Any:
    """The class that ROS has for a type: `package/msg/Name`."""
    package, room, name = kind.split("/")
    return getattr(import_module(f"{package}.{room}"), name)


def ros_message(message: Any) -> Any:
    """A message of lpslam as ROS's own class."""
    return deserialize_message(types.encoded(message), ros_class(message.__msgtype__))


def _quality(latched: bool, reliable: bool) -> QoSProfile:
    return QoSProfile(
        history=QoSHistoryPolicy.KEEP_LAST,
        depth=1 if latched else _DEPTH,
        reliability=QoSReliabilityPolicy.RELIABLE if reliable else QoSReliabilityPolicy.BEST_EFFORT,
        durability=QoSDurabilityPolicy.TRANSIENT_LOCAL if latched else QoSDurabilityPolicy.VOLATILE,
    )
