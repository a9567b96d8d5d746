"""Anthropic's and Google's own protocols, against doubles of their servers."""

import json
from collections.abc import Callable
from importlib.util import find_spec

import pytest
from chat_server import Behaviour, ChatServer, Json, Reply, fails

from lpslam.config import LanguageConfig
from lpslam.errors import UserError
from lpslam.language.hosted.usage import usage_of
from lpslam.language.model import Candidate
from lpslam.language.registry import language_model

Serve = Callable[..., ChatServer]

SPECS = [
    pytest.param("anthropic:claude-haiku-4-5", id="anthropic"),
    pytest.param("google:gemini-2.5-flash", id="google"),
]
MARKS = [Candidate(3, "KFC"), Candidate(8, "Zebra Quux")]


def knows(tree: Json) -> Json:
    sure = {"confidence": 0.9, "evidence": "it is so"}
    if "sign" in tree:
        return {"answer": tree["sign"] == "KFC", **sure}
    if "place" in tree:
        return {"serves": True, **sure}
    label = next(mark["id"] for mark in tree["landmarks"] if mark["name"] == "Zebra Quux")
    return {"landmark": label, "alternatives": [], **sure}


def anthropic(body: Json) -> Reply:
    content = body["messages"][0]["content"]
    tree = json.loads(content if isinstance(content, str) else content[0]["text"])
    answer: Json = {"type": "text", "text": json.dumps(knows(tree))}
    if "tools" in body:
        answer = {"type": "tool_use", "id": "t", "name": body["tools"][0]["name"], "input": knows(tree)}
    message = {
        "id": "m", "type": "message", "role": "assistant", "model": body["model"], "content": [answer],
        "stop_reason": "end_turn", "stop_sequence": None, "usage": {"input_tokens": 50, "output_tokens": 10},
    }  # fmt: skip
    return Reply(200, json.dumps(message))


def google(body: Json) -> Reply:
    tree = json.loads(body["contents"][0]["parts"][0]["text"])
    content = {"role": "model", "parts": [{"text": json.dumps(knows(tree))}]}
    usage = {"promptTokenCount": 50, "candidatesTokenCount": 10, "totalTokenCount": 60}
    candidates = [{"content": content, "finishReason": "STOP", "index": 0}]
    return Reply(200, json.dumps({"candidates": candidates, "usageMetadata": usage, "modelVersion": "g"}))


@pytest.fixture(autouse=True)
def keys(monkeypatch: pytest.MonkeyPatch) -> None:
    if find_spec("anthropic") is None or find_spec("google") is None:
        pytest.skip("the optional parts [anthropic] and [google] are not installed")
    monkeypatch.setenv("ANTHROPIC_API_KEY", "secret")
    monkeypatch.setenv("GEMINI_API_KEY", "secret")


@pytest.fixture
def at(serve: Serve, monkeypatch: pytest.MonkeyPatch) -> Callable[..., ChatServer]:
    def start(*replies: Behaviour) -> ChatServer:
        server = serve(*replies)
        monkeypatch.setenv("ANTHROPIC_BASE_URL", server.address)
        monkeypatch.setenv("GOOGLE_GEMINI_BASE_URL", server.address)
        return server

    return start


@pytest.mark.parametrize("spec", SPECS)
def test_right_answers_come_through(at: Serve, spec: str) -> None:
    server = at(anthropic if spec.startswith("anthropic") else google)
    model = language_model(spec, LanguageConfig(cache=False))
    choice = model.choose("I want a quux", MARKS)
    assert (choice.landmark, choice.model) == (8, spec)
    assert [each.answer for each in model.judge(["KFC", "DANGER"], "Is this a shop?")] == [True, False]
    usage = usage_of(model)
    assert usage is not None
    assert (usage.calls, usage.tokens) == (len(server.requests), 60 * len(server.requests))
    assert all("secret" in (key or "") for key in server.keys)


@pytest.mark.parametrize("spec", SPECS)
def test_a_refused_schema_is_asked_for_in_other_ways(at: Serve, spec: str) -> None:
    right = anthropic if spec.startswith("anthropic") else google

    def picky(body: Json) -> Reply:
        if "output_config" in body or "tools" in body or "responseMimeType" in body.get("generationConfig", {}):
            return Reply(400, '{"error": {"message": "unknown field"}}')
        return right(body)

    server = at(picky)
    model = language_model(spec, LanguageConfig(cache=False))
    assert model.choose("I want a quux", MARKS).landmark == 8
    assert len(server.requests) == 4, "schema and tools are refused once, then both questions are put plainly"


@pytest.mark.parametrize("spec", SPECS)
@pytest.mark.parametrize(
    ("status", "body"),
    [(401, "{}"), (404, "{}"), (400, '{"error": {"code": 400, "message": "API key not valid.", "status": "X"}}')],
)
def test_a_users_mistake_is_one_line(at: Serve, spec: str, status: int, body: str) -> None:
    server = at(fails(status, body))
    with pytest.raises(UserError, match=spec) as raised:
        language_model(spec, LanguageConfig(cache=False)).choose("I want a quux", MARKS)
    assert "\n" not in str(raised.value)
    assert "secret" not in str(raised.value)
    assert len(server.requests) == 1


@pytest.mark.parametrize("spec", SPECS)
@pytest.mark.parametrize("fault", [fails(529), fails(429), lambda _: Reply(200, "<html>"), lambda _: Reply(200, "{}")])
def test_a_fault_is_answered_by_the_embedded_model(at: Serve, spec: str, fault: Behaviour) -> None:
    server = at(fault)
    model = language_model(spec, LanguageConfig(cache=False, backoff_s=0.0, rest_s=0.0, attempts=2))
    choice = model.choose("Where can I eat chicken?", MARKS)
    assert (choice.landmark, choice.model) == (3, f"offline (instead of {spec})")
    assert len(server.requests) <= 2, "the provider's library does not try again beside the exchange"
