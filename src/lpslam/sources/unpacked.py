"""Archives of recordings: unpacked once, privately, until the process ends."""

from pathlib import Path

from lpslam.config import JobsConfig
from lpslam.errors import UserError
from lpslam.sources.archives import unpack
from lpslam.sources.unpacked_once import unpacked_once

ARCHIVES = frozenset((".zip", ".tar", ".gz", ".tgz", ".bz2", ".xz", ".zst", ".7z", ".rar"))


def unpacked(archive: Path) -> Path:
    """The folder, or the only file, that an archive holds; it lies unpacked until the process ends.

    Raises:
        UserError: it is no archive that can be read, holds what is refused, or more than the disk has room for.
    """
    inner = unpacked_once(archive, lambda folder, room: _unpack(archive, folder, room))
    while inner.is_dir() and len(entries := list(inner.iterdir())) == 1:
        inner = entries[0]
    if inner.suffix.lower() in ARCHIVES:
        # One in another may hold itself.
        raise UserError(f"{archive} holds another archive, {inner.name}; unpack it, and give what is in it")
    return inner


def _unpack(archive: Path, folder: Path, room: int) -> None:
    # A recording goes by the name of its folder.
    named = folder / _bare_name(archive.name)
    named.mkdir()
    try:
        unpack(archive, named, JobsConfig(unpacked_bytes=room))
    except UserError as error:
        raise UserError(f"{archive}: {error}") from error


def _bare_name(name: str) -> str:
    """The name of an archive without its endings."""
    while (suffix := Path(name).suffix.lower()) in ARCHIVES:
        name = name[: -len(suffix)]
    return name if name.strip(".") else "archive"
