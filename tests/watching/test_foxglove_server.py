"""A run that is served to Foxglove's viewer: by its protocol, over a websocket, to whoever subscribes."""

import json
import socket
import struct
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("foxglove", reason="the extra 'foxglove' is not installed")
client_module = pytest.importorskip("websockets.sync.client", reason="websockets is not installed")
closed_module = pytest.importorskip("websockets.exceptions")

from command_line import Command  # noqa: E402
from lpslam import pipeline  # noqa: E402
from lpslam.errors import UserError  # noqa: E402
from lpslam.sources.open import open_source  # noqa: E402
from lpslam.watching.foxglove_server import ServerWatcher  # noqa: E402
from lpslam.watching.telling import TOPICS  # noqa: E402
from lpslam.watching.watchers import Watchers  # noqa: E402
from small_maps import CAMERA  # noqa: E402

_SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
_MESSAGE = struct.Struct("<BIQ")


class Viewer:
    """A viewer that subscribes to some topics, or to all, and keeps what it is sent."""

    def __init__(self, url: str, *topics: str) -> None:
        self._open = ExitStack()
        connecting = client_module.connect(url, subprotocols=list(_SUBPROTOCOLS), max_size=None, close_timeout=0.5)
        self._connection = self._open.enter_context(connecting)
        self.channels: dict[int, dict[str, Any]] = {}
        self.got: dict[str, list[Any]] = {}
        while len(self.channels) < len(TOPICS):
            told = json.loads(self._connection.recv(10))
            if told["op"] == "advertise":
                self.channels |= {each["id"]: each for each in told["channels"]}
        wanted = [key for key, each in self.channels.items() if not topics or each["topic"] in topics]
        asked = [{"id": key, "channelId": key} for key in wanted]
        self._connection.send(json.dumps({"op": "subscribe", "subscriptions": asked}))
        self._reading = threading.Thread(target=self._read, daemon=True)
        self._reading.start()

    def _read(self) -> None:
        # It ends with whichever side closes first.
        with suppress(closed_module.ConnectionClosed):
            for message in self._connection:
                if isinstance(message, bytes) and message[0] == 1:
                    _, key, _ = _MESSAGE.unpack_from(message)
                    content = json.loads(message[_MESSAGE.size :])
                    self.got.setdefault(self.channels[key]["topic"], []).append(content)

    def close(self) -> None:
        self._open.close()
        self._reading.join(5)


@pytest.fixture
def server() -> Iterator[ServerWatcher]:
    one = ServerWatcher(0, CAMERA, "a walk")
    yield one
    one.close()


def test_it_listens_here_alone_and_a_port_that_is_taken_is_one_line(server: ServerWatcher) -> None:
    assert server.url.startswith("ws://127.0.0.1:")
    with pytest.raises(UserError, match="--foxglove"):
        ServerWatcher(int(server.url.rpartition(":")[2]), CAMERA, "another")


def test_every_topic_has_the_schema_that_foxglove_knows(server: ServerWatcher) -> None:
    viewer = Viewer(server.url)
    told = {each["topic"]: (each["encoding"], each["schemaName"]) for each in viewer.channels.values()}
    assert told == {topic: ("json", name) for topic, name in TOPICS.items()}
    for each in viewer.channels.values():
        assert json.loads(each["schema"])["title"] == each["schemaName"]
    viewer.close()


@pytest.mark.slow
def test_a_run_is_seen_by_who_subscribes_and_by_who_comes_late(server: ServerWatcher, walk: Path) -> None:
    source = open_source(walk, max_frames=40)
    early, late = Viewer(server.url), []
    said: list[str] = []
    time.sleep(0.3)
    with Watchers([server], said.append) as watchers:

        def on_step(frame: Any, step: Any, session: Any) -> None:
            watchers.take(frame, step, session)
            if step.index == 20:
                late.append(Viewer(server.url, "/landmarks", "/camera/color/camera_info"))
                time.sleep(0.3)

        world = pipeline.run(source, on_step=on_step)
        watchers.finish(world)
        time.sleep(0.5)
        early.close()
        late[0].close()
    assert said == []
    assert len(early.got["/camera/color/image/compressed"]) == 40
    assert {"/pose", "/tf", "/points", "/way", "/landmarks", "/camera/color/boxes"} <= set(early.got)
    names = [entity["texts"][0]["text"] for entity in early.got["/landmarks"][-1]["entities"]]
    assert sorted(names) == sorted(mark.name for mark in world.landmarks())
    # Who comes late is told at once what is told seldom, and nothing that was not subscribed to.
    assert set(late[0].got) == {"/landmarks", "/camera/color/camera_info"}
    # At its coming and, a second of the recording having passed, perhaps once more.
    assert 1 <= len(late[0].got["/camera/color/camera_info"]) <= 2


def test_what_nobody_wants_is_not_made(server: ServerWatcher) -> None:
    made: list[int] = []
    server._put("/points", 0, lambda: made.append(1) or {})
    assert made == []


def test_the_command_line_refuses_a_taken_port_and_a_run_that_maps_nothing(
    lpslam: Command, walk: Path, tmp_path: Path
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        said = lpslam("run", walk, "-o", tmp_path / "x.lpmap", "--no-text", "--foxglove", port).complaint
    assert "--foxglove" in said
    assert not (tmp_path / "x.lpmap").exists()
    said = lpslam(
        "run", walk, "--localize", tmp_path / "x.lpmap", "--trajectory", tmp_path / "t.txt", "--foxglove", 0
    ).complaint
    assert "--foxglove" in said
