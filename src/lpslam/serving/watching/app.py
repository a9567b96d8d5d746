"""The page of a growing map, its events, and its questions."""

import asyncio
import json
import os
import signal
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Annotated, Any, BinaryIO

import numpy as np
from fastapi import FastAPI, Path, Query, Request
from starlette.exceptions import HTTPException
from starlette.responses import HTMLResponse, Response, StreamingResponse

from lpslam.language.registry import language_model
from lpslam.mapfile.export import corrections_record
from lpslam.page.building import growing_page, policy
from lpslam.page.record import lens_record, sign_records, way_record
from lpslam.serving import records
from lpslam.serving.answerers import ThreadAnswerer, as_json
from lpslam.serving.http.asking import asked_of
from lpslam.serving.http.problems import conflict, handle_problems
from lpslam.serving.http.saying import problem
from lpslam.serving.http.shield import Door, Shield, allowed_hosts
from lpslam.serving.watching.board import Board
from lpslam.serving.watching.grown import Grown
from lpslam.serving.watching.room import Room
from lpslam.serving.watching.wire import Begin, Corrected, End, Ground, Happened, Signs, State, receive

_FAREWELL_S = 2.0  # seconds in which watchers are told the end, and ask for the last
_PATIENCE_S = 20.0  # seconds in which the run takes a correction: it may be reading a frame
_LAST = "end"


class Watched:
    """What the page's process holds.

    Args:
        begin: what the page is of.
        on_count: called with how many watch, when that changes.
        on_request: called with what the run is to correct, as JSON.
    """

    def __init__(self, begin: Begin, on_count: Callable[[int], None], on_request: Callable[[str], None]) -> None:
        self.begin, limits = begin, begin.config.serving
        self.board = Board(limits.listeners, on_count)
        self.grown = Grown(begin.config)
        language = begin.config.language
        self.answerer = ThreadAnswerer(
            language_model(begin.llm, language), language.question_length, limits.waiting_questions
        )
        self._ask_run = on_request
        self._requests, self._pending = 0, {}  # type: int, dict[int, asyncio.Future[Corrected]]
        self.room = Room(self.grown, begin.config.serving.watching)

    def take(self, messages: BinaryIO, loop: asyncio.AbstractEventLoop) -> None:
        """Take what the run tells, in a thread, until it ends; then end this process."""

        def show(name: str, content: dict[str, Any]) -> None:
            loop.call_soon_threadsafe(self.board.put, name, as_json(content))

        ended = End("")
        self.room.start(show)
        while (message := receive(messages)) is not None:
            if isinstance(message, State):
                show("state", _state_record(message))
            elif isinstance(message, Happened):
                show("events", _events_record(message))
            elif isinstance(message, Signs):
                self.grown.take_signs(message)
                edits = corrections_record(message.corrections)
                signs = sign_records(message.landmarks)
                show("signs", {"signs": signs, "question": message.question, "edits": edits})
            elif isinstance(message, Corrected):
                loop.call_soon_threadsafe(self._settle, message)
            elif isinstance(message, Ground):
                self.grown.take_ground(message)
                show("way", {"way": way_record(message.poses), "lens": lens_record(message.camera)})
            elif isinstance(message, End):
                ended = message
                break
        self.room.finish(is_watched=self.board.watchers > 0)
        watchers = self.board.watchers
        show(_LAST, {"map": ended.map_file})
        loop.call_soon_threadsafe(lambda: asyncio.create_task(self._leave(watchers)))

    async def change(self, request: dict[str, Any]) -> Corrected:
        """Have the run take what a person said.

        Raises:
            HTTPException: it does not, in time.
        """
        self._requests += 1
        number = self._requests
        self._pending[number] = asyncio.get_running_loop().create_future()
        self._ask_run(json.dumps({**request, "request": number}))
        try:
            async with asyncio.timeout(_PATIENCE_S):
                return await self._pending[number]
        except TimeoutError:
            raise HTTPException(504, "the run has not taken it in time") from None
        finally:
            del self._pending[number]

    def _settle(self, message: Corrected) -> None:
        promise = self._pending.get(message.request)
        if promise is not None and not promise.done():
            promise.set_result(message)

    async def _leave(self, watchers: int) -> None:
        """End once the watchers know, and have asked for the last there is to see, or have had time to."""
        with suppress(TimeoutError):
            async with asyncio.timeout(_FAREWELL_S):
                while self.board.watchers or self.room.farewells < watchers:
                    await asyncio.sleep(0.02)
        os.kill(os.getpid(), signal.SIGTERM)


def build(watched: Watched) -> Shield:
    """The application of a growing map's page."""
    begin, limits = watched.begin, watched.begin.config.serving

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        yield
        await watched.answerer.close()

    app = FastAPI(title="lpslam", docs_url=None, redoc_url=None, openapi_url=None, lifespan=lifespan)
    handle_problems(app)
    text = growing_page(begin.title)

    @app.get("/")
    def page() -> Response:
        return HTMLResponse(text, headers={"content-security-policy": policy(live=True) + "; frame-ancestors 'none'"})

    @app.get("/points")
    def points(since: Annotated[int, Query(ge=0)] = 0) -> Response:
        return Response(watched.room.points(since), media_type="application/octet-stream")

    @app.get("/picture")
    async def picture(last: bool = False) -> Response:
        drawn = watched.room.picture(is_last=last)
        return Response(drawn, media_type="application/json") if drawn else Response(status_code=204)

    @app.get("/watch")
    async def watch() -> Response:
        if watched.board.is_full:
            raise HTTPException(503, "as many watch as may")
        return StreamingResponse(watched.board.watch(limits.heartbeat_s, _LAST), media_type="text/event-stream")

    @app.post("/ask")
    async def ask(body: records.Question, request: Request) -> Response:
        asked = asked_of(body, limits.question_letters)
        # Only what is asked is read of it.
        answer = await watched.answerer.ask(asked, watched.grown.known)  # type: ignore[arg-type]
        return Response(answer, media_type="application/json")

    @app.post("/corrections")
    async def correct(body: records.NewCorrection) -> Response:
        return _became(await watched.change(body.model_dump(exclude={"map"})))

    @app.delete("/corrections/{number}")
    async def take_back(number: Annotated[int, Path(ge=0, le=2**53)], revision: int) -> Response:
        return _became(await watched.change({"number": number, "revision": revision}))

    return Shield(app, Door(allowed_hosts("127.0.0.1", ()), None, limits))


def _became(corrected: Corrected) -> Response:
    """What became of a correction; who was late is told what there is now."""
    if corrected.status == 200:
        return Response(as_json(corrections_record(corrected.corrections)), media_type="application/json")
    if corrected.status == 409:
        return conflict(corrected.detail, corrected.corrections)
    return problem(corrected.status, corrected.detail)


def _events_record(happened: Happened) -> dict[str, Any]:
    """What has happened, by seconds since the first frame."""
    events = [
        {
            "kind": event.kind.value,
            "frame": event.frame,
            "seconds": round(event.timestamp - happened.start, 2),
            "reason": event.reason,
        }
        for event in happened.events
    ]
    return {"count": happened.count, "events": events}


def _state_record(state: State) -> dict[str, Any]:
    record: dict[str, Any] = {
        "frames": state.frames,
        "keyframes": state.keyframes,
        "texts": state.texts,
        "rate": round(state.rate, 1),
        "tracking": state.tracking,
        "reason": state.reason,
        "submaps": state.submaps,
        "dropped": state.dropped,
        "at": None,
    }
    if state.pose is not None and np.isfinite(state.pose).all():
        (record["at"],) = way_record(state.pose[None])
    return record
