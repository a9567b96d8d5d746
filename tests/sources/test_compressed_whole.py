"""Files of messages that were compressed as a whole, one by one, as `ros2 bag record --compression-mode file` does."""

import bz2
import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zstandard
from bag_writers import KINDS, walk, write

from lpslam.errors import UserError
from lpslam.sources.open import open_source

PACKED: dict[str, Callable[[bytes], bytes]] = {
    "zstd": lambda data: zstandard.ZstdCompressor(write_checksum=True).compress(data),
    "gz": gzip.compress,
    "bz2": bz2.compress,
}


def packed(path: Path, how: str) -> Path:
    found = path.with_name(f"{path.name}.{how}")
    found.write_bytes(PACKED[how](path.read_bytes()))
    return found


@pytest.mark.parametrize(("kind", "how"), [*((kind, "zstd") for kind in KINDS), ("bag", "gz"), ("db3", "bz2")])
def test_what_is_in_it_is_read(tmp_path: Path, kind: str, how: str) -> None:
    plain = write(tmp_path / f"walk.{kind}", lambda types: walk(types, 5))
    expected = list(open_source(plain))
    found = list(open_source(packed(plain, how)))
    assert len(found) == len(expected) == 5
    for one, other in zip(found, expected, strict=True):
        assert one.timestamp == other.timestamp
        np.testing.assert_array_equal(one.depth, other.depth)
        np.testing.assert_array_equal(one.rgb, other.rgb)


@pytest.mark.parametrize("leaves_plain", [False, True])
def test_a_folder_of_such_parts_is_one_recording(tmp_path: Path, leaves_plain: bool) -> None:
    (tmp_path / "bag").mkdir()
    part = write(tmp_path / "bag" / "walk_0.db3", lambda types: walk(types, 5))
    packed(part, "zstd")
    if not leaves_plain:
        part.unlink()
    assert len(open_source(tmp_path / "bag")) == 5


@pytest.mark.parametrize("how", PACKED)
def test_what_is_cut_off_damaged_or_something_else_is_said(tmp_path: Path, how: str) -> None:
    plain = write(tmp_path / "walk.db3", lambda types: walk(types, 5))
    whole = packed(plain, how)
    data = whole.read_bytes()
    damaged = bytearray(data)
    damaged[len(data) // 2 : len(data) // 2 + 40] = bytes(40)
    for number, content in enumerate((data[: len(data) // 2], bytes(damaged))):
        path = tmp_path / f"part{number}.db3.{how}"
        path.write_bytes(content)
        with pytest.raises(UserError):
            open_source(path)
    other = tmp_path / f"other.db3.{how}"
    other.write_bytes(PACKED[how](b"no database"))
    with pytest.raises(UserError, match="holds neither a ROS bag"):
        open_source(other)


def test_what_unpacks_to_far_more_than_any_recording_is_refused(tmp_path: Path) -> None:
    bomb = tmp_path / "bomb.db3.zstd"
    bomb.write_bytes(PACKED["zstd"](b"SQLite format 3\0" + bytes(1 << 26)))
    with pytest.raises(UserError, match="unpacks to more than"):
        open_source(bomb)
