"""What carries messages between a robot and the map: DDS, or rclpy's node. Bytes are CDR with its header."""

from collections.abc import Callable
from typing import Any, Protocol

OnBytes = Callable[[bytes], None]
Send = Callable[[Any], None]


class Bus(Protocol):
    """Topics and services. Callbacks come in threads of the bus and must not take long, but for services'."""

    def publisher(self, topic: str, kind: str, *, latched: bool = False) -> Send:
        """A function that sends messages of a type; who comes late gets the last one if it is `latched`."""
        ...

    def subscribe(
        self, topic: str, kind: str, on_bytes: OnBytes, *, latched: bool = False, reliable: bool = False
    ) -> None:
        """Call for the bytes of every message on a topic; `latched` also for those sent before."""
        ...

    def serve(self, name: str, service: str, respond: Callable[[Any], Any]) -> None:
        """Offer a service: called with requests, in a thread in which it may take long."""
        ...

    def close(self) -> None:
        """Let go of everything; no callback comes afterwards."""
        ...
