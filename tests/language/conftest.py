"""The embedded model, chat servers for tests, and a cache folder and environment of a test's own."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from chat_server import Behaviour, ChatServer

from lpslam.config import LanguageConfig
from lpslam.language.hosted.chat import ChatModel
from lpslam.language.offline import OfflineModel
from lpslam.language.registry import language_model
from lpslam.language.tables.knowledge import Knowledge, load_knowledge

Serve = Callable[..., ChatServer]


@pytest.fixture(autouse=True)
def own_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    for name in ("OPENAI", "ANTHROPIC", "GOOGLE", "GEMINI", "LPSLAM_LLM", "OLLAMA"):
        for what in ("API_KEY", "BASE_URL", "HOST", "GEMINI_BASE_URL", "ORG_ID", "PROJECT_ID"):
            monkeypatch.delenv(f"{name}_{what}", raising=False)


@pytest.fixture(scope="session")
def knowledge() -> Knowledge:
    return load_knowledge()


@pytest.fixture(scope="session")
def model() -> OfflineModel:
    return OfflineModel()


@pytest.fixture
def serve() -> Iterator[Serve]:
    servers: list[ChatServer] = []

    def start(*replies: Behaviour) -> ChatServer:
        servers.append(ChatServer(*replies))
        return servers[-1]

    yield start
    for server in servers:
        server.close()


@pytest.fixture
def chat() -> Callable[..., ChatModel]:
    """A model at a server, that loses no time and keeps nothing unless told otherwise."""

    def at(server: ChatServer, **config: Any) -> ChatModel:
        quick = {"backoff_s": 0.0, "rest_s": 0.0, "cache": False, **config}
        model = language_model(f"{server.url}#test-model", LanguageConfig.model_validate(quick))
        assert isinstance(model, ChatModel)
        return model

    return at
