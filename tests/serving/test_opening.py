"""The page of a map is there before the server is loaded, and what else is asked waits for it."""

import threading
from collections.abc import AsyncIterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from typing import Any

import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Route
from starlette.testclient import TestClient

from lpslam.serving.http.opening import Opening


def app(words: str, *paths: str, **options: Any) -> Starlette:
    async def say(request: Request) -> PlainTextResponse:
        return PlainTextResponse(words)

    return Starlette(routes=[Route(path, say) for path in paths], **options)


PAGES = app("page", "/", "/page/mall/points")


def test_the_page_comes_first_and_everything_else_waits_until_it_is_loaded() -> None:
    went: list[str] = []
    may_load = threading.Event()

    @asynccontextmanager
    async def life(whole: Starlette) -> AsyncIterator[None]:
        went.append("begins")
        yield
        went.append("ends")

    def load() -> Starlette:
        went.append("loads")
        assert may_load.wait(10)
        return app("whole", "/", "/ask", lifespan=life)

    with (
        TestClient(Opening(PAGES, lambda: went.append("prepares"), load)) as client,
        ThreadPoolExecutor(1) as beside,
    ):
        assert client.get("/").text == "page"
        assert client.get("/page/mall/points").text == "page"
        asked = beside.submit(client.get, "/ask")
        with pytest.raises(TimeoutError):
            asked.result(0.3)
        may_load.set()
        assert asked.result(10).text == "whole"
        assert client.get("/").text == "whole"
        assert went == ["prepares", "loads", "begins"]
    assert went == ["prepares", "loads", "begins", "ends"]


@pytest.mark.parametrize("fails", ["load", "begin"])
def test_what_cannot_be_loaded_is_said_and_the_page_stays(fails: str, caplog: pytest.LogCaptureFixture) -> None:
    @asynccontextmanager
    async def life(whole: Starlette) -> AsyncIterator[None]:
        raise OSError("no room for processes")
        yield

    def load() -> Starlette:
        if fails == "load":
            raise OSError("no room for processes")
        return app("whole", "/ask", lifespan=life)

    with TestClient(Opening(PAGES, lambda: None, load)) as client:
        answer = client.get("/ask")
        assert answer.status_code == 503
        assert answer.headers["content-type"] == "application/problem+json"
        assert client.get("/").text == "page"
    assert "no room for processes" in caplog.text


def test_a_server_that_is_ended_while_it_loads_ends() -> None:
    loaded = threading.Event()

    def load() -> Starlette:
        loaded.wait(0.5)
        return app("whole", "/ask")

    with TestClient(Opening(PAGES, lambda: None, load)) as client:
        assert client.get("/").text == "page"
