"""ROS 2's databases (`.db3`): a table of topics and one of messages.

The tables: https://github.com/ros2/rosbag2/tree/rolling/rosbag2_storage_sqlite3
"""

import sqlite3
from collections.abc import Collection, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any
from urllib.parse import quote

from lpslam.errors import UserError
from lpslam.sources.bags.containers.container import Damage, Encoding, Message, Topic, ros2_type

MAGIC = b"SQLite format 3\0"
_LEAPS = 40
"""How often rows that cannot be read are leapt over, each time twice as many: pages of a database are missing."""


class Ros2Database:
    """A `Container` over one `.db3`.

    Args:
        path: the file.

    Raises:
        UserError: it is no such database, or nothing of it can be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.damage = Damage(path)
        self._options = "mode=ro"
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
        # Rows are recorded in order; only where they are not does the index of times decide.
        self._is_whole = self._can_be_walked()

    def messages(self, names: Collection[str], start: int | None = None, end: int | None = None) -> Iterator[Message]:
        """See `Container`."""
        wanted = {self._ids[topic.name]: topic for topic in self.topics if topic.name in names}
        if not wanted:
            return
        marks = ",".join("?" * len(wanted))
        bounds = (start if start is not None else -(1 << 62), end if end is not None else (1 << 62))
        if not self._is_whole:
            yield from self._salvaged(wanted, *bounds)
            return
        query = (
            f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({marks}) "
            "AND timestamp >= ? AND timestamp < ? ORDER BY timestamp"
        )
        try:
            with closing(self._connection()) as connection:
                for topic_id, logged, data in connection.execute(query, (*wanted, *bounds)):
                    yield Message(wanted[topic_id], int(logged), bytes(data or b""))
        except (sqlite3.Error, TypeError, ValueError) as error:
            self.damage.note(f"a part of it cannot be read ({error})")

    def times(self, name: str) -> list[int]:
        """See `Container`."""
        if name not in self._ids:
            return []
        if not self._is_whole:
            topic = {self._ids[name]: Topic(name, "", Encoding.CDR)}
            return [message.logged for message in self._salvaged(topic, -(1 << 62), 1 << 62)]
        try:
            with closing(self._connection()) as connection:
                rows = connection.execute(
                    "SELECT timestamp FROM messages WHERE topic_id = ? ORDER BY timestamp", (self._ids[name],)
                )
                return [int(row[0]) for row in rows]
        except (sqlite3.Error, TypeError, ValueError):
            return []

    def _connection(self) -> sqlite3.Connection:
        connection = sqlite3.connect(f"file:{quote(str(self.path.absolute()))}?{self._options}", uri=True)
        # Else SQLite refuses a database whose file is shorter than its header says. It is read-only.
        connection.execute("PRAGMA writable_schema = ON")
        connection.text_factory = lambda data: data.decode("utf-8", "replace")
        return connection

    def _topic_rows(self) -> list[tuple[Any, ...]]:
        with closing(self._connection()) as connection:
            return connection.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()

    def _tables_or_refusal(self) -> list[tuple[Any, ...]]:
        try:
            return self._topic_rows()
        except sqlite3.Error as error:
            raise UserError(f"{self.path} is no ROS 2 recording that can be read ({error})") from error

    def _can_be_walked(self) -> bool:
        """Whether the first and the last row, by number and by time, are there: they are at a file's two ends."""
        try:
            with closing(self._connection()) as connection:
                pages = connection.execute("PRAGMA page_count").fetchone()[0]
                size = connection.execute("PRAGMA page_size").fetchone()[0]
                stated = int.from_bytes(self._head()[28:32], "big")
                if max(pages, stated) * size > self.path.stat().st_size:
                    raise sqlite3.DatabaseError("it is cut off")
                connection.execute("SELECT id FROM messages ORDER BY id DESC LIMIT 1").fetchone()
                connection.execute("SELECT id FROM messages ORDER BY timestamp DESC LIMIT 1").fetchone()
        except sqlite3.Error as error:
            self.damage.note(f"a part of it is missing ({error})")
            return False
        return True

    def _head(self) -> bytes:
        with self.path.open("rb") as file:
            return file.read(100)

    def _salvaged(self, wanted: dict[int, Topic], start: int, end: int) -> Iterator[Message]:
        """Rows in the order in which they were written; rows that cannot be read are leapt over."""
        row, step = 0, 1
        with closing(self._connection()) as connection:
            for _ in range(_LEAPS):
                try:
                    query = "SELECT id, topic_id, timestamp, data FROM messages WHERE id > ? ORDER BY id"
                    for found, topic_id, logged, data in connection.execute(query, (row,)):
                        if int(found) <= row:
                            return  # a damaged tree that leads back into itself
                        row, step = int(found), 1
                        if topic_id in wanted and start <= int(logged) < end:
                            yield Message(wanted[topic_id], int(logged), bytes(data or b""))
                    return
                except (sqlite3.Error, TypeError, ValueError):
                    row, step = row + step, 2 * step


def _encoding(name: str) -> Encoding:
    return Encoding.CDR if name == "cdr" else Encoding.UNKNOWN
