"""Frames of bags: the same pixels and times, whatever they were recorded in."""

import io
import struct
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from bag_writers import COLOUR, COLOUR_INFO, DEPTH, FIRST, KINDS, STEP, Entry, K, Types, walk, write
from mcap.reader import make_reader
from recordings import picture, raw_depth

from lpslam.errors import UserError
from lpslam.frames import FrameSource, RgbdFrame
from lpslam.sources.bags.topics import TopicChoice
from lpslam.sources.open import SourceOptions, open_source
from lpslam.sources.writing.mcap_recording import McapSink
from lpslam.sources.writing.messages import FoxgloveMessages
from lpslam.sources.writing.recordings import written


def same(one: list[RgbdFrame], other: list[RgbdFrame]) -> None:
    assert len(one) == len(other) > 0
    for a, b in zip(one, other, strict=True):
        assert (a.index, a.timestamp) == (b.index, b.timestamp)
        np.testing.assert_array_equal(a.rgb, b.rgb)
        np.testing.assert_array_equal(a.depth, b.depth)


def changed(types: Types, topic: str, message: object) -> Iterator[Entry]:
    for name, logged, each in walk(types):
        yield name, logged, message(logged) if name == topic and callable(message) else each


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("padding", [0, 10])
def test_frames_are_what_was_recorded(tmp_path: Path, kind: str, padding: int) -> None:
    source = open_source(write(tmp_path / f"walk.{kind}", lambda types: walk(types, padding=padding)))
    assert isinstance(source, FrameSource)
    assert (source.camera.fx, source.camera.cy, source.camera.fps) == (50.0, 23.5, 30.0)
    frames = list(source)
    assert len(source) == len(frames) == 6
    for i, frame in enumerate(frames):
        assert frame.index == i
        assert frame.timestamp == (FIRST + i * STEP) / 10**9
        np.testing.assert_array_equal(frame.rgb, picture(i))
        np.testing.assert_allclose(frame.depth, raw_depth(i) / 1000, rtol=1e-6)
    same(frames, list(source))
    one = source.frame(4)
    assert one is not None
    same([one], frames[4:5])
    assert len(source.sample_depths(3)) == 3


def test_every_container_and_a_folder_give_the_same_bits(tmp_path: Path) -> None:
    sources = [open_source(write(tmp_path / f"walk.{kind}", walk)) for kind in KINDS]
    written(sources[0], tmp_path / "tum")
    written(sources[1], tmp_path / "again.mcap")
    sources += [open_source(tmp_path / "tum"), open_source(tmp_path / "again.mcap")]
    first = list(sources[0])
    for source in sources[1:]:
        same(first, list(source))
        assert source.camera == sources[0].camera


def test_foxglove_messages_are_written_and_read(tmp_path: Path) -> None:
    path = tmp_path / "foxglove.mcap"
    whole = open_source(write(tmp_path / "walk.mcap", walk))
    assert written(whole, path, foxglove=True) == 6
    found = open_source(path)
    same(list(found), list(whole))
    assert found.camera == whole.camera
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
        assert summary is not None
        assert {each.name for each in summary.schemas.values()} == {
            "foxglove.CameraCalibration",
            "foxglove.CompressedImage",
            "foxglove.RawImage",
        }
        assert {each.message_encoding for each in summary.channels.values()} == {"json"}
    with pytest.raises(UserError, match=r"is no \.mcap"):
        written(whole, tmp_path / "folder", foxglove=True)


@pytest.mark.parametrize(
    "spoilt",
    [
        b"{",
        b"[]",
        b'{"data": 5}',
        b'{"timestamp": 1, "data": ""}',
        b'{"timestamp": {"sec": 1e400}, "encoding": "16UC1", "width": -1, "height": 1, "step": 0, "data": "AAA="}',
        b'{"encoding": "rgb8", "width": 4, "height": 4, "step": 12, "data": "*"}',
        b'{"width": "wide", "height": [], "encoding": "rgb8", "step": null, "data": ""}',
    ],
)
def test_hostile_foxglove_messages_are_faults(tmp_path: Path, spoilt: bytes) -> None:
    path = tmp_path / "foxglove.mcap"
    written(open_source(write(tmp_path / "walk.mcap", walk)), path, foxglove=True)
    messages = FoxgloveMessages.of

    class Spoiling(FoxgloveMessages):
        def of(self, frame: RgbdFrame, nanoseconds: int) -> list[tuple[str, bytes]]:
            found = messages(self, frame, nanoseconds)
            return [(topic, spoilt if frame.index in (2, 3) else data) for topic, data in found]

    source = open_source(path)
    sink = McapSink(tmp_path / "spoilt.mcap", Spoiling(source.camera))
    for frame in source:
        sink.add(frame)
    sink.finish()
    sink.close()
    again = open_source(tmp_path / "spoilt.mcap")
    assert len(list(again)) == 4
    assert 0 < len(again.faults) <= 2


def test_a_folder_of_ros2_with_parts_is_one_recording(tmp_path: Path) -> None:
    folder = tmp_path / "parts"
    folder.mkdir()
    entries = walk(Types(2), 8)
    for number, part in enumerate((entries[:16], entries[16:])):
        write(folder / f"parts_{number}.mcap", lambda types, part=part: part)
    whole = write(tmp_path / "whole.mcap", lambda types: entries)
    same(list(open_source(folder)), list(open_source(whole)))


@pytest.mark.parametrize("kind", KINDS)
def test_a_part_is_read_by_seconds(tmp_path: Path, kind: str) -> None:
    path = write(tmp_path / f"walk.{kind}", lambda types: walk(types, 30))
    source = open_source(path, options=SourceOptions(start=0.49, end=0.71))
    assert [round((frame.timestamp - FIRST / 1e9) * 30) for frame in source] == [15, 16, 17, 18, 19, 20, 21]
    with pytest.raises(UserError, match="no colour picture lies between"):
        open_source(path, options=SourceOptions(start=50.0))
    with pytest.raises(UserError, match="must come after"):
        open_source(path, options=SourceOptions(start=5.0, end=2.0))


def png(pixels: np.ndarray) -> bytes:
    return bytes(cv2.imencode(".png", pixels)[1].tobytes())


def rvl(raw: np.ndarray) -> bytes:
    """RVL as its paper writes it."""
    nibbles: list[int] = []

    def variable(value: int) -> None:
        while True:
            low, value = value & 7, value >> 3
            nibbles.append(low | (8 if value else 0))
            if not value:
                return

    flat, i, previous = raw.ravel().astype(int).tolist(), 0, 0
    while i < len(flat):
        start = i
        while i < len(flat) and flat[i] == 0:
            i += 1
        variable(i - start)
        start = i
        while i < len(flat) and flat[i]:
            i += 1
        variable(i - start)
        for value in flat[start:i]:
            delta, previous = value - previous, value
            variable((delta << 1) ^ (delta >> 31))
    nibbles += [0] * (-len(nibbles) % 8)
    words = [int("".join(f"{n:x}" for n in nibbles[at : at + 8]), 16) for at in range(0, len(nibbles), 8)]
    return struct.pack("<ii", raw.shape[1], raw.shape[0]) + struct.pack(f"<{len(words)}I", *words)


@pytest.mark.parametrize("how", ["png", "rvl"])
def test_compressed_depth_keeps_all_sixteen_bits(tmp_path: Path, how: str) -> None:
    topic = "/camera/aligned_depth_to_color/image_raw/compressedDepth"

    def entries(types: Types) -> list[Entry]:
        kept = [entry for entry in walk(types) if entry[0] != DEPTH]
        for i in range(6):
            raw = raw_depth(i)
            body = png(raw) if how == "png" else rvl(raw)
            data = struct.pack("<iff", 0, 0.0, 0.0) + body
            stamp = FIRST + i * STEP
            kept.append((topic, stamp + 40_000_003, types.compressed(stamp, f"16UC1; compressedDepth {how}", data)))
        return sorted(kept, key=lambda entry: entry[1])

    for i, frame in enumerate(open_source(write(tmp_path / "walk.mcap", entries))):
        np.testing.assert_allclose(frame.depth, raw_depth(i) / 1000, rtol=1e-6)


def test_quantised_metres_come_back(tmp_path: Path) -> None:
    """As compressed_depth_image_transport writes 32FC1: a / depth + b, kept in 16 bits."""
    metres = np.linspace(0.6, 9.0, 64 * 48, dtype=np.float32).reshape(48, 64)
    metres[:, :5] = np.nan
    quantisation = 100.0
    a = quantisation * (quantisation + 1.0)
    b = 1.0 - a / 10.0
    with np.errstate(invalid="ignore"):
        raw = np.where(np.isfinite(metres), a / metres + b, 0).astype(np.uint16)

    def entries(types: Types) -> list[Entry]:
        kept = [entry for entry in walk(types) if entry[0] != DEPTH]
        data = struct.pack("<iff", 0, a, b) + png(raw)
        for i in range(6):
            stamp = FIRST + i * STEP
            message = types.compressed(stamp, "32FC1; compressedDepth", data)
            kept.append(("/camera/aligned_depth_to_color/image_raw/compressedDepth", stamp + 40_000_003, message))
        return sorted(kept, key=lambda entry: entry[1])

    frame = next(iter(open_source(write(tmp_path / "walk.bag", entries))))
    held = np.isfinite(metres)
    assert not frame.depth[~held].any()
    np.testing.assert_allclose(frame.depth[held], metres[held], rtol=0.01)


def test_lens_models(tmp_path: Path) -> None:
    def with_lens(d: list[float], model: str):  # type: ignore[no-untyped-def]
        def entries(types: Types) -> list[Entry]:
            return list(changed(types, COLOUR_INFO, lambda logged: types.info(logged, K, d, model)))

        return entries

    plain = write(tmp_path / "five.bag", with_lens([0.1, -0.05, 0.001, 0.002, 0.01], "plumb_bob"))
    assert open_source(plain).camera.distortion == (0.1, -0.05, 0.001, 0.002, 0.01)
    # Azure Kinect's factory values, at a focal length like its own.
    eight = [0.514, -2.717, 0.000541, -0.000191, 1.56, 0.391, -2.533, 1.484]

    def rational(types: Types) -> list[Entry]:
        k = (61.0, 0, 31.5, 0, 61.0, 23.5, 0, 0, 1)
        return [
            (n, t, types.info(t, k, eight, "rational_polynomial") if n.endswith("info") else m)
            for n, t, m in walk(types)
        ]

    camera = open_source(write(tmp_path / "eight.mcap", rational)).camera
    rays = np.array([[0.0, 0.0], [0.3, 0.2], [-0.4, 0.3]])
    exact = cv2.projectPoints(np.c_[rays, np.ones(3)], np.zeros(3), np.zeros(3), camera.matrix, np.array(eight))[0][
        :, 0
    ]
    np.testing.assert_allclose(camera.distort(rays * [camera.fx, camera.fy] + [camera.cx, camera.cy]), exact, atol=0.1)
    with pytest.raises(UserError, match="equidistant is not a pinhole's; record rectified"):
        open_source(write(tmp_path / "fish.db3", with_lens([0.1, 0.02, 0, 0], "equidistant")))
    with pytest.raises(UserError, match="not calibrated"):
        open_source(write(tmp_path / "none.db3", lambda types: list(
            changed(types, COLOUR_INFO, lambda logged: types.info(logged, np.zeros(9))))))  # fmt: skip


def test_topics_are_chosen_and_can_be_asked_for(tmp_path: Path) -> None:
    def two(types: Types) -> list[Entry]:
        entries = walk(types)
        return entries + [(n.replace("/camera/", "/rear/"), t + 9, m) for n, t, m in entries]

    path = write(tmp_path / "two.mcap", lambda types: sorted(two(types), key=lambda entry: entry[1]))
    with pytest.raises(UserError, match=r"several cameras: .*choose with --color TOPIC"):
        open_source(path)
    chosen = TopicChoice("/rear/color/image_raw", "/rear/aligned_depth_to_color/image_raw")
    assert len(list(open_source(path, options=SourceOptions(chosen)))) == 6
    with pytest.raises(UserError, match="has no pictures on /left"):
        open_source(path, options=SourceOptions(TopicChoice("/left")))
    with pytest.raises(UserError, match="is depth; give a topic of colour"):
        open_source(path, options=SourceOptions(TopicChoice(DEPTH)))
    with pytest.raises(UserError, match="has no calibration /nowhere"):
        open_source(path, options=SourceOptions(TopicChoice("/rear/color/image_raw", info="/nowhere")))


def test_an_index_that_lists_no_type_definitions_is_enough(tmp_path: Path) -> None:
    import sqlite3
    from contextlib import closing

    path = write(tmp_path / "old.db3", walk)
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("DROP TABLE IF EXISTS message_definitions")
        connection.commit()
    assert len(list(open_source(path))) == 6


def test_foreign_profiles_of_mcap(tmp_path: Path) -> None:
    """ROS 1 messages in MCAP, as Foxglove's converter writes them."""
    from mcap.writer import Writer

    types = Types(1)
    buffer = io.BytesIO()
    writer = Writer(buffer)
    writer.start("ros1", "test")
    channels: dict[str, int] = {}
    for topic, logged, message in walk(types):
        if topic not in channels:
            schema = writer.register_schema(message.__msgtype__.replace("/msg/", "/"), "ros1msg", b"")
            channels[topic] = writer.register_channel(topic, "ros1", schema)
        data = bytes(types.store.serialize_ros1(message, message.__msgtype__))
        writer.add_message(channels[topic], logged, data, logged)
    writer.finish()
    (tmp_path / "ros1.mcap").write_bytes(buffer.getvalue())
    same(list(open_source(tmp_path / "ros1.mcap")), list(open_source(write(tmp_path / "walk.bag", walk))))


def test_stamps_of_zero_are_replaced_by_the_times_of_recording(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    def entries(types: Types) -> list[Entry]:
        return [
            (name, logged, types.image(0, raw_depth(0), "16UC1") if name == DEPTH else
             types.image(0, picture(i), "rgb8") if name == COLOUR else message)
            for i, (name, logged, message) in enumerate(walk(types))
        ]  # fmt: skip

    frames = list(open_source(write(tmp_path / "zero.db3", entries)))
    assert len(frames) == 6
    assert frames[1].timestamp - frames[0].timestamp == pytest.approx(STEP / 1e9, abs=1e-6)
    assert "carry no time of their own" in caplog.text
