"""`lpslam serve` itself: where it listens, what a raw connection can do to it, and how it ends."""

import http.client
import json
import os
import re
import signal
import socket
import struct
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from command_line import Command
from lpslam.isolated import python_command
from small_maps import small_map

pytestmark = pytest.mark.slow

CODE = "import sys; sys.argv = ['lpslam', *sys.argv[1:]]; from lpslam.__main__ import main; main()"
LIMITS = "serving: {request_s: 1.0, look_s: 0.1, connections: 40, heartbeat_s: 0.3, rate: 100000, burst: 100000}\n"


class Server:
    """A server in a process of its own."""

    def __init__(self, folder: Path) -> None:
        self.map = folder / "mall.lpmap"
        small_map().save(self.map)
        (folder / "limits.yaml").write_text(LIMITS)
        options = ["--port", "0", "--workers", "1", "--config", str(folder / "limits.yaml")]
        self.process = subprocess.Popen(
            python_command(CODE, "serve", str(self.map), *options), stderr=subprocess.PIPE, text=True, cwd=folder
        )
        assert self.process.stderr is not None
        said = self.process.stderr.readline()
        found = re.search(r"http://127\.0\.0\.1:(\d+)", said)
        assert found is not None, said + self.process.stderr.read()
        self.port = int(found[1])

    def get(self, path: str = "/maps") -> tuple[int, bytes]:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        connection.request("GET", path)
        response = connection.getresponse()
        answer = response.status, response.read()
        connection.close()
        return answer

    def connect(self) -> socket.socket:
        return socket.create_connection(("127.0.0.1", self.port), timeout=120)

    def raw(self, data: bytes) -> bytes:
        """What it says to some bytes before it closes."""
        with self.connect() as connection:
            try:
                connection.sendall(data)
                connection.shutdown(socket.SHUT_WR)
                answer = b""
                while piece := connection.recv(65536):
                    answer += piece
            except ConnectionError:
                return b""
        return answer


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    one = Server(tmp_path_factory.mktemp("served"))
    with one.process:
        yield one
        one.process.send_signal(signal.SIGINT)
        assert one.process.wait(20) == 0
        assert one.process.stderr is not None
        # However it was treated, it has nothing to tell.
        assert one.process.stderr.read() == ""


HOST = b"host: 127.0.0.1\r\n"
RAW = [
    b"", b"\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\x16\x03\x01\x02\x00\x01\x00", b"\x00" * 5000,
    b"GET /maps HTTP/1.1\r\n\r\n", b"GET /maps HTTP/1.0\r\n\r\n", b"GET /maps HTTP/1.1\r\nhost: a\r\nhost: b\r\n\r\n",
    b"GET http://evil.example/maps HTTP/1.1\r\nhost: evil.example\r\n\r\n", b"GET /" + b"a" * 40_000 + b" HTTP/1.1\r\n",
    b"GET /maps HTTP/1.1\r\n" + HOST + b"x: " + b"y" * 40_000, b"GET /\xff\xfe HTTP/1.1\r\n" + HOST + b"\r\n",
    b"GET /maps HTTP/1.1\r\n" + HOST + b"a\x00b: c\r\n\r\n", b"GET /maps HTTP/1.1\r\n" + HOST + b" folded: x\r\n\r\n",
    b"POST /ask HTTP/1.1\r\n" + HOST + b"content-length: 5\r\ncontent-length: 6\r\n\r\nhello",
    b"POST /ask HTTP/1.1\r\n" + HOST + b"content-length: -5\r\n\r\n",
    b"POST /ask HTTP/1.1\r\n" + HOST + b"content-length: 99999999999999999999\r\n\r\n",
    b"POST /ask HTTP/1.1\r\n" + HOST + b"transfer-encoding: chunked\r\ncontent-length: 3\r\n\r\n0\r\n\r\nGET /maps",
    b"POST /ask HTTP/1.1\r\n" + HOST + b"transfer-encoding: chunked\r\n\r\nzz\r\n",
    b"POST /ask HTTP/1.1\r\n" + HOST + b"transfer-encoding: chunked\r\n\r\n" + b"f" * 30 + b"\r\n",
    b"POST /ask HTTP/1.1\r\n" + HOST + b"content-type: application/json\r\ncontent-length: 100\r\n\r\n{",
    b"CONNECT evil.example:443 HTTP/1.1\r\n" + HOST + b"\r\n", b"GET /maps HTTP/2.0\r\n" + HOST + b"\r\n",
    b"GET /maps HTTP/1.1\r\n" + HOST + b"upgrade: websocket\r\nconnection: upgrade\r\n\r\n",
]  # fmt: skip


@pytest.mark.parametrize("data", RAW, ids=lambda data: repr(data[:40]))
def test_bytes_that_are_no_request_end_the_connection_alone(server: Server, data: bytes) -> None:
    answer = server.raw(data)
    assert b"Traceback" not in answer
    assert not answer.startswith(b"HTTP/1.1 500")
    assert server.get()[0] == 200


def test_who_sends_slowly_is_cut_off(server: Server) -> None:
    heads = (b"GET /maps HTT", b"POST /ask HTTP/1.1\r\n" + HOST + b"content-type: application/json\r\n"
             b"content-length: 60000\r\n\r\n", b"")  # fmt: skip
    begun = time.monotonic()
    for head in heads:
        with server.connect() as connection:
            connection.sendall(head)
            try:
                while time.monotonic() - begun < 15:
                    # A byte now and then does not buy more time.
                    connection.sendall(b" " if b"\r\n\r\n" in head else b"x" if head else b"")
                    connection.settimeout(0.2)
                    try:
                        if not connection.recv(1000):
                            break
                    except TimeoutError:
                        continue
            except ConnectionError:
                pass
        assert time.monotonic() - begun < 12, head
    assert server.get()[0] == 200


def test_a_flood_of_connections_that_break_leaves_nothing_behind(server: Server) -> None:
    files = Path(f"/proc/{server.process.pid}/fd")
    asked = b'{"question": "pizza"}'
    head = b"content-type: application/json\r\ncontent-length: %d\r\n\r\n" % len(asked)
    requests = [
        b"GET /events HTTP/1.1\r\n" + HOST + b"\r\n", b"POST /ask HTTP/1.1\r\n" + HOST + head + asked,
        b"GET /landmarks HTTP/1.1\r\n" + HOST + b"\r\n" * 40, b"\x00" * 900,
        b"GET /map.png HTTP/1.1\r\n" + HOST + b"\r\n",
        (b"GET /maps HTTP/1.1\r\n" + HOST + b"\r\n") * 30, b"POST /ask HTTP/1.1\r\n" + HOST + head + asked * 50,
    ]  # fmt: skip
    before = 0
    for turn in range(300):
        if turn == 2 * len(requests):
            # What is opened once, pictures and processes that answer, is open by now.
            time.sleep(1.5)
            before = len(os.listdir(files)) if files.is_dir() else 0
        with server.connect() as connection:
            connection.sendall(requests[turn % len(requests)])
            if turn % 3 == 0:
                # The connection is reset, and not ended in order.
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    end = time.monotonic() + 120
    # It closes the last of them first: until then no more may be open.
    while server.get()[0] != 200:
        assert time.monotonic() < end
        time.sleep(0.1)
    while before and len(os.listdir(files)) > before + 3:
        assert time.monotonic() < end, os.listdir(files)
        time.sleep(0.1)


def test_more_connections_than_may_be_open_are_refused_and_then_taken_again(server: Server) -> None:
    many = [server.connect() for _ in range(60)]
    for connection in many:
        connection.sendall(b"GET /maps HTTP/1.1\r\n" + HOST + b"\r\n")
    answers = [connection.recv(100) for connection in many]
    assert any(answer.startswith(b"HTTP/1.1 503") for answer in answers)
    for connection in many:
        connection.close()
    time.sleep(0.2)
    assert server.get()[0] == 200


def test_events_tell_of_a_map_that_is_replaced_and_go_on_where_they_were(server: Server) -> None:
    def listening(last: str = "") -> tuple[socket.socket, Any]:
        connection = server.connect()
        more = f"last-event-id: {last}\r\n" if last else ""
        connection.sendall(b"GET /events HTTP/1.1\r\n" + HOST + more.encode() + b"\r\n")
        lines = connection.makefile("rb")
        while b": connected" not in (line := lines.readline()):
            assert line
        return connection, lines

    def next_event(lines: Any) -> dict[str, str]:
        found: dict[str, str] = {}
        while True:
            line = lines.readline().decode().strip()
            if not line and "data" in found:
                return found
            if ": " in line and not line.startswith(":"):
                name, _, value = line.partition(": ")
                found[name] = value

    connection, lines = listening()
    small_map(["Bakery"]).save(server.map)
    event = next_event(lines)
    assert (event["event"], json.loads(event["data"])["landmarks"]) == ("map", 1)
    connection.close()
    small_map().save(server.map)
    time.sleep(1.0)
    connection, lines = listening(event["id"])
    assert json.loads(next_event(lines)["data"])["landmarks"] == 8
    connection.close()


def test_the_port_is_taken(server: Server, lpslam: Command) -> None:
    said = lpslam("serve", server.map, "--port", server.port).complaint
    assert f"port {server.port}" in said
    assert "--port" in said


def test_elsewhere_only_with_tokens(lpslam: Command, server: Server) -> None:
    for host in ("0.0.0.0", "::", "192.168.1.7", "example.org"):
        assert "--tokens" in lpslam("serve", server.map, "--host", host).complaint


def test_mistakes_are_one_line(lpslam: Command, server: Server, tmp_path: Path) -> None:
    (tmp_path / "broken.json").write_text('{"tokens": [{"name": "a"}]}')
    (tmp_path / "empty.json").write_text("{}")
    (tmp_path / "scope.json").write_text(
        json.dumps({"tokens": [{"name": "a", "sha256": "0" * 64, "scopes": ["everything"]}]})
    )
    twice = tmp_path / "mall.lpmap"
    small_map().save(twice)
    for words in (
        (), (tmp_path / "none.lpmap",), (server.map, twice), (server.map, "--tokens", tmp_path / "none.json"),
        (server.map, "--tokens", tmp_path / "broken.json"), (server.map, "--tokens", tmp_path / "empty.json"),
        (server.map, "--tokens", tmp_path / "scope.json"), (server.map, "--certificate", tmp_path / "a.pem"),
        (server.map, "--certificate", tmp_path / "a.pem", "--key", tmp_path / "b.pem", "--port", 0),
        (server.map, "--uploads", tmp_path / "mall.lpmap" / "x", "--port", 0), (server.map, "--host", "no such host"),
    ):  # fmt: skip
        assert lpslam("serve", *words).complaint


def test_a_file_that_is_none_of_tokens_is_said_to_be(lpslam: Command, tmp_path: Path) -> None:
    (tmp_path / "tokens.json").write_text("no tokens")
    said = lpslam("token", tmp_path / "tokens.json", "--name", "a").complaint
    assert "is no file of tokens: Invalid JSON" in said


def test_a_token_is_made_once_and_kept_as_a_digest(lpslam: Command, tmp_path: Path) -> None:
    file = tmp_path / "tokens.json"
    made = lpslam("token", file, "--name", "robot", "--scope", "ask", "--days", "1", "--json").json["token"]
    assert made not in file.read_text()
    assert oct(file.stat().st_mode & 0o777) == "0o600"
    assert "robot" in lpslam("token", file, "--name", "robot").complaint
    assert "scope" in lpslam("token", file, "--name", "other", "--scope", "all").complaint
    assert lpslam("token", file, "--name", "").code == 2
    assert "written" in lpslam("token", tmp_path / "nowhere" / "tokens.json", "--name", "x").complaint


@pytest.mark.parametrize(("command", "extra"), [("serve", "serve"), ("mcp", "mcp")])
def test_a_missing_part_is_named(
    command: str, extra: str, lpslam: Command, monkeypatch: pytest.MonkeyPatch, mall: Path
) -> None:
    import importlib.util

    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *more: None if name in ("uvicorn", "mcp") else found(name, *more)
    )
    assert f"lp-slam[{extra}]" in lpslam(command, mall).complaint


def test_processes_end_with_a_server_that_is_killed(tmp_path: Path) -> None:
    server = Server(tmp_path)
    assert server.get()[0] == 200
    children = Path(f"/proc/{server.process.pid}/task/{server.process.pid}/children")
    if not children.is_file():
        pytest.skip("the system does not tell a process's children")
    (child,) = children.read_text().split()
    with server.process:
        server.process.kill()
    for _ in range(100):
        if not os.path.exists(f"/proc/{child}") or "Z" in Path(f"/proc/{child}/stat").read_text().split(")")[1][:3]:
            break
        time.sleep(0.1)
    else:
        raise AssertionError("the process that answers goes on")
