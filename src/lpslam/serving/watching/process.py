"""The process that serves the page of a growing map: the run tells it by a pipe, browsers ask it over loopback."""

import asyncio
import contextlib
import os
import signal
import sys
import threading
from typing import BinaryIO

from lpslam.errors import LpSlamError
from lpslam.priority import READING, yield_to_others
from lpslam.serving.watching.wire import Begin, receive


def main() -> None:
    """Serve until the run ends or is gone."""
    # Ctrl-C is the run's: it says when it ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    yield_to_others(READING)
    messages = sys.stdin.buffer
    replies = os.fdopen(os.dup(sys.stdout.fileno()), "wb", buffering=0)
    # What else is printed must not come between replies.
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    begin = receive(messages)
    if not isinstance(begin, Begin):
        return
    try:
        _serve(begin, messages, replies)
    except LpSlamError as error:
        _reply(replies, f"not {error}")


def _serve(begin: Begin, messages: BinaryIO, replies: BinaryIO) -> None:
    from lpslam.serving.http.server import Address, bound, run, url_of

    address = Address(port=begin.port)
    listening = bound(address)
    # Who asks from now on waits for what is loaded below; the run does not.
    _reply(replies, f"at {url_of(listening, address)}")
    with listening:
        from lpslam.serving.watching.app import Watched, build

        watched = Watched(
            begin,
            on_count=lambda count: _reply(replies, f"watchers {count}"),
            on_request=lambda said: _reply(replies, f"correct {said}"),
        )

        def ready() -> None:
            loop = asyncio.get_running_loop()
            threading.Thread(target=watched.take, args=(messages, loop), name="lpslam-told", daemon=True).start()

        run(build(watched), listening, address, begin.config.serving, ready)


def _reply(replies: BinaryIO, line: str) -> None:
    # The run may be gone; the end of its pipe says so.
    with contextlib.suppress(OSError):
        replies.write(" ".join(line.split()).encode("utf-8", "replace") + b"\n")
