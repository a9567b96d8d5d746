"""The process that answers questions with the embedded model: requests come in by a pipe, answers go out by another."""

import gc
import json
import logging
import os
import select
import signal
import struct
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import FileIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.language.offline import embedded_model
from lpslam.navigation.directory import Directory
from lpslam.serving.answerers import as_json, unpacked
from lpslam.serving.questions import Asked, answered, understood

logger = logging.getLogger(__name__)

_HEAD = struct.Struct("<Q")
_MAP = b"map "  # how a request begins that brings one
_BUILT = object()
_FIRST = (
    "where can I buy a book next to the exit?", "哪里可以买书？", "本はどこで買えますか？", "책은 어디서 살 수 있나요?",
    "¿dónde puedo comprar un libro?", "où puis-je acheter un livre ?", "Wo kann ich hier ein Buch kaufen?",
)  # fmt: skip
"""One question in each language, whose tables are read at its first."""


@dataclass(frozen=True, slots=True, eq=False)
class _KnownMap:
    name: str
    version: str
    directory: Directory
    view: tuple[NDArray[np.float64], float]


def main() -> None:
    """Answer until the pipe is closed."""
    # Ctrl-C is the server's: it closes the pipe.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    requests = FileIO(sys.stdin.fileno(), closefd=False)
    # What else is printed must not come between answers.
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    maps: dict[str, _KnownMap] = {}
    preparations: Iterator[None] = iter(())
    while (request := _asked_next(requests, preparations)) is not None:
        try:
            reply = b"J" + _reply(request, maps)
            if request.startswith(_MAP):
                preparations = _preparations(list(maps.values()))
        except UserError as error:
            reply = b"U" + str(error).encode("utf-8", "replace")
        except Exception:
            logger.exception("a question met an error")
            reply = b"E"
        answers.write(_HEAD.pack(len(reply)) + reply)
        answers.flush()


def _asked_next(requests: FileIO, preparations: Iterator[None]) -> bytes | None:
    """The next request; None after the last. Until it comes, what later ones need is built."""
    while not select.select([requests], [], [], 0)[0]:
        if next(preparations, _BUILT) is _BUILT:
            break
    head = _exactly(requests, _HEAD.size)
    return None if head is None else _exactly(requests, _HEAD.unpack(head)[0])


def _exactly(requests: FileIO, size: int) -> bytes | None:
    parts: list[bytes] = []
    while size > 0:
        part = requests.read(size)
        if not part:
            return None
        parts.append(part)
        size -= len(part)
    return b"".join(parts)


def _preparations(maps: Sequence[_KnownMap]) -> Iterator[None]:
    try:
        for known in maps:
            yield from known.directory.preparations()
            yield from embedded_model().preparations(known.directory.candidates)
    except Exception:
        # Whatever a map has met here, its questions meet again, and say so.
        logger.exception("a map could not be prepared for questions")
    _keep_what_is_built()


def _keep_what_is_built() -> None:
    """None of it is garbage: the collector need not go through it again and again."""
    gc.collect()
    gc.freeze()


def _reply(request: bytes, maps: dict[str, _KnownMap]) -> bytes:
    if request.startswith(_MAP):
        name, version, directory, view = unpacked(request[len(_MAP) :])
        maps[name] = known = _KnownMap(name, version, directory, view)
        # The tables are made now, and not when the first question waits for them.
        embedded_model().scorer(known.directory.candidates)
        for first in _FIRST:
            answered(Asked(first), known, embedded_model(), len(first))
        _keep_what_is_built()
        return b"{}"
    asked = json.loads(request)
    question = Asked(**{key: _frozen(value) for key, value in asked["asked"].items()})
    if asked["do"] == "understand":
        return as_json(understood(question, embedded_model()))
    return as_json(answered(question, maps[asked["map"]], embedded_model(), asked["longest"]))


def _frozen(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
