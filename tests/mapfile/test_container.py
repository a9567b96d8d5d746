import io
import json
import os
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from lpslam.errors import UserError
from lpslam.mapfile.container import FORMAT_VERSION, read_manifest, read_map_file, refuse_foreign_file, write_map_file

DOCUMENTS: dict[str, Any] = {
    "text": {"classes": [{"name": "请勿拍打 \u202e𠮷", "score": 2.5}], "none": None, "empty": {}},
    "trajectory.log": [],
}
ARRAYS: dict[str, np.ndarray] = {
    "points": np.random.default_rng(0).normal(size=(100, 3)),
    "empty": np.zeros((0, 32), np.uint8),
    "scalar": np.array(3.5, np.float32),
    "nan": np.array([np.nan, np.inf, -np.inf, -0.0]),
    "fortran": np.asfortranarray(np.arange(12).reshape(3, 4)),
    "flags": np.array([True, False]),
}


def write(path: Path) -> Path:
    write_map_file(path, DOCUMENTS, ARRAYS)
    return path


def test_round_trip(tmp_path: Path) -> None:
    contents = read_map_file(write(tmp_path / "a.lpmap"))
    assert contents.documents == DOCUMENTS
    assert contents.arrays.keys() == ARRAYS.keys()
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(contents.arrays[name], array)
        assert contents.arrays[name].dtype == array.dtype
        assert contents.arrays[name].shape == array.shape
    assert contents.manifest["format_version"] == FORMAT_VERSION
    assert read_manifest(tmp_path / "a.lpmap") == contents.manifest


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=10,
)
any_array = hnp.arrays(
    st.sampled_from([np.float64, np.float32, np.int64, np.uint8, np.bool_]), hnp.array_shapes(min_dims=0, min_side=0)
)


@given(json_values, any_array)
@settings(max_examples=40, deadline=None)
def test_anything_comes_back_equal(tmp_path_factory: pytest.TempPathFactory, value: Any, array: np.ndarray) -> None:
    path = tmp_path_factory.mktemp("maps") / "a.lpmap"
    write_map_file(path, {"d": value}, {"a": array})
    contents = read_map_file(path)
    assert contents.documents["d"] == value
    np.testing.assert_array_equal(contents.arrays["a"], array)
    assert contents.arrays["a"].dtype == array.dtype


def test_nan_in_a_document_comes_back(tmp_path: Path) -> None:
    write_map_file(tmp_path / "a.lpmap", {"d": [float("nan")]}, {})
    assert np.isnan(read_map_file(tmp_path / "a.lpmap").documents["d"][0])


def test_the_same_content_gives_the_same_bytes(tmp_path: Path) -> None:
    first, second = tmp_path / "a.lpmap", tmp_path / "b.lpmap"
    write(first)
    reordered = {name: ARRAYS[name] for name in reversed(ARRAYS)} | {"fortran": np.arange(12).reshape(3, 4)}
    write_map_file(second, DOCUMENTS, reordered)
    assert first.read_bytes() == second.read_bytes()
    write_map_file(second, DOCUMENTS, ARRAYS, created="2024-01-01")
    assert first.read_bytes() != second.read_bytes()


def test_an_own_map_is_replaced_and_nothing_is_left_behind(tmp_path: Path) -> None:
    path = write(tmp_path / "a.lpmap")
    write_map_file(path, {"only": 1}, {})
    assert read_map_file(path).documents == {"only": 1}
    assert list(tmp_path.iterdir()) == [path]


def test_the_old_map_survives_a_failed_write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "a.lpmap")
    before = path.read_bytes()

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(UserError, match="No space left"):
        write_map_file(path, {"only": 1}, {})
    monkeypatch.undo()
    with pytest.raises(TypeError):
        write_map_file(path, {"only": object()}, {})
    with pytest.raises(ValueError, match="pickle"):
        write_map_file(path, {}, {"objects": np.array([{}], dtype=object)})
    with pytest.raises(ValueError, match="no name"):
        write_map_file(path, {"../up": 1}, {})
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def zip_of(path: Path, members: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return path


def manifest(**changes: object) -> bytes:
    return json.dumps(
        {"format": "lpslam map", "format_version": FORMAT_VERSION, "documents": [], "arrays": []} | changes
    ).encode()


def pickled() -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, np.array([{}], dtype=object), allow_pickle=True)
    return buffer.getvalue()


FOREIGN = {
    "empty": lambda path: path.write_bytes(b""),
    "text": lambda path: path.write_text("groceries: milk"),
    "another zip": lambda path: zip_of(path, {"word/document.xml": b"<x/>"}),
    "another manifest": lambda path: zip_of(path, {"manifest.json": b'{"format": "webapp"}'}),
    "no object": lambda path: zip_of(path, {"manifest.json": b"[1]"}),
    "broken manifest": lambda path: zip_of(path, {"manifest.json": b"{"}),
    "version true": lambda path: zip_of(path, {"manifest.json": manifest(format_version=True)}),
    "version 0": lambda path: zip_of(path, {"manifest.json": manifest(format_version=0)}),
    "older": lambda path: zip_of(path, {"manifest.json": manifest(format_version=1)}),
    "newer": lambda path: zip_of(path, {"manifest.json": manifest(format_version=FORMAT_VERSION + 1)}),
}


@pytest.mark.parametrize("kind", FOREIGN)
def test_what_is_no_known_map_is_neither_read_nor_overwritten(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "a.lpmap"
    FOREIGN[kind](path)
    before = path.read_bytes()
    remedy = {"newer": "update lpslam", "older": "map it again"}.get(kind, "not an lpslam map")
    with pytest.raises(UserError, match=remedy) as caught:
        read_map_file(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(UserError, match="not overwritten"):
        write(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("share", [0.001, 0.1, 0.5, 0.9, 0.999])
def test_truncated_maps_are_clear_errors(tmp_path: Path, share: float) -> None:
    path = write(tmp_path / "a.lpmap")
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])
    with pytest.raises(UserError, match="damaged"):
        read_map_file(path)


def test_flipped_bytes_never_give_another_map(tmp_path: Path) -> None:
    path = write(tmp_path / "a.lpmap")
    data = path.read_bytes()
    refused = 0
    for position in np.random.default_rng(0).integers(0, len(data), 150):
        damaged = bytearray(data)
        damaged[position] ^= 0x40
        path.write_bytes(damaged)
        try:
            contents = read_map_file(path)
        except UserError:
            refused += 1
        else:
            # Zip's own bookkeeping (dates, attributes) is not content.
            assert contents.documents == DOCUMENTS
            for name, array in ARRAYS.items():
                np.testing.assert_array_equal(contents.arrays[name], array)
    assert refused > 100


@pytest.mark.parametrize(
    "members",
    [
        {"manifest.json": manifest(arrays=["points"])},
        {"manifest.json": manifest(documents=["text"])},
        {"manifest.json": manifest(documents=7)},
        {"manifest.json": manifest(), "arrays/a.npy": b"not numpy"},
        {"manifest.json": manifest(), "documents/a.json": b"{"},
        {"manifest.json": manifest(), "arrays/a.npy": pickled()},
    ],
)
def test_parts_missing_broken_or_pickled_are_refused(tmp_path: Path, members: dict[str, bytes]) -> None:
    with pytest.raises(UserError, match="damaged") as caught:
        read_map_file(zip_of(tmp_path / "a.lpmap", members))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("packing", [zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
def test_a_member_packed_as_no_map_is_is_refused(tmp_path: Path, packing: int) -> None:
    path = tmp_path / "a.lpmap"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("manifest.json", manifest())
        archive.writestr("documents/a.json", b"[1, 2, 3]" * 50, packing)
    data = path.read_bytes()
    # Damaged, the unpacker of LZMA raises an error of its own.
    at = data.index(b"documents/a.json") + len("documents/a.json")
    for content in (data, data[: at + 12] + bytes(8) + data[at + 20 :]):
        path.write_bytes(content)
        with pytest.raises(UserError, match="damaged"):
            read_map_file(path)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_member_that_is_there_twice_or_is_an_archive_is_refused(tmp_path: Path) -> None:
    path, inner = tmp_path / "a.lpmap", io.BytesIO()
    np.savez(inner, a=np.zeros(3))
    for members in ([("documents/a.json", b"1"), ("documents/a.json", b"2")], [("arrays/a.npy", inner.getvalue())]):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("manifest.json", manifest())
            for name, content in members:
                archive.writestr(name, content)
        with pytest.raises(UserError, match="damaged"):
            read_map_file(path)


@pytest.mark.parametrize(("name", "count"), [("arrays/a.npy", 300), ("documents/more.json", 130)])
def test_a_map_that_would_fill_the_memory_is_not_read(tmp_path: Path, name: str, count: int) -> None:
    path = write(tmp_path / "a.lpmap")
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open(name, "w") as member,
    ):
        for _ in range(count):
            member.write(bytes(1 << 20))
    with pytest.raises(UserError, match="it is not read"):
        read_map_file(path)


def test_unwritable_and_unreadable_places(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="does not exist"):
        write(tmp_path / "none" / "a.lpmap")
    with pytest.raises(UserError, match="is a folder"):
        write(tmp_path)
    with pytest.raises(UserError, match="cannot be read"):
        read_map_file(tmp_path / "none.lpmap")
    with pytest.raises(UserError, match="cannot be read"):
        read_map_file(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="folder"):
        write(tmp_path / "file" / "a.lpmap")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(UserError, match="cannot be written"):
            refuse_foreign_file(tmp_path / "a.lpmap")
    finally:
        tmp_path.chmod(0o700)


def test_a_free_place_is_not_refused(tmp_path: Path) -> None:
    refuse_foreign_file(tmp_path / "a.lpmap")
    refuse_foreign_file(write(tmp_path / "b.lpmap"))
