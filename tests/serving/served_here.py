"""Servers in this process: how tests start them, and what they use."""

from collections.abc import Callable

from starlette.testclient import TestClient

from lpslam.serving.http.services import Services

Serve = Callable[..., TestClient]
SERVICES: dict[int, Services] = {}
"""What a client's server uses, by the client's `id`."""
