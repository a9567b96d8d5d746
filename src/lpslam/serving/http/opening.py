"""The page of a map at once, and all else once it is loaded: whoever opens a map wants to see it first."""

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from lpslam.serving.http.saying import problem

logger = logging.getLogger(__name__)

_PAGES = "/page/"


class Opening:
    """ASGI application: pages from the first request on; what else is asked waits for the rest.

    Args:
        pages: gives pages.
        prepare: makes the first page; called in a thread before anything else is done.
        load: gives the whole application, which gives pages too; called in the same thread.
    """

    def __init__(self, pages: ASGIApp, prepare: Callable[[], object], load: Callable[[], ASGIApp]) -> None:
        self._pages, self._prepare, self._load = pages, prepare, load
        self._whole: ASGIApp | None = None
        self._is_loaded = asyncio.Event()
        self._ends = asyncio.Event()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or have it answered."""
        if scope["type"] == "lifespan":
            return await self._live(receive, send)
        if self._whole is None and (scope["path"] == "/" or scope["path"].startswith(_PAGES)):
            return await self._pages(scope, receive, send)
        await self._is_loaded.wait()
        if self._whole is None:
            return await problem(503, "the server could not be loaded; its log says why")(scope, receive, send)
        return await self._whole(scope, receive, send)

    async def _live(self, receive: Receive, send: Send) -> None:
        await receive()
        loading = asyncio.create_task(self._run_whole())
        await send({"type": "lifespan.startup.complete"})
        await receive()
        self._ends.set()
        if self._is_loaded.is_set():
            await loading
        else:
            loading.cancel()
            with suppress(asyncio.CancelledError):
                await loading
        await send({"type": "lifespan.shutdown.complete"})

    async def _run_whole(self) -> None:
        """Load the whole application, and be its server: from its start to its end."""
        try:
            await self._be(await asyncio.to_thread(self._prepared))
        except Exception as error:
            logger.error("the server cannot be loaded, or has ended: %s", error or type(error).__name__)
        finally:
            self._is_loaded.set()

    async def _be(self, whole: ASGIApp) -> None:
        asked = iter(("lifespan.startup", "lifespan.shutdown"))

        async def receive() -> Message:
            kind = next(asked)
            if kind == "lifespan.shutdown":
                await self._ends.wait()
            return {"type": kind}

        async def send(message: Message) -> None:
            if message["type"] == "lifespan.startup.complete":
                self._whole = whole
            self._is_loaded.set()

        await whole({"type": "lifespan", "asgi": {"version": "3.0"}, "state": {}}, receive, send)

    def _prepared(self) -> ASGIApp:
        self._prepare()
        return self._load()
