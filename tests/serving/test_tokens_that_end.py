"""Tokens that expire or are withdrawn while they are used."""

import asyncio
import json
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from served_here import Serve

from lpslam.config import Config
from lpslam.serving import tokens as tokens_module
from lpslam.serving.http.shield import Door, Shield
from lpslam.serving.tokens import Tokens, add_token


def heard(path: Path, token: str, between: Any) -> list[bytes]:
    """What somebody hears of a stream of four words, when something happens after the second."""
    said: list[bytes] = []

    async def talks(scope: Any, receive: Any, send: Any) -> None:
        await send({"type": "http.response.start", "status": 200, "headers": []})
        for number in range(4):
            if number == 2:
                between()
            await send({"type": "http.response.body", "body": b"%d" % number, "more_body": number < 3})

    async def hear(message: Any) -> None:
        said.append(message.get("body", b""))
        assert said[-1] or message["type"] == "http.response.start" or not message["more_body"]

    async def nothing() -> Any:
        return {"type": "http.request", "body": b"", "more_body": False}

    shield = Shield(talks, Door(frozenset(), Tokens(path), Config().serving))
    headers = [(b"host", b"localhost"), (b"authorization", b"Bearer " + token.encode())]
    scope = {"type": "http", "method": "GET", "path": "/events", "headers": headers, "client": ("127.0.0.1", 1)}
    asyncio.run(shield(scope, nothing, hear))
    return [each for each in said if each]


def test_a_stream_ends_when_its_token_is_withdrawn(tmp_path: Path) -> None:
    path = tmp_path / "tokens.json"
    token = add_token(path, "robot", ["read"], 1)
    assert heard(path, token, lambda: None) == [b"0", b"1", b"2", b"3"]
    assert heard(path, token, path.unlink) == [b"0", b"1"]


class Later(datetime):
    """Two days from now."""

    @classmethod
    def now(cls, tz: Any = None) -> datetime:
        return datetime.now(tz) + timedelta(days=2)


def test_a_token_that_expires_while_the_server_runs_lets_in_no_longer(
    serve: Serve, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "tokens.json"
    scopes = ["read", "ask", "write", "map"]
    headers = {"authorization": f"Bearer {add_token(path, 'robot', scopes, 1)}"}
    client = serve(tokens=path, uploads=tmp_path / "uploads")
    assert client.get("/maps", headers=headers).status_code == 200
    monkeypatch.setattr(tokens_module, "datetime", Later)
    change = {"revision": 0, "kind": "hide", "landmark": 0}
    # One after the other: whoever is let in to the last hears it for ever.
    for method, path, body in (
        ("GET", "/maps", b""),
        ("POST", "/ask", b'{"question": "pizza"}'),
        ("POST", "/corrections", json.dumps(change).encode()),
        ("POST", "/jobs?name=new&file=walk.zip", b"x"),
        ("GET", "/events", b""),
    ):
        response = client.request(method, path, content=body, headers={**headers, "content-type": "application/json"})
        assert (response.status_code, response.json()["detail"]) == (401, "the token has expired")
        assert "invalid_token" in response.headers["www-authenticate"]
    assert not list((tmp_path / "uploads").rglob("*.zip"))


def test_a_moment_without_its_time_zone_is_no_moment(tmp_path: Path) -> None:
    from lpslam.errors import UserError

    path = tmp_path / "tokens.json"
    add_token(path, "robot", ["read"], 1)
    document = json.loads(path.read_text())
    assert datetime.fromisoformat(document["tokens"][0]["expires"]) > datetime.now(UTC)
    document["tokens"][0]["expires"] = "2030-01-31T00:00:00"
    path.write_text(json.dumps(document))
    with pytest.raises(UserError, match="time zone"):
        Tokens(path)
