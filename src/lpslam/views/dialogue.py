"""Several questions about one map, one after the other: what was asked and named before is kept in mind."""

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam.config import Config
from lpslam.errors import UserError
from lpslam.language.model import Converses, LanguageModel
from lpslam.language.questions.phrasing import follow_up
from lpslam.navigation.asking import Answer, answer
from lpslam.navigation.directory import Directory
from lpslam.navigation.known import Known
from lpslam.navigation.places import FARTHEST
from lpslam.views.answers import answer_text

_PROMPT = "? "
_KEPT = 1000  # questions of the history


class Dialogue:
    """Questions asked from one place; “and another one?” asks for the same again, without what was named."""

    def __init__(
        self,
        known: Known,
        language: LanguageModel,
        position: NDArray[np.float64] | None = None,
        heading: float | None = None,
        config: Config | None = None,
    ) -> None:
        self._directory = Directory(known.landmarks, config.navigation if config is not None else None)
        self._view, self._language = known.view, language
        self._position, self._heading = position, heading
        self._before: str | None = None
        self._history: tuple[tuple[str, str], ...] = ()
        self._named: frozenset[int] = frozenset()
        self._language_said, self._is_further = "en", False

    def ask(self, text: str) -> Answer:
        """Answer a question, in its own right or as one that follows the last.

        Raises:
            UserError: the question is empty.
        """
        converses = isinstance(self._language, Converses)
        # A model that converses is told what was said before; for the embedded one the question is written in full.
        read = follow_up(text, None if converses else self._before)
        named = self._named if read.keeps else frozenset()
        given = answer(
            read.question,
            self._directory,
            self._view,
            self._language,
            self._position,
            self._heading,
            excluded=named,
            history=self._history,
        )
        self._history += ((text, "" if given.landmark is None else given.landmark.name),)
        self._before, self._language_said, self._is_further = read.question, read.language, bool(named)
        self._named = named if given.landmark is None else named | {given.landmark.id}
        return given

    def said(self, answer: Answer, *, understood: bool = False) -> str:
        """The last answer as text, in the language of the question; first what was `understood`, if wanted."""
        return answer_text(answer, self._language_said, is_further=self._is_further, understood=understood)


def parsed_place(text: str) -> tuple[NDArray[np.float64], float | None]:
    """A place on the map, (2,) metres, and the heading in radians where one is given, from "x,y[,degrees]".

    Raises:
        UserError: the text is none of this.
    """
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in (2, 3) or not (np.abs(values) <= FARTHEST).all():
        raise UserError(
            f"--from {text}: give a place as X,Y or X,Y,HEADING, in metres and in degrees counter-clockwise from the "
            "map's x axis, as in --from 1.5,-2,90"
        )
    return np.array(values[:2]), float(np.radians(values[2])) if len(values) == 3 else None


def questions() -> Iterator[str]:
    """Questions from a prompt with a history, or line by line from a pipe; empty lines ask nothing."""
    if sys.stdin is None:
        raise UserError("there is no standard input to take questions from; give one: lpslam ask MAP QUESTION")
    lines = _typed() if sys.stdin.isatty() else iter(sys.stdin)
    for line in lines:
        if text := line.strip():
            yield text


def history_file() -> Path:
    """Where questions typed at the prompt are kept: the user's state folder."""
    folder = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(folder) / "lpslam" / "questions"


def _typed() -> Iterator[str]:
    with _history():
        while True:
            try:
                yield input(_PROMPT)
            except EOFError:
                print()
                return


@contextlib.contextmanager
def _history() -> Iterator[None]:
    """Line editing with the questions of earlier days, where the system has it; a prompt is not worth an error."""
    try:
        import readline
    except ImportError:
        yield
        return
    path = history_file()
    with contextlib.suppress(OSError):
        readline.read_history_file(path)
    readline.set_history_length(_KEPT)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            readline.write_history_file(path)
            path.chmod(0o600)
