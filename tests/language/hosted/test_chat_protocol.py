"""Everything that can come back from a server: in every mode right answers stay right, in no fault one is invented."""

import json
import time
from collections.abc import Callable
from typing import Any

import pytest
from chat_server import (
    Behaviour,
    ChatServer,
    Json,
    Reply,
    answers,
    completion,
    fails,
    given,
    label_of,
    refusing,
    says,
    slowly,
    tool_call,
)

from lpslam.config import LanguageConfig
from lpslam.errors import UserError
from lpslam.language.hosted.chat import ChatModel
from lpslam.language.model import Candidate, Reading
from lpslam.language.registry import language_model

Serve = Callable[..., ChatServer]
Chat = Callable[..., ChatModel]

MARKS = [Candidate(3, "KFC"), Candidate(8, "必胜客欢乐餐厅"), Candidate(11, "GUCCI"), Candidate(12, "Zebra Quux")]
SHOPS = {"KFC": True, "GUCCI": True, "DANGER": False, "小心地滑": False}
WISHES = {"Where can I eat pizza?": 8, "chicken, please": 3, "I want a quux": 12, "Where can I swim?": None}
READINGS = [Reading("Allenware", 2, 0.8), Reading("Alienvvare", 1, 0.7)]


def knows(tree: Json) -> Json:
    """A model that knows every answer of these tests."""
    sure = {"confidence": 0.9, "evidence": "it is so"}
    names = {mark.id: mark.name for mark in MARKS}
    if "readings" in tree:
        return {"name": "Alienware", **sure}
    if "sign" in tree:
        return {"answer": SHOPS[tree["sign"]], **sure}
    right = names.get(WISHES[tree["question"]] or 0)
    if "place" in tree:
        return {"serves": tree["place"]["name"] == right, **sure}
    return {"landmark": label_of(tree, right) if right else "none", "alternatives": [], **sure}


def in_words(tree: Json) -> str:
    return f"Of course! Here is my answer:\n\n```json\n{json.dumps(knows(tree), indent=2)}\n```\nHope that helps."


RIGHT = answers(knows)
MODES: dict[str, tuple[Behaviour, list[str]]] = {
    "schema": (RIGHT, ["response_format"]),
    "tools": (refusing("response_format", then=RIGHT), ["tools"]),
    "tools, refused by 422": (refusing("response_format", status=422, then=RIGHT), ["tools"]),
    "plain": (refusing("response_format", "tools", "tool_choice", "max_completion_tokens", then=RIGHT), []),
    "plain, wrapped in words": (refusing("response_format", "tools", then=answers(in_words)), []),
    "schema ignored, in words": (answers(in_words), ["response_format"]),
    "tools ignored": (
        refusing("response_format", then=lambda body: Reply(200, completion(knows(given(body))))),
        ["tools"],
    ),
    "no token counts": (lambda body: Reply(200, completion(knows(given(body)), usage=None)), ["response_format"]),
    "slowly": (slowly(RIGHT, 0.05), ["response_format"]),
}


@pytest.mark.parametrize("mode", MODES)
def test_a_model_that_answers_rightly_is_right_in_every_mode(serve: Serve, chat: Chat, mode: str) -> None:
    behaviour, fields = MODES[mode]
    server = serve(behaviour)
    model = chat(server)
    assert {wish: model.choose(wish, MARKS).landmark for wish in WISHES} == WISHES
    assert {name: each.answer for name, each in zip(SHOPS, model.judge(list(SHOPS), "Shop?"), strict=True)} == SHOPS
    named = model.name(READINGS)
    assert (named.name, named.model) == ("Alienware", f"{server.url}#test-model")
    # What was refused once is not sent again.
    asked = [name for name in ("response_format", "tools") if name in server.requests[-1]]
    assert asked == fields
    assert sum("response_format" in body for body in server.requests) in (1, len(server.requests))
    assert all("max_completion_tokens" not in body and "temperature" not in body for body in server.requests)
    assert model.usage.tokens > 0


def fields_of_nothing(body: Json) -> Reply:
    return Reply(200, json.dumps({"choices": [{"message": {"content": None}}]}))


FAULTS: dict[str, Behaviour] = {
    "429": fails(429),
    "429 with Retry-After": fails(429, Retry_After="0"),
    "429 for an hour": fails(429, Retry_After="3600"),
    "429 in odd words": fails(429, Retry_After="soon"),
    "no credit": fails(429, '{"error": {"code": "insufficient_quota"}}'),
    "500": fails(500),
    "503 as a page": fails(503, "<html>busy</html>"),
    "529": fails(529),
    "teapot": fails(418),
    "redirect to nowhere": fails(302),
    "too long": fails(413),
    "everything refused": fails(400),
    "everything refused, 422": fails(422, '{"detail": []}'),
    "too slow": slowly(RIGHT, 1.0),
    "cut off": lambda body: Reply(200, completion(knows(given(body))), cut=40),
    "cut off at once": lambda body: Reply(200, completion(knows(given(body))), cut=0),
    "half an answer": says('{"landmark": "L10'),
    "a web page": lambda body: Reply(200, "<html>Welcome</html>"),
    "no choices": lambda body: Reply(200, '{"choices": []}'),
    "null": lambda body: Reply(200, "null"),
    "a list": lambda body: Reply(200, "[1, 2]"),
    "nothing": lambda body: Reply(200, ""),
    "an empty message": fields_of_nothing,
    "an error in a 200": lambda body: Reply(200, '{"error": {"message": "overloaded"}}'),
    "prose": says("You could try the second floor, there is a nice place."),
    "ids that do not exist": says(
        {"landmark": "L9999", "alternatives": ["L9998"], "serves": True, "confidence": 1, "evidence": ""}
    ),
    "ids of the map": says({"landmark": 8, "alternatives": [3], "confidence": 1, "evidence": ""}),
    "another tool": lambda body: Reply(200, tool_call({"place": "KFC"})),
    "broken arguments": lambda body: Reply(200, tool_call('{"landmark": ')),
    "deep": says("[" * 5000 + "]" * 5000),
    "deep object": says('{"landmark":' * 3000 + "1" + "}" * 3000),
    "not a number": says('{"landmark": "L1000", "confidence": NaN, "alternatives": [NaN], "evidence": 7}'),
    "surrogates": says('{"landmark": "\\ud800", "confidence": 1, "evidence": "\\ud800"}'),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_no_landmark_is_invented_and_nothing_is_raised_under_any_fault(serve: Serve, chat: Chat, fault: str) -> None:
    server = serve(FAULTS[fault])
    model = chat(server, timeout_s=0.3, attempts=2, longest_wait_s=1.0)
    ids = {mark.id for mark in MARKS}
    instead = f"offline (instead of {server.url}#test-model)"
    started = time.monotonic()
    choice = model.choose("Where can I eat pizza?", MARKS)
    assert choice.landmark in ids
    assert set(choice.alternatives) <= ids
    if choice.model == instead:
        assert choice.landmark == 8, "the embedded model's answer"
        assert "did not answer: " in choice.evidence
        assert "\n" not in choice.evidence
    else:
        assert fault == "not a number", "only an answer that is allowed is taken"
    judged = model.judge(list(SHOPS), "Is this a shop?")
    assert [each.answer for each in judged] == list(SHOPS.values())
    assert {each.model for each in judged} == {instead}
    named = model.name(READINGS)
    assert (named.name, named.model) == ("Alienware", instead)
    assert time.monotonic() - started < 10.0


@pytest.mark.parametrize("status", [408, 429, 500, 502, 503])
def test_a_busy_server_is_asked_again(serve: Serve, chat: Chat, status: int) -> None:
    server = serve(fails(status), fails(status), RIGHT)
    model = chat(server)
    assert model.choose("chicken, please", MARKS).model.endswith("#test-model")
    assert len(server.requests) == 3
    assert model.usage.calls == 3, "attempts are paid for too"


def test_a_busy_server_is_given_the_time_that_it_asks_for(serve: Serve, chat: Chat) -> None:
    server = serve(fails(429, Retry_After="1"), RIGHT)
    started = time.monotonic()
    assert chat(server).choose("chicken, please", MARKS).landmark == 3
    assert 0.9 < time.monotonic() - started < 4.0
    server = serve(fails(429, Retry_After="3600"), RIGHT)
    assert chat(server).choose("chicken, please", MARKS).model.startswith("offline")
    assert len(server.requests) == 1, "nobody waits an hour"


def test_pauses_grow(serve: Serve, chat: Chat) -> None:
    server = serve(fails(500), fails(500), RIGHT)
    started = time.monotonic()
    chat(server, backoff_s=0.2).choose("chicken, please", MARKS)
    assert time.monotonic() - started > 0.6, "0.2 and 0.4 s"
    assert len(server.requests) == 3


def test_a_server_that_is_not_there_is_replaced_visibly(unused_port: int) -> None:
    config = LanguageConfig(attempts=2, timeout_s=2.0, backoff_s=0.0, cache=False)
    model = language_model(f"http://127.0.0.1:{unused_port}/v1#gone", config)
    choice = model.choose("Where can I eat pizza?", MARKS)
    assert choice.landmark == 8
    assert f"http://127.0.0.1:{unused_port}/v1 cannot be reached" in choice.evidence


@pytest.fixture
def unused_port(serve: Serve) -> int:
    server = serve(RIGHT)
    server.close()
    server.close = lambda: None  # type: ignore[method-assign]
    return int(server.address.rpartition(":")[2])


def test_a_silent_server_is_left_alone_for_a_while(serve: Serve, chat: Chat) -> None:
    server = serve(fails(503))
    model = chat(server, rest_s=60.0, attempts=3)
    names = [f"Shop {number}" for number in range(50)]
    judged = model.judge(names, "Is this a shop?")
    assert {each.model for each in judged} == {f"offline (instead of {server.url}#test-model)"}
    assert len(server.requests) == 3, "one question finds out; the others do not wait for it again"
    assert "left alone" in judged[-1].evidence
    server = serve(fails(503), fails(503), fails(503), RIGHT)
    model = chat(server, rest_s=0.0, attempts=3)
    assert model.choose("chicken, please", MARKS).model.startswith("offline")
    assert model.choose("chicken, please", MARKS).model.endswith("#test-model"), "it is tried again later"


@pytest.mark.parametrize(
    ("reply", "told"),
    [
        (fails(401), "the key was refused"),
        (fails(403), "the key may not use this model"),
        (fails(404), "no such model or address"),
        (fails(405), "no such model or address"),
        (
            fails(400, '{"error": {"message": "API key not valid. Please pass a valid API key."}}'),
            "the key was refused",
        ),
    ],
)
def test_a_users_mistake_is_one_line_and_is_made_once(serve: Serve, chat: Chat, reply: Behaviour, told: str) -> None:
    server = serve(reply)
    model = chat(server)
    uses: list[Callable[[], Any]] = [
        lambda: model.choose("pizza?", MARKS),
        lambda: model.judge(["A shop", "B shop"], "Is this a shop?"),
        lambda: model.name(READINGS),
    ]
    for use in uses:
        with pytest.raises(UserError, match=told) as raised:
            use()
        assert "\n" not in str(raised.value)
        assert "leave --llm out" in str(raised.value), "the offline answer is offered"
    assert len(server.requests) == 1


def test_the_budget_ends_asking_and_says_so(serve: Serve, chat: Chat) -> None:
    server = serve(RIGHT)
    model = chat(server, max_calls=2, at_once=1)
    judged = model.judge(["KFC", "GUCCI", "DANGER", "小心地滑"], "Is this a shop?")
    assert [each.answer for each in judged] == [True, True, False, False]
    assert [each.model.startswith("offline") for each in judged] == [False, False, True, True]
    assert "limit of 2 calls is reached (language.max_calls)" in judged[2].evidence
    assert len(server.requests) == 2
    model = chat(server, max_tokens=100)
    assert model.choose("chicken, please", MARKS).model.endswith("#test-model")
    second = model.choose("Where can I eat pizza?", MARKS)
    assert "limit of 100 tokens is reached (language.max_tokens)" in second.evidence
    assert (second.landmark, model.usage.calls) == (8, 1)


def test_it_works_where_an_event_loop_is_running(serve: Serve, chat: Chat) -> None:
    import asyncio

    model = chat(serve(RIGHT))

    async def notebook() -> int | None:
        return model.choose("chicken, please", MARKS).landmark

    assert asyncio.run(notebook()) == 3
