"""ROS 2's databases (`.db3`): a table of topics and one of messages.

The tables: https://github.com/ros2/rosbag2/tree/rolling/rosbag2_storage_sqlite3
"""

import sqlite3
from array import array
from bisect import bisect_left
from collections.abc import Collection, Iterator
from contextlib import closing
from itertools import islice, pairwise
from pathlib import Path
from typing import Any
from urllib.parse import quote

from lpslam.errors import UserError
from lpslam.sources.bags.containers.container import Damage, Encoding, Message, Topic, ros2_type
from lpslam.sources.bags.containers.unpacking import LARGEST

MAGIC = b"SQLite format 3\0"
_LEAPS = 40
"""How often rows that cannot be read are leapt over, each time twice as many: pages of a database are missing."""
_MOST_TOPICS, _SHOWN = 10_000, 6
_LEAST_ROW = 4
"""Bytes that a row takes at least: its number, its lengths and its cell's place."""


class Ros2Database:
    """A `Container` over one `.db3`.

    Args:
        path: the file.

    Raises:
        UserError: it is no such database, or nothing of it can be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._damage = Damage(path)
        self.damages = [self._damage]
        self._options = "mode=ro"
        # No row takes less: damaged trees may lead around for ever.
        self._most_rows = path.stat().st_size // _LEAST_ROW + 1
        try:
            rows = self._topic_rows()
        except sqlite3.OperationalError:
            # A database that was not closed wants to write beside itself, which a read-only folder does not allow.
            self._options = "mode=ro&immutable=1"
            rows = self._tables_or_refusal()
        except sqlite3.DatabaseError:
            rows = self._tables_or_refusal()
        self._ids = {str(name): int(row) for row, name, _, _ in rows}
        self.topics = tuple(
            Topic(str(name), ros2_type(str(kind)), _encoding(str(form))) for _, name, kind, form in rows
        )
        self._rows, self._logged, self._of_topic = array("q"), array("q"), array("q")
        self._is_whole = self._walk()
        if not self._is_whole:
            self._collect()
        # Rows are recorded in order; only where they are not does the index of times decide.
        self._is_in_order = all(one <= other for one, other in pairwise(self._logged))

    def messages(self, names: Collection[str], start: int | None = None, end: int | None = None) -> Iterator[Message]:
        """See `Container`."""
        wanted = {self._ids[topic.name]: topic for topic in self.topics if topic.name in names}
        if not wanted:
            return
        bounds = (start if start is not None else -(1 << 62), end if end is not None else (1 << 62))
        if not self._is_whole:
            yield from self._salvaged(wanted, *bounds)
            return
        query, values = self._query(*bounds)
        marks = ",".join("?" * len(wanted))
        try:
            with closing(self._connection()) as connection:
                found = connection.execute(query.format(marks), (*wanted, *values))
                for _, topic_id, logged, data in islice(found, self._most_rows):
                    yield Message(wanted[topic_id], int(logged), bytes(data or b""))
                    # Where it breaks off, what is after it may be whole.
                    bounds = (int(logged) + 1, bounds[1])
        except (sqlite3.Error, TypeError, ValueError, OverflowError) as error:
            self._damage.note(f"a part of it cannot be read ({error})")
            yield from self._salvaged(wanted, *bounds)

    def times(self, name: str) -> list[int]:
        """See `Container`."""
        if name not in self._ids:
            return []
        number = self._ids[name]
        return sorted(logged for logged, topic in zip(self._logged, self._of_topic, strict=True) if topic == number)

    def _query(self, start: int, end: int) -> tuple[str, tuple[int, int]]:
        """Row number, topic, time and data between two times; the topics' marks are left open."""
        columns = "SELECT id, topic_id, timestamp, data FROM messages"
        if not self._is_in_order:
            order = "AND timestamp >= ? AND timestamp < ? ORDER BY timestamp"
            return f"{columns} WHERE topic_id IN ({{}}) {order}", (start, end)
        first, last = bisect_left(self._logged, start), bisect_left(self._logged, end)
        bounds = (self._rows[first] if first < len(self._rows) else 1 << 62, self._rows[last - 1] if last else -1)
        return f"{columns} NOT INDEXED WHERE topic_id IN ({{}}) AND id >= ? AND id <= ? ORDER BY id", bounds

    def _connection(self) -> sqlite3.Connection:
        connection = sqlite3.connect(f"file:{quote(str(self.path.absolute()))}?{self._options}", uri=True)
        # Else SQLite refuses a database whose file is shorter than its header says. It is read-only.
        connection.execute("PRAGMA writable_schema = ON")
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LARGEST)
        connection.text_factory = lambda data: data.decode("utf-8", "replace")
        return connection

    def _topic_rows(self) -> list[tuple[Any, ...]]:
        with closing(self._connection()) as connection:
            _refuse_programs(connection)
            query = "SELECT id, name, type, serialization_format FROM topics"
            return [row for row in connection.execute(query).fetchmany(_MOST_TOPICS) if isinstance(row[0], int)]

    def _tables_or_refusal(self) -> list[tuple[Any, ...]]:
        try:
            return self._topic_rows()
        except sqlite3.Error as error:
            tables = self._table_names()
            if tables and not {"topics", "messages"} & set(tables):
                raise UserError(
                    f"{self.path} is a database of SQLite that no ROS 2 recorder wrote (tables: {', '.join(tables)}); "
                    "write its pictures, depth and calibration into a folder, or into a ROS bag"
                ) from error
            raise UserError(f"{self.path} is no ROS 2 recording that can be read ({error})") from error

    def _table_names(self) -> list[str]:
        try:
            with closing(self._connection()) as connection:
                found = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'").fetchmany(_SHOWN)
        except sqlite3.Error:
            return []
        return ["".join(letter for letter in str(name)[:40] if letter.isprintable()) for (name,) in found]

    def _walk(self) -> bool:
        """Collect number, topic and time of every row, without what it holds; whether all rows were reached.

        Recorders number rows one by one and delete none.
        """
        try:
            with closing(self._connection()) as connection:
                pages = connection.execute("PRAGMA page_count").fetchone()[0]
                size = connection.execute("PRAGMA page_size").fetchone()[0]
                if max(pages, int.from_bytes(self._head()[28:32], "big")) * size > self.path.stat().st_size:
                    raise sqlite3.DatabaseError("it is cut off")
                query = "SELECT id, topic_id, timestamp FROM messages NOT INDEXED ORDER BY id"
                for row, topic_id, logged in islice(connection.execute(query), self._most_rows):
                    if self._rows and row <= self._rows[-1]:
                        raise sqlite3.DatabaseError("its rows are not in order")
                    self._rows.append(row)
                    self._of_topic.append(topic_id)
                    self._logged.append(logged)
        except (sqlite3.Error, TypeError, OverflowError) as error:
            self._damage.note(f"a part of it is missing ({error})")
            return False
        missing = self._rows[-1] - self._rows[0] + 1 - len(self._rows) if self._rows else 0
        if missing:
            self._damage.note(f"{missing} of its messages cannot be reached")
        return not missing

    def _head(self) -> bytes:
        with self.path.open("rb") as file:
            return file.read(100)

    def _collect(self) -> None:
        """Number, topic and time of all rows that can be read with what they hold: one pass over a damaged file."""
        self._rows, self._logged, self._of_topic = array("q"), array("q"), array("q")
        for row, topic_id, logged, _ in self._readable(0):
            self._rows.append(row)
            self._of_topic.append(topic_id)
            self._logged.append(logged)

    def _salvaged(self, wanted: dict[int, Topic], start: int, end: int) -> Iterator[Message]:
        """Messages between two times in the order in which they were written."""
        first = bisect_left(self._logged, start) if self._is_in_order else 0
        if first == len(self._rows):
            return
        for _, topic_id, logged, data in self._readable(self._rows[first] - 1):
            if self._is_in_order and logged >= end:
                return
            if topic_id in wanted and start <= logged < end:
                yield Message(wanted[topic_id], logged, data)

    def _readable(self, row: int) -> Iterator[tuple[int, int, int, bytes]]:
        """Number, topic, time and data of the rows after one; rows that cannot be read are leapt over."""
        step = 1
        with closing(self._connection()) as connection:
            for _ in range(_LEAPS):
                try:
                    query = "SELECT id, topic_id, timestamp, data FROM messages NOT INDEXED WHERE id > ? ORDER BY id"
                    for found, topic_id, logged, data in connection.execute(query, (row,)):
                        if int(found) <= row:
                            return  # a damaged tree that leads back into itself
                        row, step = int(found), 1
                        yield row, int(topic_id), int(logged), bytes(data or b"")
                    return
                except (sqlite3.Error, TypeError, ValueError, OverflowError):
                    row, step = row + step, 2 * step


def _refuse_programs(connection: sqlite3.Connection) -> None:
    """A view, or a column that is computed, is a program: it may run for ever. Recorders write plain tables.

    Raises:
        sqlite3.DatabaseError: there is one under a name that is read.
    """
    for name in ("topics", "messages"):
        kinds = connection.execute("SELECT type, sql FROM sqlite_master WHERE name = ? LIMIT 9", (name,)).fetchall()
        columns = connection.execute(f"PRAGMA table_xinfo({name})").fetchmany(_MOST_TOPICS)
        is_plain = all(kind == "table" and not str(sql).upper().startswith("CREATE VIRTUAL") for kind, sql in kinds)
        if not is_plain or any(column[6] for column in columns):
            raise sqlite3.DatabaseError(f"its {name} are computed, not recorded")


def _encoding(name: str) -> Encoding:
    return Encoding.CDR if name == "cdr" else Encoding.UNKNOWN
