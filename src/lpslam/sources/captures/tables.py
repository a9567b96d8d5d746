"""Lists of pictures and of their times, however they are written: lines of words, CSV, JSON or a JSON a line."""

import csv
import json
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.regular_files import text_of
from lpslam.sources.captures.common import number_of
from lpslam.sources.clocks import in_seconds
from lpslam.sources.continuity import refuse_clock_set_back
from lpslam.sources.inside import PictureFile

Times = NDArray[np.float64]

_LISTS = frozenset((".txt", ".csv", ".tsv", ".json", ".jsonl", ".ndjson", ".log", ".lst"))
_OF_TIME = ("time", "stamp", "sec", "date", "clock")
_SECONDS, _NANOSECONDS = ("sec", "secs", "seconds"), ("nsec", "nsecs", "nanosec", "nanosecs", "nanoseconds")
_MOST_ROWS = 100
"""For each picture; a longer table, as of an inertial sensor, names none."""
_MOST_COLUMNS = 1000
"""Of a list of pictures; what has more is a table of something else."""
_MOST = 0.8
"""Share of a list's rows that must name pictures of a series, or times."""


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of cells under the names of the columns, which may be empty."""

    names: tuple[str, ...]
    rows: list[list[str]]

    def column(self, index: int) -> list[str]:
        """Its cells."""
        return [row[index] if index < len(row) else "" for row in self.rows]

    @property
    def width(self) -> int:
        """Columns that most rows have."""
        return int(np.median([len(row) for row in self.rows])) if self.rows else 0


@dataclass(slots=True)
class Listing:
    """What the lists of a folder say.

    Attributes:
        times: seconds by picture.
        pairs: depth by colour picture, where a row names both.
        notes: what was made of the stamps.
    """

    times: dict[PictureFile, float] = field(default_factory=dict)
    pairs: dict[PictureFile, PictureFile] = field(default_factory=dict)
    notes: set[str] = field(default_factory=set)


def listing_of(files: Sequence[Path], series: Sequence[tuple[PictureFile, ...]]) -> Listing:
    """Read every list among files that names pictures of the series, or has as many times as one of them pictures.

    Args:
        files: of the folder.
        series: pictures of colour, then of depth.
    """
    found, unnamed = Listing(), []
    for path in files:
        for table in _tables(path):
            columns = _columns(table, path.parent, series)
            if columns:
                _take(table, columns, found, path)
            else:
                unnamed.append(table)
    for pictures in series:
        if not any(picture in found.times for picture in pictures):
            _take_in_order(unnamed, pictures, found)
    return found


def _take(table: Table, columns: dict[int, list[PictureFile | None]], found: Listing, path: Path) -> None:
    for index, pictures in columns.items():
        stamps = _times(table, before=index, taken=set(columns), is_named=True)
        if stamps is not None:
            named = [(time, picture) for time, picture in zip(stamps, pictures, strict=True) if picture is not None]
            refuse_clock_set_back(np.array([time for time, _ in named]), [picture for _, picture in named], path)
            seconds, note = in_seconds(stamps)
            found.notes |= {note} - {""}
            found.times |= {picture: float(time) for picture, time in zip(pictures, seconds, strict=True) if picture}
    if len(columns) == 2:
        colours, depths = (columns[index] for index in columns)
        found.pairs |= {one: other for one, other in zip(colours, depths, strict=True) if one and other}


def _take_in_order(tables: Sequence[Table], pictures: tuple[PictureFile, ...], found: Listing) -> None:
    """Times without names belong to pictures by their numbers, where a column has these, or in order."""
    for table in tables:
        stamps = _times(table) if len(table.rows) <= _MOST_ROWS * len(pictures) else None
        if stamps is None or len(stamps) < len(pictures):
            continue
        seconds, note = in_seconds(stamps)
        found.notes |= {note} - {""}
        numbers = [number_of(picture) for picture in pictures]
        by_number = _by_number(table, seconds)
        if all(number in by_number for number in numbers):
            found.times |= {
                each: by_number[number] for each, number in zip(pictures, numbers, strict=True) if number is not None
            }
            return
        if len(table.rows) == len(pictures):
            found.times |= dict(zip(pictures, seconds.tolist(), strict=True))
            return


def _by_number(table: Table, seconds: Times) -> dict[int | None, float]:
    for index in range(min(table.width, 3)):
        cells = table.column(index)
        if all(cell.isdecimal() and len(cell) < 10 for cell in cells) and len(set(cells)) == len(cells):
            return {int(cell): float(time) for cell, time in zip(cells, seconds, strict=True)}
    return {}


def _columns(
    table: Table, beside: Path, series: Sequence[tuple[PictureFile, ...]]
) -> dict[int, list[PictureFile | None]]:
    """The columns that name pictures, those of the first series first: for each row the picture, if it names one."""
    columns: dict[int, list[PictureFile | None]] = {}
    for pictures in series:
        if len(table.rows) > _MOST_ROWS * len(pictures):
            continue
        by_name: dict[str, PictureFile] = {}
        for picture in pictures:
            parts = [part.lower() for part in picture.parts]
            # By as much of the path as is written; a bare name last.
            by_name |= {"/".join(parts[-depth:]): picture for depth in (1, 2, 3, 4)}
            by_name.setdefault("/".join([*parts[-2:-1], picture.stem.lower()]), picture)
        best: tuple[int, int] | None = None
        for index in range(table.width):
            if index in columns:
                continue
            named = [_named(cell, by_name) for cell in table.column(index)]
            count = sum(picture is not None for picture in named)
            if count >= _MOST * len(named) and (best is None or count > best[0]):
                best = count, index
        if best is not None:
            columns[best[1]] = [_named(cell, by_name) for cell in table.column(best[1])]
    return columns


def _named(cell: str, by_name: dict[str, PictureFile]) -> PictureFile | None:
    parts = [part for part in cell.replace("\\", "/").lower().split("/") if part not in ("", ".", "..")][-4:]
    written = ("/".join(parts[start:]) for start in range(len(parts)))
    return next((by_name[name] for name in written if name in by_name), None)


def _times(
    table: Table, before: int | None = None, taken: Collection[int] = (), *, is_named: bool = False
) -> Times | None:
    """The column of times (n,), raw: the one called so, else the last before a column; None without.

    Where each row names its picture, a column that is called so need not rise.
    """
    together = _seconds_and_parts(table)
    if together is not None:
        return together
    columns = {index: _numeric(table.column(index)) for index in range(table.width) if index not in taken}
    clocks = {
        index: values
        for index, values in columns.items()
        if values is not None and (_rises(values) or (is_named and _falls(table, index, values)))
    }
    # A counter of rows is no clock where there is another.
    clocks = {index: values for index, values in clocks.items() if not _counts(values)} or clocks
    named = [index for index in clocks if index < len(table.names) and _says_time(table.names[index])]
    left = [index for index in clocks if before is not None and index < before]
    chosen = named[:1] or left[-1:] or list(clocks)[:1]
    return clocks[chosen[0]] if chosen else None


def _seconds_and_parts(table: Table) -> Times | None:
    """Seconds and nanoseconds in two columns, as ROS has them."""
    names = [name.lower() for name in table.names]
    parts = next((index for index, name in enumerate(names) if name.endswith(_NANOSECONDS)), None)
    whole = next((index for index, name in enumerate(names) if name.endswith(_SECONDS) and index != parts), None)
    if parts is None or whole is None:
        return None
    seconds, nanoseconds = (_numeric(table.column(index)) for index in (whole, parts))
    if seconds is None or nanoseconds is None or not _rises(seconds + nanoseconds * 1e-9):
        return None
    return np.asarray(seconds + nanoseconds * 1e-9)


def _rises(values: Times) -> bool:
    is_rising = np.isfinite(values).all() and (np.diff(values) >= 0).all()
    return bool(is_rising and len(np.unique(values)) > len(values) / 2)


def _falls(table: Table, index: int, values: Times) -> bool:
    """Whether a column is one of times that somebody put into another order, or whose clock was set back."""
    is_called_so = index < len(table.names) and _says_time(table.names[index])
    return bool(is_called_so and np.isfinite(values).all() and len(np.unique(values)) == len(values))


def _says_time(name: str) -> bool:
    return any(word in name.lower() for word in _OF_TIME)


def _counts(values: Times) -> bool:
    return len(values) > 2 and bool((np.diff(values) == 1).all()) and values[0] in (0, 1)


def _numeric(cells: Sequence[str]) -> Times | None:
    try:
        return np.array([float(cell) for cell in cells])
    except ValueError:
        pass
    try:
        return np.array([_seconds(cell) for cell in cells])
    except ValueError:
        return None


def _seconds(cell: str) -> float:
    moment = datetime.fromisoformat(cell.strip())
    return (moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)).timestamp()


def times_in_names(pictures: Sequence[PictureFile]) -> tuple[Times | None, str]:
    """Seconds (n,) that the pictures' names say, and what was made of them; None where they only count."""
    split = [re.findall(r"\d{1,30}(?:\.\d{1,30})?", picture.stem) for picture in pictures]
    if len({len(parts) for parts in split}) != 1:
        return None, ""
    for index in range(len(split[0])):
        values = np.array([float(parts[index]) for parts in split])
        steps = np.diff(np.sort(values))
        # Nobody counts in fractions.
        is_whole = not all("." in parts[index] for parts in split)
        is_even = np.median(steps) < _LEAST_STEP or bool((steps == steps[0]).all())
        counts = is_whole and values.min() < _LEAST_STAMP and is_even
        if not counts and (steps > 0).all():
            return in_seconds(values)
    moments = [re.sub(r"^\D*", "", picture.stem) for picture in pictures]
    try:
        return np.array(
            [_seconds(re.sub(r"(T\d\d)[-_.](\d\d)[-_.](\d\d)", r"\1:\2:\3", moment)) for moment in moments]
        ), ""
    except ValueError:
        return None, ""


def _tables(path: Path) -> Iterator[Table]:
    if path.suffix.lower() not in _LISTS:
        return
    try:
        text = text_of(path, "list").lstrip("\ufeff")
    except (UserError, ValueError, OSError):
        return
    tables = _of_json(text) if path.suffix.lower() in (".json", ".jsonl", ".ndjson") else [_of_lines(text)]
    yield from (table for table in tables if table is not None and len(table.rows) > 1)


def _of_lines(text: str) -> Table | None:
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith(("#", "%", "//"))]
    if len(lines) < 2:
        return None
    mark = next((each for each in ("\t", ";", ",") if sum(each in line for line in lines) >= _MOST * len(lines)), None)
    try:
        rows = (
            list(csv.reader(lines, delimiter=mark, skipinitialspace=True)) if mark else [line.split() for line in lines]
        )
    except csv.Error:
        return None
    if max(map(len, rows)) > _MOST_COLUMNS:
        return None
    rows = [[cell.strip().strip("\"'") for cell in row if mark or cell] for row in rows]
    is_named = not any(_numeric([cell]) is not None for cell in rows[0]) and any(
        _numeric([cell]) is not None for cell in rows[1]
    )
    return Table(tuple(rows[0]), rows[1:]) if is_named else Table((), rows)


def _of_json(text: str) -> list[Table | None]:
    try:
        try:
            found: object = json.loads(text)
        except ValueError:
            found = [json.loads(line) for line in text.splitlines() if line.strip() and line[0] not in "#%"]
    except (ValueError, RecursionError):
        return []
    lists = found if isinstance(found, list) else None
    if isinstance(found, dict):
        lists = max((each for each in found.values() if isinstance(each, list)), key=len, default=None)
    if not lists or not all(isinstance(each, dict) for each in lists):
        return []
    rows = [_flat(each) for each in lists]
    names = tuple(rows[0])
    if len(names) > _MOST_COLUMNS:
        return []
    return [Table(names, [[row.get(name, "") for name in names] for row in rows])]


def _flat(tree: dict[str, object], around: str = "", depth: int = 3) -> dict[str, str]:
    cells: dict[str, str] = {}
    for name, value in tree.items():
        if isinstance(value, dict) and depth:
            cells |= _flat(value, f"{around}{name}.", depth - 1)
        elif isinstance(value, (str, int, float)):
            cells[f"{around}{name}"] = str(value)
    return cells


_LEAST_STAMP = 1e6
"""A smaller number in a name may count pictures: as seconds it would be of January 1970 ..."""

_LEAST_STEP = 1000
"""... unless it rises by so much, and not evenly: microseconds from where the camera began."""
