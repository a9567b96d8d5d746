"""Archives from strangers, unpacked into a folder or refused as a whole.

Plain files and folders inside the folder are written, and nothing else: no links, no devices, no name that leads out,
none twice, and no more than is allowed, counted as it is written and not as the archive claims.
"""

import os
import re
import tarfile
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from lpslam.config import JobsConfig
from lpslam.errors import UserError

_PIECE = 1 << 20
_LONGEST_PATH, _LONGEST_NAME, _DEEPEST = 500, 200, 12
_ENCRYPTED = 0x1
# Windows reads these as places elsewhere, or as devices.
_FOREIGN = re.compile(r'[\\:*?"<>|\x00-\x1f\x7f]')
_DAMAGE = (
    zipfile.BadZipFile, tarfile.TarError, zlib.error, EOFError, KeyError, ValueError, RuntimeError, NotImplementedError,
    OverflowError, TypeError, IndexError,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Member:
    """A file or folder of an archive; `data` is None for a folder."""

    name: str
    data: IO[bytes] | None


def unpack(archive: Path, folder: Path, limits: JobsConfig) -> int:
    """Unpack a zip, or a tar, perhaps compressed, into an empty folder.

    Returns:
        How many files were written.

    Raises:
        UserError: it is no such archive, is damaged, or holds what is refused; the folder then holds a part.
    """
    root = folder.resolve()
    free = max(limits.free_bytes, int(limits.unpacked_ratio * archive.stat().st_size))
    most = min(limits.unpacked_bytes, free)
    written, files, seen = 0, 0, set[str]()
    try:
        for entries, member in enumerate(_members(archive), 1):
            if entries > limits.files:
                raise UserError(f"the archive holds more than {limits.files:,} files; it is refused")
            path = _place(member.name, root, seen)
            if member.data is None:
                path.mkdir(parents=True, exist_ok=True)
                continue
            path.parent.mkdir(parents=True, exist_ok=True)
            files += 1
            # Only new files, and never through a link.
            handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0), 0o600)
            with os.fdopen(handle, "wb") as file:
                while piece := member.data.read(_PIECE):
                    written += len(piece)
                    if written > most:
                        raise UserError(f"the archive unpacks to more than {most:,} bytes; it is refused")
                    file.write(piece)
    except OSError as error:
        raise UserError(f"the archive cannot be unpacked ({error.strerror or 'it is damaged'})") from error
    except _DAMAGE as error:
        raise UserError(f"the archive is damaged ({_plain(error)}); pack it again") from error
    if not files:
        raise UserError("the archive holds no files")
    return files


def _plain(what: object) -> str:
    """A name or an error in letters that any terminal shows."""
    return " ".join(str(what).encode("ascii", "replace").decode().split())[:100]


def _place(name: str, root: Path, seen: set[str]) -> Path:
    """Where a member goes, inside the folder."""
    parts = [part for part in name.split("/") if part not in ("", ".")]
    wrong = (
        name.startswith("/")
        or ".." in parts
        or not parts
        or len(name) > _LONGEST_PATH
        or len(parts) > _DEEPEST
        or any(len(part.encode("utf-8", "replace")) > _LONGEST_NAME for part in parts)
        or _FOREIGN.search(name) is not None
    )
    if wrong:
        raise UserError(f"the archive holds “{_plain(name)}”, which is no plain name inside it; it is refused")
    plain = "/".join(parts)
    path = root.joinpath(*parts)
    if plain in seen:
        raise UserError(f"the archive holds “{_plain(plain)}” twice; it is refused")
    if not name.endswith("/"):
        seen.add(plain)
    return path


def _members(archive: Path) -> Iterator[_Member]:
    if zipfile.is_zipfile(archive):
        yield from _of_zip(archive)
    elif tarfile.is_tarfile(archive):
        yield from _of_tar(archive)
    else:
        raise UserError("it is neither a zip nor a tar; pack the recording's folder as one of them")


def _of_zip(archive: Path) -> Iterator[_Member]:
    with zipfile.ZipFile(archive) as opened:
        for info in opened.infolist():
            kind = (info.external_attr >> 16) & 0o170000 if info.create_system == 3 else 0
            if kind not in (0, 0o100000, 0o040000):
                raise UserError(f"the archive holds a link or device, “{_plain(info.filename)}”; it is refused")
            if info.flag_bits & _ENCRYPTED:
                raise UserError("the archive is encrypted; pack it without a password")
            # What stands in the directory may differ from what stands before the data: the raw name is what counts.
            if info.is_dir():
                yield _Member(info.orig_filename, None)
                continue
            with opened.open(info) as data:
                yield _Member(info.orig_filename, data)


def _of_tar(archive: Path) -> Iterator[_Member]:
    with tarfile.open(archive, "r|*") as opened:
        for info in opened:
            if info.isdir() and info.name in (".", "./"):
                # The folder itself, which `tar -C folder .` begins with.
                continue
            if not (info.isreg() or info.isdir()) or info.issparse():
                raise UserError(f"the archive holds a link or device, “{_plain(info.name)}”; it is refused")
            yield _Member(info.name, None if info.isdir() else opened.extractfile(info))
