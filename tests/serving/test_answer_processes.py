"""Questions answered in processes of their own: as in this one, and on when a process ends or hangs."""

import asyncio
import json
import os
import signal
from collections.abc import Awaitable, Callable, Iterator
from io import FileIO
from pathlib import Path

import pytest

from lpslam.config import NavigationConfig
from lpslam.errors import UserError
from lpslam.language.offline import OfflineModel
from lpslam.serving.answer_process import _asked_next
from lpslam.serving.answerers import AnswerLostError, BusyError, ProcessAnswerer, ThreadAnswerer
from lpslam.serving.atlas import Atlas
from lpslam.serving.questions import Asked
from small_maps import small_map

QUESTIONS = ("Where can I eat pizza?", "哪里可以买书？", "a place that sells aeroplanes")


def with_processes(
    path: Path,
    use: Callable[[ProcessAnswerer, Atlas], Awaitable[None]],
    waiting: int = 64,
    patience: float = 120.0,
    kept: int = 0,
    processes: int = 1,
) -> None:
    async def run() -> None:
        # A threshold that is not the default's reaches the processes.
        atlas = Atlas([path], NavigationConfig(alternatives=1))
        answerer = ProcessAnswerer(processes, 400, waiting, patience, kept)
        await answerer.start(atlas.maps.values())
        try:
            await use(answerer, atlas)
        finally:
            await answerer.close()
        assert answerer.process_ids == []

    asyncio.run(run())


@pytest.mark.slow
def test_they_answer_as_threads_do_and_survive_what_happens(
    mall: Path, model: OfflineModel, request: pytest.FixtureRequest
) -> None:
    asked = [Asked(question, position=(1.0, 2.0), heading=45.0) for question in QUESTIONS]

    async def use(answerer: ProcessAnswerer, atlas: Atlas) -> None:
        served, threads = atlas.get(), ThreadAnswerer(model, 400, 64)
        alone = [await threads.ask(each, served) for each in asked]
        assert list(await asyncio.gather(*(answerer.ask(each, served) for each in asked * 2))) == alone * 2
        assert max(len(json.loads(each)["answer"]["alternatives"]) for each in alone) == 1
        assert await answerer.understand(asked[0]) == await threads.understand(asked[0])
        with pytest.raises(UserError, match="empty"):
            await answerer.ask(Asked("  "), served)
        request.getfixturevalue("started_at_once")
        # It is ended: the next questions begin another one.
        for process in answerer.process_ids:
            os.kill(process, signal.SIGKILL)
        assert list(await asyncio.gather(*(answerer.ask(each, served) for each in asked))) == alone
        # The other is ended while it answers.
        running = asyncio.gather(*(answerer.ask(each, served) for each in asked * 4))
        await asyncio.sleep(0.01)
        os.kill(answerer.process_ids[0], signal.SIGKILL)
        assert list(await running) == alone * 4
        # A map that is replaced is known to it.
        small_map(["Bakery"]).save(mall)
        (new,) = atlas.refresh()
        await answerer.know(new)
        answers = await asyncio.gather(*(answerer.ask(Asked("bakery"), new) for _ in range(4)))
        assert [json.loads(each)["answer"]["landmark"]["name"] for each in answers] == ["Bakery"] * 4

    with_processes(mall, use)


@pytest.mark.slow
@pytest.mark.usefixtures("started_at_once")
def test_one_that_hangs_is_given_up_and_too_many_questions_are_refused(mall: Path) -> None:
    async def use(answerer: ProcessAnswerer, atlas: Atlas) -> None:
        served = atlas.get()
        await answerer.ask(Asked("pizza"), served)
        for process in answerer.process_ids:
            os.kill(process, signal.SIGSTOP)
        hanging = [asyncio.ensure_future(answerer.ask(Asked("pizza"), served)) for _ in range(4)]
        await asyncio.sleep(0.05)
        with pytest.raises(BusyError):
            await answerer.ask(Asked("pizza"), served)
        done = await asyncio.gather(*hanging, return_exceptions=True)
        assert any(isinstance(each, AnswerLostError) for each in done)
        assert json.loads(await answerer.ask(Asked("pizza"), served))["answer"]["landmark"]["id"] == 1000

    with_processes(mall, use, waiting=4, patience=3.0)


@pytest.mark.slow
@pytest.mark.usefixtures("started_at_once")
def test_who_asks_the_same_gets_the_same_until_the_map_is_another(mall: Path) -> None:
    async def use(answerer: ProcessAnswerer, atlas: Atlas) -> None:
        served, asked = atlas.get(), Asked("something to eat", position=(0.0, 0.0))
        first = await answerer.ask(asked, served)
        stopped = answerer.process_ids
        for process in stopped:
            os.kill(process, signal.SIGSTOP)
        # No process is needed for what is known, and another place is another question.
        assert await answerer.ask(asked, served) == first
        for process in stopped:
            os.kill(process, signal.SIGCONT)
        elsewhere = await answerer.ask(Asked("something to eat", position=(28.0, 0.0)), served)
        assert json.loads(elsewhere)["answer"]["landmark"]["name"] == "KFC" != json.loads(first)["answer"]["landmark"]
        small_map(["KFC"]).save(mall)
        (new,) = atlas.refresh()
        await answerer.know(new)
        assert json.loads(await answerer.ask(asked, new))["version"] == new.version != served.version
        # More than are kept push out the oldest.
        for number in range(5):
            await answerer.ask(Asked(f"shop {number}"), new)
        assert json.loads(await answerer.ask(asked, new))["answer"]["landmark"]["name"] == "KFC"

    with_processes(mall, use, kept=3)


@pytest.mark.usefixtures("started_at_once")
def test_a_question_that_takes_long_holds_up_no_other(mall: Path) -> None:
    async def use(answerer: ProcessAnswerer, atlas: Atlas) -> None:
        slow = answerer.process_ids[0]
        os.kill(slow, signal.SIGSTOP)
        try:
            asked = [asyncio.create_task(answerer.ask(Asked(f"exit {at}"), atlas.get())) for at in range(8)]
            done, left = await asyncio.wait(asked, timeout=5.0)
            while len(left) > 1 and done:
                done, left = await asyncio.wait(left, timeout=5.0)
        finally:
            os.kill(slow, signal.SIGCONT)
        assert len(left) == 1
        await asyncio.gather(*asked)

    with_processes(mall, use, processes=2)


def test_while_nobody_asks_what_later_questions_need_is_built() -> None:
    reader, writer = os.pipe()
    built = 0

    def preparations() -> Iterator[None]:
        nonlocal built
        while True:
            built += 1
            if built == 3:
                os.write(writer, (5).to_bytes(8, "little") + b"first" + (6).to_bytes(8, "little") + b"second")
            yield

    steps = preparations()
    with FileIO(reader) as requests:
        assert _asked_next(requests, steps) == b"first"
        assert _asked_next(requests, steps) == b"second"
        assert built == 3
        os.close(writer)
        assert _asked_next(requests, steps) is None
