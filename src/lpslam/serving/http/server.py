"""A server at an address: bound before anything slow is done, and ended in order."""

import asyncio
import contextlib
import ipaddress
import logging
import socket
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import uvicorn
from starlette.types import ASGIApp
from uvicorn.protocols.http.h11_impl import H11Protocol

from lpslam.config import ServingConfig
from lpslam.errors import UserError
from lpslam.serving.http.shield import HEAD_BYTES

_FAREWELL_S = 2  # seconds that open requests have when the server ends
_KEEP_ALIVE_S = 15  # seconds between two requests of a connection
_BACKLOG = 512


@dataclass(frozen=True, slots=True)
class Address:
    """Where a server listens.

    Attributes:
        host: a name or an address of this machine.
        port: 0 for any that is free.
        certificate, key: files for TLS; plain HTTP without.
    """

    host: str = "127.0.0.1"
    port: int = 8765
    certificate: Path | None = None
    key: Path | None = None

    @property
    def is_loopback(self) -> bool:
        """Whether only this machine can reach it."""
        if self.host.lower() == "localhost":
            return True
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return False


def bound(address: Address) -> socket.socket:
    """A socket that listens there.

    Raises:
        UserError: the port is taken, or the host is none of this machine's.
    """
    try:
        family, _, _, _, place = socket.getaddrinfo(address.host, address.port, type=socket.SOCK_STREAM)[0]
        # With the protocol's number asyncio knows it for TCP, and sends what there is at once.
        listening = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        try:
            # A port that a server has just left is free at once.
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listening.bind(place)
            listening.listen(_BACKLOG)
        except OSError:
            listening.close()
            raise
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UserError(
            f"{address.host} port {address.port} cannot be listened at ({reason}); give another with --port, "
            "or --port 0 for any that is free"
        ) from error
    return listening


def url_of(listening: socket.socket, address: Address) -> str:
    """How the server is reached from this machine."""
    port = listening.getsockname()[1]
    host = f"[{address.host}]" if ":" in address.host else address.host
    return f"{'https' if address.certificate else 'http'}://{host}:{port}"


def run(
    app: ASGIApp,
    listening: socket.socket,
    address: Address,
    limits: ServingConfig,
    on_ready: Callable[[], None] = lambda: None,
) -> None:
    """Serve until interrupted.

    Raises:
        UserError: the certificate or its key cannot be read.
    """
    # Invalid requests and connections that break are no news, and a flood of them no reason to fill a disk, or a pipe
    # that nobody reads, which would hold up the server.
    for name in ("uvicorn.error", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    config = uvicorn.Config(
        app,
        http=_protocol(limits.request_s),
        log_config=None,
        access_log=False,
        server_header=False,
        # Nobody is believed to be somebody else.
        proxy_headers=False,
        limit_concurrency=limits.connections,
        timeout_keep_alive=_KEEP_ALIVE_S,
        timeout_graceful_shutdown=_FAREWELL_S,
        h11_max_incomplete_event_size=HEAD_BYTES,
        ws_max_size=limits.body_bytes,
        lifespan="on",
        ssl_certfile=address.certificate,
        ssl_keyfile=address.key,
    )
    try:
        config.load()
    except OSError as error:
        raise UserError(f"--certificate or --key cannot be used ({error.strerror or error})") from error
    server = _Server(config, on_ready)
    # Where it cannot begin, uvicorn ends the program; what is said of that is below.
    with contextlib.suppress(KeyboardInterrupt, SystemExit):
        asyncio.run(server.serve(sockets=[listening]))
    if not server.started:
        raise UserError("the server could not be started; what was wrong is said above")


class _Server(uvicorn.Server):
    """Says when it is ready."""

    def __init__(self, config: uvicorn.Config, on_ready: Callable[[], None]) -> None:
        super().__init__(config)
        self._on_ready = on_ready

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Begin to listen."""
        await super().startup(sockets)
        if self.started:
            self._on_ready()


def _protocol(patience: float) -> type[H11Protocol]:
    """HTTP/1.1 whose connections end when no whole request head comes within `patience` seconds."""

    class Patient(H11Protocol):
        _timer: asyncio.TimerHandle | None = None

        def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
            super().connection_made(transport)
            self._watch()

        def data_received(self, data: bytes) -> None:
            super().data_received(data)
            self._watch()

        def connection_lost(self, exc: Exception | None) -> None:
            self._stop()
            super().connection_lost(exc)

        def _is_waiting(self) -> bool:
            return self.cycle is None or self.cycle.response_complete

        def _watch(self) -> None:
            if not self._is_waiting():
                self._stop()
            elif self._timer is None:
                self._timer = self.loop.call_later(patience, self._give_up)

        def _stop(self) -> None:
            if self._timer is not None:
                self._timer.cancel()
                self._timer = None

        def _give_up(self) -> None:
            self._timer = None
            # A connection that has become a web socket is another protocol's.
            transport: Any = self.transport
            if self._is_waiting() and transport.get_protocol() is self:
                transport.close()

    return Patient
