"""A run for Foxglove while it goes: a server on this machine, which its viewer connects to (extra "foxglove")."""

import json
import threading
from collections.abc import Callable
from typing import Any

import foxglove as sdk
from foxglove.websocket import ServerListener

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.watching.telling import TOPICS, Telling, schema_of

_HOST = "127.0.0.1"
_WAITING = 64  # messages that wait for one viewer: two seconds of a camera; of a slow one's the oldest are dropped


class ServerWatcher(Telling):
    """A `Watcher` that serves Foxglove's viewers on loopback. What no viewer has subscribed to is not even made.

    Args:
        port: 0 for any that is free.
        camera: of the frames.
        title: of the run.

    Raises:
        UserError: the port is taken.
    """

    def __init__(self, port: int, camera: PinholeCamera, title: str) -> None:
        super().__init__(camera)
        self.name = "the Foxglove server"
        self._asking, self._asked = threading.Lock(), set[str]()
        # Channels are gone with their context.
        context = self._context = sdk.Context()
        self._channels = {}
        for topic in TOPICS:
            name, definition = schema_of(topic)
            schema = sdk.Schema(name=name, encoding="jsonschema", data=definition)
            self._channels[topic] = sdk.Channel(topic, schema=schema, message_encoding="json", context=context)
        try:
            self._server = sdk.start_server(
                name=title,
                host=_HOST,
                port=port,
                context=context,
                server_listener=self._listener(),
                message_backlog_size=_WAITING,
            )
        except (OSError, RuntimeError) as error:
            raise UserError(
                f"{_HOST} port {port} cannot be listened at ({error}); give another with --foxglove, or 0 for any"
            ) from error

    @property
    def url(self) -> str:
        """What a viewer connects to."""
        return f"ws://{_HOST}:{self._server.port}"

    def _listener(self) -> Any:
        """What the server tells, in a thread of its own, when a viewer wants a topic."""

        def on_subscribe(listener: object, client: object, channel: Any) -> None:
            with self._asking:
                self._asked.add(channel.topic)

        return type("Subscriptions", (ServerListener,), {"on_subscribe": on_subscribe})()

    def _is_asked_for(self, topic: str) -> bool:
        with self._asking:
            is_asked = topic in self._asked
            self._asked.discard(topic)
        return is_asked

    def _put(self, topic: str, nanoseconds: int, make: Callable[[], dict[str, Any]]) -> None:
        channel = self._channels[topic]
        if channel.has_sinks():
            channel.log(json.dumps(make(), ensure_ascii=False).encode(), log_time=nanoseconds)

    def close(self) -> None:
        """See `Watcher`."""
        self._server.stop()
