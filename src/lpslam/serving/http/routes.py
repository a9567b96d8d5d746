"""Maps, landmarks, questions, goals and events over HTTP."""

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, Query, Request
from starlette.exceptions import HTTPException
from starlette.responses import Response, StreamingResponse

from lpslam._version import __version__
from lpslam.errors import LpSlamError, UserError
from lpslam.language.questions.phrasing import answer_language
from lpslam.navigation.places import FARTHEST
from lpslam.serving import records
from lpslam.serving.answerers import as_json
from lpslam.serving.atlas import ServedMap
from lpslam.serving.filters import Filter, Judged, listed
from lpslam.serving.ground import Start
from lpslam.serving.http.asking import asked_of
from lpslam.serving.http.services import Services
from lpslam.serving.hub import Event
from lpslam.serving.questions import Asked
from lpslam.serving.summaries import landmark_of, summary
from lpslam.text.types import Landmark

_EVENTS = "text/event-stream"


def needs(scope: Literal["read", "ask", "map", "write"]) -> Any:
    """A dependency: whoever asks must hold this scope."""

    # A coroutine: a plain function would be sent to a thread, with every request.
    async def check(request: Request) -> None:
        if scope not in request.scope["holder"].scopes:
            raise HTTPException(403, f"the token lacks the scope {scope}")

    return Depends(check)


MapQuery = Annotated[
    records.MapName | None, Query(alias="map", description="Its name; may be left out where one map is served.")
]
PROBLEMS: dict[int | str, dict[str, Any]] = {
    code: {"model": records.Problem, "content": {"application/problem+json": {}}}
    for code in (401, 403, 404, 413, 422, 429, 503)
}


def point_of(text: str | None, name: str) -> tuple[float, ...] | None:
    """A place in an address, "x,y" or "x,y,z" in metres.

    Raises:
        UserError: it is none.
    """
    if text is None:
        return None
    try:
        values = tuple(float(part) for part in text.split(",")) if len(text) < 100 else ()
    except ValueError:
        values = ()
    # What is no number is not within any bounds.
    if len(values) not in (2, 3) or not all(-FARTHEST <= value <= FARTHEST for value in values):
        raise UserError(f"{name}: give a place as X,Y or X,Y,Z in metres, as in {name}=1.5,-2")
    return values


def map_routes(services: Services) -> APIRouter:
    """What can be read of maps."""
    router, limits = APIRouter(responses=PROBLEMS), services.config.serving

    @router.get("/health", summary="Whether the server runs", tags=["server"])
    async def health() -> dict[str, str]:
        return {"status": "ok", "lpslam": __version__}

    @router.get("/maps", response_model=records.MapList, dependencies=[needs("read")], tags=["maps"])
    def maps() -> Response:
        """The maps that are served."""
        return _json({"maps": [summary(each, services.atlas) for each in services.atlas.maps.values()]})

    @router.get("/maps/{name}", response_model=records.MapRecord, dependencies=[needs("read")], tags=["maps"])
    def one_map(name: str) -> Response:
        """One of them."""
        return _json(summary(services.atlas.get(name), services.atlas))

    @router.get("/landmarks", response_model=records.LandmarkPage, dependencies=[needs("read")], tags=["maps"])
    def landmarks(
        map_: MapQuery = None,
        text: Annotated[str, Query(max_length=200, description="Stands on the board.")] = "",
        role: Annotated[Literal["primary", "list", "contact"] | None, Query()] = None,
        judged: Annotated[Judged | None, Query(description="By the map's current question.")] = None,
        near: Annotated[str | None, Query(description="X,Y or X,Y,Z in metres: nearest first.")] = None,
        within: Annotated[float | None, Query(ge=0, le=FARTHEST, allow_inf_nan=False)] = None,
        confidence: Annotated[float, Query(ge=0, le=1, allow_inf_nan=False, description="At least.")] = 0.0,
        page: Annotated[int, Query(ge=1, le=1_000_000)] = 1,
        size: Annotated[int, Query(ge=1, le=limits.page_size)] = limits.usual_page_size,
    ) -> Response:
        """Landmarks by id, or by distance where `near` is given; metres, map frame."""
        served, place = services.atlas.get(map_), point_of(near, "near")
        if within is not None and place is None:
            raise UserError("within: give near=X,Y too")
        found = listed(served, Filter(text, role, judged, place, within, confidence, page, size))
        head = {"map": served.name, "version": served.version, "total": found.total, "page": page, "size": size}
        return _json({**head, "landmarks": found.records})

    @router.get("/landmarks/{id_}", response_model=records.LandmarkRecord, dependencies=[needs("read")], tags=["maps"])
    def landmark(id_: int, map_: MapQuery = None) -> Response:
        """One landmark."""
        served = services.atlas.get(map_)
        mark = landmark_of(served, id_)
        return _json(served.records[served.directory.landmarks.index(mark)])

    @router.get("/map.png", response_class=Response, dependencies=[needs("read")], tags=["maps"])
    def picture(map_: MapQuery = None) -> Response:
        """The map from above."""
        return Response(services.pictures.of(services.atlas.get(map_)), media_type="image/png")

    @router.get("/grid", response_model=records.GridRecord, dependencies=[needs("read")], tags=["ways"])
    def grid_facts(map_: MapQuery = None) -> Response:
        """Where the occupancy grid lies; 501 where the map has no ground."""
        return _json(services.grounds.facts(services.atlas.get(map_)))

    @router.get("/grid.png", response_class=Response, dependencies=[needs("read")], tags=["ways"])
    def grid(map_: MapQuery = None) -> Response:
        """The occupancy grid, a pixel a cell; 501 where the map has no ground."""
        return Response(services.grounds.picture(services.atlas.get(map_)), media_type="image/png")

    @router.get("/events", response_class=StreamingResponse, dependencies=[needs("read")], tags=["server"])
    async def events(request: Request) -> Response:
        """Server-sent events: `map` when one is new or replaced, `job` when one goes on, `missed` when too slow."""
        last = request.headers.get("last-event-id", "")
        after = int(last) if last.isascii() and last.isdecimal() and len(last) < 16 else None
        heard = services.hub.listen(after, limits.heartbeat_s)
        return StreamingResponse(_as_events(heard), media_type=_EVENTS)

    return router


def question_routes(services: Services) -> APIRouter:
    """Questions, goals and ways."""
    router = APIRouter(responses=PROBLEMS, dependencies=[needs("ask")])

    @router.post("/ask", response_model=records.AnswerEnvelope, tags=["questions"])
    async def ask(body: records.Question, request: Request) -> Response:
        """A place that serves; with `Accept: text/event-stream`, first what was understood, then the answer."""
        served, asked = services.atlas.get(body.map), asked_of(body, services.config.serving.question_letters)
        if _EVENTS in request.headers.get("accept", ""):
            return StreamingResponse(_steps(services, asked, served), media_type=_EVENTS)
        return Response(await services.answerer.ask(asked, served), media_type="application/json")

    @router.post("/goal", response_model=records.GoalRecord, tags=["ways"])
    async def goal(body: records.Destination) -> Response:
        """Where to stand before a landmark; 501 where the map has no ground."""
        served, marks, start, _ = await _destination(services, body)
        return _json(await asyncio.to_thread(services.grounds.goal, served, marks[-1], start))

    @router.post("/path", response_model=records.PathRecord, tags=["ways"])
    async def path(body: records.Destination) -> Response:
        """The way there, through all stops of a plan; 501 where the map has no ground."""
        served, marks, start, language = await _destination(services, body)
        return _json(await asyncio.to_thread(services.grounds.path, served, marks, start, language))

    return router


async def _destination(
    services: Services, body: records.Destination
) -> tuple[ServedMap, list[Landmark], Start | None, str]:
    """Where to, one after the other, from where, and the language of who asks; not where a map has no ground."""
    served = services.atlas.get(body.map)
    if not services.grounds.has(served):
        services.grounds.facts(served)
    if (body.landmark is None) == (body.question is None):
        raise UserError("give either a landmark or a question")
    start = None if body.position is None else (tuple(body.position), body.heading)
    language, stops = body.language or answer_language(body.question or ""), body.via
    if body.landmark is not None:
        stops = [*stops, body.landmark]
    else:
        asked = asked_of(body, services.config.serving.question_letters)
        answer = json.loads(await services.answerer.ask(asked, served))["answer"]
        if answer["landmark"] is None:
            raise UserError(f"nothing in this map serves that: {answer['choice']['evidence']}")
        planned = [stop for stop in answer["stops"][:-1] if stop is not None]
        stops = [*stops, *planned, answer["landmark"]["id"]]
    return served, [landmark_of(served, stop) for stop in stops], start, language


async def _steps(services: Services, asked: Asked, served: ServedMap) -> AsyncIterator[bytes]:
    """What was understood, then the answer; whatever goes wrong is an event too."""
    try:
        yield _event("understood", await services.answerer.understand(asked))
        yield _event("answer", await services.answerer.ask(asked, served))
    except LpSlamError as error:
        yield _event("problem", as_json({"detail": str(error)}))


async def _as_events(heard: AsyncIterator[Event | None]) -> AsyncIterator[bytes]:
    try:
        yield b": connected\n\n"
        async for event in heard:
            yield b": alive\n\n" if event is None else _event(event.kind, as_json(event.data), event.id)
    except LpSlamError as error:
        yield _event("problem", as_json({"detail": str(error)}))


def _event(kind: str, data: bytes, id_: int | None = None) -> bytes:
    """An event; JSON is one line, whatever signs say."""
    head = b"" if id_ is None else b"id: %d\n" % id_
    return head + b"event: " + kind.encode() + b"\ndata: " + data + b"\n\n"


def _json(value: dict[str, Any]) -> Response:
    return Response(as_json(value), media_type="application/json")
