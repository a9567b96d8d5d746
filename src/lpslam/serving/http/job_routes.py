"""Uploads of recordings over HTTP."""

from collections.abc import AsyncIterator
from dataclasses import asdict
from typing import Annotated

from fastapi import APIRouter, Query, Request
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.responses import Response

from lpslam.errors import UserError
from lpslam.serving import records
from lpslam.serving.answerers import as_json
from lpslam.serving.http.routes import PROBLEMS, needs
from lpslam.serving.http.services import Services
from lpslam.serving.jobs.queue import Job, Jobs

_BODY = {
    "required": True,
    "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
}


def job_routes(services: Services) -> APIRouter:
    """Recordings in, maps out."""
    router = APIRouter(responses=PROBLEMS, dependencies=[needs("map")], tags=["jobs"])

    @router.post("/jobs", response_model=records.JobRecord, status_code=202, openapi_extra={"requestBody": _BODY})
    async def upload(
        request: Request,
        name: Annotated[str, Query(max_length=60, description="Under which the map will be served.")],
        file: Annotated[str, Query(max_length=200, description="Its name: a zip, a tar, a bag.")] = "recording.zip",
    ) -> Response:
        """Map a recording: the body is the file itself. The job says how far it is, and /events tells."""
        length = request.headers.get("content-length")
        if length is not None and not (length.isascii() and length.isdecimal() and len(length) < 19):
            raise HTTPException(400, "content-length is no number")
        if request.headers.get("content-type", "").startswith(("multipart/", "application/x-www-form-urlencoded")):
            raise HTTPException(415, "send the file itself as the body, as application/octet-stream")
        jobs, size = _jobs(services), None if length is None else int(length)
        try:
            job = await jobs.receive(name, file, size, _pieces(request))
        except ClientDisconnect:
            raise UserError("the upload was broken off") from None
        return _record(job, 202)

    @router.get("/jobs", response_model=records.JobList)
    async def jobs() -> Response:
        """Jobs, the newest first."""
        return Response(as_json({"jobs": [asdict(job) for job in _jobs(services).listed()]}), media_type=_JSON)

    @router.get("/jobs/{id_}", response_model=records.JobRecord)
    async def one_job(id_: str) -> Response:
        """One of them."""
        return _record(_found(services, id_))

    @router.delete("/jobs/{id_}", response_model=records.JobRecord)
    async def cancel(id_: str) -> Response:
        """Give one up; a map that is made stays."""
        job = _found(services, id_)
        _jobs(services).cancel(job)
        return _record(job)

    return router


_JSON = "application/json"


def _jobs(services: Services) -> Jobs:
    if services.jobs is None:
        raise HTTPException(404, "this server takes no uploads; start it with --uploads FOLDER")
    return services.jobs


def _found(services: Services, id_: str) -> Job:
    job = _jobs(services).get(id_)
    if job is None:
        raise HTTPException(404, "there is no such job")
    return job


def _record(job: Job, status: int = 200) -> Response:
    return Response(as_json(asdict(job)), status, media_type=_JSON)


async def _pieces(request: Request) -> AsyncIterator[bytes]:
    async for piece in request.stream():
        if piece:
            yield piece
