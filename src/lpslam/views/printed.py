"""What the commands print: a line, a table, or JSON."""

import json
import logging
import sys
from pathlib import Path
from typing import Any


class Spoken(logging.Handler):
    """What the library warns of, as one line each on standard error."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print a record."""
        say(record.getMessage())


def say(line: str) -> None:
    """One line on standard error; what it quotes of a recording cannot steer the terminal."""
    from lpslam.views.drawable import printable

    print(f"lpslam: {printable(line, longest=1000)}", file=sys.stderr)


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
