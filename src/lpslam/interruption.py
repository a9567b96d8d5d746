"""The process's edges: Ctrl-C or a polite kill at any moment is one line and exit code 130, and standard streams may be
closed.
"""

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import NoReturn, TextIO

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it, and after a polite kill."""
_LINE = "lpslam: interrupted\n"
_LEAVINGS: list[Callable[[], None]] = []
_was_pressed = False
_number = signal.SIGINT  # by which it was


def watch() -> None:
    """Note the key from now on, and the kill that containers and services end with, which is the same to us.

    What whoever started the process lets be ignored stays ignored.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) in (signal.default_int_handler, signal.SIG_DFL):
            signal.signal(number, _press)
    sys.unraisablehook = _unraisable


def was_pressed() -> bool:
    """Whether the key broke something off: what fails from then on fails because of it."""
    return _was_pressed


def end(is_said: bool = False) -> NoReturn:
    """End at once: the reading engine may be at work in its thread, and tearing it down meanwhile would crash."""
    _close_ears()
    for leave in _LEAVINGS:
        with contextlib.suppress(Exception):
            leave()
    try:
        sys.stderr.write("" if is_said else _LINE)
        sys.stderr.flush()
    except (OSError, ValueError):
        pass
    os._exit(INTERRUPTED)


def at_end(leave: Callable[[], None]) -> None:
    """Have something done also where the process ends at once; it removes what is temporary."""
    _LEAVINGS.append(leave)


def _close_ears() -> None:
    """Hear no key and no kill from now on: one that falls into the end would say the same line again.

    A handler of Python takes their place, since a signal that has come already and is then ignored is told of on
    standard error. Only the main thread hears signals, and only there can this be set.
    """
    with contextlib.suppress(ValueError):
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: None)


def hold_streams() -> None:
    """Keep closed standard streams from becoming the next file that is opened: they lead nowhere."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            # The lowest free number is taken, which is this one.
            os.open(os.devnull, os.O_RDWR)
    sys.stdout = sys.stdout or _nowhere()
    sys.stderr = sys.stderr or _nowhere()


def _nowhere() -> TextIO:
    return Path(os.devnull).open("w", encoding="utf-8")


def _press(number: int, frame: FrameType | None) -> None:
    global _was_pressed, _number
    if _was_pressed:
        end()
    _was_pressed, _number = True, signal.Signals(number)
    raise KeyboardInterrupt


def _unraisable(what: "sys.UnraisableHookArgs") -> None:
    """A key that falls into the end of an object has nobody to tell, and is pressed again a moment later."""
    if not isinstance(what.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(what)
        return
    global _was_pressed
    _was_pressed = False
    again = threading.Timer(_AGAIN, os.kill, (os.getpid(), _number))
    again.daemon = True
    again.start()


_AGAIN = 0.02
"""Seconds until a key is pressed again: the end of an object is over by then."""
