"""The run's side: a thread that tells the page's process how far the map has grown, and costs tracking little.

The thread that tracks only says that there was a step. All else happens beside it, as often as a share of one core
allows, and only while somebody watches. Whatever becomes of the other process, the run goes on.
"""

import json
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Any, Self

from lpslam.camera import PinholeCamera
from lpslam.config import WatchingConfig
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.isolated import python_command
from lpslam.mapfile.language_map import LanguageMap
from lpslam.priority import READING, yield_to_others
from lpslam.serving.watching.pace import Pace
from lpslam.serving.watching.wire import Begin, Corrected, End, Ground, Happened, Message, Signs, State, send
from lpslam.session.growth import Growth, growth_of
from lpslam.session.session import Session
from lpslam.session.step import Step
from lpslam.slam.state import SlamEvent
from lpslam.text.correcting.changing import Change, ConflictError, NoSuchCorrectionError
from lpslam.text.correcting.corrections import Corrections, Kind

_CODE = "from lpslam.serving.watching.process import main; main()"
_SAID = ("landmark", "name", "into", "answer")  # of a change, besides its kind
_FAREWELL_S = 8.0  # seconds in which the other process tells its watchers the end


class Feed:
    """A page of a growing map; use it in a `with` block, and hand `on_step` to the run.

    Args:
        begin: what the page is of, and where it is served.
        on_lost: called, in a thread, if the page is lost before the run ends.

    Raises:
        UserError: on entering, where the port is taken or the page cannot be served.

    Attributes:
        url: of the page, once entered.
    """

    def __init__(self, begin: Begin, on_lost: Callable[[], None] = lambda: None) -> None:
        self._begin, self._on_lost = begin, on_lost
        self._limits: WatchingConfig = begin.config.serving.watching
        self.url = ""
        self._process: subprocess.Popen[bytes] | None = None
        self._latest: tuple[Session, Step] | None = None
        self._map_file, self._world = "", None  # type: tuple[str, LanguageMap | None]
        self._watchers = 0
        self._telling = threading.Lock()
        self._woken, self._has_ended = threading.Event(), threading.Event()
        self._has_news = True
        self._events: deque[SlamEvent] = deque(maxlen=self._limits.events)
        self._events_count = self._events_told = 0
        self._start: float | None = None
        self._threads: list[threading.Thread] = []
        self._known: set[int] = set()

    def __enter__(self) -> Self:
        self._process = subprocess.Popen(
            python_command(_CODE), stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
        )
        try:
            self._tell(self._begin)
            assert self._process.stdout is not None
            said, _, rest = self._process.stdout.readline().decode("utf-8", "replace").strip().partition(" ")
        except OSError:
            said, rest = "", ""
        except BaseException:
            # Broken off while it starts: a block that is not entered is not left either.
            self._kill()
            raise
        if said != "at":
            self._kill()
            raise UserError(rest or "the page cannot be served: its process has ended")
        self.url = rest
        for work in (self._listen, self._feed):
            self._threads.append(threading.Thread(target=work, name=f"lpslam-watch{work.__name__}", daemon=True))
            self._threads[-1].start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._has_ended.set()
        self._woken.set()
        # The feeding thread may wait for a process that does not read; it ends with it.
        self._threads[1].join(_FAREWELL_S)
        process = self._process
        if process is not None:
            with suppress(subprocess.TimeoutExpired):
                process.wait(_FAREWELL_S if not self._threads[1].is_alive() else 0)
        self._kill()

    @property
    def watchers(self) -> int:
        """How many browsers show the page."""
        return self._watchers

    def on_step(self, frame: RgbdFrame, step: Step, session: Session) -> None:
        """Note that there was a step; called by whoever tracks."""
        if self._start is None:
            self._start = step.timestamp
        self._events.extend(step.events)
        self._events_count += len(step.events)
        self._latest = session, step
        if step.new_landmarks or step.renamed_landmarks:
            self._has_news = True

    def end(self, world: LanguageMap | None, map_file: str) -> None:
        """The run has ended: the last that watchers see is this map."""
        self._world, self._map_file = world, map_file

    def _feed(self) -> None:
        yield_to_others(READING)
        limits = self._limits
        signs, ground = Pace(limits.signs_s, limits.share), Pace(limits.ground_s, limits.share)
        told = -1
        try:
            while not self._has_ended.is_set():
                self._woken.wait(limits.state_s if self._watchers else None)
                self._woken.clear()
                if self._latest is None or not self._watchers or self._latest[1].index == told:
                    continue
                session, step = self._latest
                told = step.index
                self._tell(_state(session, step))
                self._tell_events()
                if signs.is_due(hurried=self._has_news):
                    self._has_news = False
                    with signs:
                        self._tell_signs(session)
                if ground.is_due():
                    with ground:
                        self._tell_ground(session)
            self._tell_end()
        except OSError:
            # Nobody reads any more: the run has one thing less to do.
            return
        except Exception:
            # What cannot be told is no reason to end a run.
            self._kill()
            raise

    def _tell_events(self) -> None:
        """Tell the newest events, if there are new ones."""
        count = self._events_count
        if count != self._events_told:
            self._events_told = count
            # Copied in one go: the thread that tracks may add to it meanwhile.
            self._tell(Happened(tuple(self._events.copy()), count, self._start or 0.0))

    def _tell_signs(self, session: Session) -> None:
        marks = tuple(session.landmarks())
        self._tell(Signs(marks, session.corrections, session.question))

    def _correct(self, request: dict[str, Any]) -> None:
        """Have the session take what a person said, and say what became of it."""
        if self._latest is None:
            return self._tell(Corrected(request["request"], 404, "nothing is mapped yet", Corrections()))
        session, status, detail = self._latest[0], 200, ""
        try:
            if "number" in request:
                session.take_back(request["number"], request["revision"])
            else:
                change = Change(Kind(request["kind"]), **{key: request[key] for key in _SAID})
                session.correct(change, request["revision"])
        except UserError as error:
            status = {ConflictError: 409, NoSuchCorrectionError: 404}.get(type(error), 422)
            detail = str(error)
        self._tell(Corrected(request["request"], status, detail, session.corrections))
        return self._tell_signs(session)

    def _tell_ground(self, session: Session) -> None:
        grown = session.growth(self._known, self._limits.scans)
        self._known |= {int(each) for each in grown.scans.get("keyframe", ())}
        self._tell(_ground(session.camera, grown))

    def _tell_end(self) -> None:
        if self._latest is not None and self._watchers:
            self._tell(_state(*self._latest))
            self._tell_events()
        if self._world is not None and self._watchers:
            world, text = self._world, self._world.text
            self._tell(Signs(tuple(world.landmarks()), text.corrections, text.question))
            self._tell(_ground(world.camera, growth_of(world.slam, world.trajectory, world.scans, self._known)))
        self._tell(End(self._map_file))
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.close()

    def _listen(self) -> None:
        """Learn how many watch."""
        assert self._process is not None
        assert self._process.stdout is not None
        for line in self._process.stdout:
            kind, _, value = line.decode("utf-8", "replace").strip().partition(" ")
            if kind == "watchers" and value.isdecimal():
                self._watchers = int(value)
                self._woken.set()
            elif kind == "correct" and not self._has_ended.is_set():
                with suppress(OSError):
                    self._correct(json.loads(value))
        self._watchers = 0
        if not self._has_ended.is_set():
            self._on_lost()

    def _tell(self, message: Message) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        with self._telling:
            send(self._process.stdin, message)

    def _kill(self) -> None:
        process, self._watchers = self._process, 0
        if process is None:
            return
        with suppress(OSError):
            process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()


def _state(session: Session, step: Step) -> State:
    rate = session.frames / max(session.seconds, time.get_clock_info("perf_counter").resolution)
    return State(
        frames=session.frames,
        keyframes=session.keyframes,
        texts=session.texts,
        rate=rate,
        tracking=step.state.value,
        reason=step.reason,
        submaps=session.submaps,
        dropped=session.frames_dropped,
        pose=step.pose,
    )


def _ground(camera: PinholeCamera, grown: Growth) -> Ground:
    return Ground(camera, grown.poses, grown.keyframes, grown.scans)
