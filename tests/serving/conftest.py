"""A small map served in this process."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from served_here import SERVICES, Serve
from starlette.testclient import TestClient

from lpslam.config import Config
from lpslam.language.offline import OfflineModel
from lpslam.serving import answerers
from lpslam.serving.answerers import ThreadAnswerer
from lpslam.serving.atlas import Atlas
from lpslam.serving.http.app import build_app
from lpslam.serving.http.services import Services
from lpslam.serving.http.shield import Door, allowed_hosts
from lpslam.serving.hub import Hub
from lpslam.serving.tokens import Tokens
from small_maps import small_map

_AT_ONCE = """
from lpslam.serving import answer_process
answer_process._FIRST = answer_process._FIRST[:1]
answer_process._preparations = lambda maps: iter(())
answer_process.main()
"""


@pytest.fixture
def started_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes read the tables of one language before they are asked: half of what starting another one costs."""
    monkeypatch.setattr(answerers, "_CODE", _AT_ONCE)


@pytest.fixture
def mall(tmp_path: Path) -> Path:
    """The file of a small map."""
    path = tmp_path / "mall.lpmap"
    small_map().save(path)
    return path


@pytest.fixture(scope="session")
def model() -> OfflineModel:
    """The embedded model, made once."""
    return OfflineModel()


@pytest.fixture
def serve(mall: Path, model: OfflineModel) -> Iterator[Serve]:
    """Serves maps in this process; `serve(maps, tokens=…, uploads=…, limit=value…)` gives a client."""
    opened: list[TestClient] = []

    def start(
        *paths: Path,
        tokens: Path | None = None,
        uploads: Path | None = None,
        answerer: Any = None,
        jobs: dict[str, Any] | None = None,
        **limits: Any,
    ) -> TestClient:
        config = Config.model_validate({"serving": {**limits, "jobs": jobs or {}}})
        bounds = config.serving
        answerer = answerer or ThreadAnswerer(model, config.language.question_length, bounds.waiting_questions)
        services = Services(
            Atlas(paths or [mall]), answerer, Hub(bounds.listeners, bounds.waiting_events), config, uploads
        )
        door = Door(
            allowed_hosts("127.0.0.1", ()), Tokens(tokens) if tokens else None, bounds, streams=frozenset({"/jobs"})
        )
        client = TestClient(build_app(services, door), base_url="http://127.0.0.1:8765", raise_server_exceptions=False)
        client.__enter__()
        SERVICES[id(client)] = services
        opened.append(client)
        return client

    yield start
    for client in opened:
        client.__exit__(None, None, None)


@pytest.fixture
def client(serve: Serve) -> TestClient:
    """A client of a server without tokens."""
    return serve()
