"""The map on disk: one file of JSON documents and numpy arrays, written whole or not at all.

An .lpmap is a zip: `manifest.json` first, then `documents/NAME.json` and `arrays/NAME.npy`. The same content gives the
same bytes. What the documents mean is their writers' business.
"""

import io
import json
import os
import re
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from lpslam._version import __version__
from lpslam.errors import UserError
from lpslam.regular_files import refuse_endless
from lpslam.whole_files import refuse_unwritable, written_whole

FORMAT = "lpslam map"
FORMAT_VERSION = 3
# Maps of version 2 lack points known by direction alone, which their readers would take for sure ones. Those of
# version 1 have descriptors by other test pairs, and no sub-maps.
_OLDEST_VERSION = 2

# Other ways of packing are never written; their unpackers raise errors of their own.
_PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)

_MANIFEST = "manifest.json"
_DOCUMENTS, _ARRAYS = "documents/", "arrays/"
# Zip cannot say "no date"; its own earliest one keeps equal maps equal byte for byte.
_DATE = (1980, 1, 1, 0, 0, 0)
# Enough for hours of walking, small enough that a crafted file cannot fill the memory.
_MOST_BYTES = 8 << 30
_FREE_BYTES, _MOST_RATIO = 1 << 28, 100
"""A map that unpacks to more has at most so many times its own bytes: maps shrink by half, bombs a thousandfold."""
_MOST_DOCUMENT_BYTES = 1 << 27
"""Values take many times the room of their text; ten thousand signs have twenty megabytes."""
_MOST_MANIFEST_BYTES = 1 << 20
# What reading a file can raise that is no zip, a damaged one, or one made to deceive.
_DAMAGE = (
    zipfile.BadZipFile, zlib.error, EOFError, KeyError, ValueError, RuntimeError, MemoryError, OverflowError, TypeError,
    struct.error, SyntaxError, tokenize.TokenError,
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class MapContents:
    """All that a map file holds.

    Attributes:
        manifest: format, format_version, lpslam_version, created.
        documents: JSON values by name.
        arrays: numpy arrays by name.
    """

    manifest: dict[str, Any]
    documents: dict[str, Any]
    arrays: dict[str, NDArray[Any]]


def write_map_file(
    path: Path | str, documents: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], created: str = ""
) -> bytes:
    """Write a map; whoever reads `path` sees the old file or the new one, never a part.

    Args:
        path: where to; an existing file is replaced only if it is a map of a known version.
        documents: JSON-able values by name (letters, digits, `_`, `-`, `.`).
        arrays: by name; no objects.
        created: when, as text; empty keeps the bytes a function of the content alone.

    Returns:
        What `identity_of` says of it, whoever else writes there by then.

    Raises:
        UserError: the place cannot be written, or holds something else.
    """
    path = Path(path)
    refuse_foreign_file(path)
    manifest = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "lpslam_version": __version__,
        "created": created,
        "documents": sorted(documents),
        "arrays": sorted(arrays),
    }
    with written_whole(path, "map") as part, part.open("wb") as file:
        identity = _write_members(file, manifest, documents, arrays)
        file.flush()
        os.fsync(file.fileno())
    _sync_folder(Path(os.path.realpath(path)).parent)
    return identity


def read_map_file(path: Path | str) -> MapContents:
    """Read a map.

    Raises:
        UserError: the file cannot be read, is no map, is damaged, or is of a newer version.
    """
    path = Path(path)
    with _opened(path) as (archive, manifest):
        members = [member for member in archive.infolist() if member.filename != _MANIFEST]
        _refuse_large(path, members)
        contents = MapContents(manifest, {}, {})
        for member in members:
            # Reading a member to its end checks its CRC.
            data = archive.read(member)
            if member.filename.startswith(_DOCUMENTS):
                contents.documents[member.filename[len(_DOCUMENTS) : -len(".json")]] = json.loads(data)
            elif member.filename.startswith(_ARRAYS):
                name = member.filename[len(_ARRAYS) : -len(".npy")]
                contents.arrays[name] = _array(name, data)
        missing = (set(manifest.get("documents", ())) - contents.documents.keys()) | (
            set(manifest.get("arrays", ())) - contents.arrays.keys()
        )
        if missing:
            raise UserError(f"map {path} is damaged: {min(missing)} is missing; make the map again")
    return contents


def identity_of(path: Path | str) -> bytes:
    """What tells a map's content from any other's: names, sizes and checksums of all that it holds.

    Raises:
        UserError: as in `read_map_file`, but of what only reading to the end shows.
    """
    with _opened(Path(path)) as (archive, _):
        return _identity(archive)


def _identity(archive: zipfile.ZipFile) -> bytes:
    return repr([(member.filename, member.file_size, member.CRC) for member in archive.infolist()]).encode()


def read_manifest(path: Path | str) -> dict[str, Any]:
    """Read only what the map says of itself; errors as in `read_map_file`."""
    with _opened(Path(path)) as (_, manifest):
        return manifest


def refuse_foreign_file(path: Path | str) -> None:
    """Raise a `UserError` if a map must not be written to `path`: call it before hours of work, not after.

    A folder, a file that is not a map, and a map of a newer version are never overwritten; no folder is made.
    """
    path = Path(path)
    refuse_unwritable(path, "map")
    if path.exists():
        try:
            read_manifest(path)
        except UserError as error:
            raise UserError(f"{error}; it is not overwritten: remove it or choose another name") from error


@contextmanager
def _opened(path: Path) -> Iterator[tuple[zipfile.ZipFile, dict[str, Any]]]:
    """Open an archive with its manifest; whatever is wrong with it, also later, becomes one clear line."""
    refuse_endless(path, "map")
    try:
        with zipfile.ZipFile(path) as archive:
            _check_members(archive)
            yield archive, _checked_manifest(path, archive)
    except OSError as error:
        raise UserError(f"map {path} cannot be read ({error.strerror or error})") from error
    except _DAMAGE as error:
        reason = " ".join(str(error).split())[:120]
        raise UserError(f"{path} is not an lpslam map, or is damaged ({reason})") from error


def _check_members(archive: zipfile.ZipFile) -> None:
    """Refuse what no map has: one member twice, of which each reader may take another, and unusual packing."""
    names = set()
    for member in archive.infolist():
        if member.filename in names:
            raise ValueError(f"{member.filename[:60]} is in it twice")
        if member.compress_type not in _PACKED:
            raise ValueError(f"{member.filename[:60]} is packed in a way that maps are not")
        names.add(member.filename)


def _refuse_large(path: Path, members: Sequence[zipfile.ZipInfo]) -> None:
    """Raise a `UserError` where what a map holds would fill the memory."""
    most = min(_MOST_BYTES, max(_FREE_BYTES, _MOST_RATIO * path.stat().st_size))
    if sum(member.file_size for member in members) > most:
        raise UserError(f"map {path} claims to unpack to more than {most / 1e9:.3g} GB; it is not read")
    for member in members:
        if member.filename.startswith(_DOCUMENTS) and member.file_size > _MOST_DOCUMENT_BYTES:
            raise UserError(
                f"map {path} claims {member.file_size / 1e6:,.0f} MB of {member.filename[:60]}, more than any map; it "
                "is not read"
            )


def _array(name: str, data: bytes) -> NDArray[Any]:
    array = np.load(io.BytesIO(data), allow_pickle=False)
    if not isinstance(array, np.ndarray):
        raise ValueError(f"{name[:60]} is no array")
    return array


def _checked_manifest(path: Path, archive: zipfile.ZipFile) -> dict[str, Any]:
    if archive.getinfo(_MANIFEST).file_size > _MOST_MANIFEST_BYTES:
        raise ValueError("its manifest is too large")
    manifest = json.loads(archive.read(_MANIFEST))
    version = manifest.get("format_version") if isinstance(manifest, dict) else None
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT or type(version) is not int or version < 1:
        raise ValueError("its manifest is another program's")
    if version > FORMAT_VERSION:
        raise UserError(
            f"map {path} is of format version {version}, this lpslam reads up to {FORMAT_VERSION}: update lpslam"
        )
    if version < _OLDEST_VERSION:
        raise UserError(
            f"map {path} is of format version {version}, whose keypoints this lpslam cannot compare: map it again"
        )
    return manifest


def _write_members(
    file: BinaryIO, manifest: dict[str, Any], documents: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]
) -> bytes:
    with zipfile.ZipFile(file, "w") as archive:
        _write_member(archive, _MANIFEST, _json_bytes(manifest))
        for name in sorted(documents):
            _write_member(archive, f"{_DOCUMENTS}{_checked_name(name)}.json", _json_bytes(documents[name]))
        for name in sorted(arrays):
            buffer = io.BytesIO()
            np.save(buffer, np.asarray(arrays[name], order="C"), allow_pickle=False)
            _write_member(archive, f"{_ARRAYS}{_checked_name(name)}.npy", buffer.getvalue())
        return _identity(archive)


def _write_member(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    info = zipfile.ZipInfo(name, _DATE)
    info.create_system = 3
    info.external_attr = 0o644 << 16
    # The fastest level: descriptors hardly shrink, and saving must not hold up a robot.
    archive.writestr(info, data, zipfile.ZIP_DEFLATED, compresslevel=1)


def _json_bytes(value: Any) -> bytes:
    # A name of a file may have bytes that are no text; as they are, the map could not be read again.
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "replace")


def _checked_name(name: str) -> str:
    if not re.fullmatch(r"[\w.-]+", name, re.ASCII):
        raise ValueError(f"{name!r} is no name for a part of a map")
    return name


def _sync_folder(folder: Path) -> None:
    """Make the rename itself survive a power cut, where the system can."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        return
    try:
        os.fsync(handle)
    except OSError:
        pass
    finally:
        os.close(handle)
