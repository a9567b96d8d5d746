"""A chat endpoint on this machine that behaves in every way a server can."""

import json
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

Json = dict[str, Any]


@dataclass(frozen=True)
class Reply:
    """What goes over the wire: `cut` sends that many bytes of the body and hangs up, `delay` waits first (seconds)."""

    status: int
    body: str
    headers: Mapping[str, str] = field(default_factory=dict)
    delay: float = 0.0
    cut: int | None = None


Behaviour = Callable[[Json], Reply]


class ChatServer:
    """Replies in the order given; the last one repeats.

    Attributes:
        requests: the bodies that came.
        paths, keys: the same requests' paths, and their keys by whatever header.
        most_at_once: how many were being answered at the same time.
    """

    def __init__(self, *replies: Behaviour) -> None:
        self.replies = list(replies)
        self.requests: list[Json] = []
        self.paths: list[str] = []
        self.keys: list[str | None] = []
        self.most_at_once = 0
        self._at_once = 0
        self._lock = threading.Lock()
        outer = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_POST(self) -> None:
                body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
                with outer._lock:
                    outer._at_once += 1
                    outer.most_at_once = max(outer.most_at_once, outer._at_once)
                    outer.requests.append(body)
                    outer.paths.append(self.path)
                    key = self.headers.get("Authorization") or self.headers.get("x-api-key")
                    outer.keys.append(key or self.headers.get("x-goog-api-key"))
                    reply = outer.replies.pop(0) if len(outer.replies) > 1 else outer.replies[0]
                try:
                    self._send(reply(body))
                except OSError:
                    self.close_connection = True  # whoever asked has given up
                finally:
                    with outer._lock:
                        outer._at_once -= 1

            def _send(self, reply: Reply) -> None:
                time.sleep(reply.delay)
                payload = reply.body.encode()
                self.send_response(reply.status)
                self.send_header("Content-Type", "application/json")
                self.send_header("Content-Length", str(len(payload)))
                for name, value in reply.headers.items():
                    self.send_header(name, value)
                self.end_headers()
                self.wfile.write(payload if reply.cut is None else payload[: reply.cut])
                self.wfile.flush()
                self.close_connection = self.close_connection or reply.cut is not None

            def log_message(self, format: str, *args: object) -> None:
                """Say nothing."""

        self._http = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._http.daemon_threads = True
        self._thread = threading.Thread(target=self._http.serve_forever, args=(0.01,), daemon=True)
        self._thread.start()
        self.address = f"http://127.0.0.1:{self._http.server_port}"
        self.url = f"{self.address}/v1"

    def close(self) -> None:
        self._http.shutdown()
        self._http.server_close()
        self._thread.join()


def given(body: Json) -> Json:
    """What a request is about: the JSON of its user message."""
    tree: Json = json.loads(body["messages"][-1]["content"])
    return tree


def completion(content: object, usage: tuple[int, int] | None = (100, 20)) -> str:
    text = content if isinstance(content, str) else json.dumps(content, ensure_ascii=False)
    return _wrapped({"role": "assistant", "content": text}, usage)


def tool_call(arguments: object, usage: tuple[int, int] | None = (100, 20)) -> str:
    text = arguments if isinstance(arguments, str) else json.dumps(arguments, ensure_ascii=False)
    call = {"id": "call_1", "type": "function", "function": {"name": "answer", "arguments": text}}
    return _wrapped({"role": "assistant", "content": None, "tool_calls": [call]}, usage)


def _wrapped(message: Json, usage: tuple[int, int] | None) -> str:
    tree: Json = {"choices": [{"message": message}]}
    if usage is not None:
        tree["usage"] = {"prompt_tokens": usage[0], "completion_tokens": usage[1], "total_tokens": sum(usage)}
    return json.dumps(tree)


def says(content: object) -> Behaviour:
    """Answers this, whatever it is asked, in the form that it is asked for."""
    return answers(lambda _given: content)


def answers(reason: Callable[[Json], object]) -> Behaviour:
    """Answers what `reason` makes of the question, as a tool call where tools are offered."""

    def reply(body: Json) -> Reply:
        content = reason(given(body))
        return Reply(200, tool_call(content) if "tools" in body else completion(content))

    return reply


def fails(status: int, body: str = "{}", **headers: str) -> Behaviour:
    return lambda _body: Reply(status, body, {name.replace("_", "-"): value for name, value in headers.items()})


def slowly(then: Behaviour, delay: float) -> Behaviour:
    """Takes so many seconds."""
    return lambda body: replace(then(body), delay=delay)


def refusing(*fields: str, status: int = 400, then: Behaviour) -> Behaviour:
    """Refuses requests with one of these fields, as servers do that do not know them."""

    def reply(body: Json) -> Reply:
        unknown = [name for name in fields if name in body]
        return Reply(status, json.dumps({"error": f"unknown field {unknown[0]}"})) if unknown else then(body)

    return reply


def label_of(tree: Json, name: str) -> str:
    """The id under which a name was sent."""
    return str(next(mark["id"] for mark in tree["landmarks"] if mark["name"] == name))


def picks(*names: str) -> Behaviour:
    """Chooses the first of these names, with the others as alternatives; confirms them; says none without names."""

    def reason(tree: Json) -> Json:
        sure = {"confidence": 0.9, "evidence": "as told"}
        if "place" in tree:
            return {"serves": tree["place"]["name"] in names[:1], **sure}
        here = [label_of(tree, name) for name in names]
        return {"landmark": here[0] if here else "none", "alternatives": here[1:], **sure}

    return answers(reason)
