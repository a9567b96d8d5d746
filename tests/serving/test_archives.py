"""Archives are unpacked inside a folder, or refused as a whole."""

import io
import os
import tarfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from lpslam.config import JobsConfig
from lpslam.errors import UserError
from lpslam.sources.archives import unpack

LIMITS = JobsConfig()


def zipped(path: Path, files: dict[str, bytes], **attributes: int) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            info = zipfile.ZipInfo("x")
            info.filename = name
            info.create_system = 3
            info.compress_type = zipfile.ZIP_DEFLATED
            for key, value in attributes.items():
                setattr(info, key, value)
            archive.writestr(info, data)
    return path


def tarred(path: Path, *members: tuple[str, bytes, str, str]) -> Path:
    """A tar of (name, data, type, linked name)."""
    with tarfile.open(path, "w:gz") as archive:
        for name, data, kind, link in members:
            info = tarfile.TarInfo(name)
            info.type, info.linkname, info.size = kind.encode("latin-1"), link, len(data)
            archive.addfile(info, io.BytesIO(data))
    return path


def into(tmp_path: Path) -> Path:
    folder = tmp_path / "inside"
    folder.mkdir()
    return folder


def refusal(archive: Path, tmp_path: Path, limits: JobsConfig = LIMITS) -> str:
    folder = into(tmp_path)
    before = sorted(path for path in tmp_path.rglob("*") if folder not in path.parents)
    with pytest.raises(UserError) as caught:
        unpack(archive, folder, limits)
    assert sorted(path for path in tmp_path.rglob("*") if folder not in path.parents) == before, "nothing outside"
    assert not [path for path in folder.rglob("*") if path.is_symlink()]
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("pack", ["zip", "tar"])
def test_a_recording_is_unpacked_as_it_is(tmp_path: Path, pack: str) -> None:
    files = {"walk/rgb.txt": b"1 rgb/1.png\n", "walk/rgb/1.png": b"\x89PNG", "./walk/名字.txt": b"x"}
    if pack == "zip":
        archive = zipped(tmp_path / "a.zip", files)
    else:
        members = [(name, data, "0", "") for name, data in files.items()]
        archive = tarred(tmp_path / "a.tgz", ("walk", b"", "5", ""), *members)
    folder = into(tmp_path)
    assert unpack(archive, folder, LIMITS) == 3
    assert (folder / "walk/rgb/1.png").read_bytes() == b"\x89PNG"
    assert (folder / "walk/名字.txt").read_bytes() == b"x"
    assert oct((folder / "walk/rgb.txt").stat().st_mode & 0o777) == "0o600"


NAMES = ["../out.txt", "a/../../out.txt", "/tmp/out.txt", "..", "a/..", "\\\\host\\out", "..\\out.txt", "C:\\out.txt",
         "C:out.txt", "a\nb", "a\x1b[2Jb", "a" * 300, "d/" * 20 + "x", "x" * 400 + "/y" * 60, "/", "con:"]  # fmt: skip


@pytest.mark.parametrize("name", NAMES, ids=lambda name: repr(name[:20]))
def test_a_name_that_leads_out_refuses_the_archive(tmp_path: Path, name: str) -> None:
    assert "refused" in refusal(zipped(tmp_path / "a.zip", {"fine.txt": b"x", name: b"x"}), tmp_path)


@pytest.mark.parametrize(
    "name", [name for name in NAMES if name not in ("/", "..", "a/..")], ids=lambda n: repr(n[:20])
)
def test_the_same_in_a_tar(tmp_path: Path, name: str) -> None:
    assert "refused" in refusal(tarred(tmp_path / "a.tar", ("fine", b"", "0", ""), (name, b"x", "0", "")), tmp_path)


@pytest.mark.parametrize("kind", ["1", "2", "3", "4", "6", "S"])
def test_links_and_devices_are_refused(tmp_path: Path, kind: str) -> None:
    archive = tarred(tmp_path / "a.tar", ("link", b"", kind, "/etc/passwd"), ("link/x", b"x", "0", ""))
    refusal(archive, tmp_path)


def test_links_in_a_zip_are_refused(tmp_path: Path) -> None:
    archive = zipped(tmp_path / "a.zip", {"link": b"/etc"}, external_attr=0o120777 << 16)
    assert "link" in refusal(archive, tmp_path)


def test_a_name_twice_is_refused_and_nothing_is_written_over(tmp_path: Path) -> None:
    archive = tarred(tmp_path / "a.tar", ("a/b", b"1", "0", ""), ("a//b", b"2", "0", ""))
    assert "twice" in refusal(archive, tmp_path)


def test_a_file_where_a_folder_is_needed_is_a_line(tmp_path: Path) -> None:
    refusal(tarred(tmp_path / "a.tar", ("a", b"1", "0", ""), ("a/b", b"2", "0", "")), tmp_path)


def test_a_bomb_stops_at_the_limit(tmp_path: Path) -> None:
    limits = JobsConfig(free_bytes=1 << 20, unpacked_ratio=10)
    archive = zipped(tmp_path / "a.zip", {"zeros": bytes(64 << 20)})
    assert archive.stat().st_size < 1 << 20
    assert "unpacks to more" in refusal(archive, tmp_path, limits)
    assert sum(path.stat().st_size for path in (tmp_path / "inside").rglob("*")) <= 1 << 20


def test_what_an_archive_says_of_its_sizes_is_not_believed(tmp_path: Path) -> None:
    archive = zipped(tmp_path / "a.zip", {"zeros": bytes(8 << 20)})
    data = archive.read_bytes()
    # The directory and the head before the data both say that the file has one byte.
    archive.write_bytes(data.replace((8 << 20).to_bytes(4, "little"), (1).to_bytes(4, "little")))
    refusal(archive, tmp_path, JobsConfig(free_bytes=1 << 20, unpacked_ratio=1))


def test_too_many_files_are_refused(tmp_path: Path) -> None:
    archive = zipped(tmp_path / "a.zip", {f"{number}/": b"" for number in range(50)})
    assert "more than 20 files" in refusal(archive, tmp_path, JobsConfig(files=20))


def _cut(data: bytes) -> bytes:
    return data[: len(data) // 2]


def _flipped(data: bytes) -> bytes:
    return data[:60] + bytes(each ^ 0xFF for each in data[60:120]) + data[120:]


@pytest.mark.parametrize("damage", [_cut, _flipped, lambda _: b"", lambda _: b"no archive", lambda _: os.urandom(9999)])
@pytest.mark.parametrize("pack", ["zip", "tar"])
def test_damage_is_one_line(tmp_path: Path, damage: Callable[[bytes], bytes], pack: str) -> None:
    if pack == "zip":
        archive = zipped(tmp_path / "a", {"a": os.urandom(2000), "b": os.urandom(2000)})
    else:
        archive = tarred(tmp_path / "a", ("a", os.urandom(2000), "0", ""), ("b", os.urandom(2000), "0", ""))
    archive.write_bytes(damage(archive.read_bytes()))
    refusal(archive, tmp_path)


def test_an_encrypted_archive_is_refused(tmp_path: Path) -> None:
    archive = zipped(tmp_path / "a.zip", {"a": b"x"})
    data = bytearray(archive.read_bytes())
    data[6] |= 1
    data[data.index(b"PK\x01\x02") + 8] |= 1
    archive.write_bytes(bytes(data))
    assert "encrypted" in refusal(archive, tmp_path)
