"""The page of a growing map among clients that mean harm, and signs that do."""

import asyncio
import json
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from starlette.testclient import TestClient

from lpslam.camera import PinholeCamera
from lpslam.config import Config
from lpslam.ground.scans import Scans
from lpslam.serving.http.shield import Door, Shield
from lpslam.serving.watching.app import Watched, build
from lpslam.serving.watching.wire import Begin, Ground

CAMERA = PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5)
JSON = {"content-type": "application/json"}


@pytest.fixture
def watched() -> Watched:
    """A page of which nothing but a wall was seen, and whose run takes no correction."""
    one = Watched(Begin("walk <b>1</b>", 0, Config()), lambda count: None, lambda said: None)
    scans = Scans(CAMERA, 64)
    scans.take(0, np.zeros((48, 64, 3), np.uint8), np.full((48, 64), 2.0, np.float32))
    one.grown.take_ground(Ground(CAMERA, np.eye(4)[None], {0: np.eye(4)}, scans.to_arrays()))
    one.grown.update_points()
    return one


@pytest.fixture
def client(watched: Watched) -> Iterator[TestClient]:
    with TestClient(build(watched), base_url="http://127.0.0.1:8765", raise_server_exceptions=False) as one:
        yield one


def test_the_recordings_name_is_text(client: TestClient) -> None:
    page = client.get("/").text
    assert "<b>1</b>" not in page
    assert "\\u003cb\\u003e1" in page


@pytest.mark.parametrize("since", ["-1", "x", "1.5", "1e3", "", "NaN", "9" * 5000, "%00", "1&since=x"])
def test_a_version_that_is_none_is_refused_in_one_line(client: TestClient, since: str) -> None:
    response = client.get(f"/points?since={since}")
    assert response.status_code == 422
    assert "\n" not in response.json()["detail"]


@pytest.mark.parametrize("since", [0, 2, 99, 2**32, 2**62])
def test_a_version_that_never_was_is_told_all(client: TestClient, since: int) -> None:
    content = client.get(f"/points?since={since}").content
    _, is_whole, records = struct.unpack("<3I", content[:12])
    assert (is_whole, records) == (1, 1)


@pytest.mark.parametrize(
    "body",
    [b"", b"{", b"[]", b"null", b'{"question": 7}', b'{"question": ""}', b"\xff\xfe", b"[" * 30_000,
     b'{"question": "x", "unknown": 1}', b'{"question": "x", "position": [NaN, 0]}',
     b'{"question": "' + b"x" * 5000 + b'"}'],
    ids=lambda body: repr(body[:30]),
)  # fmt: skip
def test_a_malformed_body_is_one_line(client: TestClient, body: bytes) -> None:
    for route in ("/ask", "/corrections"):
        response = client.post(route, content=body, headers=JSON)
        assert response.status_code in (400, 422), (route, response.text)
        assert "\n" not in response.json()["detail"]
    assert client.get("/").status_code == 200


def test_large_bodies_are_not_read(client: TestClient) -> None:
    for route in ("/ask", "/corrections"):
        body = json.dumps({"question": "x" * (10 << 20)}).encode()
        assert client.post(route, content=body, headers=JSON).status_code == 413
        # Without its length said beforehand, it is counted as it comes.
        drops = (b"x" * (64 << 10) for _ in range(40))
        assert client.post(route, content=drops, headers=JSON).status_code == 413


def test_a_body_that_says_it_is_too_large_is_refused_before_any_of_it_comes() -> None:
    said: list[int] = []

    async def inside(scope: Any, receive: Any, send: Any) -> None:
        pytest.fail("it was handed on")

    async def comes() -> Any:
        pytest.fail("it was read")

    async def hear(message: Any) -> None:
        said.append(message.get("status", 0))

    headers = [(b"host", b"localhost"), (b"content-length", b"%d" % (10 << 20))]
    scope = {"type": "http", "method": "POST", "path": "/ask", "headers": headers, "client": ("127.0.0.1", 1)}
    asyncio.run(Shield(inside, Door(frozenset(), None, Config().serving))(scope, comes, hear))
    assert said[0] == 413


@pytest.mark.parametrize(
    "headers",
    [{"host": "evil.example"}, {"origin": "http://evil.example"}, {"origin": "null"}, {"sec-fetch-site": "cross-site"}],
    ids=str,
)
def test_pages_of_others_see_and_ask_nothing(client: TestClient, headers: dict[str, str]) -> None:
    change = {"revision": 0, "kind": "hide", "landmark": 0}
    # One after the other: whoever is let in to the last watches for ever.
    for method, path, body in (
        ("GET", "/", None),
        ("GET", "/points", None),
        ("GET", "/picture", None),
        ("POST", "/ask", {"question": "pizza"}),
        ("POST", "/corrections", change),
        ("GET", "/watch", None),
    ):
        assert client.request(method, path, json=body, headers=headers).status_code in (403, 421), path


def test_more_watchers_than_may_are_refused(watched: Watched, client: TestClient) -> None:
    async def fill() -> None:
        watchers = [watched.board.watch(5.0, "end") for _ in range(Config().serving.listeners)]
        for each in watchers:
            await anext(each)
        assert watched.board.is_full
        # Whoever were let in all the same would be told the end, and nothing else.
        watched.board.put("end", b"{}")
        response = await asyncio.to_thread(client.get, "/watch")
        assert response.status_code == 503
        for each in watchers:
            await each.aclose()  # type: ignore[attr-defined]

    asyncio.run(fill())
