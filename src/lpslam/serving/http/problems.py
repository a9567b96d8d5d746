"""Which error is answered by which status; never a traceback, never a path of the server."""

import logging
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import Response

from lpslam.errors import LpSlamError, UserError
from lpslam.mapfile.export import corrections_record
from lpslam.serving.answerers import AnswerLostError, BusyError, as_json
from lpslam.serving.atlas import NoSuchMapError
from lpslam.serving.ground import NoGroundError
from lpslam.serving.http.saying import problem, problem_record
from lpslam.serving.hub import TooManyListenersError
from lpslam.serving.jobs.queue import NameTakenError, TooLargeError, TooManyJobsError
from lpslam.serving.summaries import NoSuchLandmarkError
from lpslam.text.correcting.changing import NoSuchCorrectionError
from lpslam.text.correcting.corrections import Corrections

logger = logging.getLogger(__name__)

# The first that an error is counts.
_STATUS: tuple[tuple[type[LpSlamError], int], ...] = (
    (NoSuchMapError, 404),
    (NoSuchLandmarkError, 404),
    (NoSuchCorrectionError, 404),
    (NoGroundError, 501),
    (NameTakenError, 409),
    (TooLargeError, 413),
    (TooManyJobsError, 503),
    (TooManyListenersError, 503),
    (BusyError, 503),
    (AnswerLostError, 504),
    (UserError, 422),
)


def conflict(detail: str, now: Corrections) -> Response:
    """A response to who was late with a correction: what is wrong, and what there is now."""
    encoded = as_json(problem_record(409, detail) | corrections_record(now))
    return Response(encoded, 409, media_type="application/problem+json")


def handle_problems(app: FastAPI) -> None:
    """Have every error of an application answered so."""

    async def of_http(request: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)
        return problem(error.status_code, str(error.detail), error.headers)

    async def of_input(request: Request, error: Exception) -> Response:
        assert isinstance(error, RequestValidationError)
        return problem(422, _first_fault(error.errors()))

    async def of_lpslam(request: Request, error: Exception) -> Response:
        return problem(next((code for kind, code in _STATUS if isinstance(error, kind)), 500), str(error))

    async def of_the_server(request: Request, error: Exception) -> Response:
        logger.error("%s met %s: %s", request.scope["path"], type(error).__name__, error, exc_info=error)
        return problem(500, "the server met an error, which is logged; it goes on")

    app.add_exception_handler(HTTPException, of_http)
    app.add_exception_handler(RequestValidationError, of_input)
    app.add_exception_handler(LpSlamError, of_lpslam)
    app.add_exception_handler(Exception, of_the_server)


def _first_fault(faults: Any) -> str:
    """The first thing that is wrong with an input; what was sent is not sent back."""
    if not faults:
        return "the request is not as the schema says"
    first = faults[0]
    where = ".".join(str(part)[:60] for part in first.get("loc", ())[:4])
    return f"{where}: {first.get('msg', 'is wrong')}"
