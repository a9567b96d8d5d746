"""What watchers are shown: the newest of everything, whoever they are and however slow."""

import asyncio
import time
from collections.abc import AsyncIterator
from io import BytesIO

import pytest

from lpslam.serving.watching.board import Board
from lpslam.serving.watching.pace import Pace
from lpslam.serving.watching.wire import End, send


async def take(events: AsyncIterator[bytes], count: int) -> list[bytes]:
    return [await asyncio.wait_for(anext(events), 5) for _ in range(count)]


def event(name: str, content: str) -> bytes:
    return f"event: {name}\ndata: {content}\n\n".encode()


def test_who_is_slow_gets_the_newest_and_holds_up_nobody() -> None:
    async def scenario() -> None:
        counts: list[int] = []
        board = Board(2, counts.append)
        slow, quick = board.watch(5.0, "end"), board.watch(5.0, "end")
        await take(slow, 1)
        await take(quick, 1)
        assert board.is_full
        for number in range(1000):
            board.put("state", b"%d" % number)
            assert await take(quick, 1) == [event("state", str(number))]
        board.put("signs", b"[]")
        assert await take(slow, 2) == [event("state", "999"), event("signs", "[]")]
        board.put("end", b"{}")
        assert [each async for each in slow] == [event("end", "{}")]
        await quick.aclose()
        assert counts == [1, 2, 1, 0]

    asyncio.run(scenario())


def test_who_comes_late_or_again_is_told_everything_and_silence_has_signs_of_life() -> None:
    async def scenario() -> None:
        board = Board(2)
        board.put("state", b"1")
        board.put("way", b"[]")
        board.put("state", b"2")
        for _ in range(2):
            watch = board.watch(0.01, "end")
            assert await take(watch, 4) == [
                b"retry: 1000\n\n",
                event("state", "2"),
                event("way", "[]"),
                b": alive\n\n",
            ]
            await watch.aclose()
        assert board.watchers == 0

    asyncio.run(scenario())


def test_what_costs_much_is_done_seldom() -> None:
    pace = Pace(0.0, 0.1)
    assert pace.is_due()
    with pace:
        sum(range(2_000_000))
    assert not pace.is_due()
    cheap = Pace(0.0, 1.0)
    with cheap:
        pass
    time.sleep(0.01)
    assert cheap.is_due()


def test_what_is_told_when_the_run_has_closed_the_pipe_reaches_nobody_and_is_no_error_of_the_run() -> None:
    pipe = BytesIO()
    send(pipe, End("mall.lpmap"))
    pipe.close()
    # The thread that tells gives up at this, and at nothing else.
    with pytest.raises(OSError, match="closed"):
        send(pipe, End("mall.lpmap"))
