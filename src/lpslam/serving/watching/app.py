"""The page of a growing map, its events, and its questions."""

import asyncio
import base64
import json
import logging
import os
import signal
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Annotated, Any, BinaryIO

import numpy as np
from fastapi import FastAPI, Path, Request
from starlette.exceptions import HTTPException
from starlette.responses import HTMLResponse, Response, StreamingResponse

from lpslam.language.registry import language_model
from lpslam.mapfile.export import corrections_record
from lpslam.page.building import growing_page, policy
from lpslam.page.pictures import RoomPicture
from lpslam.page.record import lens_record, sign_records, way_record
from lpslam.serving import records
from lpslam.serving.answerers import ThreadAnswerer, as_json
from lpslam.serving.http.asking import asked_of
from lpslam.serving.http.problems import conflict, handle_problems
from lpslam.serving.http.saying import problem
from lpslam.serving.http.shield import Door, Shield, allowed_hosts
from lpslam.serving.watching.board import Board
from lpslam.serving.watching.grown import Grown
from lpslam.serving.watching.pace import Pace
from lpslam.serving.watching.wire import Begin, Corrected, End, Ground, Happened, Signs, State, receive

logger = logging.getLogger(__name__)

_LOOK_S = 0.2  # seconds between looks at whether a new picture may be made
_LAST_PICTURE_S = 5.0  # seconds in which the last picture is made
_FAREWELL_S = 1.0  # seconds in which watchers are told the end
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
        self._is_new, self._are_points_wanted = threading.Event(), threading.Event()
        self._points = b""
        self._gone, self._has_painted = threading.Event(), threading.Event()

    def take(self, messages: BinaryIO, loop: asyncio.AbstractEventLoop) -> None:
        """Take what the run tells, in a thread, until it ends; then end this process."""

        def show(name: str, content: dict[str, Any]) -> None:
            loop.call_soon_threadsafe(self.board.put, name, as_json(content))

        ended = End("")
        threading.Thread(target=self._paint, args=(show,), name="lpslam-painting", daemon=True).start()
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
                self._is_new.set()
            elif isinstance(message, End):
                ended = message
                break
        self._gone.set()
        self._has_painted.wait(_LAST_PICTURE_S)
        show(_LAST, {"map": ended.map_file})
        loop.call_soon_threadsafe(lambda: asyncio.create_task(self._leave()))

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

    async def _leave(self) -> None:
        """End once the watchers know, or have had time to."""
        with suppress(TimeoutError):
            async with asyncio.timeout(_FAREWELL_S):
                while self.board.watchers:
                    await asyncio.sleep(0.02)
        os.kill(os.getpid(), signal.SIGTERM)

    def _paint(self, show: Callable[[str, dict[str, Any]], None]) -> None:
        """Make a picture of the room from time to time, and a last one."""
        limits = self.begin.config.serving.watching
        pace = Pace(limits.picture_s, limits.painting_share)
        # What is loaded or compiled at the first time is not what a picture costs.
        self._picture(Grown.anything(self.begin.config))
        while not self._gone.wait(_LOOK_S):
            if self._is_new.is_set() and pace.is_due():
                self._is_new.clear()
                with pace:
                    self._show_picture(show)
                    self._show_points(show)
        if self._is_new.is_set() and self.board.watchers:
            self._show_picture(show)
            self._show_points(show)
        self._has_painted.set()

    def _show_picture(self, show: Callable[[str, dict[str, Any]], None]) -> None:
        picture = self._picture(self.grown)
        if picture is not None:
            data = "data:image/png;base64," + base64.b64encode(picture.png).decode("ascii")
            show("picture", {"picture": data, "extent": [round(each, 3) for each in picture.extent]})

    def _show_points(self, show: Callable[[str, dict[str, Any]], None]) -> None:
        """Make points, where somebody has asked for some since they were made last, and say that there are new ones."""
        if not self._are_points_wanted.is_set():
            return
        self._are_points_wanted.clear()
        self._points = self.grown.points().content()
        show("points", {"bytes": len(self._points)})

    def points(self) -> bytes:
        """The room's points as they were made last; newer ones are made."""
        self._are_points_wanted.set()
        return self._points

    @staticmethod
    def _picture(grown: Grown) -> RoomPicture | None:
        try:
            return grown.picture()
        except Exception as error:
            # The page goes on without a picture.
            logger.warning("the room cannot be drawn: %s", error)
            return None


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
    def points() -> Response:
        return Response(watched.points(), media_type="application/octet-stream")

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
