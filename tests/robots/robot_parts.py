"""A robot for tests: a bus within the process, and a driver that publishes a recording's frames."""

from collections.abc import Callable
from typing import Any

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.frames import RgbdFrame
from lpslam.robots import building, types
from lpslam.robots.bus import OnBytes, Send

FRAME = "camera_color_optical_frame"
COLOUR, DEPTH = "/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw"
INFO = "/camera/color/camera_info"


class WireBus:
    """A `Bus` of one process: what is sent is bytes, and comes at once."""

    def __init__(self) -> None:
        self.sent: dict[str, list[Any]] = {}
        self.services: dict[str, Callable[[Any], Any]] = {}
        self.latched: set[str] = set()
        self._listeners: dict[str, list[OnBytes]] = {}

    def publisher(self, topic: str, kind: str, *, latched: bool = False) -> Send:
        def send(message: Any) -> None:
            assert message.__msgtype__ == kind
            self.sent.setdefault(topic, []).append(types.decoded(types.encoded(message), kind))

        if latched:
            self.latched.add(topic)
        return send

    def subscribe(
        self, topic: str, kind: str, on_bytes: OnBytes, *, latched: bool = False, reliable: bool = False
    ) -> None:
        self._listeners.setdefault(topic, []).append(on_bytes)

    def serve(self, name: str, service: str, respond: Callable[[Any], Any]) -> None:
        self.services[name] = lambda request: types.decoded(
            types.encoded(respond(types.decoded(types.encoded(request), types.request_of(service)))),
            types.response_of(service),
        )

    def close(self) -> None:
        self._listeners.clear()

    def give(self, topic: str, message: Any) -> None:
        """What the robot publishes: a message, or bytes that are none."""
        for on_bytes in self._listeners.get(topic, ()):
            on_bytes(message if isinstance(message, bytes) else types.encoded(message))


def nanoseconds(frame: RgbdFrame) -> int:
    return round(frame.timestamp * 1e9)


def pictures(frame: RgbdFrame, late: float = 0.004) -> list[tuple[str, Any]]:
    """A frame as a driver publishes it: depth some milliseconds after its colour."""
    stamp = nanoseconds(frame)
    depth = np.rint(1000 * frame.depth).astype(np.uint16)
    return [
        (COLOUR, building.picture(frame.rgb, stamp, FRAME)),
        (DEPTH, building.picture(depth, stamp + round(late * 1e9), FRAME)),
    ]


def calibration(camera: PinholeCamera, stamp: int = 0) -> tuple[str, Any]:
    return (INFO, building.camera_info(camera, stamp, FRAME))
