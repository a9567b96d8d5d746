"""What stands before every route: hosts, origins, tokens, rates, sizes, and headers of every response."""

import asyncio
import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import ceil
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from lpslam.config import ServingConfig
from lpslam.serving.http.saying import problem
from lpslam.serving.rates import Rates
from lpslam.serving.tokens import SCOPES, Holder, TokenError, Tokens

logger = logging.getLogger(__name__)

POLICY = "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
"""Of responses that are no pages: a browser that shows one loads and runs nothing."""

_HEADERS = {
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "permissions-policy": "camera=(), geolocation=()",
}
_LONGEST_HOST = 255
HEAD_BYTES = 16 << 10
"""Of a request line with all its headers."""
_BETWEEN = 4  # a colon, a space and the end of the line
_EVERYBODY = Holder("", frozenset(SCOPES))


@dataclass(frozen=True, slots=True)
class Door:
    """Who is let in.

    Attributes:
        hosts: names, without ports, under which the server may be asked; a page elsewhere that gives its own name this
            server's address is refused. Empty: any.
        tokens: who has which; everybody may do everything without.
        limits: rates and sizes.
        streams: paths whose bodies may be long; their routes count them.
        public: paths for which no token is needed.
    """

    hosts: frozenset[str]
    tokens: Tokens | None
    limits: ServingConfig
    streams: frozenset[str] = frozenset()
    public: frozenset[str] = field(default_factory=lambda: frozenset({"/health"}))


class Shield:
    """ASGI middleware; `scope["holder"]` is whoever asks.

    Args:
        app: what is shielded.
        door: who is let in.
    """

    def __init__(self, app: ASGIApp, door: Door) -> None:
        limits = door.limits
        self._app, self._door = app, door
        self._rates = Rates(limits.rate, limits.burst, limits.clients)
        self._refusals = Rates(limits.refusals_a_minute / 60.0, limits.refusals_a_minute, limits.clients)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or have it answered."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if scope["type"] == "websocket":
            if refusal is None:
                await self._app(scope, receive, send)
            else:
                await send({"type": "websocket.close", "code": 1008})
            return
        guarded = _Guarded(send, lambda: self._is_still_let_in(scope))
        if refusal is not None:
            await refusal(scope, receive, guarded)
            return
        inside = receive if scope["path"] in self._door.streams else _Bounded(receive, self._door.limits)
        try:
            await self._app(scope, inside, guarded)
        except Exception as error:
            # It has been answered and logged inside, unless its answer itself has failed.
            logger.debug("%s", error, exc_info=error)
            if not guarded.has_begun:
                await problem(500, "the server met an error; it goes on")(scope, receive, guarded)

    def _refusal(self, scope: Scope) -> Response | None:
        """Why a request goes no further; None where it does, and `scope` then says whose it is."""
        headers = Headers(scope=scope)
        client = scope["client"][0] if scope.get("client") else "local"
        refusal = _too_long(scope) or self._misdirected(headers) or self._from_elsewhere(headers)
        if refusal is not None:
            return refusal
        if (wait := self._rates.wait(f"address {client}") if self._door.tokens is None else 0.0) > 0:
            return _come_back(wait)
        holder = _EVERYBODY
        if self._door.tokens is not None and scope["path"] not in self._door.public:
            found = self._holder(headers, client)
            if isinstance(found, Response):
                return found
            holder = found
        scope["holder"] = holder
        if self._door.tokens is not None:
            who = f"token {holder.name}" if holder.name else f"address {client}"
            if (wait := self._rates.wait(who)) > 0:
                return _come_back(wait)
        if scope["type"] == "http" and scope["path"] not in self._door.streams:
            length = headers.get("content-length", "0")
            if not length.isdecimal() or not length.isascii():
                return problem(400, "content-length is no number")
            if len(length) > 18 or int(length) > self._door.limits.body_bytes:
                return problem(413, _too_large(self._door.limits), {"connection": "close"})
        return None

    def _misdirected(self, headers: Headers) -> Response | None:
        """A name that leads here but is not ours: DNS was made to lie to somebody's browser."""
        hosts = headers.getlist("host")
        if len(hosts) != 1 or len(hosts[0]) > _LONGEST_HOST:
            return problem(400, "the request must name one host")
        if self._door.hosts and _host_of(hosts[0]) not in self._door.hosts:
            return problem(421, "this server is not asked under that name; see --allow-host")
        return None

    def _from_elsewhere(self, headers: Headers) -> Response | None:
        """A page of another origin has no business here: nothing is shared across origins."""
        origin = headers.get("origin")
        if origin is not None and not _same(origin, headers["host"]):
            return problem(403, "pages of other origins are not answered")
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin"):
            return problem(403, "pages of other sites are not answered")
        return None

    def _is_still_let_in(self, scope: Scope) -> bool:
        """Whether the token with which an answer has begun holds yet."""
        if self._door.tokens is None or scope["path"] in self._door.public:
            return True
        try:
            self._door.tokens.holder(_token_of(Headers(scope=scope)))
        except TokenError:
            return False
        return True

    def _holder(self, headers: Headers, client: str) -> Holder | Response:
        assert self._door.tokens is not None
        token = _token_of(headers)
        reason, challenge = "a token is needed: Authorization: Bearer TOKEN", "Bearer"
        if token:
            try:
                return self._door.tokens.holder(token)
            except TokenError as error:
                reason, challenge = str(error), 'Bearer error="invalid_token"'
        if (wait := self._refusals.wait(client)) > 0:
            return _come_back(wait)
        return problem(401, reason, {"www-authenticate": challenge})


class _Guarded:
    """Adds the headers that every response has, and ends one that goes on when whoever asked is let in no longer."""

    def __init__(self, send: Send, is_still_let_in: Callable[[], bool]) -> None:
        self._send, self._is_still_let_in = send, is_still_let_in
        self.has_begun = False

    async def __call__(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self.has_begun = True
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers.setdefault(name, value)
            # A page says itself what it may load.
            headers.setdefault("content-security-policy", POLICY)
            headers.setdefault("cache-control", "no-store")
        elif message.get("more_body") and not self._is_still_let_in():
            await self._send({"type": "http.response.body", "body": b"", "more_body": False})
            raise TokenError("the token was withdrawn, or has expired, while it was answered")
        await self._send(message)


class _Bounded:
    """Hands on a body as long as it is small and comes in time."""

    def __init__(self, receive: Receive, limits: ServingConfig) -> None:
        self._receive, self._limits = receive, limits
        self._size, self._is_whole = 0, False
        # Of the whole body: one that drips a byte at a time comes never.
        self._deadline = asyncio.get_running_loop().time() + limits.request_s

    async def __call__(self) -> Message:
        if self._is_whole:
            # What comes now is that the client is gone, whenever that may be.
            return await self._receive()
        try:
            async with asyncio.timeout_at(self._deadline):
                message = await self._receive()
        except TimeoutError:
            raise HTTPException(408, "the request has not come in time", {"connection": "close"}) from None
        if message["type"] == "http.request":
            self._size += len(message.get("body", b""))
            self._is_whole = not message.get("more_body", False)
            if self._size > self._limits.body_bytes:
                raise HTTPException(413, _too_large(self._limits), {"connection": "close"})
        return message


def _token_of(headers: Headers) -> str:
    """The token that is shown; empty without."""
    scheme, _, token = headers.get("authorization", "").partition(" ")
    return token.strip() if scheme.lower() == "bearer" else ""


def _too_large(limits: ServingConfig) -> str:
    return f"a request may have {limits.body_bytes:,} bytes"


def _too_long(scope: Scope) -> Response | None:
    """A head that came whole is as long as a read of the socket, however little is taken of one in pieces."""
    size = len(scope.get("raw_path") or b"") + len(scope.get("query_string") or b"")
    size += sum(len(name) + len(value) + _BETWEEN for name, value in scope["headers"])
    if size <= HEAD_BYTES:
        return None
    return problem(431, f"a request's line and headers may have {HEAD_BYTES:,} bytes", {"connection": "close"})


def _come_back(wait: float) -> Response:
    return problem(429, "too many requests; come back later", {"retry-after": str(max(1, ceil(wait)))})


def _host_of(value: str) -> str:
    """The name in a Host header, without its port, in small letters."""
    try:
        return (urlsplit(f"//{value}").hostname or "").lower()
    except ValueError:
        return ""


def _same(origin: str, host: str) -> bool:
    """Whether an origin is this server as it was asked; "null" is nobody's."""
    try:
        parts = urlsplit(origin)
        return parts.scheme in ("http", "https") and parts.netloc.lower() == host.lower()
    except ValueError:
        return False


def allowed_hosts(host: str, more: Iterable[str]) -> frozenset[str]:
    """Names under which a server that listens at `host` may be asked; of one that listens everywhere, any."""
    named = frozenset(each.lower() for each in more)
    if host in ("0.0.0.0", "::", ""):
        return named and named | {"localhost", "127.0.0.1", "::1"}
    return named | {host.lower(), "localhost", "127.0.0.1", "::1"}
