"""Whenever a server ends, no process that it has started is left, and none is told of when it is gone."""

import asyncio
import gc
import os
import warnings
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path

import pytest

from lpslam.config import Config
from lpslam.isolated import python_command
from lpslam.serving import processes
from lpslam.serving.answerers import AnswerLostError, ProcessAnswerer
from lpslam.serving.atlas import Atlas
from lpslam.serving.hub import Hub
from lpslam.serving.jobs.queue import Jobs
from lpslam.serving.processes import ended, started
from lpslam.serving.questions import Asked

SLEEPS = ["/bin/sleep", "600"]


def leaves_nothing(run: Callable[[], Awaitable[None]]) -> bool:
    """Whether the garbage of a loop holds no process and no pipe that is open."""

    async def whole() -> None:
        await run()

    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        asyncio.run(whole())
        gc.collect()
    return not told


async def turns(count: int) -> None:
    for _ in range(count):
        await asyncio.sleep(0)


@pytest.mark.parametrize("count", range(0, 12, 2))
def test_whoever_is_cancelled_leaves_no_process(count: int) -> None:
    async def run() -> None:
        async def use() -> None:
            process = await started(SLEEPS, dict(os.environ))
            await ended(process)
            assert process.returncode is not None

        using = asyncio.ensure_future(use())
        await turns(count)
        using.cancel()
        await turns(count // 2)
        using.cancel()
        with pytest.raises(asyncio.CancelledError):
            await using

    assert leaves_nothing(run)


def test_a_loop_that_ends_before_its_process_leaves_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """`asyncio.run` cancels every task at its end, also the one that waits; a loaded machine ends a process late."""

    async def run() -> None:
        process = await started(SLEEPS, dict(os.environ))
        ending = asyncio.ensure_future(ended(process))
        await turns(2)
        assert not ending.done()

    monkeypatch.setattr(processes, "kill", lambda process: None)
    assert leaves_nothing(run)


def test_a_process_that_cannot_be_started_is_said() -> None:
    async def run() -> None:
        with pytest.raises(OSError, match="absent"):
            await started(["/absent/program"], {})

    assert leaves_nothing(run)


@pytest.mark.parametrize("count", range(0, 14, 2))
def test_a_server_that_ends_while_a_job_starts_leaves_no_process(mall: Path, tmp_path: Path, count: int) -> None:
    async def pieces() -> AsyncIterator[bytes]:
        yield b"x" * 100

    async def unheard(served: object) -> None:
        raise AssertionError(served)

    async def run() -> None:
        config = Config()
        jobs = Jobs(tmp_path / "uploads", config, Atlas([mall], config.navigation), Hub(9, 9), unheard)
        jobs.start()
        await jobs.receive("new", "walk.zip", 100, pieces())
        await turns(count)
        closing = asyncio.ensure_future(jobs.close())
        await turns(count // 2)
        await jobs.close()
        await closing

    assert leaves_nothing(run)


@pytest.mark.slow
@pytest.mark.usefixtures("started_at_once")
def test_a_question_that_waits_while_the_server_ends_starts_no_process(mall: Path) -> None:
    async def run() -> None:
        atlas = Atlas([mall], Config().navigation)
        answerer = ProcessAnswerer(1, 400, 9, 30.0)
        await answerer.start(atlas.maps.values())
        waiting = asyncio.ensure_future(answerer.ask(Asked("pizza"), atlas.get()))
        await turns(2)
        await answerer.close()
        with pytest.raises(AnswerLostError):
            await waiting
        assert answerer.process_ids == []

    assert leaves_nothing(run)


def test_what_a_process_has_started_ends_with_it() -> None:
    async def run() -> None:
        code = (
            "import subprocess, sys; subprocess.Popen(['/bin/sleep', '600']); print('up', flush=True); sys.stdin.read()"
        )
        process = await started(python_command(code), dict(os.environ))
        assert process.stdout is not None
        assert await process.stdout.readline() == b"up\n"
        await ended(process)
        # Its pipe closes only when the last that holds it is gone.
        assert await process.stdout.read() == b""

    assert leaves_nothing(run)
