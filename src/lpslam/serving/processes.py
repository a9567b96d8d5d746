"""Processes that a server starts: none is left behind, whenever the server or whoever waited for them goes."""

import asyncio
import contextlib
import os
import signal
import subprocess
from asyncio.subprocess import PIPE, Process
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

_Result = TypeVar("_Result")
_PATIENCE = 5.0
"""Seconds until a killed process is gone, where no loop waits for it any more; it takes a thousandth of one."""


async def started(
    command: list[str], env: Mapping[str, str], cwd: Path | None = None, stderr: int | None = None
) -> Process:
    """Start a process with pipes to its standard input and output, in a session of its own.

    A caller that is cancelled meanwhile is told so only when the process is gone.

    Raises:
        OSError: it cannot be started.
    """
    options: dict[str, Any] = {"env": env, "cwd": cwd, "stderr": stderr, "start_new_session": True}
    starting = asyncio.ensure_future(asyncio.create_subprocess_exec(*command, stdin=PIPE, stdout=PIPE, **options))
    try:
        return await asyncio.shield(starting)
    except asyncio.CancelledError:
        # In a task of its own, which nobody cancels: whoever waits for it may be cancelled once more.
        with contextlib.suppress(asyncio.CancelledError, OSError):
            await _to_its_end(asyncio.ensure_future(_ended_once_started(starting)))
        raise


async def _ended_once_started(starting: "asyncio.Future[Process]") -> None:
    await ended(await starting)


async def ended(process: Process) -> None:
    """End a process and all that it has started, and wait until the system has forgotten it."""
    kill(process)
    try:
        await _to_its_end(asyncio.ensure_future(process.wait()))
    finally:
        # Only with its transport closed is a process released before the loop ends; no public name leads to it.
        if (transport := getattr(process, "_transport", None)) is not None:
            child: subprocess.Popen[bytes] | None = transport.get_extra_info("subprocess")
            transport.close()
            if child is not None and child.returncode is None:
                # The loop ends, and the thread that waits for the process would tell nobody. Closing has killed it.
                with contextlib.suppress(subprocess.TimeoutExpired):
                    child.wait(_PATIENCE)


def kill(process: Process) -> None:
    """End a process and all that it has started."""
    if process.returncode is not None:
        return
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        with contextlib.suppress(ProcessLookupError):
            process.kill()


async def _to_its_end(task: "asyncio.Future[_Result]") -> _Result:
    """What a task gives; its caller is cancelled after it, not in the middle."""
    cancelled: asyncio.CancelledError | None = None
    while not task.done():
        try:
            await asyncio.shield(task)
        except asyncio.CancelledError as error:
            cancelled = error
    if cancelled is not None:
        # An error of the task has been met by whoever cancelled.
        if not task.cancelled():
            task.exception()
        raise cancelled
    return task.result()
