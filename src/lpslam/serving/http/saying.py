"""What is wrong, as one line of JSON (RFC 9457) with a status."""

import json
from collections.abc import Mapping
from typing import Any

from starlette.responses import Response

from lpslam.views.drawable import printable

TITLES = {
    400: "Bad request", 401: "Unauthorized", 403: "Forbidden", 404: "Not found", 405: "Method not allowed",
    408: "Request timeout", 409: "Conflict", 411: "Length required", 413: "Content too large",
    415: "Unsupported media type", 421: "Misdirected request", 422: "Unprocessable content", 429: "Too many requests",
    431: "Request header fields too large",
    500: "Internal server error", 501: "Not implemented", 503: "Service unavailable", 504: "Gateway timeout",
}  # fmt: skip


def problem(status: int, detail: str, headers: Mapping[str, str] | None = None) -> Response:
    """A response that says what is wrong."""
    body = problem_record(status, detail)
    more = dict(headers or {})
    if status == 503:
        more.setdefault("retry-after", "1")
    encoded = json.dumps(body, ensure_ascii=False).encode("utf-8", "replace")
    return Response(encoded, status, more, media_type="application/problem+json")


def problem_record(status: int, detail: str) -> dict[str, Any]:
    """What is wrong, as RFC 9457 has it."""
    title = TITLES.get(status, "Error")
    return {"type": "about:blank", "title": title, "status": status, "detail": printable(detail, longest=500)}
