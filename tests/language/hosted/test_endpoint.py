"""What a specification means, whose key goes where, and what is said where something is missing."""

import subprocess
import sys
from collections.abc import Callable
from importlib.machinery import ModuleSpec

import pytest
from chat_server import ChatServer, picks

from lpslam.config import LanguageConfig
from lpslam.errors import UserError
from lpslam.language.hosted import exchange
from lpslam.language.hosted.chat import ChatModel
from lpslam.language.hosted.endpoint import Endpoint
from lpslam.language.model import Candidate
from lpslam.language.registry import language_model

MARKS = [Candidate(3, "KFC"), Candidate(8, "GUCCI")]
CONFIG = LanguageConfig(cache=False, backoff_s=0.0)

Serve = Callable[..., ChatServer]


@pytest.mark.parametrize(
    ("spec", "variables"),
    [
        ("openai:gpt-4.1-mini", "OPENAI_API_KEY"),
        ("anthropic:claude-haiku-4-5", "ANTHROPIC_API_KEY"),
        ("google:gemini-2.5-flash", "GOOGLE_API_KEY"),
    ],
)
def test_a_missing_key_names_the_variable_and_the_way_without_it(spec: str, variables: str) -> None:
    with pytest.raises(UserError, match=variables) as raised:
        language_model(spec)
    assert "leave --llm out" in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    "spec", ["gpt-4", "openai:", "ollama:", "anthropic:", "mistral:x", "http://host/v1", "#model", "ftp://host#m"]
)
def test_an_unknown_specification_says_what_there_is(spec: str) -> None:
    with pytest.raises(UserError, match="use offline, openai:MODEL, anthropic:MODEL, google:MODEL, ollama:MODEL or"):
        language_model(spec)


@pytest.mark.parametrize(
    "url", ["http://", "http://:80/v1", "http://host:port/v1", "http://ho st/v1", "https://[::1/v1"]
)
def test_an_address_that_is_none_is_refused_at_once(url: str) -> None:
    with pytest.raises(UserError, match="is no address; it should look like"):
        language_model(f"{url}#model")


def test_a_providers_key_goes_to_that_provider_alone(serve: Serve, monkeypatch: pytest.MonkeyPatch) -> None:
    server = serve(picks("KFC"))
    monkeypatch.setenv("OPENAI_API_KEY", "secret-1")
    monkeypatch.setenv("OPENAI_ORG_ID", "secret-org")
    monkeypatch.setenv("OPENAI_BASE_URL", server.url)
    model = language_model("openai:gpt-4.1-mini", CONFIG)
    assert isinstance(model, ChatModel)
    assert model.model == "openai:gpt-4.1-mini"
    assert "secret-1" not in repr(Endpoint.from_spec("openai:gpt-4.1-mini"))
    assert model.choose("chicken?", MARKS).landmark == 3
    monkeypatch.delenv("OPENAI_BASE_URL")
    at_url = f"{server.url}#test"
    assert language_model(at_url, CONFIG).choose("chicken?", MARKS).landmark == 3
    monkeypatch.setenv("LPSLAM_LLM_API_KEY", "secret-2")
    assert language_model(at_url, CONFIG).choose("chicken?", MARKS).landmark == 3
    monkeypatch.setenv("OLLAMA_HOST", server.address.removeprefix("http://"))
    assert language_model("ollama:qwen3:4b", CONFIG).choose("chicken?", MARKS).landmark == 3
    assert server.keys == ["Bearer secret-1", "Bearer none", "Bearer secret-2", "Bearer none"]
    assert server.requests[-1]["model"] == "qwen3:4b"
    assert server.paths == ["/v1/chat/completions"] * 4


@pytest.mark.parametrize(
    ("spec", "key", "library", "extra"),
    [
        ("http://localhost/v1#m", "", "openai", "llm"),
        ("openai:m", "OPENAI_API_KEY", "pydantic_ai", "llm"),
        ("anthropic:m", "ANTHROPIC_API_KEY", "anthropic", "anthropic"),
        ("google:m", "GEMINI_API_KEY", "google.genai", "google"),
    ],
)
def test_a_missing_part_names_the_extra(
    monkeypatch: pytest.MonkeyPatch, spec: str, key: str, library: str, extra: str
) -> None:
    def find_spec(name: str) -> ModuleSpec | None:
        return None if name == library else ModuleSpec(name, None)

    if key:
        monkeypatch.setenv(key, "k")
    monkeypatch.setattr(exchange, "find_spec", find_spec)
    with pytest.raises(UserError, match=rf"pip install 'lp-slam\[{extra}\]'"):
        language_model(spec)


def test_making_a_model_loads_no_client_and_asking_offline_neither() -> None:
    script = """
import sys
from lpslam.language.model import Candidate
from lpslam.language.registry import language_model
language_model("http://localhost:1/v1#any")
language_model().choose("Where can I eat?", [Candidate(1, "KFC")])
clients = {"pydantic_ai", "openai", "anthropic", "google.genai", "httpx", "httpx2"}
print(*(clients & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
