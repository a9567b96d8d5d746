"""Files that are unpacked once, privately, until the process ends."""

import logging
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

from lpslam.interruption import at_end

logger = logging.getLogger(__name__)

_SHARE_OF_DISK = 0.8
"""Of the free room of the disk for temporary files, that one file may take."""
_KEPT: dict[tuple[str, int, int], tempfile.TemporaryDirectory[str]] = {}


def unpacked_once(path: Path, unpack: Callable[[Path, int], None]) -> Path:
    """The private folder that holds what a file was unpacked to; done anew only where the file is another since.

    Args:
        path: of the file.
        unpack: puts what it holds into a folder, within so many bytes; where it raises, nothing is left.
    """
    status = path.stat()
    key = str(path.resolve()), status.st_mtime_ns, status.st_size
    if key not in _KEPT:
        kept = tempfile.TemporaryDirectory(prefix="lpslam-")
        at_end(kept.cleanup)
        room = int(shutil.disk_usage(kept.name).free * _SHARE_OF_DISK)
        logger.warning("%s: it is unpacked into %s until the end", path.name, kept.name)
        try:
            unpack(Path(kept.name), max(room, 1))
        except BaseException:
            kept.cleanup()
            raise
        _KEPT[key] = kept
    return Path(_KEPT[key].name)
