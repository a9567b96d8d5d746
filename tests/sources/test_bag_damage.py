"""Bags that are cut off, empty or hold something else: one line, and what can be read is read."""

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_writers import COLOUR, DEPTH, FIRST, KINDS, Entry, Types, walk, write
from recordings import picture, raw_depth

from command_line import Command
from lpslam.errors import LpSlamError, UserError
from lpslam.frames import RgbdFrame
from lpslam.sources.bags.containers import container, ros1
from lpslam.sources.bags.containers.opening import open_container
from lpslam.sources.open import open_source
from lpslam.sources.writing.mcap_recording import McapSink
from lpslam.sources.writing.messages import RosMessages
from lpslam.sources.writing.recordings import written


@pytest.mark.parametrize("kind", KINDS)
def test_a_recording_that_was_cut_off_is_read_as_far_as_it_goes(tmp_path: Path, kind: str) -> None:
    whole = write(tmp_path / f"whole.{kind}", lambda types: walk(types, 200)).read_bytes()
    counts = []
    for part in range(20):
        path = tmp_path / f"part.{kind}"
        path.write_bytes(whole[: len(whole) * part // 20 + 11 * part])
        try:
            frames = list(open_source(path))
        except UserError as error:
            assert "\n" not in str(error)  # noqa: PT017
            counts.append(0)
            continue
        counts.append(len(frames))
        for frame in frames:
            np.testing.assert_array_equal(frame.rgb, picture(round((frame.timestamp - frames[0].timestamp) * 30)))
    assert counts == sorted(counts), counts
    # The last chunk of a megabyte, which holds 65 frames, is lost with its end.
    assert counts[19] >= 190 - 65, counts
    assert counts[10] >= 100 - 65, counts


@pytest.mark.parametrize("kind", KINDS)
def test_a_part_of_what_was_cut_off_is_read_alone(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    whole = write(tmp_path / f"whole.{kind}", lambda types: walk(types, 500)).read_bytes()
    (tmp_path / f"part.{kind}").write_bytes(whole[: len(whole) * 9 // 10])
    monkeypatch.setattr(container, "_LARGE", 0)
    found = open_container(tmp_path / f"part.{kind}")
    assert ("are read through first" in caplog.text) == (kind != "db3")
    everything = list(found.messages([COLOUR, DEPTH]))
    start, end = everything[500].logged, everything[520].logged
    expected = [message for message in everything if start <= message.logged < end]
    unpacked = 0
    record = ros1._record

    def counted(*given: Any) -> Any:
        nonlocal unpacked
        unpacked += 1
        return record(*given)

    monkeypatch.setattr(ros1, "_record", counted)
    assert list(found.messages([COLOUR, DEPTH], start, end)) == expected
    assert unpacked < 600, "one chunk of a megabyte, or two"
    assert found.times(COLOUR) == [message.logged for message in everything if message.topic.name == COLOUR]


@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_a_recording_of_which_nothing_is_left_is_one_line(
    lpslam: Command, tmp_path: Path, kind: str, caplog: pytest.LogCaptureFixture
) -> None:
    whole = write(tmp_path / f"whole.{kind}", lambda types: walk(types, 20)).read_bytes()
    (tmp_path / f"part.{kind}").write_bytes(whole[:9000])
    complaint = lpslam("run", tmp_path / f"part.{kind}", "-o", tmp_path / "map.lpmap").complaint
    assert "holds no messages that can be read" in complaint
    assert "cut off" in complaint


@pytest.mark.parametrize("page", [0.2, 0.5, 0.8])
def test_a_database_with_a_damaged_page_says_so_and_gives_the_rest(
    tmp_path: Path, page: float, caplog: pytest.LogCaptureFixture
) -> None:
    path = write(tmp_path / "walk.db3", lambda types: walk(types, 60))
    data = bytearray(path.read_bytes())
    size = int.from_bytes(data[16:18], "big")
    leaves = [begin for begin in range(size, len(data), size) if data[begin] == 0x0D and begin > len(data) // 10]
    begin = leaves[int(page * len(leaves))]
    # Its cells lie elsewhere than it says.
    data[begin + 3 : begin + 5] = b"\x00\x00"
    data[begin + 8 : begin + 16] = b"\xff" * 8
    path.write_bytes(data)
    frames = list(open_source(path))
    assert "cannot be reached" in caplog.text or "a part of it" in caplog.text
    assert 40 <= len(frames) < 60
    for frame in frames:
        np.testing.assert_array_equal(frame.rgb, picture(round((frame.timestamp - FIRST / 1e9) * 30)))


def test_a_tree_that_leads_around_ends(tmp_path: Path) -> None:
    """Every child of the table's root is the same leaf: its rows come again and again."""
    path = write(tmp_path / "walk.db3", lambda types: walk(types, 200))
    data = bytearray(path.read_bytes())
    size = int.from_bytes(data[16:18], "big")
    for begin in range(size, len(data), size):
        if data[begin] == 0x05:
            cells = [int.from_bytes(data[begin + 12 + 2 * i : begin + 14 + 2 * i], "big")
                     for i in range(int.from_bytes(data[begin + 3 : begin + 5], "big"))]  # fmt: skip
            for cell in cells:
                data[begin + cell : begin + cell + 4] = data[begin + cells[0] : begin + cells[0] + 4]
    path.write_bytes(data)
    try:
        assert len(list(open_source(path))) < 200
    except UserError as error:
        assert "\n" not in str(error)  # noqa: PT017


@pytest.mark.parametrize("kind", KINDS)
def test_bytes_that_were_overwritten_never_end_in_a_traceback(tmp_path: Path, kind: str) -> None:
    whole = bytearray(write(tmp_path / f"whole.{kind}", lambda types: walk(types, 20)).read_bytes())
    draw = np.random.default_rng(5)
    for _ in range(20):
        broken = whole.copy()
        start = int(draw.integers(0, len(whole) - 64))
        broken[start : start + 64] = draw.integers(0, 256, 64, dtype=np.uint8).tobytes()
        path = tmp_path / f"broken.{kind}"
        path.write_bytes(broken)
        try:
            assert len(list(open_source(path))) <= 20
        except LpSlamError as error:
            assert "\n" not in str(error)  # noqa: PT017


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_recording_lacks_is_said(tmp_path: Path, kind: str) -> None:
    def only(*, colour: bool, depth: bool, name: str) -> Path:
        return write(tmp_path / f"{name}.{kind}", lambda types: walk(types, colour=colour, depth=depth))

    with pytest.raises(UserError, match=r"has depth .* but no colour"):
        open_source(only(colour=False, depth=True, name="depth"))
    with pytest.raises(UserError, match=r"has colour .* but no depth"):
        open_source(only(colour=True, depth=False, name="colour"))

    def flat(types: Types) -> list[Entry]:
        dull = raw_depth(0).astype(np.uint8)
        return [(n, t, types.image(t, dull, "8UC1") if n == DEPTH else m) for n, t, m in walk(types)]

    with pytest.raises(UserError, match="no depth of 16 bits"):
        open_source(write(tmp_path / f"flat.{kind}", flat))

    def strings(types: Types) -> list[Entry]:
        return [("/chatter", 1, types.make("std_msgs/msg/String", "hello"))]

    with pytest.raises(UserError, match="holds no pictures that can be read"):
        open_source(write(tmp_path / f"strings.{kind}", strings))
    empty = tmp_path / f"empty.{kind}"
    empty.touch()
    with pytest.raises(UserError, match="is empty"):
        open_source(empty)
    empty.write_bytes(b"PK\x03\x04 and so on, as a zip begins")
    with pytest.raises(UserError, match="compressed as a whole"):
        open_source(empty)
    empty.write_bytes(b"something that is no recording")
    with pytest.raises(UserError, match="no recording that is known"):
        open_source(empty)


@pytest.mark.parametrize("kind", KINDS)
def test_pictures_that_cannot_be_decoded_are_faults(tmp_path: Path, kind: str) -> None:
    def odd(types: Types) -> list[Entry]:
        entries = walk(types)
        seen = 0
        for row, (name, logged, message) in enumerate(entries):
            if name == COLOUR:
                seen += 1
                if seen == 3:
                    message.data = message.data[:100]
                if seen == 4:
                    entries[row] = name, logged, types.image(logged, picture(0, 32, 24), "rgb8")
                if seen == 5:
                    message.encoding = "nv21"
        return entries

    source = open_source(write(tmp_path / f"odd.{kind}", odd))
    assert len(list(source)) == 3
    assert len(source.faults) == 3
    assert "need 9216" in source.faults[0].reason


def test_messages_of_no_bytes_are_faults(tmp_path: Path) -> None:
    path = write(tmp_path / "walk.db3", walk)
    with closing(sqlite3.connect(path)) as connection:
        query = "UPDATE messages SET data = x'' WHERE id IN (SELECT id FROM messages WHERE topic_id = " \
            "(SELECT id FROM topics WHERE name = ?) LIMIT 2)"  # fmt: skip
        connection.execute(query, (COLOUR,))
        connection.commit()
    source = open_source(path)
    assert len(list(source)) == 4
    assert len(source.faults) == 2


def test_messages_of_no_bytes_in_mcap_are_faults(tmp_path: Path) -> None:
    path = tmp_path / "walk.mcap"
    written(open_source(write(tmp_path / "walk.db3", walk)), path)
    whole = open_source(path)
    messages = RosMessages.of

    class Emptied(RosMessages):
        def of(self, frame: RgbdFrame, nanoseconds: int) -> list[tuple[str, bytes]]:
            found = messages(self, frame, nanoseconds)
            return [(topic, b"" if frame.index == 2 else data) for topic, data in found]

    sink = McapSink(tmp_path / "emptied.mcap", Emptied(whole.camera))
    for frame in whole:
        sink.add(frame)
    sink.finish()
    sink.close()
    source = open_source(tmp_path / "emptied.mcap")
    assert len(list(source)) == 5
    assert [fault.index for fault in source.faults] == [2]
    assert "is empty" in source.faults[0].reason
