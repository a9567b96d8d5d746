"""Archives of recordings: unpacked once, privately, until the process ends."""

import logging
import shutil
import tempfile
from pathlib import Path

from lpslam.config import JobsConfig
from lpslam.errors import UserError
from lpslam.interruption import at_end
from lpslam.sources.archives import unpack

logger = logging.getLogger(__name__)

ARCHIVES = frozenset((".zip", ".tar", ".gz", ".tgz", ".bz2", ".xz", ".zst", ".7z", ".rar"))
_SHARE_OF_DISK = 0.8
"""Of the free room of the disk for temporary files, that an archive may take."""
_UNPACKED: dict[tuple[str, int, int], tempfile.TemporaryDirectory[str]] = {}


def unpacked(archive: Path) -> Path:
    """The folder, or the only file, that an archive holds; it lies unpacked until the process ends.

    Raises:
        UserError: it is no archive that can be read, holds what is refused, or more than the disk has room for.
    """
    status = archive.stat()
    key = str(archive.resolve()), status.st_mtime_ns, status.st_size
    if key not in _UNPACKED:
        kept = tempfile.TemporaryDirectory(prefix="lpslam-")
        at_end(kept.cleanup)
        try:
            room = int(shutil.disk_usage(kept.name).free * _SHARE_OF_DISK)
            logger.warning("%s: the archive is unpacked into %s until the end", archive.name, kept.name)
            # A recording goes by the name of its folder.
            folder = Path(kept.name) / _bare_name(archive.name)
            folder.mkdir()
            unpack(archive, folder, JobsConfig(unpacked_bytes=max(room, 1)))
        except UserError as error:
            kept.cleanup()
            raise UserError(f"{archive}: {error}") from error
        _UNPACKED[key] = kept
    inner = Path(_UNPACKED[key].name)
    while inner.is_dir() and len(entries := list(inner.iterdir())) == 1:
        inner = entries[0]
    if inner.suffix.lower() in ARCHIVES:
        # One in another may hold itself.
        raise UserError(f"{archive} holds another archive, {inner.name}; unpack it, and give what is in it")
    return inner


def _bare_name(name: str) -> str:
    """The name of an archive without its endings."""
    while (suffix := Path(name).suffix.lower()) in ARCHIVES:
        name = name[: -len(suffix)]
    return name or "archive"
