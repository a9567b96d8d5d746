"""What the commands print: a line, a table, or JSON."""

import io
import json
import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TextIO


class Spoken(logging.Handler):
    """What the library warns of, as one line each on standard error."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print a record."""
        say(record.getMessage())


def prepare_streams() -> None:
    """Have output that no letter of a sign can break, and what the library warns of on lines of its own."""
    # A terminal or a pipe that lacks a letter of some sign shows its number instead.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    # Terminals that do not know their width say 0, in which nothing can be printed.
    if not os.environ.get("COLUMNS", "80").strip("0"):
        del os.environ["COLUMNS"]
    logging.getLogger("lpslam").handlers = [Spoken(logging.WARNING)]


def load_matplotlib() -> None:
    """Load it without a word: without a home, it and fontconfig, which it asks for fonts, complain at each start."""
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    with _unheard():
        import matplotlib.font_manager  # noqa: F401


@contextmanager
def _unheard() -> Iterator[None]:
    """Standard error, also of processes that are started meanwhile, goes nowhere."""
    try:
        kept = os.dup(2)
    except OSError:
        # It is closed.
        yield
        return
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def forget_output() -> None:
    """Drop what was not written to standard output yet, which takes nothing more."""
    _lead_nowhere(sys.stdout)


def _lead_nowhere(stream: TextIO) -> None:
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def say(line: str) -> None:
    """One line on standard error; what it quotes of a recording cannot steer the terminal."""
    from lpslam.views.drawable import printable

    write_line(f"lpslam: {printable(line, longest=1000)}")


def write_line(line: str) -> None:
    """A line on standard error; where that takes none, what is to be said is lost and nothing else."""
    try:
        print(line, file=sys.stderr, flush=True)
    except OSError:
        _lead_nowhere(sys.stderr)


def print_json(value: dict[str, Any]) -> None:
    """A record on standard output, in the letters that it has."""
    print(json.dumps(value, ensure_ascii=False, indent=1))


def print_table(facts: dict[str, str]) -> None:
    """What is known, by name."""
    from rich.console import Console

    from lpslam.views.tables import facts_table

    Console().print(facts_table(facts))


def facts_of(world: Any, path: Path) -> dict[str, Any]:
    """What is known of a map and its file."""
    from lpslam.views.facts import map_facts

    return {"map": str(path), **map_facts(world)}


def print_facts(world: Any, path: Path, as_json: bool) -> None:
    """What is known of a map and its file, as a table or JSON."""
    from lpslam.views.facts import fact_lines

    facts = facts_of(world, path)
    if as_json:
        print_json(facts)
    else:
        print_table({"map": str(path), **fact_lines(facts)})


def print_written(paths: list[Path], as_json: bool) -> None:
    """Which files were written."""
    if as_json:
        print_json({"written": [str(path) for path in paths]})
    else:
        print(*(f"written: {path}" for path in paths), sep="\n")


def landmark_records(landmarks: Any) -> dict[str, Any]:
    """Landmarks as JSON has them."""
    from lpslam.mapfile.export import landmark_record

    return {"landmarks": [landmark_record(mark) for mark in landmarks]}


def print_landmarks(landmarks: Any, title: str, as_json: bool) -> None:
    """Landmarks as a table or JSON."""
    if as_json:
        print_json(landmark_records(landmarks))
        return
    if not landmarks:
        print("No text is in this map's long-term memory.")
        return
    from rich.console import Console

    from lpslam.views.tables import landmark_table

    Console().print(landmark_table(landmarks, title))
