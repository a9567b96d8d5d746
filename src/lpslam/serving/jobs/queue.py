"""Jobs, one after the other: an upload received, mapped in a process of its own, and served."""

import asyncio
import contextlib
import json
import os
import re
import secrets
import shutil
import signal
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from lpslam.config import Config
from lpslam.errors import LpSlamError, UserError
from lpslam.isolated import python_command
from lpslam.serving.atlas import Atlas, ServedMap
from lpslam.serving.hub import Hub
from lpslam.serving.jobs.running import MAP
from lpslam.serving.processes import ended, kill, started

SUFFIXES = {
    **dict.fromkeys(("zip", "tar", "tar.gz", "tgz"), ".archive"),
    **{bag: f".{bag}" for bag in ("bag", "mcap", "db3")},
}
"""What may be sent, by the end of its name, and the suffix that it is kept under."""

_NAME = re.compile(r"[A-Za-z0-9][\w.-]{0,59}", re.ASCII)
_CODE = "from lpslam.serving.jobs.running import main; main()"
_KEPT_VARIABLES = ("PATH", "LANG", "LC_ALL", "TZ", "NUMBA_CACHE_DIR", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
_MAPS, _WORK = "maps", "jobs"
_FINAL = ("done", "failed", "cancelled")


class TooManyJobsError(LpSlamError):
    """As many jobs wait as may."""


class NameTakenError(UserError):
    """A map of that name is served, or being made."""


class TooLargeError(UserError):
    """An upload is larger than it may be."""


@dataclass(slots=True)
class Job:
    """An uploaded recording, and what has become of it; see `records.JobRecord`."""

    id: str
    name: str
    state: str = "waiting"
    frames: int = 0
    frames_total: int = 0
    frames_per_second: float = 0.0
    keyframes: int = 0
    landmarks: int = 0
    message: str = ""

    @property
    def is_over(self) -> bool:
        """Whether nothing more happens to it."""
        return self.state in _FINAL


class Jobs:
    """Takes uploads and maps them; belongs to one event loop.

    Args:
        folder: where uploads are worked on and maps are kept; made where it is missing.
        config: of the maps, and the limits.
        atlas: gets the maps.
        hub: is told of progress.
        on_map: called for every new map.

    Raises:
        UserError: the folder cannot be written.
    """

    def __init__(
        self, folder: Path, config: Config, atlas: Atlas, hub: Hub, on_map: Callable[[ServedMap], Awaitable[None]]
    ) -> None:
        self._folder, self._config, self._limits = folder.absolute(), config, config.serving.jobs
        self._atlas, self._hub, self._on_map = atlas, hub, on_map
        self._jobs: dict[str, Job] = {}
        self._uploads: dict[str, Path] = {}
        self._receiving = 0
        self._queue: asyncio.Queue[Job] = asyncio.Queue()
        self._running: tuple[Job, asyncio.subprocess.Process] | None = None
        self._runner: asyncio.Task[None] | None = None
        try:
            (self._folder / _MAPS).mkdir(parents=True, exist_ok=True)
            # Whatever was not finished when the server ended is gone.
            shutil.rmtree(self._folder / _WORK, ignore_errors=True)
            (self._folder / _WORK).mkdir(mode=0o700)
        except OSError as error:
            raise UserError(f"uploads cannot be kept in {folder} ({error.strerror}); choose another folder") from error

    @staticmethod
    def kept_maps(folder: Path) -> list[Path]:
        """The maps that jobs of earlier servers have left in a folder."""
        return sorted((folder / _MAPS).glob("*.lpmap"))

    @property
    def process_id(self) -> int | None:
        """Of the job that runs."""
        return None if self._running is None else self._running[1].pid

    def start(self) -> None:
        """Begin to work."""
        self._runner = asyncio.create_task(self._work())

    async def close(self) -> None:
        """End what runs."""
        if self._runner is not None:
            self._runner.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._runner
        shutil.rmtree(self._folder / _WORK, ignore_errors=True)

    def get(self, id_: str) -> Job | None:
        """A job by its id."""
        return self._jobs.get(id_)

    def listed(self) -> list[Job]:
        """All that are remembered, the newest first."""
        return list(reversed(self._jobs.values()))

    async def receive(self, name: str, file: str, length: int | None, pieces: AsyncIterator[bytes]) -> Job:
        """Take an upload, to be mapped when its turn comes.

        Args:
            name: under which the map will be served.
            file: its name; only how it ends counts.
            length: bytes, as its sender says.
            pieces: its bytes.

        Raises:
            UserError: the name or the file is none that is taken.
            NameTakenError, TooLargeError, TooManyJobsError: as they say.
        """
        suffix = self._refuse(name, file, length)
        job = Job(secrets.token_hex(8), name)
        place = self._folder / _WORK / job.id
        self._receiving += 1
        try:
            place.mkdir(mode=0o700)
            upload = place / f"upload{suffix}"
            await self._write(upload, pieces)
            # Another of the same name may have come meanwhile.
            self._refuse(name, file, length, receiving=1)
        except BaseException as error:
            shutil.rmtree(place, ignore_errors=True)
            if isinstance(error, OSError):
                raise UserError(f"the upload cannot be kept ({error.strerror})") from error
            raise
        finally:
            self._receiving -= 1
        self._jobs[job.id], self._uploads[job.id] = job, upload
        self._forget_oldest()
        self._queue.put_nowait(job)
        self._tell(job)
        return job

    def cancel(self, job: Job) -> None:
        """Give a job up; one that is over stays as it is."""
        if job.is_over:
            return
        job.state, job.message = "cancelled", "cancelled on request"
        if self._running is not None and self._running[0] is job:
            kill(self._running[1])
        self._tell(job)

    def _refuse(self, name: str, file: str, length: int | None, receiving: int = 0) -> str:
        if _NAME.fullmatch(name) is None:
            raise UserError("a map's name has up to 60 letters a-z, digits, dots and dashes, and no dot or dash first")
        suffix = next((kept for end, kept in SUFFIXES.items() if file.lower().endswith(f".{end}")), None)
        if suffix is None:
            raise UserError(f"send a recording's folder as an archive, or a bag: {', '.join(SUFFIXES)}")
        waiting = [job for job in self._jobs.values() if not job.is_over]
        if name in self._atlas.maps or any(job.name == name for job in waiting):
            raise NameTakenError(f"a map named {name} is served or being made; choose another name")
        if len(waiting) + self._receiving - receiving >= self._limits.waiting:
            raise TooManyJobsError("as many recordings wait as may; come back later")
        if length is not None and length > self._limits.upload_bytes:
            raise TooLargeError(f"an upload may have {self._limits.upload_bytes:,} bytes")
        if shutil.disk_usage(self._folder).free < self._limits.spare_disk_bytes + (length or 0):
            raise TooManyJobsError("the disk is too full for uploads; come back later")
        return suffix

    async def _write(self, upload: Path, pieces: AsyncIterator[bytes]) -> None:
        size = 0
        with upload.open("xb") as file:
            while True:
                try:
                    async with asyncio.timeout(self._limits.silence_s):
                        piece = await anext(pieces, None)
                except TimeoutError:
                    raise UserError("the upload has stopped coming; it is given up") from None
                if piece is None:
                    break
                size += len(piece)
                if size > self._limits.upload_bytes:
                    raise TooLargeError(f"an upload may have {self._limits.upload_bytes:,} bytes")
                await asyncio.to_thread(file.write, piece)
        if not size:
            raise UserError("the upload is empty")

    async def _work(self) -> None:
        while True:
            job = await self._queue.get()
            place = self._folder / _WORK / job.id
            try:
                if not job.is_over:
                    await self._run(job, place)
            except LpSlamError as error:
                job.state, job.message = "failed", str(error)
            except OSError as error:
                job.state, job.message = "failed", error.strerror or "its process could not be started"
            finally:
                self._uploads.pop(job.id, None)
                shutil.rmtree(place, ignore_errors=True)
                self._tell(job)

    async def _run(self, job: Job, place: Path) -> None:
        temporary = place / "tmp"
        temporary.mkdir()
        command = python_command(_CODE, str(place), str(self._uploads[job.id]))
        process = await started(command, _surroundings(temporary), place, asyncio.subprocess.DEVNULL)
        self._running, is_mapped = (job, process), False
        try:
            async with asyncio.timeout(self._limits.clock_s):
                is_mapped = await self._follow(job, process)
        except TimeoutError:
            job.state, job.message = "failed", f"the job took longer than {self._limits.clock_s:g} s"
        finally:
            self._running = None
            await ended(process)
        if is_mapped and not job.is_over:
            await self._serve(job, place / MAP)

    async def _follow(self, job: Job, process: asyncio.subprocess.Process) -> bool:
        """Read what the process says until it ends, and say it on; whether it has made a map."""
        assert process.stdin is not None
        assert process.stdout is not None
        # Its standard input stays open: when it closes, the server is gone.
        with contextlib.suppress(ConnectionError):
            process.stdin.write(self._config.model_dump_json().encode() + b"\n")
            await process.stdin.drain()
        is_mapped = False
        while line := await process.stdout.readline():
            facts = _facts(line)
            if facts.get("state") == "done":
                # It is done when it is served.
                is_mapped, facts["state"] = True, job.state
            if not job.is_over:
                for name, value in facts.items():
                    setattr(job, name, value)
                self._tell(job)
        code = await process.wait()
        if not job.is_over and (code or not is_mapped):
            job.state, job.message = "failed", _why(code)
        return is_mapped

    async def _serve(self, job: Job, made: Path) -> None:
        path = self._folder / _MAPS / f"{job.name}.lpmap"
        os.replace(made, path)
        try:
            served = await asyncio.to_thread(self._atlas.add, path, job.name)
        except UserError:
            path.unlink(missing_ok=True)
            job.state, job.message = "failed", "its map cannot be read"
            return
        await self._on_map(served)
        job.state = "done"

    def _tell(self, job: Job) -> None:
        self._hub.tell("job", asdict(job))

    def _forget_oldest(self) -> None:
        over = [job for job in self._jobs.values() if job.is_over]
        for job in over[: max(0, len(self._jobs) - self._limits.remembered)]:
            del self._jobs[job.id]


_KNOWN: dict[str, type] = {
    "state": str, "message": str, "frames": int, "frames_total": int, "frames_per_second": float, "keyframes": int,
    "landmarks": int,
}  # fmt: skip


def _surroundings(temporary: Path) -> dict[str, str]:
    """Variables of a job: no keys, and a home of its own; only compiled kernels are kept where they are."""
    kept = {name: os.environ[name] for name in _KEPT_VARIABLES if name in os.environ}
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return kept | {"HOME": str(temporary), "TMPDIR": str(temporary), "XDG_CACHE_HOME": cache}


def _facts(line: bytes) -> dict[str, Any]:
    """What a line of the process says, as far as it is what such a line says."""
    try:
        said = json.loads(line)
    except ValueError:
        return {}
    if not isinstance(said, dict):
        return {}
    return {name: kind(said[name]) for name, kind in _KNOWN.items() if isinstance(said.get(name), kind | int)}


def _why(code: int) -> str:
    if code >= 0:
        return "its process ended with an error; the server's owner finds out by mapping the recording with lpslam run"
    try:
        name = signal.Signals(-code).name
    except ValueError:
        name = f"signal {-code}"
    return f"its process was ended by {name}: stopped from outside, or out of memory or processor time"
