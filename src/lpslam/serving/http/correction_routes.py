"""A person's corrections over HTTP."""

import asyncio
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query
from starlette.responses import Response

from lpslam.serving import records
from lpslam.serving.answerers import as_json
from lpslam.serving.corrections import state_of
from lpslam.serving.http.problems import conflict
from lpslam.serving.http.routes import PROBLEMS, MapQuery, needs
from lpslam.serving.http.services import Services
from lpslam.text.correcting.changing import Change, ConflictError
from lpslam.text.correcting.corrections import Kind

_Revision = Annotated[int, Query(ge=0, le=2**53 - 1, description="As /corrections gave it.")]


def correction_routes(services: Services) -> APIRouter:
    """What a person says of landmarks, kept in the maps."""
    too_late: dict[int | str, dict[str, Any]] = {
        409: {"model": records.Conflict, "content": {"application/problem+json": {}}}
    }
    router = APIRouter(responses={**PROBLEMS, **too_late}, tags=["corrections"])

    @router.get("/corrections", response_model=records.CorrectionState, dependencies=[needs("read")])
    def corrections(map_: MapQuery = None) -> Response:
        """All of a map."""
        return Response(as_json(state_of(services.atlas.get(map_))), media_type="application/json")

    @router.post("/corrections", response_model=records.CorrectionState, dependencies=[needs("write")])
    async def correct(body: records.NewCorrection) -> Response:
        """Rename, merge, hide or judge a landmark; what a person says wins over what was read."""
        change = Change(Kind(body.kind), body.landmark, body.name, body.into, body.answer)
        try:
            served = await asyncio.to_thread(services.editor.correct, body.map, change, body.revision)
        except ConflictError as error:
            return conflict(str(error), error.corrections)
        await services.on_map(served)
        return Response(as_json(state_of(served)), media_type="application/json")

    @router.delete("/corrections/{number}", response_model=records.CorrectionState, dependencies=[needs("write")])
    async def take_back(
        number: Annotated[int, Path(ge=0, le=2**53 - 1)], revision: _Revision, map_: MapQuery = None
    ) -> Response:
        """Take a correction back."""
        try:
            served = await asyncio.to_thread(services.editor.take_back, map_, number, revision)
        except ConflictError as error:
            return conflict(str(error), error.corrections)
        await services.on_map(served)
        return Response(as_json(state_of(served)), media_type="application/json")

    return router
