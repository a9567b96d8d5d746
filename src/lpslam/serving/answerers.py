"""Who answers questions: processes of their own for the embedded model, threads for one that is asked over a network.

The embedded model is Python from end to end, so threads would share one core, and a question that takes too long could
not be stopped.
"""

import asyncio
import contextlib
import json
import os
import pickle
import struct
from collections import OrderedDict, deque
from collections.abc import AsyncIterator, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from typing import Any, Protocol

from lpslam.errors import LpSlamError, UserError
from lpslam.isolated import python_command
from lpslam.language.model import LanguageModel
from lpslam.navigation.directory import Directory
from lpslam.serving.atlas import ServedMap
from lpslam.serving.processes import ended, kill, started
from lpslam.serving.questions import Asked, answered, understood

_HEAD = struct.Struct("<Q")
_HEAD_BYTES = 400  # of an answer, in which its map and version stand
_THREADS = 8  # questions that wait for a hosted model at once
_TRIES = 2  # processes that a question is given to before it is given up
_CODE = "from lpslam.serving.answer_process import main; main()"


class BusyError(LpSlamError):
    """More questions wait than may; the asker may come back."""


class AnswerLostError(LpSlamError):
    """A question took too long, or ended the processes that it was given to."""


class Answerer(Protocol):
    """Answers questions about served maps."""

    async def start(self, maps: Iterable[ServedMap]) -> None:
        """Make ready; the first question about these maps waits for nothing."""
        ...

    async def know(self, served: ServedMap) -> None:
        """Take a new map, or a new version of one."""
        ...

    async def ask(self, asked: Asked, served: ServedMap) -> bytes:
        """The answer as JSON.

        Raises:
            UserError: the question is empty.
            BusyError, AnswerLostError: there is none.
        """
        ...

    async def understand(self, asked: Asked) -> bytes:
        """What is understood of a question, as JSON; raises as `ask`."""
        ...

    async def close(self) -> None:
        """End."""
        ...


class ThreadAnswerer:
    """Answers in threads of this process, which share one language model.

    Args:
        language: the model.
        longest: letters of a question that are read.
        waiting: questions that may wait.
    """

    def __init__(self, language: LanguageModel, longest: int, waiting: int) -> None:
        self._language, self._longest, self._waiting = language, longest, waiting
        self._pool = ThreadPoolExecutor(_THREADS, "lpslam-answer")
        self._pending = 0

    async def start(self, maps: Iterable[ServedMap]) -> None:
        """Nothing is needed."""

    async def know(self, served: ServedMap) -> None:
        """Nothing is needed."""

    async def ask(self, asked: Asked, served: ServedMap) -> bytes:
        """As in `Answerer`."""
        return await self._run(lambda: answered(asked, served, self._language, self._longest))

    async def understand(self, asked: Asked) -> bytes:
        """As in `Answerer`."""
        return await self._run(lambda: understood(asked, self._language))

    async def close(self) -> None:
        """Leave what runs; it changes nothing."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    async def _run(self, work: Any) -> bytes:
        if self._pending >= self._waiting:
            raise BusyError("too many questions wait for an answer; ask again in a second")
        self._pending += 1
        try:
            return as_json(await asyncio.get_running_loop().run_in_executor(self._pool, work))
        finally:
            self._pending -= 1


class ProcessAnswerer:
    """Answers with the embedded model in processes of their own.

    Args:
        count: of processes.
        longest: letters of a question that are read.
        waiting: questions that may wait.
        patience: seconds after which a question that no process has taken is given up; as many after one has, that
            process is ended with it.
        kept: answers that are kept.
    """

    def __init__(self, count: int, longest: int, waiting: int, patience: float, kept: int = 0) -> None:
        self._longest, self._waiting, self._patience, self._kept = longest, waiting, patience, kept
        self._members = [_Process() for _ in range(count)]
        # A question is given to a process that answers no other: a long one holds up none but itself.
        self._turns, self._taken = asyncio.Semaphore(count), set[_Process]()
        self._pending = 0
        self._maps: dict[str, tuple[str, bytes]] = {}
        self._given: OrderedDict[tuple[str, Asked], bytes] = OrderedDict()

    @property
    def process_ids(self) -> list[int]:
        """Of the processes that run."""
        return [each.process.pid for each in self._members if each.process is not None]

    async def start(self, maps: Iterable[ServedMap]) -> None:
        """As in `Answerer`."""
        for served in maps:
            self._maps[served.name] = await asyncio.to_thread(_packed, served)
        await asyncio.gather(*(each.ready(self._maps) for each in self._members))

    async def know(self, served: ServedMap) -> None:
        """As in `Answerer`; questions that come meanwhile are answered by the version before."""
        packed = await asyncio.to_thread(_packed, served)
        self._maps = {**self._maps, served.name: packed}
        await asyncio.gather(*(each.ready(self._maps) for each in self._members))

    async def ask(self, asked: Asked, served: ServedMap) -> bytes:
        """As in `Answerer`."""
        if served.name not in self._maps:
            await self.know(served)
        # Visitors ask the same; of one version of a map, the answer is the same too.
        key = f"{served.name} {served.version}", asked
        if key in self._given:
            self._given.move_to_end(key)
            return self._given[key]
        request = {"do": "ask", "map": served.name, "longest": self._longest, "asked": asdict(asked)}
        answer = await self._call(request)
        # While a new version is on its way to the processes, the one before may have answered.
        if f'"version":"{served.version}"'.encode() in answer[:_HEAD_BYTES]:
            self._given[key] = answer
            if len(self._given) > self._kept:
                self._given.popitem(last=False)
        return answer

    async def understand(self, asked: Asked) -> bytes:
        """As in `Answerer`."""
        return await self._call({"do": "understand", "asked": asdict(asked)})

    async def close(self) -> None:
        """End the processes."""
        await asyncio.gather(*(each.close() for each in self._members))

    async def _call(self, request: dict[str, Any]) -> bytes:
        if self._pending >= self._waiting:
            raise BusyError("too many questions wait for an answer; ask again in a second")
        self._pending += 1
        try:
            body = json.dumps(request).encode()
            for _ in range(_TRIES):
                with contextlib.suppress(ConnectionError, asyncio.IncompleteReadError):
                    async with self._turn() as member:
                        await member.ready(self._maps)
                        return _opened(await member.call(body, self._patience))
                # Its process has ended; another takes the question.
        finally:
            self._pending -= 1
        raise AnswerLostError("this question ended the process that was to answer it; the others go on")

    @contextlib.asynccontextmanager
    async def _turn(self) -> AsyncIterator["_Process"]:
        """A process that answers no question, for one: whoever waits longest has the next."""
        try:
            async with asyncio.timeout(self._patience):
                await self._turns.acquire()
        except TimeoutError:
            raise AnswerLostError("too many questions came before this one; it is given up") from None
        # One that is being told of a map may be free as well.
        member = min((each for each in self._members if each not in self._taken), key=lambda each: len(each.pending))
        self._taken.add(member)
        try:
            yield member
        finally:
            self._taken.discard(member)
            self._turns.release()


class _Process:
    """One process, which answers one request after the other."""

    def __init__(self) -> None:
        self.process: asyncio.subprocess.Process | None = None
        self.pending: deque[asyncio.Future[bytes]] = deque()
        self._known: dict[str, str] = {}
        self._starting = asyncio.Lock()
        self._listening: asyncio.Task[None] | None = None
        self._is_closed = False

    async def ready(self, maps: dict[str, tuple[str, bytes]]) -> None:
        """Have it run and know these maps."""
        if self.process is not None and all(self._known.get(name) == version for name, (version, _) in maps.items()):
            return
        async with self._starting:
            if self._is_closed:
                raise ConnectionError("no more questions are answered")
            if self.process is None:
                await self._start()
            for name, (version, packed) in maps.items():
                if self._known.get(name) != version:
                    await self.call(b"map " + packed, None)
                    self._known[name] = version

    async def call(self, body: bytes, patience: float | None) -> bytes:
        """The answer to a request.

        Raises:
            ConnectionError, asyncio.IncompleteReadError: the process has ended.
            AnswerLostError: it took longer than `patience`; the process is ended.
        """
        if self.process is None or self.process.stdin is None:
            raise ConnectionError("the process has ended")
        promise: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self.pending.append(promise)
        # Both in one step: answers come in the order of the requests.
        self.process.stdin.write(_HEAD.pack(len(body)) + body)
        try:
            async with asyncio.timeout(patience):
                await self.process.stdin.drain()
                return await asyncio.shield(promise)
        except TimeoutError:
            if not promise.done() and self.pending and self.pending[0] is promise:
                await self.end()
            raise AnswerLostError("the answer took too long; it is given up") from None
        finally:
            promise.cancel()

    async def _start(self) -> None:
        # What is read from a map reaches it through the pipe alone; keys of language models are none of its business.
        kept = {key: value for key, value in os.environ.items() if not key.upper().endswith(("_KEY", "_TOKEN"))}
        process = await started(python_command(_CODE), kept)
        if self._is_closed:
            await ended(process)
            raise ConnectionError("no more questions are answered")
        self.process, self._known = process, {}
        self._listening = asyncio.create_task(self._listen(process))

    async def _listen(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None
        error: Exception = ConnectionError("the process has ended")
        try:
            while True:
                (size,) = _HEAD.unpack(await process.stdout.readexactly(_HEAD.size))
                body = await process.stdout.readexactly(size)
                promise = self.pending.popleft()
                if not promise.done():
                    promise.set_result(body)
        except (asyncio.IncompleteReadError, ConnectionError, IndexError) as met:
            error = met if isinstance(met, ConnectionError) else error
        finally:
            if self.process is process:
                self.process, self._known = None, {}
            waiting, self.pending = self.pending, deque()
            for promise in waiting:
                if not promise.done():
                    promise.set_exception(error)
                    # Whoever waited may be gone.
                    promise.exception()
            await ended(process)

    async def close(self) -> None:
        """End it for good."""
        self._is_closed = True
        await self.end()

    async def end(self) -> None:
        """End it; whoever waits for an answer of it is told."""
        if self.process is not None:
            kill(self.process)
        if self._listening is not None:
            await asyncio.shield(self._listening)


def as_json(value: dict[str, Any]) -> bytes:
    """A record in UTF-8; letters that are none become question marks."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode("utf-8", "replace")


def _packed(served: ServedMap) -> tuple[str, bytes]:
    """What an answer needs of a map: not its points."""
    known = served.directory
    return served.version, pickle.dumps((served.name, served.version, known.landmarks, known.config, served.view))


def _opened(reply: bytes) -> bytes:
    kind, body = reply[:1], reply[1:]
    if kind == b"U":
        raise UserError(body.decode())
    if kind == b"E":
        raise AnswerLostError("this question cannot be answered: it met an error in lpslam, which is logged")
    return body


def unpacked(packed: bytes) -> tuple[str, str, Directory, Any]:
    """What `_packed` made, by the process that made this one."""
    name, version, landmarks, config, view = pickle.loads(packed)
    return name, version, Directory(landmarks, config), view
