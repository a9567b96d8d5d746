"""Recordings that are made to fill the memory, to run for ever, or to break whoever reads them: each is one line."""

import bz2
import json
import os
import sqlite3
import struct
import tracemalloc
import zipfile
from base64 import b64encode
from collections.abc import Callable
from contextlib import closing
from functools import cache
from pathlib import Path
from typing import Any

import lz4.frame
import pytest
import zstandard
from bag_writers import COLOUR, COLOUR_INFO, DEPTH, FIRST, KINDS, STEP, Entry, Types, walk, write
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from recordings import picture, raw_depth, write_seven_scenes, write_tum
from test_captures import FRAMES, restate, write_pairs, write_record3d, write_replica, write_scannet, write_stray

from lpslam.errors import LpSlamError, UserError
from lpslam.sources.bags.containers import mcap_file
from lpslam.sources.bags.containers.opening import open_container
from lpslam.sources.bags.containers.unpacking import LARGEST, unpacked
from lpslam.sources.bags.topics import TopicChoice
from lpslam.sources.open import SourceOptions, open_source

BOMB = LARGEST + (1 << 20)
PACKERS: dict[str, Callable[[bytes], bytes]] = {
    "bz2": bz2.compress, "lz4": lz4.frame.compress, "zstd": zstandard.compress
}  # fmt: skip


@cache
def bomb(compression: str) -> bytes:
    """Zeros, packed: more of them than are ever unpacked at once."""
    return PACKERS[compression](bytes(BOMB))


def complaint(path: Path) -> str:
    with pytest.raises(LpSlamError) as caught:
        list(open_source(path))
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("compression", PACKERS)
def test_a_part_unpacks_to_what_it_says_and_no_further(compression: str) -> None:
    bomb(compression)
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=r"unpacks to more than 1\.05 MB"):
            unpacked(compression, bomb(compression), 1 << 20)
        assert tracemalloc.get_traced_memory()[1] < 1 << 25
    finally:
        tracemalloc.stop()
    with pytest.raises(ValueError, match="unpacks to more than 268 MB"):
        unpacked(compression, bomb(compression), 2 * BOMB)


@pytest.mark.parametrize("compression", ["none", *PACKERS])
def test_what_is_within_its_bounds_is_unpacked_as_it_was(compression: str) -> None:
    data = bytes(range(256)) * 999
    pack = {"none": bytes, **PACKERS}[compression]
    assert unpacked(compression, pack(data), len(data)) == data
    if compression != "none":
        with pytest.raises(ValueError, match="is cut off"):
            unpacked(compression, pack(data)[:-40], len(data))


def _ros1_record(fields: dict[bytes, bytes], data: bytes) -> bytes:
    header = b"".join(struct.pack("<I", len(k) + 1 + len(v)) + k + b"=" + v for k, v in fields.items())
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def _ros1(*records: bytes) -> bytes:
    numbers = {name: struct.pack("<I", 1) for name in (b"conn_count", b"chunk_count")}
    head = _ros1_record({b"op": b"\x03", b"index_pos": bytes(8), **numbers}, bytes(4000))
    return b"#ROSBAG V2.0\n" + head + b"".join(records)


def _ros1_chunk(compression: bytes, data: bytes, size: int) -> bytes:
    return _ros1_record({b"op": b"\x05", b"compression": compression, b"size": struct.pack("<I", size)}, data)


@pytest.mark.parametrize("size", [1 << 20, 0xFFFFFFFF])
@pytest.mark.parametrize("compression", ["bz2", "lz4"])
def test_a_bag_that_unpacks_to_gigabytes_is_one_line(tmp_path: Path, compression: str, size: int) -> None:
    path = tmp_path / "bomb.bag"
    path.write_bytes(_ros1(_ros1_chunk(compression.encode(), bomb(compression), size)))
    assert "unpacks to more than" in complaint(path)


def test_chunks_in_chunks_are_damage(tmp_path: Path) -> None:
    nested = b""
    for _ in range(3000):
        nested = _ros1_chunk(b"none", nested, len(nested))
    path = tmp_path / "nested.bag"
    path.write_bytes(_ros1(nested))
    assert "a chunk lies in another one" in complaint(path)


def _mcap_record(kind: int, body: bytes) -> bytes:
    return bytes([kind]) + struct.pack("<Q", len(body)) + body


@pytest.mark.parametrize("size", [1 << 20, BOMB, 1 << 60])
@pytest.mark.parametrize("compression", ["lz4", "zstd"])
def test_an_mcap_that_unpacks_to_gigabytes_is_one_line(tmp_path: Path, compression: str, size: int) -> None:
    name, packed = compression.encode(), bomb(compression)
    body = struct.pack("<QQQI", 0, 1, size, 0) + struct.pack("<I", len(name)) + name
    chunk = _mcap_record(6, body + struct.pack("<Q", len(packed)) + packed)
    path = tmp_path / "bomb.mcap"
    path.write_bytes(mcap_file.MAGIC + _mcap_record(1, bytes(8)) + chunk)
    assert "unpacks to more than" in complaint(path)


def test_chunks_that_overlap_come_in_order_or_within_bounds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every chunk says that it reaches from the first to the last: all of them would have to be in memory."""
    path = write(tmp_path / "walk.mcap", lambda types: walk(types, 300))
    whole = open_container(path)
    expected = [message.logged for message in whole.messages([COLOUR, DEPTH])]
    assert expected == sorted(expected)
    index = whole._index  # type: ignore[attr-defined]
    assert len(index.chunk_indexes) > 3
    for entry in index.chunk_indexes:
        entry.message_start_time = 0
    assert [message.logged for message in whole.messages([COLOUR, DEPTH])] == expected
    monkeypatch.setattr(mcap_file, "_MOST_HELD", 1 << 20)
    held = most = 0
    push, pop = mcap_file.heapq.heappush, mcap_file.heapq.heappop

    def pushed(heap: list[Any], entry: Any) -> None:
        nonlocal held, most
        held += len(entry[-1].data)
        most = max(most, held)
        push(heap, entry)

    def popped(heap: list[Any]) -> Any:
        nonlocal held
        entry = pop(heap)
        held -= len(entry[-1].data)
        return entry

    monkeypatch.setattr(mcap_file.heapq, "heappush", pushed)
    monkeypatch.setattr(mcap_file.heapq, "heappop", popped)
    assert sorted(message.logged for message in whole.messages([COLOUR, DEPTH])) == expected
    assert 0 < most < 3 << 20, most


def test_an_index_that_lists_one_chunk_again_and_again_is_not_used(tmp_path: Path) -> None:
    path = write(tmp_path / "walk.mcap", walk)
    data = path.read_bytes()
    begun = struct.unpack_from("<Q", data, len(data) - 28)[0]
    first = data.index(b"\x08", begun)
    while data[first : first + 1] != b"\x08" or struct.unpack_from("<Q", data, first + 1)[0] > 500:
        first = data.index(b"\x08", first + 1)
    length = 9 + struct.unpack_from("<Q", data, first + 1)[0]
    path.write_bytes(data[:first] + data[first : first + length] * 1000 + data[first:])
    found = open_container(path)
    assert len(found.times(COLOUR)) == 6
    assert len(list(open_source(path))) == 6


TOPICS = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);" \
    "INSERT INTO topics VALUES (1, '/c', 'sensor_msgs/msg/Image', 'cdr');"  # fmt: skip
FOR_EVER = "WITH RECURSIVE c(x) AS (VALUES (1) UNION ALL SELECT x + 1 FROM c)"
COLUMNS = "id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER"
PROGRAMS = {
    "a view that never has a row": f"{TOPICS}CREATE VIEW messages AS {FOR_EVER} SELECT x AS id, 1 AS topic_id, "
    "x AS timestamp, x'00' AS data FROM c WHERE x < 0;",
    "topics without end": f"CREATE VIEW topics AS {FOR_EVER} SELECT x AS id, '/c' || x AS name, 'a/b' AS type, "
    f"'cdr' AS serialization_format FROM c; CREATE TABLE messages({COLUMNS}, data BLOB);",
    "data that are computed": f"{TOPICS}CREATE TABLE messages({COLUMNS}, data BLOB GENERATED ALWAYS AS "
    "(zeroblob(900000000)) VIRTUAL); INSERT INTO messages(topic_id, timestamp) VALUES (1, 1);",
    "text for numbers": "CREATE TABLE topics(id TEXT, name, type, serialization_format);"
    f"INSERT INTO topics VALUES ('a', '/c', 'b', 'cdr'); CREATE TABLE messages({COLUMNS}, data BLOB);",
    "odd values": f"{TOPICS}CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data); "
    "INSERT INTO messages VALUES (1, 1, 9e999, x'00'), (2, 1, -1, 'text'), (3, 1, NULL, 5), (4, 'x', 1.5, x'01');",
}


@pytest.mark.parametrize("script", PROGRAMS.values(), ids=PROGRAMS)
def test_a_database_that_is_a_program_is_one_line(tmp_path: Path, script: str) -> None:
    path = tmp_path / "walk.db3"
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(script)
        connection.commit()
    complaint(path)


def _foxglove(path: Path, change: Callable[[str, dict[str, Any]], Any]) -> Path:
    with path.open("wb") as file:
        writer = McapWriter(file, compression=CompressionType.NONE)
        writer.start()
        channels = {}
        for topic, kind in (("/c", "RawImage"), ("/d", "RawImage"), ("/camera_info", "CameraCalibration")):
            schema = writer.register_schema(f"foxglove.{kind}", "jsonschema", b"{}")
            channels[topic] = writer.register_channel(topic, "json", schema)
        for i in range(5):
            head = {"timestamp": {"sec": i + 1, "nsec": 0}, "frame_id": "a", "width": 64, "height": 48}
            lens = {"distortion_model": "plumb_bob", "D": [], "K": [60, 0, 32, 0, 60, 24, 0, 0, 1], "R": [], "P": []}
            colour, depth = (b64encode(each.tobytes()).decode() for each in (picture(i), raw_depth(i)))
            messages = {
                "/camera_info": {**head, **lens},
                "/c": {**head, "encoding": "rgb8", "step": 192, "data": colour},
                "/d": {**head, "encoding": "16UC1", "step": 128, "data": depth},
            }
            for topic, message in messages.items():
                changed = change(topic, message)
                data = changed if isinstance(changed, bytes) else json.dumps(changed).encode()
                writer.add_message(channels[topic], i * 10**9, data, i * 10**9)
        writer.finish()
    return path


ODD_FIELDS = [
    ("/camera_info", {"K": ["a"] * 9}),
    ("/camera_info", {"K": [[1]] * 9}),
    ("/camera_info", {"K": [None] * 9}),
    ("/camera_info", {"K": [10**400] * 9}),
    ("/camera_info", {"width": 10**400}),
    ("/c", {"width": 10**30}),
    ("/c", {"step": -192}),
    ("/c", {"format": 5}),
]


@pytest.mark.parametrize(("topic", "fields"), ODD_FIELDS, ids=lambda each: str(each)[:30])
def test_fields_of_other_kinds_are_one_line(tmp_path: Path, topic: str, fields: dict[str, Any]) -> None:
    assert len(list(open_source(_foxglove(tmp_path / "good.mcap", lambda _, message: message)))) == 5
    complaint(_foxglove(tmp_path / "odd.mcap", lambda name, m: {**m, **fields} if name == topic else m))


def test_lens_numbers_that_are_none_count_as_not_given(tmp_path: Path) -> None:
    fields = {"D": ["x"] * 5, "P": {"a": 1}}
    odd = _foxglove(tmp_path / "odd.mcap", lambda name, message: {**message, **(fields if "info" in name else {})})
    assert open_source(odd).camera.distortion == (0.0,) * 5


@pytest.mark.parametrize("data", [b"[" * 200_000, b"[]", b"null", b'"x"', b"\xff"])
def test_json_that_is_no_picture_is_one_line(tmp_path: Path, data: bytes) -> None:
    complaint(_foxglove(tmp_path / "odd.mcap", lambda name, message: data if name == "/c" else message))


def test_the_name_of_a_type_is_quoted_in_one_line(tmp_path: Path) -> None:
    """A byte that was lost shifts columns: what stood for a type is then all that stood beside it."""
    path = write(tmp_path / "bag.db3", walk)
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("UPDATE topics SET type = ?", ("a: 1\nb: 2\r\n" * 500,))
        connection.commit()
    assert len(complaint(path)) <= 1000


@pytest.mark.parametrize("what", ["image", "info"])
@pytest.mark.parametrize("kind", KINDS)
def test_topics_of_a_maker_with_messages_of_other_types_are_left_out(tmp_path: Path, kind: str, what: str) -> None:
    def odd(types: Types) -> list[Entry]:
        entries: list[Entry] = []
        for i in range(6):
            stamp = FIRST + i * STEP
            message = types.info(stamp) if what == "info" else types.image(stamp, picture(i), "rgb8")
            entries += [
                ("/device_0/sensor_1/Color_0/image/data", stamp, types.image(stamp, picture(i), "rgb8")),
                ("/device_0/sensor_0/Depth_0/image/data", stamp + 1, types.image(stamp, raw_depth(i), "16UC1")),
                ("/device_0/sensor_1/Color_0/info/camera_info", stamp + 2, types.info(stamp)),
                ("/device_0/sensor_0/option/Depth_Units/value", stamp + 2, message),
                ("/device_0/sensor_1/Color_0/tf/0", stamp + 3, message),
                ("/device_0/sensor_0/Depth_0/tf/0", stamp + 3, message),
            ]
        return entries

    topics = TopicChoice("/device_0/sensor_1/Color_0/image/data", "/device_0/sensor_0/Depth_0/image/data")
    path = write(tmp_path / f"odd.{kind}", odd)
    assert len(list(open_source(path, options=SourceOptions(topics)))) == 6


@pytest.mark.parametrize("kind", KINDS)
def test_runs_of_no_depth_that_fill_the_memory_are_one_line(tmp_path: Path, kind: str) -> None:
    """A run of 2^28 zeros is ten nibbles of RVL."""
    words = struct.pack("<2I", 0x88888888, 0x84000000)

    def bomb(types: Types) -> list[Entry]:
        data = bytes(12) + struct.pack("<ii", 1 << 14, 1 << 14) + words
        entries: list[Entry] = []
        for i in range(3):
            stamp = FIRST + i * STEP
            entries += [
                (COLOUR_INFO, stamp, types.info(stamp)),
                (COLOUR, stamp, types.image(stamp, picture(i), "rgb8")),
                (f"{DEPTH}/compressedDepth", stamp, types.compressed(stamp, "16UC1; compressedDepth rvl", data)),
            ]
        return entries

    assert "16384×16384" in complaint(write(tmp_path / f"bomb.{kind}", bomb))


@pytest.mark.parametrize("name", ["a.bag", "a.db3", "a.mcap", "a.mkv", "a.r3d", "a.sens", "a"])
def test_pipes_and_devices_are_refused_at_once(tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / name)
    assert "a device or a pipe" in complaint(tmp_path / name)
    (tmp_path / f"device_{name}").symlink_to("/dev/zero")
    assert "a device or a pipe" in complaint(tmp_path / f"device_{name}")
    (tmp_path / f"folder_{name}").mkdir()
    assert "no recording that is known" in complaint(tmp_path / f"folder_{name}")


SCENES: dict[str, tuple[Callable[[Path], Path], tuple[str, ...]]] = {
    "TUM": (write_tum, ("rgb.txt", "depth.txt", "camera.yaml")),
    "7-Scenes": (lambda place: write_seven_scenes(place), ("camera-intrinsics.txt",)),
    "Stray Scanner": (write_stray, ("rgb.mp4", "camera_matrix.csv", "odometry.csv", "depth", "confidence/000000.png")),
    "Redwood": (write_pairs, ("camera_intrinsic.json", "depth", "color")),
    "Replica": (lambda place: write_replica(place / "office0"), ("cam_params.json",)),
}


@pytest.mark.parametrize("kind", ["pipe", "device", "sparse"])
@pytest.mark.parametrize(
    ("layout", "name"), [(layout, name) for layout, (_, names) in SCENES.items() for name in names]
)
def test_files_of_a_folder_that_never_end_do_not_hold_it_up(tmp_path: Path, layout: str, name: str, kind: str) -> None:
    """What is not read is done without, or is one line; images are faults."""
    scene = SCENES[layout][0](tmp_path / "scene")
    path = tmp_path / "scene" / name
    path.rename(tmp_path / "kept") if path.exists() else None
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    else:
        path.touch()
        os.truncate(path, 1 << 33)
    tracemalloc.start()
    try:
        assert len(list(open_source(scene))) > 0
    except LpSlamError as error:
        assert "\n" not in str(error)  # noqa: PT017
    finally:
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert most < 3 << 27


def test_a_video_is_no_playlist(tmp_path: Path) -> None:
    scene = write_stray(tmp_path / "scan")
    (scene / "rgb.mp4").rename(scene / "other.mp4")
    (scene / "rgb.mp4").write_text("ffconcat version 1.0\nfile other.mp4\n")
    assert "is no video of a kind that is read" in complaint(scene)


def test_a_matroska_is_no_playlist(tmp_path: Path) -> None:
    pytest.importorskip("av")
    (tmp_path / "a.mkv").write_text("#EXTM3U\n#EXTINF:10,\nother.mkv\n#EXT-X-ENDLIST\n")
    assert "no video that can be read" in complaint(tmp_path / "a.mkv")


def test_depth_that_unpacks_to_gigabytes_is_a_fault(tmp_path: Path) -> None:
    lzfse = pytest.importorskip("lzfse")
    place = write_record3d(tmp_path / "walk.r3d")
    blocks = lzfse.compress(bytes(1 << 20))[:-4] * 128
    with zipfile.ZipFile(place) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    members["rgbd/0.depth"] = blocks + b"bvx$"
    # Blocks that say that they are small: who unpacks them does not ask.
    lie = bytearray(lzfse.compress(bytes(1 << 20)))
    struct.pack_into("<I", lie, 4, 10)
    members["rgbd/1.depth"] = bytes(lie[:-4]) * 1600 + b"bvx$"
    with zipfile.ZipFile(place, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    source = open_source(place)
    assert len(list(source)) == FRAMES - 2
    assert [fault.index for fault in source.faults] == [0, 1]


@pytest.mark.parametrize("size", [{"dh": -48, "dw": -64}, {"dh": 0, "dw": 0}, {"dh": 10**9, "dw": 1}])
def test_a_depth_image_has_a_size(tmp_path: Path, size: dict[str, int]) -> None:
    pytest.importorskip("lzfse")
    place = write_record3d(tmp_path / "walk.r3d")
    restate(**size)(place)
    assert "no recording of Record3D" in complaint(place)


def test_a_hole_in_a_file_is_its_end(tmp_path: Path) -> None:
    """Sixteen gigabytes of zeros are no frames of no bytes."""
    path = write_scannet(tmp_path / "scene.sens")
    data = bytearray(path.read_bytes())
    begun = data.index(b"\xff\xd8") - 96 - 8
    struct.pack_into("<Q", data, begun, 1 << 40)
    path.write_bytes(data)
    os.truncate(path, 1 << 34)
    assert len(list(open_source(path))) == FRAMES


def test_the_largest_part_is_larger_than_any_picture() -> None:
    assert LARGEST > 8192 * 8192 * 3
    with pytest.raises(UserError):
        open_source("/proc/self/mem")
